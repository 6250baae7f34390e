"""Runs that are interrupted twice, and folders of others. Kills, second copies and full disks are in tests/abuse.

Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCENES=scenes PYTHONPATH=scripts:tests/cli python3 -m unittest cut_off_test
"""
import signal
import subprocess
import time
import unittest

from program import PROGRAM, Case, hashes, run


class CutOff(Case):
    @staticmethod
    def finished(records):
        return len(list(records.glob("*.json"))) if records.exists() else 0

    def test_a_signal_that_comes_twice_is_one(self):
        """Protects batch systems, which tell a script and its program at once: the ping in hand is finished."""
        output = self.folder / "told_twice"
        records = output / ".work/sequences/000000"
        process = subprocess.Popen([PROGRAM, "generate", self.scenario, "-o", output, "--quiet", "--threads", "1",
                                    "--backend", "reference"], stderr=subprocess.PIPE)
        while process.poll() is None and not self.finished(records):
            time.sleep(0.01)
        for _ in range(2):
            process.send_signal(signal.SIGTERM)
            time.sleep(0.05)
        message = process.communicate()[1].decode()
        self.assertEqual(process.returncode, 130, message)

    def test_unwritable_folder(self):
        result = run("generate", self.scenario, "-o", "/proc/ensonify")
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("/proc/ensonify", result.stderr)
        file = self.folder / "file"
        file.write_text("not a folder")
        self.assertIn(run("generate", self.scenario, "-o", file / "out").returncode, (4,))

    def test_overwrite_keeps_its_own_input(self):
        output = self.folder / "out"
        pings = ["--pings", "0:1"]
        self.assertEqual(run("generate", self.scenario, "-o", output, *pings).returncode, 0)
        before = hashes(output)
        result = run("generate", output / "scenario.yaml", "-o", output, "--seed", 5, "--overwrite",
                     *pings)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("the input file", result.stderr)
        self.assertEqual(hashes(output), before)

    def test_foreign_folder_is_not_touched(self):
        output = self.folder / "mine"
        output.mkdir()
        (output / "thesis.txt").write_text("years of work")
        for extra in ([], ["--overwrite"]):
            self.assertEqual(run("generate", self.scenario, "-o", output, *extra).returncode, 2)
            self.assertEqual([p.name for p in output.iterdir()], ["thesis.txt"])


if __name__ == "__main__":
    unittest.main()
