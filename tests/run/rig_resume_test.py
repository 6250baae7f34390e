"""Rigs that are killed and resumed, and a sweep over the instruments of one.

ENSONIFY is the program.
"""
import signal
import subprocess
import time

from program import PROGRAM, hashes, run
from rig_test import PAIR, RigCase, series


class Resume(RigCase):
    def test_killed_and_resumed(self):
        whole = hashes(self.make(PAIR, name="whole"))
        out = self.folder / "killed"
        for delay_s in (0.05, 0.15, 0.3):
            command = [PROGRAM, "generate", str(self.scenario), "-o", str(out), "--quiet"]
            process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
            time.sleep(delay_s)
            process.send_signal(signal.SIGKILL)
            process.wait()
        self.assertEqual(hashes(self.make(PAIR, name="killed")), whole)

    def test_a_sweep_over_instruments(self):
        self.scenario.write_text(PAIR)
        sweep = self.folder / "sweep.yaml"
        sweep.write_text("ensonify_sweep: 1\nbase: small.yaml\nset: {sequences: 1}\n"
                         "axes:\n  - {key: instrument, values: [left, right]}\n")
        done = run("sweep", sweep, "-o", self.folder / "runs", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(run("verify", self.folder / "runs").returncode, 0)
        whole = self.make(PAIR, "--sequences", "0:1")
        found = sorted(series(folder).tobytes() for folder in (self.folder / "runs/runs").iterdir())
        self.assertEqual(found, sorted(series(whole / name).tobytes() for name in ("left", "right")))


if __name__ == "__main__":
    import unittest

    unittest.main()
