#!/usr/bin/python3
"""Shows that the readers read and that every check can fail.

    selftest.py PROGRAM

Readers against bytes made by hand, formulas against known numbers, every check on small data
sets of the program (must pass), and again on copies with one thing wrong each (must fail).
"""
import os
import pathlib
import shutil
import sys
import tempfile
import zlib

import numpy as np

import beam_patterns
import faults
import physics
import pulses
import random_numbers
import ray_tracer
import sonar_dataset
import writers
from check_scene import CHECKS, HERE, generate
from checklist import Checklist, run_check

TANK = HERE.parent.parent / "scenes/sonar_tank.yaml"
# Tight enough that clean levels are compared to the last step of half precision.
EXACT = "synthesis.tolerance=1e-7"
SMALL_TANK = ("sonar.beams.count=128", "sonar.rays.elevation=9", EXACT)
CARTESIAN = "output.cartesian.height_px=150"
BURST = ("sonar.pulse={cw: {duration_s: 2e-4}}", "sonar.receiver={adc: {bits: 16, full_scale_db: 150}}",
         "sonar.detector={looks: 3, floor_db: 105, noise_db: 1, integrate: 1.5, law: logarithm}")
# Scenario, settings, pings, the checks that fit and the faults that they find.
DATA_SETS = (
    (TANK, (*SMALL_TANK, CARTESIAN, "output.cartesian.exr=true"), 1, [*CHECKS, "check_physics_tank"], faults.TANK),
    (TANK, (*SMALL_TANK, CARTESIAN, "noise.spectrum_level_db=60"), 1, CHECKS, faults.NOISY_TANK),
    (HERE / "shaded_room.yaml", (*BURST, CARTESIAN, EXACT), 1, CHECKS, faults.BURST),
    (HERE / "turning_room.yaml", (), 6, ["check_trace"], faults.ROOM),
)


def written(folder, name, data):
    path = os.path.join(folder, name)
    with open(path, "wb") as stream:
        stream.write(data)
    return path


def expect_refused(checklist, what, read, path):
    """Record that a reader raises instead of returning something."""
    try:
        read(path)
        outcome = "read"
    except (ValueError, KeyError, zlib.error):
        outcome = "refused"
    checklist.equal(what, outcome, "refused")


def test_arrays_and_text(checklist, folder):
    header = b"{'descr': '<i2', 'fortran_order': False, 'shape': (3,), }".ljust(117) + b"\n"
    head = b"\x93NUMPY\x01\x00" + bytes([118, 0]) + header
    path = written(folder, "a.npy", head + b"\x01\x00\x02\x00\xff\xff")
    checklist.equal("NPY by hand", sonar_dataset.read_npy(path).tolist(), [1, 2, -1])
    path = written(folder, "b.npy", head + b"\x01\x00\x02\x00\xff")
    expect_refused(checklist, "NPY cut short", sonar_dataset.read_npy, path)
    path = written(folder, "c.json", b'{"a": 1, "a": 2}')
    expect_refused(checklist, "JSON with a key given twice", sonar_dataset.read_json, path)
    path = written(folder, "d.csv", b"a,b\n1,2\n3\n")
    expect_refused(checklist, "CSV with a short row", sonar_dataset.read_csv, path)


def test_png(checklist, folder):
    by_hand = bytes.fromhex(
        "89504e470d0a1a0a0000000d4948445200000002000000010800000000"
    ) + zlib.crc32(bytes.fromhex("4948445200000002000000010800000000")).to_bytes(4, "big")
    packed = b"IDAT" + zlib.compress(b"\x01\x05\x02")
    by_hand += (len(packed) - 4).to_bytes(4, "big") + packed + zlib.crc32(packed).to_bytes(4, "big")
    by_hand += bytes.fromhex("0000000049454e44ae426082")
    pixels = sonar_dataset.read_png(written(folder, "a.png", by_hand))
    checklist.equal("PNG by hand (filter Sub)", pixels.tolist(), [[5, 7]])
    generator = np.random.default_rng(1)
    for kind in (np.uint8, np.uint16):
        image = generator.integers(0, np.iinfo(kind).max + 1, (7, 5)).astype(kind)
        pixels = sonar_dataset.read_png(
            written(folder, "b.png", writers.png_bytes(image, (0, 1, 2, 3, 4)))
        )
        same = np.array_equal(pixels, image) and pixels.dtype == kind
        checklist.equal(f"PNG {kind.__name__}, five filters", same, True)
    broken = bytearray(by_hand)
    broken[20] ^= 1
    expect_refused(checklist, "PNG with a wrong CRC", sonar_dataset.read_png, written(folder, "c.png", bytes(broken)))


def test_exr(checklist, folder):
    by_hand = (
        bytes.fromhex("762f310102000000")
        + b"channels\0chlist\0"
        + bytes.fromhex("13000000")
        + b"Y\0"
        + bytes.fromhex("01000000000000000100000001000000" "00")
        + b"compression\0compression\0\x01\0\0\0\0"
        + b"dataWindow\0box2i\0"
        + bytes.fromhex("10000000" "0000000000000000" "0100000000000000")
        + b"\0"
    )
    by_hand += (len(by_hand) + 8).to_bytes(8, "little") + bytes.fromhex(
        "00000000" "04000000" "003c" "00c0"
    )
    part = sonar_dataset.read_exr(written(folder, "a.exr", by_hand))[0]
    checklist.equal("EXR by hand", part.channels["Y"].tolist(), [[1.0, -2.0]])
    generator = np.random.default_rng(2)
    arrays = {
        "b": generator.normal(size=(37, 6)).astype("<f2"),
        "a": np.zeros((37, 6), "<f4"),
        "c": np.arange(37 * 6, dtype="<u4").reshape(37, 6),
    }
    for packing in ("none", "zips", "zip"):
        parts = sonar_dataset.read_exr(
            written(
                folder,
                "b.exr",
                writers.exr_bytes(
                    [
                        ("first", {"Y": arrays["b"]}, "none", {"scale": 0.5}),
                        ("second", arrays, packing, {}),
                    ]
                ),
            )
        )
        same = (
            all(np.array_equal(parts[1].channels[name], array) for name, array in arrays.items())
            and np.array_equal(parts[0].channels["Y"], arrays["b"])
            and parts[0].attributes["scale"] == 0.5
        )
        checklist.equal(f"EXR of two parts, {packing}, the same", same, True)
        checklist.equal(f"EXR of two parts, {packing}, names", [p.name for p in parts], ["first", "second"])


def test_rle(checklist):
    # Runs 1, 2, 3, 100: the fourth is written as its difference 98 = 2 + 32 * 3 to the second.
    mask = sonar_dataset.decode_rle("123R3", 2, 53)
    wanted = np.repeat([False, True, False, True], [1, 2, 3, 100]).reshape(53, 2).T
    checklist.expect(np.array_equal(mask, wanted), "RLE by hand", mask.sum(), wanted.sum())
    generator = np.random.default_rng(3)
    for density in (0.02, 0.5, 1.0):
        mask = generator.random((40, 30)) < density
        same = np.array_equal(
            sonar_dataset.decode_rle(writers.encode_rle(mask), 40, 30), mask
        )
        checklist.expect(same, f"RLE of density {density}, there and back", same, True)
    expect_refused(checklist, "RLE of another size", lambda text: sonar_dataset.decode_rle(text, 2, 52), "123R3")


def test_formulas(checklist):
    """Numbers of the written physics that need no data set."""
    checklist.equal(
        "transform length for 2392 samples", pulses.transform_length(2392, 29900.0), 2500
    )
    bandwidth, bins, fine = 29900.0, 2500, 64
    spectrum = np.zeros(bins * fine)
    spectrum[:bins] = pulses.spectrum(pulses.Pulse(), bins, bandwidth)
    power = np.abs(np.fft.ifft(spectrum) * bins * fine) ** 2
    samples = np.arange(bins * fine) / fine
    half = np.interp(0.5, power[: 2 * fine][::-1], samples[: 2 * fine][::-1])
    checklist.near(
        "-3 dB width in range (V3)", 2 * half * 1500 / 2 / bandwidth, 0.0330, 0.00033, " m"
    )
    azimuths = physics.beam_azimuths_rad(512, np.radians(90) / 512)
    squares = np.sum(beam_patterns.beam_pattern(azimuths - azimuths[256], np.radians(1.0)) ** 2)
    checklist.near("Eq 16 at the central beam", 10 * np.log10(squares), 8.08, 0.005, " dB")
    checklist.near(
        "noise of 30 dB re 1 uPa^2/Hz (V15)",
        physics.power_level_db(physics.noise_power_pa2(30.0, bandwidth)),
        74.76,
        0.005,
        " dB",
    )
    words = [int(word) for word in random_numbers.philox_4x32([np.array(0)] * 4, 0)]
    checklist.expect(
        words == [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8],
        "Philox 4x32-10 of zeros",
        [hex(word) for word in words],
        "6627e8d5 e169c58d bc57ac4c 9b00dbd8",
    )


def test_sums(checklist):
    """The fast trigonometric sums against the formula written out."""
    generator = np.random.default_rng(4)
    bandwidth, samples = 29900.0, 60
    bins = pulses.transform_length(samples, bandwidth)
    spectrum = pulses.spectrum(pulses.Pulse(), bins, bandwidth)
    delay, weight = generator.uniform(0, samples / bandwidth, 20), generator.normal(size=20) + 1j
    offsets = np.arange(samples)[:, None] - delay * bandwidth
    pulse = (
        np.exp(2j * np.pi * offsets[..., None] * (np.arange(bins) - bins // 2) / bins) @ spectrum
    )
    sector = np.zeros(20, int)
    series = physics.sector_series(weight, sector, delay, 1, spectrum, bandwidth, samples)[0]
    power = physics.sector_intensity(
        np.abs(weight), sector, delay, 1, spectrum, bandwidth, samples
    )[0]
    checklist.near("sum of pulses", physics.relative_l2(series, pulse @ weight), 0, 1e-12)
    checklist.near(
        "sum of squared pulses",
        physics.relative_l2(power, np.abs(pulse) ** 2 @ np.abs(weight)),
        0,
        1e-12,
    )


def inside_of(shape, points, size):
    """Whether points [n, 3] lie in a solid, by its definition."""
    if shape == "box":
        return np.all(np.abs(points) < np.array(size) / 2, axis=1)
    if shape == "sphere":
        return np.linalg.norm(points, axis=1) < size
    return (np.hypot(points[:, 0], points[:, 1]) < size[0]) & (np.abs(points[:, 2]) < size[1] / 2)


def test_ray_tracer(checklist):
    """Closed forms against marching along rays until a solid is entered or left."""
    generator = np.random.default_rng(5)
    solids = (
        ("box", ray_tracer.hit_box, ((2.0, 1.0, 0.6), False), (2.0, 1.0, 0.6)),
        ("sphere", ray_tracer.hit_sphere, (0.7,), 0.7),
        ("cylinder", ray_tracer.hit_cylinder, (0.5, 1.2), (0.5, 1.2)),
    )
    step = 1e-3
    for shape, hit, parameters, size in solids:
        for origin in (np.array([0.1, -0.2, 0.15]), np.array([1.5, -1.1, 0.9])):
            directions = generator.normal(size=(300, 3)) - (origin if origin[0] > 1 else 0)
            directions /= np.linalg.norm(directions, axis=1)[:, None]
            distance, normal = hit(origin, directions, *parameters)
            worst = 0.0
            for ray, found in zip(directions, distance):
                marched = inside_of(shape, origin + np.arange(0, 4, step)[:, None] * ray, size)
                change = np.nonzero(marched[1:] != marched[:-1])[0]
                # A ray that cuts an edge by less than a step may be missed by the march.
                gap = abs((change[0] + 0.5) * step - found) if len(change) else 0.0
                worst = max(worst, gap)
            unit = np.abs(np.linalg.norm(normal[np.isfinite(distance)], axis=1) - 1).max()
            checklist.expect(
                worst < step,
                f"ray tracer, {shape} from {origin.tolist()}, largest gap to marching",
                f"{worst:.4f} m",
                f"< {step} m",
            )
            checklist.near(f"ray tracer, {shape}, length of normals", unit, 0, 1e-9)


def failed_lines(output):
    return [line for line in output.splitlines() if line.startswith("FAIL") or "Error" in line]


def test_sound_data_set(checklist, root, checks):
    for name in checks:
        status, output = run_check(name, root)
        checklist.equal(f"{name} on sound data, exit status", (status, failed_lines(output)[:3]), (0, []))
    copy = root.with_name("copy")
    shutil.copytree(root, copy)
    (copy / "provenance.json").write_text("another machine", encoding="utf-8")
    status, output = run_check("compare_datasets", root, copy)
    checklist.equal("compare_datasets on a copy, exit status", (status, failed_lines(output)), (0, []))
    shutil.rmtree(copy)


def test_fault(checklist, root, check, name, damage):
    """A fault is found, by a FAIL line rather than by a crash, and its data set differs."""
    copy = root.with_name("faulty")
    shutil.copytree(root, copy)
    damage(copy)
    status, output = run_check(check, copy)
    found = failed_lines(output)
    checklist.expect(
        status == 1 and found and "Traceback" not in output,
        f"{check} on {name}",
        f"exit {status}, {found[0][:110] if found else output[-300:]}",
        "exit 1",
    )
    status, _ = run_check("compare_datasets", root, copy)
    checklist.equal(f"compare_datasets on {name}, exit status", status, 1)
    shutil.rmtree(copy)


def main(program):
    checklist = Checklist("selftest")
    with tempfile.TemporaryDirectory() as folder:
        for test in (test_arrays_and_text, test_png, test_exr):
            test(checklist, folder)
    test_rle(checklist)
    test_formulas(checklist)
    test_sums(checklist)
    test_ray_tracer(checklist)
    for scenario, settings, pings, checks, faulty in DATA_SETS:
        with tempfile.TemporaryDirectory(prefix="ensonify-") as folder:
            root = pathlib.Path(folder) / "data"
            generate(program, scenario, root, pings, settings)
            test_sound_data_set(checklist, root, checks)
            for check, changes in faulty.items():
                for name, damage in changes.items():
                    test_fault(checklist, root, check, name, damage)
    return checklist.finish()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
