"""A data set as the checks see it: every key name of dataset.json and sequence.json is spelled here and in
sonar.py, and nowhere else."""
import os
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sonar import Grid, instance_from_json, sonar_from_json
from sonar_dataset import read_csv, read_exr, read_json, read_npy, read_png

IMAGE_KINDS = ("polar", "cartesian")


@dataclass(frozen=True)
class FileEntry:
    """One file that a manifest lists, relative to the manifest's folder."""

    path: str
    size_bytes: int
    sha256: str


@dataclass(frozen=True)
class SequenceEntry:
    """What the manifest says of one sequence."""

    pings: range
    seed: int
    split: str
    size_bytes: int
    sha256: str


def listed_files(manifest):
    """The files that a sequence.json or a dataset.json lists."""
    return [FileEntry(entry["path"], entry["bytes"], entry["sha256"]) for entry in manifest["files"]]


class Sequence:
    """One sequence folder: its description and its files by ping."""

    def __init__(self, root, name):
        self.root, self.name, self.number = root, name, int(name)
        self.folder = os.path.join(root, "sequences", name)
        self.info = read_json(os.path.join(self.folder, "sequence.json"))
        self.sonar = sonar_from_json(self.info)
        self.seed = self.info["seed"]
        self.speckle = self.info["scattering"]["speckle"]
        self.rays_by_need = self.info["sonar"]["rays"].get("per_cell", 0) > 0

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def has(self, *parts):
        return os.path.exists(self.path(*parts))

    @cached_property
    def _pose_rows(self):
        header, rows = read_csv(self.path("poses.csv"))
        return {int(row[header.index("ping")]): dict(zip(header, map(float, row))) for row in rows}

    @property
    def pings(self):
        """Ping numbers, from the rows of poses.csv."""
        return list(self._pose_rows)

    def pose(self, ping):
        """Sonar in world: x, y, z, qw, qx, qy, qz."""
        return np.array(
            [self._pose_rows[ping][key] for key in ("x", "y", "z", "qw", "qx", "qy", "qz")]
        )

    def time_s(self, ping):
        return self._pose_rows[ping]["time_s"]

    @cached_property
    def instances(self):
        return {entry["id"]: instance_from_json(entry) for entry in self.info["instances"]}

    @property
    def classes(self):
        """Class names; ids count from 1 in this order."""
        return self.info["classes"]

    @property
    def stated_record(self):
        """Stored samples and transform length as sequence.json says."""
        return self.info["record"]["samples"], self.info["record"]["transform"]

    @property
    def stated_pulse_extent_s(self):
        return self.info["record"]["pulse_extent_s"]

    @property
    def stated_processing_gain(self):
        return self.info["sonar"]["processing_gain"]

    @property
    def stated_aperture_wavelengths(self):
        return self.info["sonar"]["beams"]["shading"]["aperture_wavelengths"]

    @property
    def stated_elevation_aperture_wavelengths(self):
        return self.info["sonar"]["elevation"]["shading"]["aperture_wavelengths"]

    @property
    def stated_bytes(self):
        return self.info["bytes"]

    @property
    def files(self):
        return listed_files(self.info)

    @property
    def png_limits_db(self):
        """Levels of black and white of the grey pictures."""
        return tuple(self.info["png"]["db"])

    @property
    def png_resampling(self):
        """How Cartesian grey pictures are made: bilinear or nearest."""
        return self.info["png"]["resampling"]

    def scatterers(self, ping):
        return read_npy(self.path("scatterers", f"{ping:06d}.npy"))

    def series(self, ping):
        return read_npy(self.path("timeseries", f"{ping:06d}.npy"))

    def image(self, kind, ping):
        """The parts of a level image, by name."""
        return {part.name: part for part in read_exr(self.path(kind, f"{ping:06d}.exr"))}

    def has_image(self, kind):
        """Whether there are level images; Cartesian ones are there on request alone."""
        return self.has(kind) and any(n.endswith(".exr") for n in os.listdir(self.path(kind)))

    def cartesian_map(self):
        return read_npy(self.path("cartesian_map.npy"))

    def mask_path(self, kind, ping, what):
        return self.path(kind, f"{ping:06d}_{what}.png")

    def mask(self, kind, ping, what):
        """instance, semantic or shadow mask as stored (rows of the image)."""
        return read_png(self.mask_path(kind, ping, what))

    @cached_property
    def mask_kinds(self):
        """Masks that this sequence has; those on request are there for all its images or none."""
        names = [n for k in IMAGE_KINDS if self.has(k) for n in os.listdir(self.path(k))]
        on_request = ["shadow", "multipath"]
        return ["instance", "semantic"] + [
            what for what in on_request if any(n.endswith(f"_{what}.png") for n in names)
        ]

    def grey(self, kind, ping):
        return read_png(self.path("png", f"{ping:06d}_{kind}.png"))

    def grid(self, part):
        """Place of a Cartesian image, from its own header."""
        attributes = part.attributes
        return Grid(
            part.height,
            part.width,
            *(float(attributes[name]) for name in ("metres_per_pixel", "x_top_m", "y_left_m")),
        )


    @property
    def stated_grid(self):
        """Place of the Cartesian images as sequence.json says."""
        return Grid(
            *(
                self.info["cartesian"][name]
                for name in ("height_px", "width_px", "metres_per_pixel", "x_top_m", "y_left_m")
            )
        )


class DataSet:
    """A finished data set folder."""

    def __init__(self, root):
        self.root = root
        self.manifest = read_json(os.path.join(root, "dataset.json"))

    def path(self, *parts):
        return os.path.join(self.root, *parts)

    @property
    def files(self):
        return listed_files(self.manifest)

    @cached_property
    def sequences(self):
        return [Sequence(self.root, name) for name in self.sequence_names]

    @property
    def sequence_names(self):
        return sorted(os.listdir(self.path("sequences")))

    @property
    def sequence_entries(self):
        """Rows of the manifest by folder name."""
        return {
            f"{entry['sequence']:06d}": SequenceEntry(
                range(*entry["pings"]),
                entry["seed"],
                entry["split"],
                entry["bytes"],
                entry["sha256"],
            )
            for entry in self.manifest["sequences"]
        }

    @property
    def classes(self):
        return self.manifest["classes"]

    @property
    def splits(self):
        """Sequence numbers of each split."""
        return self.manifest["splits"]

    @property
    def stated_bytes(self):
        return self.manifest["bytes"]

    @staticmethod
    def stem(sequence_number, ping):
        """What index.csv and the split files call a ping."""
        return f"{sequence_number:06d}/{ping:06d}"
