"""The program under test and a small scenario, for tests that start it.

ENSONIFY is the program, SCENES the folder of scenes.
"""
import hashlib
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SCENES = pathlib.Path(os.environ.get("SCENES", "scenes"))

SMALL = """ensonify: 1
name: small
seed: 7
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 4
  beams: {count: 64, fov_deg: 64}
  rays: {elevation: 16, min_per_cell: 12}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [7, 7, 2], inward_facing: true}}}
trajectory: {ping_rate_hz: 5, pings: 30}
output: {cartesian: {height_px: 100}}
"""


def run(*arguments, **options):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, **options)


def hashes(folder):
    """SHA-256 of every file but provenance.json, by relative name."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "provenance.json"
    }


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scenario = self.folder / "small.yaml"
        self.scenario.write_text(SMALL)
