"""Speckle studies from outside: kills, interrupts, two copies at once, memory, what is announced.

ENSONIFY is the program, SCENES the folder of scenes. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCENES=scenes PYTHONPATH=scripts:tests/cli python3 -m unittest statistics_test
"""
import os
import random
import re
import signal
import subprocess
import time
import unittest

from program import PROGRAM, SCENES, Case, hashes, run, used_s

SCENE = SCENES / "speckle_wall.yaml"
SMALL = ["--set", "sonar.beams={count: 20, fov_deg: 20}", "--set", "trajectory.pings=260"]


def generate(folder, *more):
    return [PROGRAM, "generate", SCENE, "-o", folder, *SMALL, *more]


class Statistics(Case):
    def whole(self, *more):
        made = run(*generate(self.folder / "whole", "--quiet", *more)[1:])
        self.assertEqual(made.returncode, 0, made.stderr)
        return hashes(self.folder / "whole")

    def test_killed_and_interrupted_runs_end_in_the_same_bytes(self):
        """Of pings without files: only checkpoints of their moments are kept."""
        pings = 1500 if os.environ.get("SANITIZED") else 10000
        many = ["--set", f"trajectory.pings={pings}", "--set", "sonar.beams={count: 64, fov_deg: 64}"]
        expected = self.whole(*many)
        draw = random.Random(3)
        output = self.folder / "stopped"
        codes, kept = [], 0
        for number in [signal.SIGTERM, signal.SIGKILL, signal.SIGINT, signal.SIGKILL, signal.SIGTERM]:
            process = subprocess.Popen(generate(output, *many), stderr=subprocess.PIPE, text=True)
            while process.poll() is None and not (output / "work.json").exists():
                time.sleep(0.001)
            goal_s = used_s(process) + draw.uniform(0.15, 0.3)
            while process.poll() is None and used_s(process) < goal_s:
                time.sleep(0.001)
            process.send_signal(number)
            message = process.communicate()[1]
            codes.append(process.returncode)
            if codes[-1] == 130:
                self.assertIn("repeat the command to resume", message)
                checkpoint = (output / ".work/sequences/000000/moments.bin").read_bytes()
                said = int(re.search(rb"count (\d+)\n", checkpoint)[1])
                self.assertGreaterEqual(said, kept)
                self.assertEqual(said % 8, 0)
                kept = said
        self.assertEqual(set(codes), {130, -signal.SIGKILL})
        self.assertGreater(kept, 0)
        self.assertEqual(list(output.glob(".work/sequences/*/0*.json")), [])
        last = run(*generate(output, *many)[1:])
        self.assertEqual(last.returncode, 0, last.stderr)
        self.assertIn(f"resuming: {kept} of {pings} pings already made", last.stderr)
        self.assertEqual(hashes(output), expected)

    def test_files_of_added_pings_that_went_are_made_again(self):
        """With pings: true; a kept block must not be added twice, nor its pings be missing."""
        keep = ["--set", "output={statistics: true, polar: false, cartesian: false, png: false}",
                "--set", "trajectory.pings=60"]
        expected = self.whole(*keep)
        output = self.folder / "stopped"
        checkpoint = output / ".work/sequences/000000/moments.bin"
        process = subprocess.Popen(generate(output, *keep), stderr=subprocess.DEVNULL)
        while process.poll() is None and not (checkpoint.parent / "000030.json").exists():
            time.sleep(0.001)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(), 130)
        self.assertTrue(checkpoint.exists())
        (output / "sequences/000000/timeseries/000001.npy").unlink()
        self.assertEqual(run(*generate(output, *keep)[1:]).returncode, 0)
        self.assertEqual(hashes(output), expected)
        self.assertEqual(run("verify", output).returncode, 0)

    def test_two_copies_at_once_end_in_one_data_set(self):
        expected = self.whole()
        both = [subprocess.Popen(generate(self.folder / "both", "--quiet")) for _ in range(2)]
        self.assertEqual([process.wait() for process in both], [0, 0])
        self.assertEqual(hashes(self.folder / "both"), expected)

    @unittest.skipIf(os.environ.get("SANITIZED"), "a sanitizer takes memory of its own")
    def test_memory_does_not_grow_with_the_realisations(self):
        taken = []
        for pings in (40, 400):
            process = subprocess.Popen(generate(self.folder / str(pings), "--quiet", "--threads", "2",
                                                "--set", f"trajectory.pings={pings}"))
            _, process.returncode, usage = os.wait4(process.pid, 0)
            self.assertEqual(process.returncode, 0)
            taken.append(usage.ru_maxrss * 1024)
        # 360 series more would be 28 MB.
        self.assertLess(taken[1] - taken[0], 10e6, taken)

    def test_files_are_announced(self):
        said = run("check", SCENE, *SMALL).stdout
        self.whole()
        files = [path for path in (self.folder / "whole").rglob("*") if path.is_file()]
        self.assertIn(f"# files: {len(files)}\n", said)
        number, unit = re.search(r"# disk: about ([\d.]+) ([kM])B", said).groups()
        announced = float(number) * {"k": 1e3, "M": 1e6}[unit]
        self.assertLess(abs(announced / sum(path.stat().st_size for path in files) - 1), 0.1)


if __name__ == "__main__":
    unittest.main()
