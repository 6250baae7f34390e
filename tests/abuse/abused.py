"""What the tests of this folder share: a small scenario, the program, and the bytes of a folder.

ENSONIFY is the program.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import program  # noqa: E402
from program import PROGRAM, hashes as contents, made  # noqa: E402,F401

# Two sequences of a world with noise, draws, masks and whatever else a data set can hold.
FULL = """ensonify: 1
name: abused
seed: 11
sonar:
  preset: blueview_p900_90
  range_max_m: 4
  beams: {count: 48, fov_deg: 60}
  elevation: {fan_deg: 20, shading: uniform}
  rays: {elevation: 12, min_per_cell: 8}
materials:
  m: {reflectivity: 1e-3}
  steel: {reflectivity: {log_uniform: [1e-2, 1e-1]}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [7, 7, 2], inward_facing: true}}}
  - name: ball
    class: target
    material: steel
    shape: {sphere: {radius_m: 0.3}}
    pose: {position_m: [{uniform: [1.5, 3]}, 0, 0]}
trajectory: {ping_rate_hz: 5, pings: 12}
noise: {spectrum_level_db: 30}
output: {cartesian: {height_px: 80}, points: true}
sequences: 3
"""


def run(*words, **options):
    # The limit ends what hangs, and is no measure: machines may be busy.
    return program.run(*words, **{"timeout": 1200, **options})


def start(*words):
    return subprocess.Popen([PROGRAM, *map(str, words)], stderr=subprocess.PIPE, text=True)


def errors_in(done):
    return sum(not line.startswith("warning: ") for line in done.stderr.splitlines())


def mount(case, folder, options):
    """A tmpfs, or the test is skipped."""
    folder.mkdir(exist_ok=True)
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder]
    if subprocess.run(command, capture_output=True, check=False).returncode != 0:
        case.skipTest("mounting a small tmpfs needs root and the right to mount")
    case.addCleanup(subprocess.run, ["umount", "-l", folder], check=False)


class Case(unittest.TestCase):
    text = FULL

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scenario = self.folder / "scenario.yaml"
        self.scenario.write_text(self.text)

    def generate(self, output, *more, expect=0, scenario=None, **options):
        done = run("generate", scenario or self.scenario, "-o", output, "--quiet", *more, **options)
        self.assertEqual(done.returncode, expect, done.stderr)
        return done

    def whole(self, *more):
        """The folder of an undisturbed run, made once for all tests of a program; nobody changes it."""
        return made(self.text, *more)

    def undisturbed(self, *more):
        return contents(self.whole(*more))
