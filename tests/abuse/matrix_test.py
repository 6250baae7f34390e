"""The same bytes whatever the threads, the shards and the interruptions; levels of SIMD apart.

Combinations are compared with one process, one thread, not interrupted, of the same level. At the processor's own
level each pair of values comes together in one of them; at the others, several threads and an interruption. Between
levels the echoes of one list agree to 1e-4 (tests/synthesis); a folder begun at one level is not continued at another.
"""
import json
import pathlib
import random
import signal
import time

from abused import FULL, Case, contents, run, start

# Threads, shards, interrupted.
ALONE = (1, 1, False)
PAIRS = [(1, 3, True), (2, 1, True), (2, 3, False), (8, 1, False), (8, 3, True)]
VALUES = [(8, 1, True)]
FLAGS = {"sse4": "sse4_1", "avx2": "avx2", "avx512": "avx512f"}


def levels():
    """Those that the processor has."""
    flags = pathlib.Path("/proc/cpuinfo").read_text().split()
    return [level for level, flag in FLAGS.items() if flag in flags]


class Matrix(Case):
    text = FULL.replace("pings: 12", "pings: 4")  # enough to be interrupted in, dealt out and finished

    def make(self, output, words, shards, interrupted, draw):
        parts = [[]] if shards == 1 else [["--shard", f"{number}/{shards}"] for number in range(shards)]
        for number, part in enumerate(draw.sample(parts, len(parts))):
            command = ["generate", self.scenario, "-o", output, "--quiet", *words, *part]
            if interrupted and number == 0:
                process = start(*command)
                goal = self.pings(output) + draw.randrange(1, 4)
                while process.poll() is None and self.pings(output) < goal:
                    time.sleep(0.001)
                process.send_signal(signal.SIGTERM)
                process.communicate()
                self.assertIn(process.returncode, (130, 0))
            self.assertEqual(run(*command).returncode, 0)
        if shards > 1:
            done = run("generate", self.scenario, "-o", output, "--quiet", *words, "--finalize")
            self.assertEqual(done.returncode, 0, done.stderr)

    @staticmethod
    def pings(output):
        return len(list(output.glob("sequences/*/timeseries/*")))

    def test_threads_shards_interruptions_and_simd(self):
        draw = random.Random(2)
        made = 0
        for level in levels():
            expected = None
            for threads, shards, interrupted in [ALONE, *(PAIRS if level == levels()[-1] else VALUES)]:
                output = self.folder / f"{level}_{threads}_{shards}_{interrupted}"
                words = ["--simd", level, "--threads", threads]
                self.make(output, words, shards, interrupted, draw)
                found = contents(output)
                expected = expected or found
                self.assertEqual(found, expected, output.name)
                made += 1
        print(f"{made} data sets of {len(expected)} files, levels {', '.join(levels())}: same bytes within each")

    def test_another_level_does_not_continue(self):
        first, *others = levels()
        for other in others:
            output = self.folder / f"begun_{other}"
            self.generate(output, "--simd", first, "--sequences", "0:1")
            before = contents(output)
            done = self.generate(output, "--simd", other, expect=2)
            self.assertIn("simd", done.stderr.lower())
            self.assertEqual(contents(output), before)
            self.generate(output, "--simd", first)
            numerics = json.loads((output / "dataset.json").read_text())["numerics"]
            self.assertTrue(numerics["simd"].startswith(first))


if __name__ == "__main__":
    import unittest

    unittest.main()
