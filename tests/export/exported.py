"""A small data set of two drawn sequences, made once by the program, and its files read without it.

ENSONIFY is the program.
"""
import csv
import json
import pathlib
import sys
import unittest

import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from program import PROGRAM, hashes, made, run, scratch  # noqa: E402,F401
import sonar_dataset  # noqa: E402

# Two sequences of different length in range, one for training and one to validate with. The pole
# stands before the ball in some pings, so that masks fall apart.
SCENARIO = """ensonify: 1
name: exported
seed: 13
sequences: 2
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: {choice: [4, 5]}
  beams: {count: 48, fov_deg: 60}
  rays: {elevation: 24}
materials: {m: {reflectivity: 1e-3}, s: {reflectivity: 1e-2}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [7, 7, 2], inward_facing: true}}}
  - {name: "ball/1", class: "ball & net", material: s, shape: {sphere: {radius_m: 0.3}},
     pose: {position_m: [{uniform: [1.5, 2.5]}, 0.3, 0]}}
  - {name: pole, class: pole, material: s, shape: {cylinder: {radius_m: 0.1, height_m: 2}},
     trajectory: {poses: [{time_s: 1, position_m: [1.2, 0.1, 0]}, {time_s: 2, position_m: [1, 1.4, 0]}]}}
trajectory:
  poses: [{time_s: 1, position_m: [0, 0, 0]},
          {time_s: 2, position_m: [0.3, 0.2, 0], rotation_deg: [0, 5, 20]}]
  ping_rate_hz: 4
  pings: 3
splits: {train: 0.5, val: 0.5, test: 0}
output: {cartesian: {height_px: 60}}
"""

# The room is stuff: without these it is no object of an export.
CLASSES = ["room", "ball & net", "pole"]
ALL_CLASSES = ("--classes", ",".join(CLASSES))


def dataset(*extra):
    """The folder of the data set, made at the first call with these arguments."""
    return made(SCENARIO, *extra)


def export(format_name, *extra, source=None):
    """The folder or file that an export made."""
    out = scratch() / "out"
    result = run("export", source or dataset(), "--format", format_name, "-o", out, "--quiet", *extra)
    assert result.returncode == 0, result.stderr
    return out


class Sequence:
    """One sequence of a data set, read file by file."""

    def __init__(self, folder):
        self.folder = folder
        self.head = json.loads((folder / "sequence.json").read_text())
        self.number, self.split = self.head["sequence"], self.head["split"]
        self.pings = range(*self.head["pings"])
        with open(folder / "poses.csv", newline="") as file:
            self.poses = {int(row["ping"]): row for row in csv.DictReader(file)}
        with open(folder / "objects.csv", newline="") as file:
            self.objects = list(csv.DictReader(file))

    def png(self, kind, ping, suffix=""):
        return sonar_dataset.read_png(self.folder / kind / f"{ping:06}{suffix}.png")

    def npy(self, name):
        return sonar_dataset.read_npy(self.folder / name)

    def pose(self, ping):
        return [float(self.poses[ping][key]) for key in ("x", "y", "z", "qw", "qx", "qy", "qz")]


def sequences(folder=None):
    return [Sequence(path) for path in sorted(((folder or dataset()) / "sequences").iterdir())]


def gaussian_pulse_s(bandwidth_hz):
    """int |s|^2 dt / max |s|^2 of the pulse with the spectrum exp(-(pi x)^2) T(x), x = (f - f_c)/b."""
    x, step = np.linspace(-0.5, 0.5, 100_001, retstep=True)
    edge = np.clip((np.abs(x) - 0.4) / 0.1, 0, 1)
    spectrum = np.exp(-(np.pi * x) ** 2) * (1 + np.cos(np.pi * edge)) / 2
    return (spectrum**2).sum() / (bandwidth_hz * step * spectrum.sum() ** 2)


class Case(unittest.TestCase):
    """What every format promises; a test of a format derives from it and says which."""

    format_name = None
    options = ()

    def test_the_same_data_set_gives_the_same_bytes(self):
        if self.format_name is None:
            self.skipTest("no format of its own")
        self.assertEqual(hashes(export(self.format_name, *self.options)),
                         hashes(export(self.format_name, *self.options)))
