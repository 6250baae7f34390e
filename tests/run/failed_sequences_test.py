"""Sequences that cannot be made: exit status, summary, verify, a run of a sweep, and what the start of
very many sequences takes.

ENSONIFY is the program.
"""
import json
import os
import pathlib
import signal
import subprocess
import time

from program import PROGRAM, Case, hashes, run

CROWDED = """ensonify: 1
name: crowded
seed: 3
sequences: 12
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 8}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: floor, class: floor, material: m, shape: {box: {size_m: [6, 6, 0.2]}}, pose: {position_m: [2, 0, -0.8]}}
  - name: ball
    count: {uniform: [1, 5]}
    class: ball
    material: m
    shape: {sphere: {radius_m: 0.3}}
    place: {on: floor, area_m: [[1.2, -0.5], [2.2, 0.5]], clearance_m: 0.1, on_failure: skip_sequence}
trajectory: {ping_rate_hz: 5, pings: 1}
output: {cartesian: false}
"""


MESHES = """ensonify: 1
name: meshes
sequences: 3
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 3, beams: {count: 8, fov_deg: 24}, rays: {elevation: 8}}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: leaf, class: leaf, material: m, shape: {mesh: {file: leaf.obj, scale: {uniform: [0.5, 1]}}},
     pose: {position_m: [2, 0, 0]}}
trajectory: {pings: 1}
output: {cartesian: false}
"""
# Ends as the system ends a process for want of memory, once.
KILLED = """#!/bin/sh
if mkdir {folder}/killed 2>/dev/null; then kill -9 $$; fi
exec {importer} "$@"
"""


class Meshes(Case):
    def test_a_reader_that_somebody_kills_is_no_fault_of_the_file(self):
        self.scenario.write_text(MESHES)
        (self.folder / "leaf.obj").write_text("v 0 -1 -1\nv 0 1 -1\nv 0 0 1\nf 1 2 3\n")
        importer = self.folder / "companions/ensonify_import"
        importer.parent.mkdir()
        own = pathlib.Path(PROGRAM).with_name("ensonify_import")
        importer.write_text(KILLED.format(folder=self.folder, importer=own))
        importer.chmod(0o755)
        words = [PROGRAM, "generate", self.scenario, "-o", self.folder / "out"]
        environment = {**os.environ, "ENSONIFY_COMPANIONS": str(importer.parent)}
        killed = subprocess.run(words, capture_output=True, text=True, env=environment)
        self.assertEqual(killed.returncode, 4, killed.stderr)
        self.assertIn("ended from outside", killed.stderr)
        made = subprocess.run(words, capture_output=True, text=True, env=environment)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertNotIn("failed", json.loads((self.folder / "out/dataset.json").read_text()))


class Crowded(Case):
    def setUp(self):
        super().setUp()
        self.scenario.write_text(CROWDED)
        self.out = self.folder / "out"

    def test_failures_are_told_and_the_exit_status_is_3(self):
        made = run("generate", self.scenario, "-o", self.out)
        self.assertEqual(made.returncode, 3, made.stderr)
        failed = json.loads((self.out / "dataset.json").read_text())["failed"]
        self.assertIn(f"{12 - len(failed)} pings in {12 - len(failed)} sequences\n", made.stderr)
        told = f"{len(failed)} of 12 sequences could not be made\n"
        self.assertIn(told, made.stderr)
        for failure in failed:
            self.assertIn(f"  sequence {failure['sequence']}: {failure['error']}", made.stderr)
            self.assertNotIn(str(self.folder), failure["error"])

        verified = run("verify", self.out)
        self.assertEqual(verified.returncode, 0, verified.stderr)
        self.assertIn(told, verified.stderr)

        before = hashes(self.out)
        again = run("generate", self.scenario, "-o", self.out)
        self.assertEqual(again.returncode, 3, again.stderr)
        self.assertIn(told, again.stderr)
        self.assertEqual(hashes(self.out), before)

    def test_a_folder_without_any_sequence_is_no_data_set(self):
        run("generate", self.scenario, "-o", self.out)
        failed = json.loads((self.out / "dataset.json").read_text())["failed"][0]["sequence"]
        alone = run("generate", self.scenario, "-o", self.folder / "alone", "--sequences",
                    f"{failed}:{failed + 1}")
        self.assertEqual(alone.returncode, 2, alone.stderr)
        self.assertIn("no data set was made: 1 of 1 sequence could not be made", alone.stderr)
        self.assertFalse((self.folder / "alone/dataset.json").exists())

    def test_a_sequence_is_the_same_however_it_is_asked_for(self):
        """With the others, alone, and in a run of a sweep; of seeds for which sequence 0 fails."""
        seeds, sets = [], {}
        for seed in range(3, 40):
            sets[seed] = self.folder / str(seed)
            made = run("generate", self.scenario, "-o", sets[seed], "--set", "sequences=3", "--seed", seed)
            if made.returncode == 3 and not (sets[seed] / "sequences/000000").exists():
                seeds.append(seed)
            if len(seeds) == 2:
                break
        sweep = self.folder / "sweep.yaml"
        sweep.write_text(f"ensonify_sweep: 1\nname: s\nbase: small.yaml\nset: {{sequences: 3}}\nseeds: {seeds}\n")
        swept = run("sweep", sweep, "-o", self.out)
        self.assertEqual(swept.returncode, 3, swept.stderr)
        plan = {run["seed"]: run["run"] for run in map(json.loads, (self.out / "plan.jsonl").read_text().splitlines())}
        self.assertEqual(run("check", self.scenario, "--set", "sequences=3", "--seed", seeds[0]).returncode, 3)
        for seed in seeds:
            possible = [k for k in range(3) if (sets[seed] / f"sequences/{k:06}").exists()]
            for k in range(3):
                alone = self.folder / f"{seed}_{k}"
                made = run("generate", self.scenario, "-o", alone, "--set", "sequences=3", "--seed", seed,
                           "--sequences", f"{k}:{k + 1}")
                self.assertEqual(made.returncode, 0 if k in possible else 2, made.stderr)
                in_sweep = self.out / "runs" / plan[seed] / f"sequences/{k:06}"
                self.assertEqual(in_sweep.exists(), k in possible)
                if k in possible:
                    expected = hashes(sets[seed] / f"sequences/{k:06}")
                    self.assertEqual(hashes(alone / f"sequences/{k:06}"), expected)
                    self.assertEqual(hashes(in_sweep), expected)

    def test_an_input_file_that_is_gone_is_no_failure_of_a_sequence(self):
        """The file disappears while sequences are made: the run ends, and goes on once it is back."""
        mesh = self.folder / "tetrahedron.obj"
        text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
        mesh.write_text(text)
        self.scenario.write_text(CROWDED.replace("count: {uniform: [1, 5]}", "count: 1").replace(
            "sphere: {radius_m: 0.3}", "mesh: {file: tetrahedron.obj, scale: {uniform: [0.1, 0.2]}}"))
        arguments = ("generate", self.scenario, "-o", self.out, "--set", "sequences=3000")
        with subprocess.Popen([PROGRAM, *map(str, arguments)], stderr=subprocess.PIPE, text=True) as process:
            while not list(self.out.glob("sequences/*/sequence.json")):
                self.assertIsNone(process.poll())
                time.sleep(0.01)
            mesh.unlink()
            self.assertIn("tetrahedron.obj", process.communicate()[1])
            self.assertEqual(process.returncode, 4)
        self.assertEqual(list(self.out.glob(".work/sequences/*/failure.json")), [])
        mesh.write_text(text)
        done = run(*arguments[:-1], "sequences=3000", "--sequences", "0:20")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_run_of_a_sweep_that_lacks_sequences_has_failed(self):
        sweep = self.folder / "sweep.yaml"
        sweep.write_text("ensonify_sweep: 1\nname: s\nbase: small.yaml\naxes:\n"
                         "  - {name: radius, key: objects.1.shape.sphere.radius_m, values: [0.02, 0.3]}\n")
        for _ in range(2):
            done = run("sweep", sweep, "-o", self.out)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("of 12 sequences could not be made", done.stderr)
        failures = list(self.out.glob("failed/*.json"))
        self.assertEqual(len(failures), 1)
        self.assertEqual(json.loads(failures[0].read_text())["kind"], "usage")
        self.assertEqual(len(list(self.out.glob("runs/*/dataset.json"))), 1)


class VeryMany(Case):
    def seconds_and_memory(self, sequences):
        """Of the processor until the first ping is there; the highest memory in kB by then."""
        out = self.folder / str(sequences)
        with subprocess.Popen([PROGRAM, "generate", str(self.scenario), "-o", str(out), "--quiet", "--threads",
                               "1", "--ignore-free-space", "--set", f"sequences={sequences}"]) as process:
            while not list(out.glob(".work/sequences/*/000*.json")) + list(out.glob("sequences/*/sequence.json")):
                self.assertIsNone(process.poll())
                time.sleep(0.005)
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            times = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]
            process.send_signal(signal.SIGKILL)
        seconds = sum(map(int, times)) / os.sysconf("SC_CLK_TCK")
        peak = next(line for line in status.splitlines() if line.startswith("VmHWM"))
        return seconds, int(peak.split()[1])

    def test_a_million_sequences_begin_like_a_hundred(self):
        self.scenario.write_text(CROWDED.replace("count: {uniform: [1, 5]}", "count: {uniform: [1, 2]}"))
        _, few = self.seconds_and_memory(100)
        seconds, many = self.seconds_and_memory(1_000_000)
        self.assertLess(seconds, 10)
        self.assertLess(many, few + 8_000)
