"""Runs that are killed or interrupted, second copies, full disks and folders of others.

Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCENES=scenes python3 -m unittest cut_off_test
"""
import random
import signal
import subprocess
import time
import unittest

from program import PROGRAM, Case, hashes, run


class CutOff(Case):
    """Runs that are cut off, and places that cannot be written."""

    def undisturbed(self):
        output = self.folder / "undisturbed"
        self.assertEqual(run("generate", self.scenario, "-o", output).returncode, 0)
        return hashes(output)

    @staticmethod
    def finished(records):
        return len(list(records.glob("*.json"))) if records.exists() else 0

    def test_killed_runs_end_in_the_same_bytes(self):
        expected = self.undisturbed()
        draw = random.Random(5)
        output = self.folder / "killed"
        records = output / ".work/sequences/000000"
        kills = 0
        for _ in range(6):
            process = subprocess.Popen([PROGRAM, "generate", self.scenario, "-o", output, "--quiet"])
            goal = self.finished(records) + draw.randrange(4)
            while process.poll() is None and self.finished(records) < goal:
                pass
            time.sleep(draw.uniform(0, 0.01))
            process.send_signal(signal.SIGKILL)
            kills += process.wait() == -signal.SIGKILL
        self.assertGreater(kills, 2)
        self.assertEqual(run("generate", self.scenario, "-o", output).returncode, 0)
        self.assertEqual(hashes(output), expected)
        self.assertEqual(run("verify", output).returncode, 0)

    def test_interrupt_finishes_the_ping_and_goes_on(self):
        expected = self.undisturbed()
        output = self.folder / "interrupted"
        for number in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([PROGRAM, "generate", self.scenario, "-o", output, "--quiet"],
                                       stderr=subprocess.PIPE)
            records = output / ".work/sequences/000000"
            deadline = time.monotonic() + 30
            found = self.finished(records)
            while time.monotonic() < deadline and process.poll() is None:
                if self.finished(records) > found:
                    break
            process.send_signal(number)
            message = process.communicate()[1].decode()
            self.assertEqual(process.returncode, 130, message)
            self.assertIn("repeat the command to resume", message)
        self.assertEqual(run("generate", self.scenario, "-o", output).returncode, 0)
        self.assertEqual(hashes(output), expected)

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

    def test_two_copies_at_once_end_in_one_data_set(self):
        expected = self.undisturbed()
        output = self.folder / "twice"
        both = [subprocess.Popen([PROGRAM, "generate", self.scenario, "-o", output, "--quiet"])
                for _ in range(2)]
        self.assertEqual([process.wait() for process in both], [0, 0])
        self.assertEqual(hashes(output), expected)

    def test_unwritable_folder(self):
        result = run("generate", self.scenario, "-o", "/proc/ensonify")
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("/proc/ensonify", result.stderr)
        file = self.folder / "file"
        file.write_text("not a folder")
        self.assertIn(run("generate", self.scenario, "-o", file / "out").returncode, (4,))

    def test_full_disk(self):
        mount = self.folder / "small_disk"
        mount.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", mount],
                                 capture_output=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("mounting a small tmpfs needs root and the right to mount")
        self.addCleanup(subprocess.run, ["umount", mount], check=False)
        output = mount / "out"
        result = run("generate", self.scenario, "-o", output)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("space", result.stderr.lower())
        # Room again: the same command goes on to the same bytes.
        subprocess.run(["mount", "-o", "remount,size=100m", mount], check=True)
        self.assertEqual(run("generate", self.scenario, "-o", output).returncode, 0)
        self.assertEqual(hashes(output), self.undisturbed())

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
