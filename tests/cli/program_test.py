"""The program from outside: what its commands answer, and what happens without a device.

Run by ctest; by hand:
    ENSONIFY=build/release/ensonify python3 -m unittest program_test
"""
import ctypes
import json
import os
import re
import shutil
import subprocess
import unittest

from program import PROGRAM, Case, run


class Commands(Case):
    def test_help_and_version_everywhere(self):
        for arguments in (["--help"], ["--version"], ["generate", "--help"], ["check", "--help"],
                          ["verify", "--help"], ["presets", "--help"]):
            result = run(*arguments)
            self.assertEqual(result.returncode, 0)
            self.assertTrue(result.stdout)

    def test_what_was_meant_is_suggested(self):
        scenario, output = self.scenario, self.folder / "out"
        for arguments, told in (
                (["generat", scenario, "-o", output], "unknown command `generat` (did you mean generate?); expected one of"),
                ([], "no command; expected one of generate, "),
                (["--versio"], "unknown option `--versio` (did you mean --version?); `ensonify --help` prints"),
                (["generate", scenario, "-o", output, "--thread", "2"],
                 "unknown option `--thread` (did you mean --threads?); `ensonify generate --help` prints"),
                # The unknown option, and not the one that is missing because of it.
                (["generate", scenario, f"--ouput={output}"], "unknown option `--ouput` (did you mean --output?)"),
                (["generate", scenario], "--output is required; `ensonify generate --help` prints what is expected"),
                (["--help-format", "fis"], "--help-format: `fis` is not known (did you mean fish?)"),
                (["check", scenario, "b.yaml"], "unexpected argument `b.yaml`; `ensonify check --help` prints"),
                (["check", scenario, "--backend", "cpuu"],
                 "--backend: `cpuu` is not known (did you mean cpu?); expected one of auto, cpu, cuda, reference"),
                (["check", scenario, "--set", "objects.rom.material=m"], "(did you mean room?)"),
                (["presets", "seabat_f5"], "no preset `seabat_f5` (did you mean seabat_f50?); expected one of")):
            with self.subTest(told=told):
                result = run(*arguments)
                self.assertEqual((result.returncode, result.stdout), (2, ""))
                self.assertIn(told, result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1)

    def test_generate_warns_of_a_scene_without_echoes(self):
        made = run("generate", self.scenario, "-o", self.folder / "out", "--set", "objects=[]")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertIn("warning: objects: the scene has no object", made.stderr)
        checked = run("check", self.scenario, "--set", "objects=[]")
        self.assertEqual(checked.stderr.count("warning: "), made.stderr.count("warning: "), checked.stderr)

    def test_check_prints_a_scenario_that_reads_back(self):
        first = run("check", self.scenario)
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn("# files:", first.stdout)
        again = self.folder / "again.yaml"
        again.write_text(first.stdout)

        def but_measured(text):
            measured = ("# peak memory:", "# disk:", "# free", "# time:", "# pings measured")
            return [line for line in text.splitlines() if not line.startswith(measured)]

        self.assertEqual(but_measured(run("check", again).stdout), but_measured(first.stdout))

    def test_check_announces_files_and_bytes(self):
        announced = run("check", self.scenario).stdout
        output = self.folder / "out"
        self.assertEqual(run("generate", self.scenario, "-o", output).returncode, 0)
        files = sum(1 for path in output.rglob("*") if path.is_file())
        self.assertIn(f"# files: {files}\n", announced)

    def test_check_announces_size_and_time(self):
        for more in (["output.timeseries=exr"],
                     ["sequences=6", "trajectory.pings=5", "materials.m.reflectivity={uniform: [1e-4, 1e-2]}",
                      "output.one_file_per=sequence"]):
            with self.subTest(more=more):
                # Rays enough that pings take far longer than starting the program and its threads.
                words = [word for key in ("sonar.rays.elevation=1000", *more) for word in ("--set", key)]
                announced = run("check", self.scenario, "--threads", "2", *words).stdout
                output = self.folder / "out"
                made = subprocess.Popen([PROGRAM, "generate", self.scenario, "-o", output, "--quiet", "--threads", "2",
                                         *words])
                _, made.returncode, usage = os.wait4(made.pid, 0)
                self.assertEqual(made.returncode, 0)
                size_mb = float(re.search(r"# disk: about ([\d.]+) MB\n", announced)[1])
                taken_mb = sum(path.stat().st_size for path in output.rglob("*") if path.is_file()) / 1e6
                self.assertLess(abs(size_mb / taken_mb - 1), 0.1)
                # Other programs on the machine change the time by the clock, and processor time far less.
                core_s = float(re.search(r"# time: about [\d.]+ s with 2 threads, ([\d.]+) s of one core\n", announced)[1])
                taken_s = usage.ru_utime + usage.ru_stime
                self.assertLess(core_s, 2 * taken_s)
                self.assertLess(taken_s, 2 * core_s)
                measured = int(re.search(r"# pings measured for disk and time: (\d+) \(sequences: \d+\)\n", announced)[1])
                self.assertGreater(measured, 1)
                shutil.rmtree(output)

    def test_check_announces_the_free_space_of_a_disk(self):
        text = run("check", self.scenario, "-o", self.folder / "not/yet").stdout
        number, unit = re.search(rf"# free disk space in {self.folder}/not/yet: ([\d.]+) ([MG])B\n", text).groups()
        free = shutil.disk_usage(self.folder).free
        self.assertLess(abs(float(number) * {"M": 1e6, "G": 1e9}[unit] / free - 1), 0.2)
        self.assertIn("# free disk space in this folder: ", run("check", self.scenario).stdout)
        self.assertFalse((self.folder / "not").exists())

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

    def test_one_thing_is_told_in_the_singular(self):
        one = ["--set", "trajectory.pings=1"]
        self.assertIn("# 1 sequence x 1 ping: ", run("check", self.scenario, *one).stdout)
        output = self.folder / "out"
        made = run("generate", self.scenario, "-o", output, *one)
        self.assertIn("1 ping in 1 sequence\n", made.stderr)
        exported = run("export", output, "--format", "yolo", "-o", self.folder / "yolo")
        self.assertIn("1 ping of 1 sequence as yolo\n", exported.stderr)
        (output / "sequences/000000/range_m.npy").write_bytes(b"cut")
        self.assertTrue(run("verify", output).stderr.endswith(": 1 error\n"))

    def test_a_scenario_comes_by_standard_input(self):
        text = self.scenario.read_text()
        told = subprocess.run([PROGRAM, "check", "-"], input=text, capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertIn("# 1 sequence x ", told.stdout)
        wrong = subprocess.run([PROGRAM, "check", "-"], input="sonar: 1\n", capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 2)
        self.assertRegex(wrong.stderr, r"^-:1:")

    def test_check_looks_at_every_sequence(self):
        drawn = self.folder / "drawn.yaml"
        drawn.write_text(self.scenario.read_text() + "sequences: 12\nmultipath: {surface: {z_m: "
                         "{uniform: [-0.5, 1]}, reflection: -1}}\n")
        first = run("check", drawn, "--set", "sequences=1")
        result = run("check", drawn)
        self.assertEqual((first.returncode, result.returncode), (0, 3), first.stderr)
        self.assertRegex(result.stderr, r"sequence \d+: .*drawn\.yaml:\d+:\d+: multipath\.surface")

    def test_progress_is_quiet_when_asked(self):
        result = run("generate", self.scenario, "-o", self.folder / "out", "--quiet", "--pings", "0:1")
        self.assertEqual((result.returncode, result.stderr, result.stdout), (0, "", ""))


class Devices(Case):
    """What happens without a device; with one, these skip."""

    def without_module(self, *arguments):
        return run("generate", self.scenario, "-o", self.folder / "out", "--pings", "0:1", *arguments,
                   env={**os.environ, "ENSONIFY_CUDA_MODULE": str(self.folder / "none.so")})

    def test_a_bench_that_is_cut_off_leaves_the_old_results(self):
        results = self.folder / "bench.json"
        results.write_text("old")
        bench = subprocess.Popen([PROGRAM, "bench", "--only", "series", "--json", results],
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.assertIn("measuring", bench.stderr.readline())
        bench.kill()
        bench.communicate()
        self.assertEqual(results.read_text(), "old")

    def test_cuda_without_a_module_ends_with_5(self):
        result = self.without_module("--backend", "cuda")
        self.assertEqual(result.returncode, 5)
        self.assertIn("none.so", result.stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_auto_without_a_module_runs_on_the_processor(self):
        self.assertEqual(self.without_module().returncode, 0)
        work = json.loads((self.folder / "out/work.json").read_text())
        self.assertEqual(work["numerics"]["backend"], "cpu")

    def test_auto_without_a_driver_opens_no_library_of_cuda(self):
        """They take longer to load than a small scene takes to check."""
        try:
            ctypes.CDLL("libcuda.so.1")
            self.skipTest("there is a driver")
        except OSError:
            pass
        result = run("check", self.scenario, env={**os.environ, "LD_DEBUG": "files"})
        self.assertEqual(result.returncode, 0)
        self.assertIn("libfftw3", result.stderr, "the linker does not report what it opens")
        self.assertNotIn("libensonify_cuda", result.stderr)

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


if __name__ == "__main__":
    unittest.main()
