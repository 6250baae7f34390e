"""A sweep by GNU parallel, as docs/cluster.md has it: a shard that was killed is tried again, and one that
failed for good is taken up by the same command. Skips where parallel is not installed. ENSONIFY is the program.
"""
import pathlib
import shutil
import tempfile
import unittest

from slurm_test import PROGRAM, SCENARIO, SWEEP, hashes, run

# The first start of shard 1 is killed.
KILLED_ONCE = """#!/bin/sh
case " $* " in *" --shard 1/4 "*) mkdir %s 2>/dev/null && kill -KILL $$ ;; esac
exec %s "$@"
"""


@unittest.skipUnless(shutil.which("parallel"), "not installed: parallel")
class Parallel(unittest.TestCase):
    def test_shards_that_failed_are_tried_again(self):
        here = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-parallel-"))
        self.addCleanup(shutil.rmtree, here, ignore_errors=True)
        (here / "small_scene.yaml").write_text(SCENARIO.replace("pings: 80", "pings: 3"))
        sweep = here / "small.yaml"
        sweep.write_text(SWEEP)
        program = here / "ensonify"
        program.write_text(KILLED_ONCE % (here / "mark", PROGRAM))
        program.chmod(0o755)
        foreign = here / "out" / "runs" / run(PROGRAM, "sweep", sweep, "--list").stdout.splitlines()[3][:16]
        foreign.mkdir(parents=True)
        (foreign / "letter.txt").write_text("not a data set")

        def shards():
            return run(
                "parallel", "--jobs", "2", "--joblog", here / "joblog", "--resume-failed", "--retries", "2",
                program, "sweep", sweep, "-o", here / "out", "--shard", "{}/4", "--threads", "1", "--quiet",
                ":::", 0, 1, 2, 3,
            )

        self.assertEqual(shards().returncode, 1)  # one shard failed, twice
        self.assertTrue((here / "mark").exists())
        self.assertEqual(len((here / "joblog").read_text().splitlines()), 5)
        shutil.rmtree(foreign)
        self.assertEqual(shards().returncode, 0)
        self.assertEqual(len((here / "joblog").read_text().splitlines()), 6, "one shard again")
        for options in (["-o", here / "out", "--finalize"], ["-o", here / "alone"],
                        ["-o", here / "alone", "--finalize"]):
            self.assertEqual(run(PROGRAM, "sweep", sweep, *options).returncode, 0)
        self.assertEqual(hashes(here / "out"), hashes(here / "alone"))


if __name__ == "__main__":
    unittest.main()
