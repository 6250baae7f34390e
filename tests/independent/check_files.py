#!/usr/bin/python3
"""Holds a data set's folder against the written layout: what is there, and that it is whole.

    check_files.py DATASET_DIR

Names, types and shapes, sizes and SHA-256 in the manifests, tables, splits, no foreign file,
and nothing of the machine (host name, paths, times of day) in any compared file.
"""
import hashlib
import os
import re
import sys

import numpy as np

import beam_patterns
import boxes
import pulses
import sonar_dataset
from checklist import run_main
from machine_traces import check_machine, files_below
from sequence import IMAGE_KINDS, DataSet

TOP_LEVEL = {
    "README.md",
    "work.json",
    "dataset.json",
    "dataset.sha256",
    "scenario.yaml",
    "index.csv",
    "coco.json",
    "croissant.json",
    "provenance.json",
    "splits/train.txt",
    "splits/val.txt",
    "splits/test.txt",
}
ONCE_PER_SEQUENCE = {
    "sequence.json",
    "azimuth_rad.npy",
    "range_m.npy",
    "poses.csv",
    "poses.tum",
    "objects.csv",
    "boxes.csv",
    "first_return_m.npy",
    "annotations.jsonl",
}
POSES_HEADER = ["ping", "time_s", "x", "y", "z", "qw", "qx", "qy", "qz"]
OBJECTS_HEADER = ["ping", "instance", "x", "y", "z", "qw", "qx", "qy", "qz"]
INDEX_HEADER = ["sequence", "ping", "time_s", "split", "stem"]
SPLITS = ("train", "val", "test")


def sha256_of(path):
    digest = hashlib.sha256()
    with open(path, "rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def per_ping_files(sequence, ping):
    """Files that one ping must have, by which kinds of output the sequence has at all."""
    stem = f"{ping:06d}"
    wanted = set()
    if sequence.has("timeseries"):
        wanted.add(f"timeseries/{stem}.npy")
    if sequence.has("scatterers"):
        wanted.add(f"scatterers/{stem}.npy")
    if sequence.has("points"):
        wanted.add(f"points/{stem}.ply")
    for kind in IMAGE_KINDS:
        if sequence.has(kind):
            wanted |= {f"{kind}/{stem}_{what}.png" for what in sequence.mask_kinds}
            if kind == "polar" or sequence.has_image(kind):
                wanted.add(f"{kind}/{stem}.exr")
            if sequence.has("png"):
                wanted.add(f"png/{stem}_{kind}.png")
    return wanted


def check_listing(checklist, folder, entries, what):
    """Sizes and SHA-256 of listed files."""
    faults = []
    for entry in entries:
        path = os.path.join(folder, entry.path)
        if not os.path.isfile(path):
            faults.append(f"{entry.path} is absent")
        elif entry.size_bytes is not None and os.path.getsize(path) != entry.size_bytes:
            faults.append(
                f"{entry.path} has {os.path.getsize(path)} bytes, listed {entry.size_bytes}"
            )
        elif sha256_of(path) != entry.sha256:
            faults.append(f"{entry.path} has another SHA-256")
    checklist.expect_none(faults, f"{what}: {len(entries)} files listed, faults")


def check_top_level(checklist, data_set):
    """Exactly the files of the layout; dataset.json lists each; dataset.sha256 holds its hash."""
    found = {
        path for path in files_below(data_set.root) if not path.startswith("sequences" + os.sep)
    }
    assets = {path for path in found if re.fullmatch(r"assets/[0-9a-f]{64}(\.\w+)?", path)}
    checklist.expect_none(sorted(found - TOP_LEVEL - assets), "foreign files at the top")
    checklist.expect_none(sorted(TOP_LEVEL - found), "absent files at the top")
    wrong = [
        path for path in assets if sha256_of(data_set.path(path)) != re.split(r"[/.]", path)[1]
    ]
    checklist.expect_none(wrong, f"{len(assets)} assets, named unlike their SHA-256")
    check_listing(checklist, data_set.root, data_set.files, "dataset.json")
    unlisted = (
        found
        - {entry.path for entry in data_set.files}
        - {"dataset.json", "dataset.sha256", "provenance.json"}
    )
    checklist.expect_none(sorted(unlisted), "top-level files that dataset.json does not list")
    with open(data_set.path("dataset.sha256"), encoding="utf-8") as stream:
        text = stream.read()
    digest = sha256_of(data_set.path("dataset.json"))
    checklist.expect(text.split()[:1] == [digest], "dataset.sha256", text.strip(), digest)


def check_sequence_entry(checklist, data_set, sequence):
    """The manifest's row for one sequence."""
    entry, name = data_set.sequence_entries[sequence.name], sequence.name
    digest = sha256_of(sequence.path("sequence.json"))
    checklist.equal(f"{name} SHA-256 of sequence.json in dataset.json", entry.sha256, digest)
    checklist.equal(f"{name} pings in dataset.json", list(entry.pings), sequence.pings)
    listed_bytes = sum(listed.size_bytes for listed in sequence.files)
    checklist.equal(f"{name} bytes in sequence.json, all listed files", sequence.stated_bytes, listed_bytes)
    total = listed_bytes + os.path.getsize(sequence.path("sequence.json"))
    checklist.equal(f"{name} bytes in dataset.json, sequence.json included", entry.size_bytes, total)
    checklist.expect(entry.split in SPLITS, f"{name} split", entry.split, SPLITS)
    checklist.equal(f"{name} seed in dataset.json", entry.seed, sequence.seed)


def check_description(checklist, data_set, sequence):
    """Classes, instances and record of sequence.json among themselves and with the manifest."""
    name, ids = sequence.name, sorted(sequence.instances)
    checklist.expect(
        ids == list(range(1, len(ids) + 1)), f"{name} instance ids", ids[:5], f"1 to {len(ids)}"
    )
    wrong = [
        instance.name
        for instance in sequence.instances.values()
        if sequence.classes[instance.class_id - 1 : instance.class_id] != [instance.class_name]
    ]
    checklist.expect_none(wrong, f"{name} instances whose class id is not that class's place")
    checklist.equal(f"{name} classes", sequence.classes, data_set.classes)
    sonar = sequence.sonar
    worked_out = sonar.samples, len(sonar.spectrum)
    checklist.equal(f"{name} samples and transform length", sequence.stated_record, worked_out)
    extent_s = pulses.extent_s(sonar.pulse, sonar.bandwidth_hz, sonar.frequency_hz)
    gain = sonar.pulse.processing_gain(sonar.bandwidth_hz)
    aperture = beam_patterns.aperture_wavelengths(sonar.shading, sonar.width_rad)
    checklist.near(
        f"{name} pulse_extent_s",
        sequence.stated_pulse_extent_s,
        extent_s,
        0.51 / sonar.bandwidth_hz if sonar.pulse.shape == "table" else 1e-12,
    )
    checklist.near(f"{name} processing_gain", sequence.stated_processing_gain, gain, 1e-9 * gain)
    checklist.near(
        f"{name} aperture_wavelengths",
        sequence.stated_aperture_wavelengths,
        aperture,
        1e-6 * aperture,
    )
    height = beam_patterns.aperture_wavelengths(sonar.elevation_shading, sonar.elevation_width_rad)
    checklist.near(
        f"{name} aperture_wavelengths in elevation",
        sequence.stated_elevation_aperture_wavelengths,
        height,
        1e-6 * height,
    )


def check_sequence_files(checklist, sequence):
    """Exactly the files of the layout for its pings; sequence.json lists each of them."""
    found = files_below(sequence.folder)
    wanted = set(ONCE_PER_SEQUENCE)
    if sequence.has("cartesian"):
        wanted.add("cartesian_map.npy")
    for ping in sequence.pings:
        wanted |= per_ping_files(sequence, ping)
    extra = {path for path in found - wanted if not path.startswith(("layers/", "channels/", "statistics/"))}
    checklist.expect_none(sorted(extra), f"{sequence.name} foreign files")
    checklist.expect_none(sorted(wanted - found), f"{sequence.name} absent files")
    check_listing(checklist, sequence.folder, sequence.files, f"{sequence.name}/sequence.json")
    listed = [entry.path for entry in sequence.files]
    checklist.equal(f"{sequence.name} files listed twice", len(listed) - len(set(listed)), 0)
    checklist.expect_none(
        sorted(found - set(listed) - {"sequence.json"}),
        f"{sequence.name} files that sequence.json does not list",
    )


def check_arrays(checklist, sequence):
    """Types and shapes of arrays and images."""
    sonar, pings = sequence.sonar, sequence.pings
    wanted = {
        "azimuth_rad.npy": ("<f8", (sonar.beams,)),
        "range_m.npy": ("<f8", (sonar.samples,)),
        "first_return_m.npy": ("<f4", (len(pings), sonar.beams)),
    }
    if sequence.has("timeseries"):
        wanted |= {
            f"timeseries/{ping:06d}.npy": ("<c8", (sonar.beams, sonar.samples)) for ping in pings
        }
    if sequence.has("cartesian"):
        grid = sequence.stated_grid
        wanted["cartesian_map.npy"] = ("<i4", (grid.height, grid.width))
    faults = []
    for path, (kind, shape) in wanted.items():
        array = sonar_dataset.read_npy(sequence.path(path))
        if array.dtype.str != kind or array.shape != shape:
            faults.append(f"{path} is {array.dtype.str}{array.shape}, expected {kind}{shape}")
    for ping in pings:
        for kind in IMAGE_KINDS:
            if sequence.has(kind):
                faults += image_faults(sequence, kind, ping)
    checklist.expect_none(faults, f"{sequence.name} arrays and images of other type or shape")


def image_faults(sequence, kind, ping):
    """All images of one ping and geometry have one size; masks have 16, 8 and 16 bits."""
    if kind == "polar":
        shape = sequence.sonar.samples, sequence.sonar.beams
    else:
        shape = sequence.stated_grid.height, sequence.stated_grid.width
    parts = sequence.image(kind, ping).values() if sequence.has_image(kind) else ()
    faults = [
        f"{kind}/{ping:06d}.exr {part.name} is {part.height} x {part.width}"
        for part in parts
        if (part.height, part.width) != shape
    ]
    for what in sequence.mask_kinds:
        mask = sequence.mask(kind, ping, what)
        if mask.shape != shape or mask.dtype != (np.uint8 if what == "semantic" else np.uint16):
            faults.append(f"{kind}/{ping:06d}_{what}.png is {mask.dtype}{mask.shape}")
    if sequence.has("png"):
        grey = sequence.grey(kind, ping)
        if grey.shape != shape or grey.dtype != np.uint8:
            faults.append(f"png/{ping:06d}_{kind}.png is {grey.dtype}{grey.shape}")
    return faults


def check_tables(checklist, sequence):
    """poses.csv, poses.tum and objects.csv."""
    header, rows = sonar_dataset.read_csv(sequence.path("poses.csv"))
    checklist.equal(f"{sequence.name} poses.csv header", header, POSES_HEADER)
    poses = np.array(rows, float).reshape(len(rows), len(header))
    norm = np.linalg.norm(poses[:, 5:9], axis=1)
    checklist.expect(
        len(rows) > 0 and np.allclose(norm, 1, atol=1e-9),
        f"{sequence.name} quaternions' lengths",
        f"{norm.min():.12g} to {norm.max():.12g}",
        1,
    )
    checklist.expect(
        bool(np.all(np.diff(poses[:, 0]) == 1) and np.all(np.diff(poses[:, 1]) > 0)),
        f"{sequence.name} pings in poses.csv count up by one, times grow",
        f"{poses[0, 0]:g} to {poses[-1, 0]:g}",
        f"{len(rows)} pings",
    )
    with open(sequence.path("poses.tum"), encoding="utf-8") as stream:
        tum = np.array(
            [line.split() for line in stream if line.strip() and not line.startswith("#")], float
        )
    reordered = poses[:, [1, 2, 3, 4, 6, 7, 8, 5]]
    alike = tum.shape == reordered.shape and np.allclose(tum, reordered, rtol=0, atol=1e-9)
    checklist.expect(
        alike, f"{sequence.name} poses.tum (t x y z qx qy qz qw) agrees with poses.csv", alike, True
    )
    header, rows = sonar_dataset.read_csv(sequence.path("objects.csv"))
    checklist.equal(f"{sequence.name} objects.csv header", header, OBJECTS_HEADER)
    pairs = sorted((int(row[0]), int(row[1])) for row in rows)
    strangers = [pair for pair in pairs if pair[1] not in sequence.instances]
    checklist.expect_none(strangers, f"{sequence.name} objects.csv, instances not described")
    each = {identity for _, identity in pairs}
    checklist.expect(
        pairs == sorted((ping, identity) for ping in sequence.pings for identity in each),
        f"{sequence.name} objects.csv rows",
        f"{len(pairs)}",
        "each of its instances once a ping",
    )


def check_index(checklist, data_set):
    """index.csv has one row a ping; the split files hold every sequence's stems once."""
    header, rows = sonar_dataset.read_csv(data_set.path("index.csv"))
    checklist.equal("index.csv header", header, INDEX_HEADER)
    entries = data_set.sequence_entries
    wanted = [
        (
            str(sequence.number),
            str(ping),
            sequence.time_s(ping),
            entries[sequence.name].split,
            data_set.stem(sequence.number, ping),
        )
        for sequence in data_set.sequences
        for ping in sequence.pings
    ]
    obtained = [(row[0], row[1], float(row[2]), row[3], row[4]) for row in rows]
    faults = [f"{a} beside {b}" for a, b in zip(obtained, wanted) if a != b]
    checklist.equal("index.csv rows", len(obtained), len(wanted))
    checklist.expect_none(faults, "index.csv rows unlike poses.csv and dataset.json")
    for split in SPLITS:
        with open(data_set.path("splits", split + ".txt"), encoding="utf-8") as stream:
            lines = stream.read().split("\n")
        stems = [row[4] for row in wanted if row[3] == split]
        checklist.expect(
            lines == stems + [""],
            f"splits/{split}.txt",
            f"{len(lines) - 1} lines {lines[:2]}",
            f"{len(stems)} lines {stems[:2]}",
        )


def check(checklist, root):
    data_set = DataSet(root)
    check_top_level(checklist, data_set)
    listed = sorted(data_set.sequence_entries)
    total = sum(e.size_bytes for e in data_set.sequence_entries.values()) + sum(
        e.size_bytes for e in data_set.files
    )
    checklist.equal("bytes in dataset.json, all listed files together", data_set.stated_bytes, total)
    splits = {
        split: [int(n) for n in listed if data_set.sequence_entries[n].split == split]
        for split in SPLITS
    }
    checklist.equal("splits in dataset.json", data_set.splits, splits)
    checklist.equal("sequence folders", data_set.sequence_names, listed)
    for sequence in data_set.sequences:
        check_sequence_entry(checklist, data_set, sequence)
        check_description(checklist, data_set, sequence)
        check_sequence_files(checklist, sequence)
        check_arrays(checklist, sequence)
        check_tables(checklist, sequence)
        boxes.check_boxes(checklist, sequence)
    check_index(checklist, data_set)
    check_machine(checklist, data_set)


if __name__ == "__main__":
    sys.exit(run_main("check_files", check))
