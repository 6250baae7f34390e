"""200 runs: one shard and five, killed at random moments, end in the same bytes, and once they are
done nothing is done again.

ENSONIFY is the program. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify PYTHONPATH=scripts:tests/cli python3 -m unittest long_sweep_test
"""
import random
import signal
import subprocess
import time

import sweep_test


class TwoHundredRuns(sweep_test.SweepTest):
    sweep_text = """ensonify_sweep: 1
name: many
base: base.yaml
set: {trajectory.pings: 2}
axes:
  - {key: sonar.range_max_m, linear: [3, 4], count: 5}
  - {key: noise.spectrum_level_db, name: noise_db, uniform: [10, 40], count: 10}
  - {key: materials.m.reflectivity, values: [1e-3, 1e-2]}
seeds: 2
"""

    def test_shards_and_kills_end_in_the_same_bytes(self):
        expected = self.whole()
        self.assertEqual(len(self.plan(self.whole_folder())), 200)
        draw = random.Random(8)
        codes = []
        for shard in range(5):
            for number in [signal.SIGKILL, signal.SIGTERM, None]:
                process = subprocess.Popen(
                    [sweep_test.PROGRAM, "sweep", self.sweep, "-o", self.out, "--shard", f"{shard}/5", "--quiet"],
                    stderr=subprocess.PIPE, text=True, env=sweep_test.environment())
                if number is not None:
                    time.sleep(draw.uniform(0.2, 1.5))
                    process.send_signal(number)
                process.communicate()
                codes.append(process.returncode)
        self.assertEqual(codes[2::3], [0] * 5)
        self.assertIn(-signal.SIGKILL, codes)
        self.go("--finalize", "--quiet")
        self.assertEqual(sweep_test.contents(self.out), expected)
        self.assertIn("nothing to do: 200 of 200 runs done already", self.go().stderr)
