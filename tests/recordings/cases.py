"""Data sets that the program makes of logs. ENSONIFY is the program."""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from ensonify_dataset import SonarDataset  # noqa: E402

PROGRAM = os.environ["ENSONIFY"]
RANDOM = np.random.default_rng(3)


def ensonify(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done.stderr


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def imported(self, log, name="log.bin", *options, out="data"):
        (self.folder / name).write_bytes(log)
        self.said = ensonify("import", self.folder / name, "-o", self.folder / out, "--height-px", 200, *options)
        ensonify("verify", self.folder / out)
        return SonarDataset(self.folder / out)
