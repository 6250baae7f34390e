"""The program from outside: exit statuses, messages, interrupted runs, full disks.

ENSONIFY is the program, SCENES the folder of scenes. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCENES=scenes python3 -m unittest program_test
"""
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SCENES = pathlib.Path(os.environ.get("SCENES", "scenes"))

SMALL = """ensonify: 1
name: small
seed: 7
sonar:
  preset: blueview_p900_90
  range_max_m: 4
  beams: {count: 64, fov_deg: 64}
  rays: {elevation: 16, per_cell: 12}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [7, 7, 2], inside: true}}}
trajectory: {ping_rate_hz: 5, pings: 30}
output: {cartesian: {height_px: 100}}
"""


def run(*arguments, **options):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, **options)


def hashes(folder):
    """SHA-256 of every file but provenance.json, by relative name."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "provenance.json"
    }


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scenario = self.folder / "small.yaml"
        self.scenario.write_text(SMALL)


class WrongScenarios(Case):
    """Every class of wrong scenario ends with 2, names place and key, and writes nothing."""

    def refuse(self, text, *expected, name="wrong.yaml", mode="w"):
        file = self.folder / name
        with open(file, mode) as stream:
            stream.write(text)
        output = self.folder / "out"
        start = time.monotonic()
        result = run("generate", file, "-o", output, timeout=60)
        self.assertLess(time.monotonic() - start, 10, "took too long to refuse")
        self.assertEqual(result.returncode, 2, result.stderr)
        for part in expected:
            self.assertIn(part, result.stderr)
        self.assertFalse(output.exists(), "something was written")
        return result.stderr

    def test_unknown_key_with_the_nearest(self):
        self.refuse(SMALL.replace("range_max_m", "range_mx_m"), "wrong.yaml:6:3: sonar.range_mx_m",
                    "range_max_m")

    def test_key_given_twice(self):
        self.refuse(SMALL + "seed: 8\n", "wrong.yaml:14:1: seed", "twice")

    def test_wrong_type(self):
        self.refuse(SMALL.replace("pings: 30", "pings: many"), ":12:38: trajectory.pings", "many")

    def test_octal_looking_number(self):
        self.refuse(SMALL.replace("range_max_m: 4", "range_max_m: 010"), ":6:16: sonar.range_max_m",
                    "010")

    def test_negative_and_nan_numbers(self):
        text = SMALL.replace("reflectivity: 1e-3", "reflectivity: -1e-3")
        self.refuse(text, ":9:31: materials.m.reflectivity", "-1e-3")
        self.refuse(SMALL.replace("range_max_m: 4", "range_max_m: .nan"), "sonar.range_max_m")

    def test_missing_file(self):
        mesh = SMALL.replace("{box: {size_m: [7, 7, 2], inside: true}}", "{mesh: {file: gone.stl}}")
        self.refuse(mesh, "objects.0.shape.mesh.file", "gone.stl")
        self.assertEqual(run("generate", self.folder / "no.yaml", "-o", self.folder / "o").returncode, 2)

    def test_broken_mesh_and_path(self):
        (self.folder / "bad.stl").write_text("nothing")
        mesh = SMALL.replace("{box: {size_m: [7, 7, 2], inside: true}}", "{mesh: {file: bad.stl}}")
        self.refuse(mesh, "bad.stl")
        (self.folder / "bad.tum").write_text("1 2 3\n")
        self.refuse(SMALL.replace("{ping_rate_hz: 5, pings: 30}", "{file: bad.tum}"), "bad.tum:1")

    def test_wrong_pulse_table(self):
        (self.folder / "pulse.csv").write_text(
            "frequency_hz,amplitude,phase_deg\n890e3,1,0\n880e3,1,0\n900e3,loud,0\n")
        self.refuse(SMALL.replace("range_max_m: 4", "range_max_m: 4\n  pulse: {table: {file: pulse.csv}}"),
                    "sonar.pulse.table.file", "pulse.csv:3", "pulse.csv:4")

    def test_negative_absorption(self):
        self.refuse(SMALL + "water: {absorption: {fixed_db_m: -0.1}}\n",
                    "wrong.yaml:14:34: water.absorption.fixed_db_m", "-0.1")

    def test_grazing_table_with_gaps(self):
        (self.folder / "sand.csv").write_text("grazing_deg,strength_db\n0,-60\n10,\n20,-30\n60,-20\n")
        self.refuse(SMALL.replace("{reflectivity: 1e-3}", "{law: {table: {file: sand.csv}}}"),
                    "materials.m.law.table.file", "sand.csv:3", "sand.csv:5")

    def test_noise_against_a_signal_that_is_not_there(self):
        text = SMALL.replace("objects:", "noise: {snr_db: 20}\nobjects:")
        self.refuse(text.replace("range_max_m: 4", "range_max_m: 1"), "noise.snr_db", "ping 0")

    def test_all_broken_input_files_at_once(self):
        for name in ("a.stl", "b.stl"):
            (self.folder / name).write_text("nothing")
        (self.folder / "bad.tum").write_text("1 2 3\n")
        text = SMALL.replace("{box: {size_m: [7, 7, 2], inside: true}}", "{mesh: {file: a.stl}}")
        text = text.replace("trajectory:", "  - {name: b, material: m, shape: {mesh: {file: b.stl}}}\ntrajectory:")
        self.refuse(text.replace("{ping_rate_hz: 5, pings: 30}", "{file: bad.tum}"),
                    "objects.0.shape.mesh.file", "a.stl", "objects.1.shape.mesh.file", "b.stl",
                    "bad.tum:1")

    def test_empty_and_no_yaml(self):
        self.refuse("", "wrong.yaml")
        self.refuse("a: [1, 2\n", "wrong.yaml")
        self.refuse(bytes(range(256)) * 20, "wrong.yaml", mode="wb")
        self.refuse("just words", "wrong.yaml")

    def test_bombs(self):
        levels = "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12))
        self.refuse("ensonify: 1\na0: &a0 [1]\n" + levels, "wrong.yaml")
        self.refuse("[" * 1_000_000, "wrong.yaml")
        self.refuse("ensonify: 1\nname: &n {x: *n}\n", "wrong.yaml")

    def test_all_faults_at_once(self):
        text = SMALL.replace("range_max_m: 4", "range_max_m: -4").replace("seed: 7", "seed: x")
        errors = self.refuse(text.replace("material: m,", "material: n,"), "sonar.range_max_m",
                             "seed", "objects.0.material")
        self.assertGreaterEqual(len(errors.strip().splitlines()), 3)

    def test_wrong_usage(self):
        output = self.folder / "out"
        for arguments in ([], ["generate"], ["generate", self.scenario], ["paint"],
                          ["generate", self.scenario, "-o", ""],
                          ["generate", self.scenario, "-o", output, "--pings", "3"],
                          ["generate", self.scenario, "-o", output, "--pings", "5:5"],
                          ["generate", self.scenario, "-o", output, "--pings", "0:31"],
                          ["generate", self.scenario, "-o", output, "--backend", "opencl"],
                          ["generate", self.scenario, "-o", output, "--set", "seed"],
                          ["generate", self.scenario, "-o", output, "--seed", "-1"],
                          ["generate", self.scenario, "-o", output, "--set", "sonar.nothing=1"],
                          ["presets", "nothing"]):
            with self.subTest(arguments=arguments[:1] + arguments[-2:]):
                self.assertEqual(run(*arguments).returncode, 2)
        self.assertFalse(output.exists())


class Commands(Case):
    def test_help_and_version_everywhere(self):
        for arguments in (["--help"], ["--version"], ["generate", "--help"], ["check", "--help"],
                          ["verify", "--help"], ["presets", "--help"]):
            result = run(*arguments)
            self.assertEqual(result.returncode, 0)
            self.assertTrue(result.stdout)

    def test_check_prints_a_scenario_that_reads_back(self):
        first = run("check", self.scenario)
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn("# files:", first.stdout)
        again = self.folder / "again.yaml"
        again.write_text(first.stdout)

        def but_memory(text):  # which starts from what this very process holds
            return [line for line in text.splitlines() if not line.startswith("# peak memory:")]

        self.assertEqual(but_memory(run("check", again).stdout), but_memory(first.stdout))

    def test_check_announces_files_and_bytes(self):
        announced = run("check", self.scenario).stdout
        output = self.folder / "out"
        self.assertEqual(run("generate", self.scenario, "-o", output).returncode, 0)
        files = sum(1 for path in output.rglob("*") if path.is_file())
        self.assertIn(f"# files: {files}\n", announced)

    def test_every_scene_passes_check(self):
        scenes = sorted(SCENES.glob("*.yaml"))
        self.assertGreaterEqual(len(scenes), 6)
        for scene in scenes:
            with self.subTest(scene=scene.name):
                result = run("check", scene)
                self.assertEqual(result.returncode, 0, result.stderr)

    def test_presets(self):
        table = run("presets")
        self.assertEqual(table.returncode, 0)
        for name in ("blueview_p900_90", "paper_table1", "aris_3000_hf"):
            self.assertIn(name, table.stdout)
        one = run("presets", "paper_table1")
        self.assertIn("2950", one.stdout.replace(".0", "").replace("2.95e3", "2950"))

    def test_verify_finds_a_flipped_bit(self):
        output = self.folder / "out"
        self.assertEqual(run("generate", self.scenario, "-o", output, "--pings", "0:2").returncode, 0)
        self.assertEqual(run("verify", output).returncode, 0)
        file = output / "sequences/000000/timeseries/000001.npy"
        data = bytearray(file.read_bytes())
        data[5000] ^= 1
        file.write_bytes(data)
        result = run("verify", output)
        self.assertEqual(result.returncode, 1)
        self.assertIn("timeseries/000001.npy", result.stderr)

    def test_check_looks_at_every_sequence(self):
        drawn = self.folder / "drawn.yaml"
        drawn.write_text(self.scenario.read_text() + "sequences: 12\nmultipath: {surface: {z_m: "
                         "{uniform: [-0.5, 1]}, reflection: -1}}\n")
        first = run("check", drawn, "--set", "sequences=1")
        result = run("check", drawn)
        self.assertEqual((first.returncode, result.returncode), (0, 2), first.stderr)
        self.assertRegex(result.stderr, r"sequence \d+: .*drawn\.yaml:\d+:\d+: multipath\.surface")

    def test_progress_is_quiet_when_asked(self):
        result = run("generate", self.scenario, "-o", self.folder / "out", "--quiet", "--pings", "0:1")
        self.assertEqual((result.returncode, result.stderr, result.stdout), (0, "", ""))


class Devices(Case):
    """What happens without a device; with one, these skip."""

    def without_module(self, *arguments):
        return run("generate", self.scenario, "-o", self.folder / "out", "--pings", "0:1", *arguments,
                   env={**os.environ, "ENSONIFY_CUDA_MODULE": str(self.folder / "none.so")})

    def test_cuda_without_a_module_ends_with_5(self):
        result = self.without_module("--backend", "cuda")
        self.assertEqual(result.returncode, 5)
        self.assertIn("none.so", result.stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_auto_without_a_module_runs_on_the_processor(self):
        self.assertEqual(self.without_module().returncode, 0)
        work = json.loads((self.folder / "out/work.json").read_text())
        self.assertEqual(work["numerics"]["backend"], "cpu")

    def test_a_module_that_is_none(self):
        wrong = self.folder / "wrong.so"
        wrong.write_text("not a library")
        result = run("generate", self.scenario, "-o", self.folder / "out", "--backend", "cuda",
                     env={**os.environ, "ENSONIFY_CUDA_MODULE": str(wrong)})
        self.assertEqual(result.returncode, 5)
        self.assertIn("wrong.so", result.stderr)

    def test_cuda_without_a_device_tells_the_drivers_words(self):
        result = run("generate", self.scenario, "-o", self.folder / "out", "--pings", "0:1",
                     "--backend", "cuda")
        if result.returncode == 0:
            self.skipTest("a CUDA device answers")
        self.assertEqual(result.returncode, 5)
        self.assertTrue(result.stderr.startswith("CUDA: "), result.stderr)
        self.assertFalse((self.folder / "out").exists())


class Faults(Case):
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
            self.assertIn("goes on", message)
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
        self.assertIn("own input", result.stderr)
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
