"""Running sweeps from outside: shards, kills, interrupts, second copies, full disks.

ENSONIFY is the program. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify PYTHONPATH=scripts:tests/cli python3 -m unittest sweep_test
"""
import csv
import hashlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import time
import unittest

import program
from program import PROGRAM, scratch

# 64 beams of some hundred samples.
BASE = """ensonify: 1
name: small
seed: 5
sonar: {preset: paper_table1, range_max_m: 4, bandwidth_hz: 1e4, beams: {count: 64, fov_deg: 45},
        rays: {elevation: 4, azimuth: 64}}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: ball, material: m, shape: {sphere: {radius_m: 0.5}}, pose: {position_m: [3, 0, 0]}}
  - {name: wall, material: m, shape: {box: {size_m: [8, 8, 4], inward_facing: true}}}
trajectory: {pings: 2}
noise: {spectrum_level_db: 30}
output: {cartesian: false, png: true, shadow: false, amodal: false}
"""
SWEEP = """ensonify_sweep: 1
name: small
base: base.yaml
axes:
  - {key: sonar.range_max_m, values: [3, 3.5, 4]}
  - {key: noise.spectrum_level_db, name: noise_db, values: [20, 30]}
  - {key: trajectory.pings, values: [1, 3]}
"""


def environment(**more):
    plain = {key: value for key, value in os.environ.items() if not key.startswith("SLURM_")}
    return {**plain, **more}


def run(*words, **more):
    return program.run(*words, env=environment(**more))


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
            if path.is_file() and path.name != "provenance.json"}


def table(folder):
    return list(csv.DictReader((folder / "runs.csv").read_text().splitlines()))


_whole = {}


class SweepTest(program.Case):
    sweep_text = SWEEP

    def setUp(self):
        super().setUp()
        (self.folder / "base.yaml").write_text(BASE)
        self.sweep = self.folder / "s.yaml"
        self.sweep.write_text(self.sweep_text)
        self.out = self.folder / "out"

    def go(self, *more, out=None, expect=0, **variables):
        done = run("sweep", self.sweep, "-o", out or self.out, *more, **variables)
        self.assertEqual(done.returncode, expect, done.stderr)
        return done

    def plan(self, out=None):
        lines = ((out or self.out) / "plan.jsonl").read_text().splitlines()
        return [json.loads(line) for line in lines]

    def whole_folder(self):
        """What one process makes and finishes, in one go: once for all tests, which leave it as it is."""
        if self.sweep_text not in _whole:
            out = scratch() / "out"
            self.go("--quiet", out=out)
            _whole[self.sweep_text] = out
        return _whole[self.sweep_text]

    def whole(self):
        return contents(self.whole_folder())

    def take_whole(self):
        """As if this test had made it."""
        shutil.copytree(self.whole_folder(), self.out)


class Running(SweepTest):
    def test_each_run_is_the_data_set_of_its_scenario(self):
        out = self.whole_folder()
        plan = self.plan(out)
        self.assertEqual(len(plan), 12)
        self.assertEqual(sorted(path.name for path in (out / "runs").iterdir()),
                         sorted(line["run"] for line in plan))
        line = plan[7]
        self.assertEqual(line["values"], {"range_max_m": 3.5, "noise_db": 30, "pings": 3})
        self.assertEqual(line["settings"], {"sonar.range_max_m": 3.5, "noise.spectrum_level_db": 30,
                                            "trajectory.pings": 3})
        alone = self.folder / "alone"
        made = run("generate", self.folder / "base.yaml", "-o", alone, "--quiet",
                   "--set", "sonar.range_max_m=3.5", "--set", "noise.spectrum_level_db=30",
                   "--set", "trajectory.pings=3")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(contents(out / "runs" / line["run"]), contents(alone))

    def test_any_shards_and_threads_give_the_same_bytes(self):
        expected = self.whole()
        for shard in [2, 0, 1]:
            self.go("--quiet", "--shard", f"{shard}/3", "--threads", shard + 1)
        self.go("--finalize", "--quiet")
        self.assertEqual(contents(self.out), expected)

    def test_what_is_done_is_not_made_again(self):
        self.take_whole()
        before = {path: path.stat().st_mtime_ns for path in self.out.rglob("*")}
        again = self.go()
        self.assertIn("nothing to do", again.stderr)
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.out.rglob("*")
                          if path != self.out}, {path: t for path, t in before.items()})

    def test_verify_looks_at_every_run(self):
        self.take_whole()
        whole = run("verify", self.out)
        self.assertEqual(whole.returncode, 0, whole.stderr)
        files = sum(path.is_file() for path in self.out.glob("runs/*/**/*") if path.name != "provenance.json")
        self.assertIn(f"{self.out}: complete and undamaged: {files} files, ", whole.stderr)
        damaged = sorted(self.out.glob("runs/*"))[-1] / "sequences/000000/range_m.npy"
        content = damaged.read_bytes()
        damaged.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
        found = run("verify", self.out)
        self.assertEqual(found.returncode, 1)
        self.assertIn(damaged.relative_to(self.out).as_posix(), found.stderr)

    def test_an_enlarged_sweep_keeps_what_is_done(self):
        self.take_whole()
        old = contents(self.out / "runs")
        self.sweep.write_text(SWEEP.replace("[3, 3.5, 4]", "[3, 3.5, 3.75, 4]"))
        grown = self.go()
        self.assertIn("4 of 16 runs to do, 8 pings", grown.stderr)
        now = contents(self.out / "runs")
        self.assertEqual({path: now[path] for path in old}, old)
        self.assertEqual(len(self.plan()), 16)
        # A smaller one would drop what is done.
        self.sweep.write_text(SWEEP.replace("[3, 3.5, 4]", "[3]"))
        refused = self.go(expect=2)
        self.assertIn("12 of its 16 runs are not in this one", refused.stderr)
        self.assertEqual(len(self.plan()), 16)
        self.go("--quiet", "--overwrite")
        self.assertEqual(len(self.plan()), 4)
        self.assertEqual(contents(self.out / "runs"), now)

    def test_tables_are_those_of_the_plan(self):
        def runs_told():
            index = json.loads((self.out / "index.json").read_text())
            self.assertTrue(index["complete"])
            self.assertEqual(index["plan_sha256"], hashlib.sha256((self.out / "plan.jsonl").read_bytes()).hexdigest())
            self.assertEqual(len(index["runs"]), len(table(self.out)))
            return len(index["runs"])

        self.take_whole()
        self.assertEqual(runs_told(), 12)
        old = (self.out / "index.json").read_bytes()
        # Grown by shards, which write no tables: those of the smaller plan are gone.
        self.sweep.write_text(SWEEP.replace("[3, 3.5, 4]", "[3, 3.5, 3.75, 4]"))
        self.go("--quiet", "--shard", "0/2")
        self.assertFalse((self.out / "runs.csv").exists() or (self.out / "index.json").exists())
        # Tables of a part are not kept when the rest is done, and neither are copies of older ones.
        self.go("--quiet", "--finalize", "--partial")
        self.assertFalse(json.loads((self.out / "index.json").read_text())["complete"])
        self.go("--quiet", "--shard", "1/2")
        self.go("--quiet")
        self.assertEqual(runs_told(), 16)
        (self.out / "index.json").write_bytes(old)
        self.go("--quiet")
        self.assertEqual(runs_told(), 16)
        # Runs that are dropped, with nothing left to make.
        self.sweep.write_text(SWEEP.replace("[3, 3.5, 4]", "[3]"))
        self.go("--quiet", "--overwrite")
        self.assertEqual(runs_told(), 4)
        # A kill between the two files.
        (self.out / "index.json").unlink()
        self.go("--quiet")
        self.assertEqual(runs_told(), 4)

    def test_set_overrides_the_base_of_every_run(self):
        """Protects what --set promises: runs have the bytes of a base that says the same, and another --set is
        another sweep."""
        louder = ["--set", "sonar.source_level_db=190"]
        self.go("--quiet", *louder)
        plan = self.plan()
        other = self.folder / "other"
        self.sweep.write_text(SWEEP + "set: {sonar.source_level_db: 190}\n")
        self.go("--quiet", out=other)
        self.assertEqual(contents(self.out), contents(other))
        self.sweep.write_text(SWEEP)
        self.assertIn("nothing to do", self.go(*louder).stderr)
        for more in ([], ["--set", "sonar.source_level_db=191"]):
            for what in ([], ["--list"]):
                with self.subTest(more=more, what=what):
                    refused = self.go(*more, *what, expect=2).stderr
                    self.assertIn("another sweep: 12 of its 12 runs are not in this one", refused)
        self.assertEqual(self.plan(), plan)

    def test_a_set_that_is_wrong_is_refused(self):
        for given, words in (("seed", "--set seed: no value; expected KEY.PATH=VALUE"),
                             ("sonar.nothing=1", "--set sonar.nothing: sonar.nothing"),
                             ("sonar.range_max_m=-1", "sonar.range_max_m: "),
                             ("trajectory.pings=2", "--set trajectory.pings: trajectory.pings: has no effect "
                                                    "with the axis `pings`")):
            with self.subTest(given=given):
                self.assertIn(words, self.go("--set", given, expect=2).stderr)
        self.assertFalse(self.out.exists())
        for what in ("--status", "--finalize"):
            self.go(what, "--set", "seed=1", expect=2)

    def test_faults_come_before_anything_is_written(self):
        self.sweep.write_text(SWEEP.replace("3.5", "-3.5"))
        self.assertIn("range_max_m", self.go(expect=2).stderr)
        self.assertFalse(self.out.exists())
        self.assertEqual(run("sweep", self.sweep).returncode, 2)
        self.sweep.write_text(SWEEP)
        self.go("--partial", expect=2)
        self.go("--list", "--status", expect=2)
        self.go("--shard", "5/5", expect=2)
        # A data set is no sweep's folder.
        run("generate", self.folder / "base.yaml", "-o", self.out, "--quiet")
        before = contents(self.out)
        self.assertIn("is a data set", self.go(expect=2).stderr)
        self.assertEqual(contents(self.out), before)

    def test_what_is_done_stays_as_it_is(self):
        """Protects finished runs of another instruction set, cut off before their last files went, from
        --overwrite too."""
        self.go("--quiet", "--simd", "sse4")
        before = contents(self.out)
        for folder in sorted((self.out / "runs").iterdir())[:3]:
            (folder / ".work/sequences/000000").mkdir(parents=True)
            (folder / ".work/sequences/000000/000000.json").write_text("{}")
        for more in ([], ["--overwrite"]):
            with self.subTest(more):
                self.go("--quiet", "--simd", "avx2", *more)
                self.assertEqual(contents(self.out), before)

    def test_list_refuses_what_the_sweep_would_refuse(self):
        """Protects submit.sh, which submits what --list accepts."""
        (self.folder / "foreign").mkdir()
        (self.folder / "foreign" / "thesis.txt").write_text("mine")
        (self.folder / "file").write_text("mine")
        run("generate", self.folder / "base.yaml", "-o", self.folder / "data", "--quiet")
        self.go("--quiet", "--shard", "0/12")
        head = self.out / "sweep.json"
        head.write_text(head.read_text().replace('"version": "', '"version": "9'))
        for out, status, words in (("foreign", 2, "contains other files"), ("file", 4, "Not a directory"),
                                   ("data", 2, "is a data set"), ("out", 2, "began this sweep")):
            for more in (["--list"], []):
                with self.subTest(out=out, more=more):
                    refused = self.go(*more, out=self.folder / out, expect=status)
                    self.assertIn(words, refused.stderr)
        self.go("--list", "--overwrite")

    def test_a_sweep_begun_by_another_program_is_refused(self):
        self.go("--quiet", "--shard", "0/3")
        head = self.out / "sweep.json"
        head.write_text(re.sub(r'"version": "[^"]*"', '"version": "0.0.0"', head.read_text()))
        self.assertIn("ensonify 0.0.0", self.go(expect=2).stderr)
        self.go("--quiet", "--overwrite")
        self.assertNotIn("0.0.0", head.read_text())


class Slurm(SweepTest):
    ARRAY = {"SLURM_ARRAY_TASK_MIN": "3", "SLURM_ARRAY_TASK_MAX": "5", "SLURM_ARRAY_TASK_COUNT": "3"}

    def test_a_task_of_an_array_makes_its_shard_and_says_so(self):
        expected = self.whole()
        for task in "345":
            said = self.go("--quiet", SLURM_ARRAY_TASK_ID=task, **self.ARRAY)
            self.assertIn(f"shard {int(task) - 3}/3, from the Slurm array, of 12 runs\n", said.stderr)
        self.go("--finalize", "--quiet", SLURM_ARRAY_TASK_ID="5", **self.ARRAY)
        self.assertEqual(contents(self.out), expected)

    def test_a_shard_that_is_given_counts_more(self):
        said = self.go("--shard", "0/12", SLURM_ARRAY_TASK_ID="4", **self.ARRAY)
        self.assertNotIn("Slurm", said.stderr)
        self.assertEqual(len(list((self.out / "runs").iterdir())), 1)

    def test_an_array_with_holes_is_refused(self):
        said = self.go(expect=2, SLURM_ARRAY_TASK_ID="7", **self.ARRAY)
        self.assertIn("--shard K/N", said.stderr)
        self.assertFalse(self.out.exists())


class Interrupts(SweepTest):
    def test_killed_and_interrupted_at_random_and_going_on(self):
        expected = self.whole()
        draw = random.Random(4)
        codes = []
        for number in [signal.SIGKILL, signal.SIGTERM] * 3:
            process = subprocess.Popen([PROGRAM, "sweep", self.sweep, "-o", self.out],
                                       stderr=subprocess.PIPE, text=True, env=environment())
            # Until some more files are there than the last one left.
            goal = self.files() + draw.randrange(1, 40)
            while process.poll() is None and self.files() < goal:
                time.sleep(0.002)
            process.send_signal(number)
            said = process.communicate()[1]
            codes.append(process.returncode)
            if codes[-1] == 130:
                self.assertIn("repeat the command to resume", said)
        self.assertIn(-signal.SIGKILL, codes)
        self.assertIn(130, codes)
        self.go("--quiet")
        self.go("--finalize", "--quiet")
        self.assertEqual(contents(self.out), expected)

    def files(self):
        return sum(len(names) for _, _, names in os.walk(self.out))

    def test_two_processes_at_once_on_the_same_shard(self):
        expected = self.whole()
        both = [subprocess.Popen([PROGRAM, "sweep", self.sweep, "-o", self.out, "--quiet"],
                                 stderr=subprocess.PIPE, text=True, env=environment())
                for _ in range(2)]
        for process in both:
            said = process.communicate()[1]
            self.assertEqual(process.returncode, 0, said)
        self.go("--quiet")
        self.go("--finalize", "--quiet")
        self.assertEqual(contents(self.out), expected)


class FullDisk(SweepTest):
    def test_a_full_disk_ends_everything_and_room_lets_it_go_on(self):
        """Protects the night: a disk that is full must not mark run after run as failed."""
        expected = self.whole()
        self.out.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", self.out],
                                 capture_output=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("mounting a small tmpfs needs root and the right to mount")
        self.addCleanup(subprocess.run, ["umount", self.out], check=False)
        self.assertIn("but only 1.0 MB is free", self.go("--quiet", expect=4).stderr)
        self.assertEqual(list(self.out.iterdir()), [])
        subprocess.run(["mount", "-o", "remount,size=2m", self.out], check=True)
        self.assertIn("No space left", self.go("--quiet", "--ignore-free-space", expect=4).stderr)
        self.assertFalse((self.out / "failed").exists())
        subprocess.run(["mount", "-o", "remount,size=200m", self.out], check=True)
        self.go("--quiet")
        self.go("--finalize", "--quiet")
        self.assertEqual(contents(self.out), expected)


class Sharing(SweepTest):
    def test_runs_of_one_world_and_of_many_have_the_bytes_of_runs_alone(self):
        """Protects what is shared: terrain, paths and places that are drawn from the seed must follow
        it, and nothing that hangs on the sonar may come from another run's world."""
        (self.folder / "base.yaml").write_text(BASE.replace("- {name: wall", """- name: sand
    material: m
    shape: {heightfield: {size_m: [8, 8], cell_m: 0.25, roughness: {rms_m: 0.1, exponent: 3.3, outer_scale_m: 4}}}
    pose: {position_m: [3, 0, -1]}
  - {name: wall"""))
        self.sweep.write_text("""ensonify_sweep: 1
base: base.yaml
axes:
  - {key: scattering.speckle, values: [per_ping, surface]}
  - {key: sonar.rays.min_per_cell, values: [0, 5]}
seeds: [5, 6]
skip_if: ["speckle == 1 && min_per_cell > 0"]
""")
        self.go("--quiet")
        for i, line in enumerate(self.plan()):
            alone = self.folder / f"alone{i}"
            values = line["values"]
            made = run("generate", self.folder / "base.yaml", "-o", alone, "--quiet",
                       "--set", f"scattering.speckle={values['speckle']}",
                       "--set", f"sonar.rays.min_per_cell={values['min_per_cell']}",
                       "--seed", line["seed"])
            self.assertEqual(made.returncode, 0, made.stderr)
            self.assertEqual(contents(self.out / "runs" / line["run"]), contents(alone), line)


if __name__ == "__main__":
    unittest.main()
