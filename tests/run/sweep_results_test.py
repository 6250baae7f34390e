"""Sweeps from outside: failing runs, what is told, and the table that finishes one.

ENSONIFY is the program. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCHEMAS=output_schema PYTHONPATH=scripts:tests/cli python3 -m unittest sweep_results_test
"""
import hashlib
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import time
import unittest

from sweep_test import BASE, PROGRAM, SweepTest, environment, run, table

SCHEMAS = pathlib.Path(os.environ.get("SCHEMAS", "output_schema"))
# A file that is there and holds no mesh is found when a world is built.
FAILING = """ensonify_sweep: 1
name: failing
base: base.yaml
axes:
  - {key: objects.ball.shape.mesh.file, name: file, values: [good.obj, bad.obj]}
  - {key: sonar.range_max_m, values: [3, 4]}
"""
TRIANGLE = "v 3 -1 -1\nv 3 1 -1\nv 3 0 1\nf 1 2 3\n"


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
        verified = run("verify", self.out)
        self.assertEqual(verified.returncode, 1)
        self.assertTrue(verified.stderr.endswith(": 2 errors\n"), verified.stderr)
        self.assertEqual(len(re.findall(r"^.*runs/[0-9a-f]{16}: is not done \(file=bad\.obj", verified.stderr, re.M)), 2)
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

    def test_commands_for_data_sets_ask_for_a_run(self):
        self.go(expect=3)
        for command in (["figure", "-o", self.folder / "figure.png"], ["render", "--name", "x"]):
            said = run(command[0], self.out, *command[1:])
            self.assertEqual(said.returncode, 2)
            self.assertIn(f"a sweep; expected one of its runs, a folder of {self.out}/runs", said.stderr)

    def test_damaged_runs_are_told_and_left_out(self):
        """Protects tables: no row is worked out from half of a run's files, and the others have theirs."""
        self.sweep.write_text(FAILING.replace(", bad.obj", ""))
        self.go("--quiet")
        gone, whole = (self.out / "runs" / line["run"] for line in self.plan())
        for name in ("timeseries/000001.npy", "polar/000001.exr"):
            (gone / "sequences/000000" / name).unlink()
        (self.out / "runs.csv").unlink()
        refused = self.go("--finalize", expect=4)
        self.assertIn("1 of 2 runs are damaged; remove their folders", refused.stderr)
        self.assertIn(f"runs/{gone.name}: ", refused.stderr)
        self.assertFalse((self.out / "runs.csv").exists())
        self.assertIn("2 runs, 1 of them done", self.go("--finalize", "--partial").stderr)
        rows = {row["run"]: row for row in table(self.out)}
        self.assertEqual((rows[gone.name]["status"], rows[gone.name]["mean_level_db"]), ("damaged", ""))
        self.assertEqual(rows[whole.name]["status"], "done")
        index = json.loads((self.out / "index.json").read_text())
        self.assertEqual([(entry["run"], entry["kind"]) for entry in index["failed"]], [(gone.name, "damage")])
        self.assertFalse(index["complete"])
        shutil.rmtree(gone)
        self.go("--quiet")
        self.go("--finalize", "--quiet")
        self.assertTrue(json.loads((self.out / "index.json").read_text())["complete"])

    @unittest.skipIf(os.environ.get("SANITIZED"), "a sanitizer takes memory of its own")
    def test_a_run_without_memory_fails_alone(self):
        """Protects the night: one run that is too large is no reason to leave out all others."""
        huge = "{sonar.range_max_m: 60, sonar.beams.count: 1024, sonar.beams.receive_width_deg: 0.5, " \
               "sonar.rays.elevation: 1024}"
        (self.folder / "base.yaml").write_text(BASE)
        self.sweep.write_text("ensonify_sweep: 1\nname: failing\nbase: base.yaml\naxes:\n  - name: size\n"
                              f"    labels: [huge, small]\n    values: [{huge}, {{sonar.range_max_m: 3}}]\n")
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (700 << 20, 700 << 20))
        done = subprocess.run([PROGRAM, "sweep", self.sweep, "-o", self.out, "--quiet", "--threads", "1",
                               "--backend", "cpu"], capture_output=True, text=True, preexec_fn=limit,
                              env=environment())
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("1 of 2 runs failed", done.stderr)
        (failed,) = (self.out / "failed").iterdir()
        self.assertEqual(json.loads(failed.read_text())["kind"], "device")
        self.assertIn("2 runs: 1 done, 0 running, 1 failed, 0 missing", self.go("--status").stdout)

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
        fields = json.loads((SCHEMAS / "sweep_tables.json").read_text())["tables"]["runs.csv"]["fields"]
        names = [field["name"] for field in fields]
        columns = (self.out / "runs.csv").read_text().splitlines()[0].split(",")
        self.assertEqual(columns[:2] + columns[columns.index("seed"):], names)

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
        self.assertIn("not the folder of a sweep", self.go("--status", expect=2).stderr)
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
        self.assertIn("1 of the running runs wrote nothing for 10 min", self.go("--status").stdout)

    def test_the_table_tells_what_the_files_tell(self):
        """Its numbers against arrays that NumPy reads."""
        import numpy as np
        expected, out = self.whole(), self.whole_folder()
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

    def test_levels_of_statistics_are_of_all_sequences(self):
        import numpy as np
        text = BASE.replace("output: {", "output: {statistics: true, pings: false} #")
        (self.folder / "base.yaml").write_text(
            text.replace("reflectivity: 1e-3", "reflectivity: {log_uniform: [1e-4, 1e-1]}") + "sequences: 3\n")
        self.sweep.write_text("ensonify_sweep: 1\nbase: base.yaml\nseeds: 1\n")
        self.go("--quiet")
        [row] = table(self.out)
        arrays = [np.load(path) for path in self.out.glob("runs/*/sequences/*/statistics/mean_intensity.npy")]
        self.assertEqual(len(arrays), 3)
        for name, power in (("mean_level_db", np.mean(arrays)), ("max_level_db", np.max(arrays))):
            self.assertAlmostEqual(float(row[name]), 10 * np.log10(power) + 120, delta=0.01)
        self.assertGreater(np.ptp([np.log10(array.mean()) for array in arrays]), 0.1)

    def test_contrast_of_speckle_studies(self):
        text = BASE.replace("output: {", "output: {statistics: true, pings: false} #")
        (self.folder / "base.yaml").write_text(text.replace("pings: 2", "pings: 200"))
        self.sweep.write_text("ensonify_sweep: 1\nbase: base.yaml\nseeds: 3\n")
        self.go("--quiet")
        self.go("--finalize", "--quiet")
        for row in table(self.out):
            contrast, error = float(row["contrast"]), float(row["contrast_se"])
            self.assertLess(error, 0.02)
            self.assertAlmostEqual(contrast, 1, delta=5 * error)


if __name__ == "__main__":
    unittest.main()
