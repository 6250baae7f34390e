"""The program under test, a small scenario, and data sets that are made once, for tests of every folder that start it.

ENSONIFY is the program, SCENES the folder of scenes.
"""
import atexit
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

# The reader of data sets, and readers of another hand.
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "tests/independent")]

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


def used_s(process):
    """Processor time until now; that of the clock depends on what else the machine does."""
    try:
        fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    except (OSError, IndexError):
        return float("inf")
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def settings(*pairs):
    return [word for pair in pairs for word in ("--set", pair)]


def scratch(text=None):
    """A new folder, with the scenario if one is given."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    if text is not None:
        (folder / "scenario.yaml").write_text(text)
    return folder


def fresh(text, *options):
    """The folder of a new data set of the scenario, which `verify` has looked at."""
    folder = scratch(text)
    for words in (["generate", folder / "scenario.yaml", "-o", folder / "set", "--quiet", *options],
                  ["verify", folder / "set"]):
        result = run(*words)
        assert result.returncode == 0, result.stdout + result.stderr
    return folder / "set"


_made = {}


def made(text, *options):
    """As fresh, at the first call with these arguments: all tests of a process share it and leave it as it is."""
    if (text, options) not in _made:
        _made[text, options] = fresh(text, *options)
    return _made[text, options]


def swept():
    """The folder of a sweep of eight tiny runs, made at the first call, and left as it is."""
    if "sweep" not in _made:
        _made["sweep"] = scratch() / "sweep"
        result = run("sweep", ROOT / "tests/report/scenes/sweep.yaml", "-o", _made["sweep"], "--quiet")
        assert result.returncode == 0, result.stderr
    return _made["sweep"]


def hashes(path):
    """SHA-256 of every file of a folder but provenance.json, by relative name; of a file alone, its own."""
    files = [path] if path.is_file() else sorted(path.rglob("*"))
    return {
        str(file.relative_to(path)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in files
        if file.is_file() and file.name != "provenance.json"
    }


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scenario = self.folder / "small.yaml"
        self.scenario.write_text(SMALL)
