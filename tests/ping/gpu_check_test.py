"""scripts/gpu_check.py on a device which is the host, and with errors in its results: a check that cannot fail is none.

ENSONIFY and SCENES as for other tests, HOST_DEVICE the module that is opened in place of CUDA's.
"""
import json
import os
import pathlib
import subprocess
import sys
import unittest

import numpy as np
from program import PROGRAM, ROOT, Case

sys.dont_write_bytecode = True
import gpu_check  # noqa: E402

# As ensonify_gpu_bench prints it.
BENCH = """device: a device, 85 GB; memory 2500 GB/s (read and written), bus up 25.1 GB/s, down 32.0 GB/s, 30.1 T multiply-adds/s
case     echoes     device     series     levels        cpu    error |     memory        fma         up       down
full      58368    20123.4     2000.0     3000.0      50.10  1.2e-06 |    50000.0    40000.0    15000.0     4000.0
dense   3735552     2433.0     1000.0     1000.0       2.10  1.2e-06 |    50000.0    40000.0     1500.0     4000.0
array     58368     1499.0     1000.0     1000.0      10.00  1.2e-06 |    50000.0    40000.0    15000.0     4000.0
"""
# The program, whose CUDA backend is wrong by a thousandth in one beam.
WRONG = """#!/usr/bin/python3
import glob, subprocess, sys, numpy
status = subprocess.run(["{program}", *sys.argv[1:]]).returncode
if "cuda" in sys.argv:
    for name in glob.glob(sys.argv[sys.argv.index("-o") + 1] + "/sequences/*/timeseries/*.npy"):
        series = numpy.load(name)
        series[len(series) // 2] *= 1.001
        numpy.save(name, series)
sys.exit(status)
"""


class GpuCheck(Case):
    def check(self, *arguments, program=PROGRAM):
        file = self.folder / "check.json"
        done = subprocess.run(
            [sys.executable, ROOT / "scripts/gpu_check.py", "--program", program, "--json", file, "--small",
             "--scenes", "calibration_sphere", *arguments], capture_output=True, text=True,
            env={**os.environ, "ENSONIFY_CUDA_MODULE": os.environ["HOST_DEVICE"]})
        self.assertTrue(file.exists(), done.stderr)
        report = json.loads(file.read_text())
        figures = report["figures"]
        self.assertEqual(done.returncode, 0 if all(figure["met"] for figure in figures.values()) else 1, done.stdout)
        return report, {name: figure["met"] for name, figure in figures.items()}

    def test_a_right_device(self):
        has_python = (pathlib.Path(PROGRAM).parent / "python").exists()
        report, met = self.check("--only", "scenes", "ensemble", "sets", *(["stream"] if has_python else []))
        self.assertEqual(report["machine"]["device"], "the host itself")
        self.assertEqual({name: met[name] for name in ("scenes", "statistics")}, {"scenes": True, "statistics": True})
        for name in ("ensemble", "sets", *(["stream"] if has_python else [])):
            self.assertGreater(report["figures"][name]["value"], 0, report["figures"][name])

    def test_a_wrong_device_is_found(self):
        wrong = self.folder / "wrong"
        wrong.write_text(WRONG.format(program=pathlib.Path(PROGRAM).resolve()))
        wrong.chmod(0o755)
        report, met = self.check("--only", "scenes", program=wrong)
        self.assertEqual(met, {"scenes": False}, report["figures"])
        self.assertIn("timeseries", report["figures"]["scenes"]["where"])

    def test_rates_of_the_benchmark(self):
        file = self.folder / "bench.txt"
        file.write_text(BENCH)
        report, met = self.check("--only", "bench", "--bench", file)
        self.assertEqual(met, {"full": True, "full_of_bus": False, "array": False})
        self.assertEqual(report["figures"]["full_of_bus"]["value"], 0.5)
        file.write_text("skipped: CUDA: no device\n")
        self.assertEqual(set(self.check("--only", "bench", "--bench", file)[1].values()), {None})

    def test_arrays_that_differ(self):
        power = np.ones((4, 50))
        power[0] = 1e-9
        right = np.arange(200.).reshape(4, 50) + 1
        quiet, loud, gap = right.copy(), right.copy(), right.copy()
        quiet[0] *= 2
        loud[2, 7] += 1
        gap[1, 1] = np.nan
        of = lambda got: gpu_check.statistics_difference("contrast.npy", got, right, power)
        self.assertEqual(of(right), 0)
        self.assertEqual(of(quiet), 0)
        self.assertGreater(of(loud), 1e-5)
        self.assertEqual(of(gap), float("inf"))
        self.assertEqual(gpu_check.difference(right, right[:3]), float("inf"))
        self.assertEqual(gpu_check.difference(right, 0 * right), float("inf"))

    def test_files_of_one_backend_alone(self):
        folders = [self.folder / backend for backend in ("cuda", "cpu")]
        for folder in folders:
            folder.mkdir()
            np.save(folder / "a.npy", np.ones(3))
        self.assertEqual(gpu_check.differences(*folders), {"a.npy": 0})
        (folders[0] / "b.npy").touch()
        with self.assertRaisesRegex(gpu_check.NotMeasured, "b.npy"):
            gpu_check.differences(*folders)


if __name__ == "__main__":
    unittest.main()
