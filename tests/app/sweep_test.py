"""Running sweeps from outside: shards, kills, interrupts, failing runs, what is told and finished.

ENSONIFY is the program. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCHEMAS=output_schema python3 -m unittest sweep_test
"""
import csv
import hashlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SCHEMAS = pathlib.Path(os.environ.get("SCHEMAS", "output_schema"))

# 64 beams of some hundred samples.
BASE = """ensonify: 1
name: small
seed: 5
sonar: {preset: blueview_p900_90, range_max_m: 4, bandwidth_hz: 1e4, beams: {count: 64, fov_deg: 45},
        rays: {elevation: 4, azimuth: 64}}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: ball, material: m, shape: {sphere: {radius_m: 0.5}}, pose: {position_m: [3, 0, 0]}}
  - {name: wall, material: m, shape: {box: {size_m: [8, 8, 4], inside: true}}}
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
# A file that is there and holds no mesh is found when a world is built.
FAILING = """ensonify_sweep: 1
name: failing
base: base.yaml
axes:
  - {key: objects.ball.shape.mesh.file, name: file, values: [good.obj, bad.obj]}
  - {key: sonar.range_max_m, values: [3, 4]}
"""
TRIANGLE = "v 3 -1 -1\nv 3 1 -1\nv 3 0 1\nf 1 2 3\n"


def environment(**more):
    plain = {key: value for key, value in os.environ.items() if not key.startswith("SLURM_")}
    return {**plain, **more}


def run(*words, **more):
    return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False,
                          env=environment(**more))


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
            if path.is_file() and path.name != "provenance.json"}


def table(folder):
    return list(csv.DictReader((folder / "runs.csv").read_text().splitlines()))


class SweepTest(unittest.TestCase):
    sweep_text = SWEEP

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
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

    def whole(self):
        """The folder that one process makes and finishes, in one go."""
        out = self.folder / "whole"
        self.go("--quiet", out=out)
        self.go("--finalize", "--quiet", out=out)
        return contents(out)


class Running(SweepTest):
    def test_each_run_is_the_data_set_of_its_scenario(self):
        self.go("--quiet")
        plan = self.plan()
        self.assertEqual(len(plan), 12)
        self.assertEqual(sorted(path.name for path in (self.out / "runs").iterdir()),
                         sorted(line["run"] for line in plan))
        line = plan[7]
        self.assertEqual(line["values"], {"range_max_m": 3.5, "noise_db": 30, "pings": 3})
        alone = self.folder / "alone"
        made = run("generate", self.folder / "base.yaml", "-o", alone, "--quiet",
                   "--set", "sonar.range_max_m=3.5", "--set", "noise.spectrum_level_db=30",
                   "--set", "trajectory.pings=3")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(contents(self.out / "runs" / line["run"]), contents(alone))
        for line in plan:
            verified = run("verify", self.out / "runs" / line["run"])
            self.assertEqual(verified.returncode, 0, verified.stderr)

    def test_any_shards_and_threads_give_the_same_bytes(self):
        expected = self.whole()
        for shard in [3, 0, 4, 1, 2]:
            self.go("--quiet", "--shard", f"{shard}/5", "--threads", shard + 1)
        self.go("--finalize", "--quiet")
        self.assertEqual(contents(self.out), expected)

    def test_what_is_done_is_not_made_again(self):
        self.go("--quiet")
        before = {path: path.stat().st_mtime_ns for path in self.out.rglob("*")}
        again = self.go()
        self.assertIn("nothing to do", again.stderr)
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.out.rglob("*")
                          if path != self.out}, {path: t for path, t in before.items()})

    def test_an_enlarged_sweep_keeps_what_is_done(self):
        self.go("--quiet")
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
        for number in [signal.SIGKILL, signal.SIGTERM] * 6:
            process = subprocess.Popen([PROGRAM, "sweep", self.sweep, "-o", self.out],
                                       stderr=subprocess.PIPE, text=True, env=environment())
            # Until some more files are there than the last one left.
            goal = self.files() + draw.randrange(1, 30)
            while process.poll() is None and self.files() < goal:
                time.sleep(0.0005)
            process.send_signal(number)
            said = process.communicate()[1]
            codes.append(process.returncode)
            if codes[-1] == 130:
                self.assertIn("goes on", said)
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
                for _ in range(3)]
        for process in both:
            said = process.communicate()[1]
            self.assertEqual(process.returncode, 0, said)
        self.go("--quiet")
        self.go("--finalize", "--quiet")
        self.assertEqual(contents(self.out), expected)


class Failures(SweepTest):
    sweep_text = FAILING

    def setUp(self):
        super().setUp()
        (self.folder / "good.obj").write_text(TRIANGLE)
        (self.folder / "bad.obj").write_text("this is no mesh\n")
        text = BASE.replace("shape: {sphere: {radius_m: 0.5}}", "shape: {mesh: {file: good.obj}}")
        (self.folder / "base.yaml").write_text(text)

    def failed(self):
        return [line["run"] for line in self.plan() if line["values"]["file"] == "bad.obj"]

    def test_a_failing_run_is_recorded_and_the_rest_go_on(self):
        said = self.go(expect=3)
        self.assertIn("2 of 4 runs failed", said.stderr)
        self.assertRegex(said.stderr, r"s\.yaml:5:.*bad\.obj.*\(run file=bad\.obj,range_max_m=3 and 1 more\)")
        for line in self.plan():
            folder = self.out / "runs" / line["run"]
            record = self.out / "failed" / f"{line['run']}.json"
            if line["run"] in self.failed():
                reason = json.loads(record.read_text())
                self.assertEqual(list(reason), ["run", "name", "kind", "message", "host", "time_utc"])
                self.assertEqual((reason["run"], reason["name"]), (line["run"], line["name"]))
                self.assertIn(reason["kind"], ["usage", "io"])
                self.assertIn("bad.obj", reason["message"])
                self.assertFalse((folder / "dataset.json").exists())
            else:
                self.assertFalse(record.exists())
                self.assertEqual(run("verify", folder).returncode, 0)
        status = self.go("--status").stdout
        self.assertIn("failing: 4 runs: 2 done, 0 running, 2 failed, 0 missing\n", status)
        self.assertEqual(len(re.findall(r"^failed: [0-9a-f]{16} file=bad\.obj.*bad\.obj", status, re.M)), 2)

    def test_failed_runs_are_tried_again(self):
        """Protects the morning: the same command makes what another disk or node can make."""
        folder = self.folder / "blocked"
        self.go("--quiet", expect=3)
        good = next(line["run"] for line in self.plan() if line["run"] not in self.failed())
        # Somebody's file where a run's folder should be: that run alone fails.
        shutil.rmtree(self.out)
        (self.out / "runs").mkdir(parents=True)
        (self.out / "runs" / good).write_text("mine")
        self.assertIn("3 of 4 runs failed", self.go("--quiet", expect=3).stderr)
        self.assertEqual(json.loads((self.out / "failed" / f"{good}.json").read_text())["kind"], "io")
        (self.out / "runs" / good).rename(folder)
        self.assertIn("2 of 3 runs failed", self.go("--quiet", expect=3).stderr)
        self.assertFalse((self.out / "failed" / f"{good}.json").exists())

    def test_finalize_refuses_missing_runs_unless_told(self):
        self.go("--quiet", expect=3)
        refused = self.go("--finalize", expect=2)
        self.assertIn("2 of 4 runs are not done (2 failed, 0 running, 0 missing)", refused.stderr)
        self.assertFalse((self.out / "runs.csv").exists())
        self.go("--finalize", "--partial", "--quiet")
        index = json.loads((self.out / "index.json").read_text())
        self.assertFalse(index["complete"])
        self.assertEqual([entry["run"] for entry in index["failed"]], self.failed())
        self.assertEqual({entry["status"] for entry in index["runs"]}, {"done", "failed"})
        rows = table(self.out)
        self.assertEqual([row["status"] for row in rows], ["done", "done", "failed", "failed"])
        self.assertEqual(rows[2]["mean_level_db"], "")

    def test_files_are_as_their_schemas_say(self):
        import jsonschema
        self.go("--quiet", expect=3)
        self.go("--finalize", "--partial", "--quiet")
        files = {"sweep": [self.out / "sweep.json"], "sweep_index": [self.out / "index.json"],
                 "failed_run": sorted((self.out / "failed").iterdir())}
        for schema, paths in files.items():
            validator = jsonschema.Draft7Validator(
                json.loads((SCHEMAS / f"{schema}.schema.json").read_text()))
            for path in paths:
                validator.validate(json.loads(path.read_text()))
                self.assertFalse(validator.is_valid({**json.loads(path.read_text()), "more": 1}))
        self.assertEqual(len(files["failed_run"]), 2)

    def test_an_input_that_changes_after_the_plan_is_no_run_of_it(self):
        """Protects ids: data made of another mesh must not stand under the old id."""
        before = self.go("--quiet", expect=3)
        self.assertIn("bad.obj", before.stderr)
        old = {line["run"] for line in self.plan()}
        (self.folder / "bad.obj").write_text(TRIANGLE.replace("v 3", "v 2"))
        changed = self.go("--quiet", expect=2)
        self.assertIn("2 of its 4 runs are not in this one", changed.stderr)
        self.go("--quiet", "--overwrite")
        self.assertEqual(len({line["run"] for line in self.plan()} - old), 2)


class Telling(SweepTest):
    def test_status_follows_the_files(self):
        self.assertIn("no sweep has begun", self.go("--status", expect=2).stderr)
        self.go("--quiet", "--shard", "0/2")
        first = self.go("--status").stdout
        done = len(list((self.out / "runs").iterdir()))
        self.assertIn(f"small: 12 runs: {done} done, 0 running, 0 failed, {12 - done} missing\n", first)
        self.assertRegex(first, r"\d+ of 24 pings, [0-9.e+]+ pings/s, ")
        part = self.go("--status", "--shard", "0/2").stdout
        self.assertIn(f"small: {done} runs: {done} done, 0 running, 0 failed, 0 missing\n", part)
        # A run that is under way: one ping of three has its record.
        run_id = next(line["run"] for line in self.plan() if line["pings"] == 3 and
                      not (self.out / "runs" / line["run"]).exists())
        folder = self.out / "runs" / run_id
        (folder / ".work/sequences/000000").mkdir(parents=True)
        (folder / "work.json").write_text("{}")
        (folder / ".work/sequences/000000/000001.json").write_text("{}")
        (folder / ".work/sequences/000000/plan.json").write_text("{}")
        before = int(re.search(r"(\d+) of 24", first)[1])
        text = self.go("--status").stdout
        self.assertIn(f"{done} done, 1 running, 0 failed, {11 - done} missing\n", text)
        self.assertIn(f"\n{before + 1} of 24 pings", text)
        old = time.time() - 3600
        for path in [folder / "work.json", folder / ".work/sequences/000000/000001.json"]:
            os.utime(path, (old, old))
        self.assertIn("1 of the running wrote nothing for 10 min", self.go("--status").stdout)

    def test_the_table_tells_what_the_files_tell(self):
        """Its numbers against arrays that NumPy reads."""
        import numpy as np
        expected = self.whole()
        out = self.folder / "whole"
        rows = table(out)
        self.assertEqual(list(rows[0])[:8], ["run", "name", "range_max_m", "noise_db", "axis_pings",
                                             "seed", "pings", "folder"])
        for row, line in zip(rows, self.plan(out), strict=True):
            self.assertEqual((row["run"], row["seed"], row["axis_pings"], row["status"]),
                             (line["run"], "5", str(line["values"]["pings"]), "done"))
            sequence = out / row["folder"] / "sequences/000000"
            power = np.abs(np.stack([np.load(path).astype(complex)
                                     for path in sorted(sequence.glob("timeseries/*.npy"))])) ** 2
            self.assertAlmostEqual(float(row["mean_level_db"]), 120 + 10 * np.log10(power.mean()), 3)
            self.assertAlmostEqual(float(row["max_level_db"]), 120 + 10 * np.log10(power.max()), 3)
            self.assertAlmostEqual(float(row["first_return_m"]),
                                   np.nanmean(np.load(sequence / "first_return_m.npy").astype(float)), 4)
            noise = json.loads((sequence / "sequence.json").read_text())["noise"]["power_pa2"]
            self.assertAlmostEqual(float(row["noise_level_db"]), 120 + 10 * np.log10(noise), 3)
            lines = [json.loads(text) for text in (sequence / "annotations.jsonl").read_text().splitlines()]
            areas = [sum(a["area"] for a in text["images"][0]["annotations"]) for text in lines]
            self.assertAlmostEqual(float(row["labelled_px"]), np.mean(areas), 2)
            seen = {a["instance"] for text in lines for image in text["images"] for a in image["annotations"]}
            self.assertEqual(int(row["instances"]), len(seen))
            self.assertEqual((row["contrast"], row["contrast_se"]), ("", ""))
        index = json.loads(expected["index.json"])
        self.assertTrue(index["complete"])
        self.assertEqual(index["plan_sha256"], hashlib.sha256(expected["plan.jsonl"]).hexdigest())
        for entry in index["runs"]:
            self.assertEqual(entry["dataset_sha256"],
                             hashlib.sha256(expected[entry["folder"] + "/dataset.json"]).hexdigest())

    def test_levels_of_pictures_where_no_series_are_kept(self):
        for word, places in [("", 0.005), ("timeseries: none, ", 0.05)]:
            (self.folder / "base.yaml").write_text(BASE.replace("output: {", "output: {" + word))
            out = self.folder / f"out{len(word)}"
            self.go("--quiet", out=out)
            self.go("--finalize", "--quiet", out=out)
            rows = table(out)
            self.levels = getattr(self, "levels", [float(row["mean_level_db"]) for row in rows])
            for row, level in zip(rows, self.levels, strict=True):
                self.assertAlmostEqual(float(row["mean_level_db"]), level, delta=places)

    def test_contrast_of_speckle_studies(self):
        text = BASE.replace("output: {", "output: {statistics: true, pings: false} #")
        (self.folder / "base.yaml").write_text(text.replace("pings: 2", "pings: 200"))
        self.sweep.write_text("ensonify_sweep: 1\nbase: base.yaml\nseeds: 3\n")
        self.go("--quiet")
        self.go("--finalize", "--quiet")
        for row in table(self.out):
            contrast, error = float(row["contrast"]), float(row["contrast_se"])
            self.assertLess(error, 0.02)
            # 1 - 1/n is the mean of the contrast of developed speckle.
            self.assertAlmostEqual(contrast, 1 - 1 / 200, delta=5 * error)


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
  - {key: sonar.rays.per_cell, values: [0, 5]}
  - {key: materials.m.reflectivity, values: [1e-3, 1e-2]}
seeds: [5, 6]
skip_if: ["speckle == 1 && per_cell > 0"]
""")
        self.go("--quiet")
        for i, line in enumerate(self.plan()):
            alone = self.folder / f"alone{i}"
            values = line["values"]
            made = run("generate", self.folder / "base.yaml", "-o", alone, "--quiet",
                       "--set", f"scattering.speckle={values['speckle']}",
                       "--set", f"sonar.rays.per_cell={values['per_cell']}",
                       "--set", f"materials.m.reflectivity={values['reflectivity']}",
                       "--seed", line["seed"])
            self.assertEqual(made.returncode, 0, made.stderr)
            self.assertEqual(contents(self.out / "runs" / line["run"]), contents(alone), line)


if __name__ == "__main__":
    unittest.main()
