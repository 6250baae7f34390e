"""The same bytes whatever the threads, the shards and the interruptions; levels of SIMD apart.

Every combination is made and compared with one process, one thread, not interrupted, of the same level.
Between levels the echoes of one list agree to 1e-4 (tests/synthesis); a folder begun at one level is
not continued at another.
"""
import itertools
import json
import pathlib
import random
import signal
import time

from program import FULL, Case, contents, run, start

FLAGS = {"sse4": "sse4_1", "avx2": "avx2", "avx512": "avx512f"}


def levels():
    """Those that the processor has."""
    flags = pathlib.Path("/proc/cpuinfo").read_text().split()
    return [level for level, flag in FLAGS.items() if flag in flags]


class Matrix(Case):
    text = FULL.replace("pings: 12", "pings: 5")  # enough to be interrupted in, dealt out and finished

    def make(self, output, words, shards, interrupted, draw):
        parts = [[]] if shards == 1 else [["--shard", f"{number}/{shards}"] for number in range(shards)]
        for part in draw.sample(parts, len(parts)):
            command = ["generate", self.scenario, "-o", output, "--quiet", *words, *part]
            while interrupted:
                process = start(*command)
                time.sleep(draw.uniform(0.02, 0.3))
                process.send_signal(signal.SIGTERM)
                process.communicate()
                if process.returncode in (130, 0):
                    break
                # Told before it listened: the signal ended it as it ends any program.
                self.assertEqual(process.returncode, -signal.SIGTERM)
            self.assertEqual(run(*command).returncode, 0)
        if shards > 1:
            done = run("generate", self.scenario, "-o", output, "--quiet", *words, "--finalize")
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_threads_shards_interruptions_and_simd(self):
        draw = random.Random(2)
        made = 0
        for level in levels():
            expected = None
            for threads, shards, interrupted in itertools.product((1, 2, 4, 8), (1, 3), (False, True)):
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
