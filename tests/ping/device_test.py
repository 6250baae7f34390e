"""The program with a CUDA backend, whose device is the host: scenes and modes with the CPU backend for comparison, runs
that lose their device, devices with too little memory. device_scenes_test has other scenes.

ENSONIFY is the program, SCENES the folder of scenes, HOST_DEVICE the module that is opened in place
of CUDA's; tests/synthesis/host_module.cpp says what ENSONIFY_HOST_DEVICE tells it.
"""
import json
import os
import re
import signal
import subprocess
import time
import unittest

import numpy as np
from program import PROGRAM, SCENES, Case, hashes, run, used_s

MODULE = os.environ["HOST_DEVICE"]

ARRAY = """ensonify: 1
name: line
seed: 3
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 32, fov_deg: 60, receive_width_deg: 4}
  rays: {elevation: 6, min_per_cell: 12}
  receiver: {mode: array, shading: taylor, gain_error_db: 1, phase_error_deg: 10, dead: [2]}
materials: {m: {reflectivity: 1e-3, coherent: {model: rician, k: 1}}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [5, 5, 2], inward_facing: true}}}
volumes: [{name: water, uniform: {strength_db: -60}}]
noise: {spectrum_level_db: 30}
trajectory: {ping_rate_hz: 5, pings: 2, poses: [{time_s: 0, position_m: [0, 0, 0]},
                                                {time_s: 1, position_m: [1, 0.5, 0], rotation_deg: [0, 0, 20]}]}
output: {cartesian: false}
"""

MODES = [
    (),
    ("motion_within_ping=true",),
    ("multipath={surface: {z_m: 0.9, reflection: -0.8}}",),
    ("scattering.speckle=surface",),
    ("scattering.speckle=per_ray",),
    ("noise={spectrum_level_db: 40}", "sonar.receiver.adc={bits: 24, full_scale_db: 170}"),
    ("output.layers=true", "noise.spectrum_level_db=40"),
]

# Of an array, what is beamformed otherwise than beams are.
MODES_OF_ARRAYS = [MODES[at] for at in (0, 1, 3, 5)]

SWEEP = """ensonify_sweep: 1
base: {base}
set: {{trajectory.pings: 3}}
axes:
  - {{key: sonar.bandwidth_hz, values: [2.0e4, 2.5e4]}}
  - {{key: noise.spectrum_level_db, values: [20, 40]}}
"""
# Every part of a scene at a size at which the device is quick, in a fan instead of azimuths that a preset gives.
REDUCED = ("--pings", "0:1", "--sequences", "0:1", "--set", "sonar.beams.count=32", "--set", "sonar.beams.fov_deg=60",
           "--set", "sonar.rays.elevation=12")


def on_device(*arguments, device="", command="generate"):
    return run(command, *arguments, "--backend", "cuda",
               env={**os.environ, "ENSONIFY_CUDA_MODULE": MODULE, "ENSONIFY_HOST_DEVICE": device})


def relative(got, expected):
    return np.linalg.norm(got - expected) / np.linalg.norm(expected)


class Compared(Case):
    def same_data(self, scenario, *arguments, series_are_there=True, adc_step_pa=0):
        """Both backends make the same files; series differ by 1e-4 at most (relative L2)."""
        folders = {}
        for backend in ("cpu", "cuda"):
            folders[backend] = self.folder / f"{len(list(self.folder.iterdir()))}-{backend}"
            common = (scenario, "-o", folders[backend], *arguments)
            result = (on_device(*common) if backend == "cuda" else
                      run("generate", *common, "--backend", backend))
            self.assertEqual(result.returncode, 0, result.stderr)
        names = {backend: set(hashes(folder)) for backend, folder in folders.items()}
        self.assertEqual(names["cpu"], names["cuda"])
        series = [name for name in names["cpu"] if "timeseries" in name and name.endswith(".npy")]
        self.assertEqual(bool(series), series_are_there)
        for name in series:
            got, expected = (np.load(folders[backend] / name) for backend in ("cuda", "cpu"))
            if adc_step_pa:
                # Rounding before the converter may take the next step; no more than that.
                for part in (np.real, np.imag):
                    self.assertLess(np.abs(part(got - expected)).max(), 1.001 * adc_step_pa)
            elif expected.any():
                self.assertLess(relative(got, expected), 1e-4, name)
            else:
                self.assertFalse(got.any(), name)
        work = json.loads((folders["cuda"] / "work.json").read_text())
        self.assertEqual(work["numerics"]["backend"], "cuda, the host itself")
        return folders

    def same_scene(self, scene):
        """Both backends on one ping of a scene."""
        text, one = scene.read_text(), (scene, *REDUCED)
        if "pings: false" in text:
            self.same_data(*one, "--set", "output.pings=true")
        elif "adc: {bits: 14, full_scale_db: 185}" in text:
            self.same_data(*one, adc_step_pa=10 ** ((185 - 120) / 20) / 2 ** 13)
            self.same_data(*one, "--set", "sonar.receiver.adc.bits=24")
        else:
            self.same_data(*one)


class Device(Compared):
    def test_scenes(self):
        """An ADC, volumes, and several trajectories of sound with layers."""
        for name in ("calibration_sphere", "bubble_plume", "shallow_water"):
            with self.subTest(name):
                self.same_scene(SCENES / f"{name}.yaml")

    def test_statistics_of_draws(self):
        """Protects speckle studies on a device: its moments are those of the processor's series."""
        study = (SCENES / "speckle_wall.yaml", "--pings", "0:12", "--set", "sonar.beams={count: 20, fov_deg: 20}")
        folders = self.same_data(*study, series_are_there=False)
        names = [path.name for path in (folders["cpu"] / "sequences/000000/statistics").iterdir()]
        self.assertIn("bin_covariance.npy", names)
        read = lambda backend, name: np.load(folders[backend] / "sequences/000000/statistics" / name)
        power = read("cpu", "mean_intensity.npy")
        for name in names:
            got, expected = read("cuda", name), read("cpu", name)
            rows, columns = expected.shape
            known = np.isfinite(expected)
            np.testing.assert_array_equal(np.isfinite(got), known)
            if name == "intensity_histogram.npy":  # rounding errors move few intensities to the next bin
                self.assertEqual(got.sum(), expected.sum())
                self.assertLess(np.abs(got - expected).sum(), 1e-3 * expected.sum())
                continue
            # A ratio where hardly anything is heard is one of rounding errors.
            known &= power[:rows, :columns] > 1e-6 * power.max()
            known[:, 1:] &= power[:rows, :columns - 1] > 1e-6 * power.max()
            self.assertGreater(known.sum(), 1000)
            self.assertLess(relative(got[known], expected[known]), 1e-4, name)

    def ensemble(self, name, *more, pings=20, outputs="pings: false", device=""):
        """The folder of an ensemble of few beams that the device makes."""
        folder = self.folder / name
        made = on_device(*self.few_beams(folder, pings, outputs), *more, device=device)
        self.assertEqual(made.returncode, 0, made.stderr)
        return folder

    @staticmethod
    def few_beams(folder, pings, outputs="pings: false"):
        return (SCENES / "speckle_wall.yaml", "-o", folder, "--set", f"trajectory.pings={pings}", "--set",
                "sonar.beams={count: 8, fov_deg: 8}", "--set", f"output={{statistics: {{lags: 2}}, {outputs}}}")

    def test_moments_stay_on_the_device_and_are_those_of_its_series(self):
        """Protects ensembles that the device adds: where pings have files, or the processor completes series,
        and where memory does not suffice for a block, series come down as they always did."""
        files = "polar: false, cartesian: false, png: false"
        for mode in ((), MODES[5][1:], ("noise={spectrum_level_db: 40, correlated: true}",
                                        "sonar.electronics={crosstalk_db: -40}")):
            with self.subTest(mode=mode):
                number = len(list(self.folder.iterdir()))
                more = [word for key in mode for word in ("--set", key)]
                arrays = [{path.name: path.read_bytes() for path in folder.rglob("statistics/*.npy")}
                          for folder in (self.ensemble(f"{number}-added", *more),
                                         self.ensemble(f"{number}-series", *more, outputs=files))]
                self.assertIn("beam_lag_products.npy", arrays[0])
                self.assertEqual(*arrays)
        whole = hashes(self.ensemble("whole"))
        for limit in (300000, 500000, 900000):
            self.assertEqual(hashes(self.ensemble(str(limit), device=f"limit={limit}")), whole)

    def test_an_ensemble_that_is_stopped_resumes(self):
        """Protects the moments on a device from an interrupt: they come down and are kept."""
        pings = 1500
        whole, stopped = self.ensemble("whole", pings=pings), self.folder / "stopped"
        process = subprocess.Popen(
            [PROGRAM, "generate", *map(str, self.few_beams(stopped, pings)), "--backend", "cuda"],
            env={**os.environ, "ENSONIFY_CUDA_MODULE": MODULE}, stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not (stopped / "work.json").exists():
            time.sleep(0.001)
        goal_s = used_s(process) + 0.2
        while process.poll() is None and used_s(process) < goal_s:
            time.sleep(0.001)
        process.send_signal(signal.SIGTERM)
        message = process.communicate()[1]
        self.assertEqual(process.returncode, 130, message)
        last = on_device(*self.few_beams(stopped, pings))
        self.assertEqual(last.returncode, 0, last.stderr)
        kept = int(re.search(r"resuming: (\d+) of 1500 pings already made", last.stderr)[1])
        self.assertTrue(kept > 0 and kept % 8 == 0, kept)
        self.assertEqual(hashes(stopped), hashes(whole))

    def test_every_mode_of_beams_and_arrays(self):
        line = self.folder / "line.yaml"
        line.write_text(ARRAY)
        for scenario, modes in (self.scenario, MODES), (line, MODES_OF_ARRAYS):
            for mode in modes:
                settings = [word for key in mode for word in ("--set", key)]
                with self.subTest(scenario=scenario.name, mode=mode):
                    self.same_data(scenario, "--pings", "0:1", *settings)

    def test_pictures_without_series_are_those_beside_series(self):
        folders = [self.folder / "with", self.folder / "without"]
        for folder, series in zip(folders, ("npy", "none")):
            result = on_device(self.scenario, "-o", folder, "--pings", "0:2", "--set",
                               f"output.timeseries={series}")
            self.assertEqual(result.returncode, 0, result.stderr)
        pictures = [{name: sum_ for name, sum_ in hashes(folder).items()
                     if name.endswith((".png", ".exr"))} for folder in folders]
        self.assertTrue(pictures[0])
        self.assertEqual(*pictures)

    def test_the_same_bytes_from_any_threads_and_any_memory(self):
        first = self.folder / "first"
        self.assertEqual(on_device(self.scenario, "-o", first, "--pings", "0:6").returncode, 0)
        for number, (threads, device) in enumerate([(1, ""), (4, "limit=900000"), (4, "devices=3")]):
            with self.subTest(threads=threads, device=device):
                other = self.folder / str(number)
                result = on_device(self.scenario, "-o", other, "--pings", "0:6", "--threads",
                                   threads, device=device)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(hashes(first), hashes(other))

    def test_a_lost_device_keeps_what_is_finished(self):
        undisturbed, output = self.folder / "undisturbed", self.folder / "out"
        pings = ("--pings", "0:12")
        self.assertEqual(on_device(self.scenario, "-o", undisturbed, *pings).returncode, 0)
        lost = on_device(self.scenario, "-o", output, "--threads", 1, *pings, device="lost_after=40")
        self.assertEqual(lost.returncode, 5, lost.stderr)
        self.assertIn("lost", lost.stderr)
        records = list(output.rglob("*.json"))
        self.assertTrue(records)
        again = on_device(self.scenario, "-o", output, *pings)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("resuming: ", again.stderr)
        self.assertEqual(hashes(output), hashes(undisturbed))

    def test_runs_of_a_sweep_share_the_device(self):
        """Protects sweeps: runs of equal tables share a backend, others have one of their own beside it."""
        sweep, output = self.folder / "sweep.yaml", self.folder / "sweep"
        sweep.write_text(SWEEP.format(base=self.scenario))
        # Few enough for any way in which the lanes may share the batches.
        lost = on_device(sweep, "-o", output, device="lost_after=6", command="sweep")
        self.assertEqual(lost.returncode, 5, lost.stderr)
        self.assertIn("lost", lost.stderr)
        done = on_device(sweep, "-o", output, "--threads", 4, device="limit=1500000", command="sweep")
        self.assertEqual(done.returncode, 0, done.stderr)
        for line in (output / "plan.jsonl").read_text().splitlines():
            planned = json.loads(line)
            alone = self.folder / planned["run"]
            keys = ["sonar.bandwidth_hz", "noise.spectrum_level_db"]
            values = [planned["values"][key.split(".")[1]] for key in keys]
            settings = [f"--set={key}={value}" for key, value in zip(keys, values)]
            made = on_device(self.scenario, "-o", alone, "--set=trajectory.pings=3", *settings)
            self.assertEqual(made.returncode, 0, made.stderr)
            self.assertEqual(hashes(output / "runs" / planned["run"]), hashes(alone), planned["name"])

    def test_a_device_that_lacks_the_memory_it_reports_ends_with_5(self):
        result = on_device(self.scenario, "-o", self.folder / "out", device="limit=500000")
        self.assertEqual(result.returncode, 5, result.stderr)
        self.assertIn("memory for one ping on the device", result.stderr)

    def test_what_a_device_cannot_do_is_refused_before_anything_is_written(self):
        """Without memory for a ping or for the tables, without a device, in double precision."""
        for device, keys, words in [("free=1000", (), "one ping needs"), ("limit=1000", (), "for the tables"),
                                    ("none", (), "no CUDA-capable device is detected"),
                                    ("", ("--set", "synthesis.tolerance=1e-7"), "double precision")]:
            with self.subTest(device=device, keys=keys):
                result = on_device(self.scenario, "-o", self.folder / "out", "--quiet", *keys, device=device)
                self.assertEqual(result.returncode, 5, result.stderr)
                self.assertRegex(result.stderr, words + r"[^\n]*; expected [^\n]*, or --backend cpu\n$")
                self.assertEqual(result.stderr.count("\n"), 1)
                self.assertFalse((self.folder / "out").exists())

    def test_auto_takes_the_processor_where_the_device_lacks_memory(self):
        folders = {name: self.folder / name for name in ("cpu", "auto")}
        environment = {**os.environ, "ENSONIFY_CUDA_MODULE": MODULE, "ENSONIFY_HOST_DEVICE": "free=1000"}
        told = run("generate", self.scenario, "-o", folders["auto"], "--pings", "0:1", "--quiet", env=environment)
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertRegex(told.stderr, r"^warning: cpu in place of cuda, the host itself: one ping needs .*\n$")
        self.assertEqual(run("generate", self.scenario, "-o", folders["cpu"], "--pings", "0:1", "--backend",
                             "cpu").returncode, 0)
        self.assertEqual(*(hashes(folder) for folder in folders.values()))

    def test_a_run_of_a_sweep_that_the_device_cannot_make_takes_the_processor(self):
        sweep, output = self.folder / "sweep.yaml", self.folder / "sweep"
        sweep.write_text(f"ensonify_sweep: 1\nbase: {self.scenario}\nset: {{trajectory.pings: 2}}\naxes: [{{key: "
                         "synthesis.tolerance, values: [1.0e-5, 2.0e-7, 1.0e-7]}]\n")
        told = run("sweep", sweep, "-o", output, env={**os.environ, "ENSONIFY_CUDA_MODULE": MODULE})
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertEqual(told.stderr.count("cpu in place of cuda"), 2, "one for each reason")
        made = [json.loads(path.read_text())["numerics"]["backend"] for path in output.glob("runs/*/work.json")]
        self.assertEqual(sorted(made), ["cpu", "cpu", "cuda, the host itself"])
        asked = run("sweep", sweep, "-o", self.folder / "asked", "--backend", "cuda",
                    env={**os.environ, "ENSONIFY_CUDA_MODULE": MODULE})
        self.assertEqual(asked.returncode, 3, asked.stderr)
        self.assertEqual(asked.stderr.count("double precision"), 2)
        self.assertEqual(len(list(self.folder.glob("asked/runs/*"))), 1)

    def test_auto_takes_the_device_and_says_so(self):
        result = run("generate", self.scenario, "-o", self.folder / "out", "--pings", "0:1",
                     env={**os.environ, "ENSONIFY_CUDA_MODULE": MODULE})
        self.assertEqual(result.returncode, 0)
        self.assertIn("backend: cuda, the host itself", result.stderr)


if __name__ == "__main__":
    unittest.main()
