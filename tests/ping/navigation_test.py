"""Navigation sensors in data sets: their tables, read by the package, against the trajectory and a floor."""
import json
import math
import shutil
import unittest

import numpy as np

import program
from ensonify_dataset import DatasetError, SequenceFolder

SONAR = """ensonify: 1
name: survey
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 6
  beams: {count: 8, fov_deg: 60}
  rays: {elevation: 4, azimuth: 1}
  mount: {position_m: [1, 0, -0.2], rotation_deg: [0, 20, 0]}
materials: {m: {reflectivity: 1e-2}}
objects:
  - {name: floor, class: bed, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -5]}}
  - {name: step, class: bed, material: m, shape: {box: {size_m: [4, 40, 1]}}, pose: {position_m: [6, 0, -4.5]}}
trajectory:
  ping_rate_hz: 2
  lawnmower: {corner_m: [0, 0, -1], length_m: 8, width_m: 4, spacing_m: 4, speed_m_s: 2}
"""
SENSORS = """navigation:
  imu:
    rate_hz: 50
    mount: {position_m: [0.1, 0, 0], rotation_deg: [0, 0, 90]}
    gyroscope: {angle_random_walk_deg_sqrth: 0.15, bias_instability_deg_h: 0.5}
    accelerometer: {velocity_random_walk_m_s_sqrth: 0.05}
  dvl: {rate_hz: 5, range_max_m: 30, velocity_noise_m_s: 0.002}
  depth: {rate_hz: 4, noise_m: 0.01}
  altimeter: {rate_hz: 10, time_offset_s: 0.05, range_max_m: 30}
  usbl: {rate_hz: 0.5, transceiver_m: [0, 0, 0], range_noise_m: 0.1}
  gps: {rate_hz: 1, latitude_deg: 54, longitude_deg: 10, surface_z_m: -2}
  odometry: {rate_hz: 5, scale_error_percent: 1}
"""
SURVEY = SONAR + SENSORS
EXACT = SONAR + "navigation: {imu: {rate_hz: 100}, dvl: {rate_hz: 5, range_max_m: 30}, altimeter: {rate_hz: 10, range_max_m: 30}}\n"


class Tables(program.Case):
    def sequence(self, text=SURVEY, *options):
        return SequenceFolder(program.made(text, *options) / "sequences/000000")

    def test_times_and_columns(self):
        sequence = self.sequence()
        tables, times = sequence.navigation, [ping.time_s for ping in sequence]
        self.assertEqual(set(tables), {"imu", "imu_truth", "dvl", "depth", "altimeter", "usbl", "gps", "odometry"})
        start, end = times[0], times[-1]
        for name, rate, offset in (("imu", 50, 1 / 50), ("dvl", 5, 0), ("depth", 4, 0), ("altimeter", 10, 0.05),
                                   ("usbl", 0.5, 0), ("gps", 1, 0), ("odometry", 5, 0)):
            t = tables[name]["time_s"]
            np.testing.assert_allclose(t, start + offset + np.arange(len(t)) / rate, rtol=0, atol=1e-12)
            self.assertLessEqual(t[-1], end)
            self.assertGreater(t[-1] + 1 / rate, end - 1 / rate)
        self.assertEqual(len(tables["imu_truth"]), len(tables["imu"]) + 1)
        mount = sequence.info["navigation"]["sonar_in_body"]
        self.assertEqual(mount["position_m"], [1, 0, -0.2])
        self.assertAlmostEqual(mount["quaternion_wxyz"][2], math.sin(math.radians(10)))

    def test_true_states_are_those_of_the_sonar_on_the_body(self):
        """The IMU at the times of pings, which lie between the begins of its samples."""
        sequence = self.sequence(EXACT)
        truth = sequence.navigation["imu_truth"]
        for ping in list(sequence)[1:-1]:
            i = np.searchsorted(truth["time_s"], ping.time_s)
            place = [(truth[a][i - 1] + truth[a][i]) / 2 for a in "xyz"]
            expected = ping.pose.position_m - ping.pose.rotation @ self.sonar_to_body() @ [1, 0, -0.2]
            # A quarter of a sample's way off a straight line, w v T^2 / 8.
            np.testing.assert_allclose(place, expected, atol=1e-4)

    @staticmethod
    def sonar_to_body():
        c, s = math.cos(math.radians(20)), math.sin(math.radians(20))
        return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T

    def test_ranges_and_velocity_over_a_floor_with_a_step(self):
        dvl, altimeter = (self.sequence(EXACT).navigation[name] for name in ("dvl", "altimeter"))
        x = 2 * altimeter["time_s"]
        line = (x < 7.9) & (np.abs(x - 4) > 0.01)  # not on the edge of the step
        self.assertTrue((x[line] > 4).any())
        np.testing.assert_allclose(altimeter["range_m"][line], np.where(x[line] < 4, 4, 3), atol=1e-9)
        here = dvl["time_s"] < 3.9
        np.testing.assert_allclose(dvl["vx_m_s"][here], 2, atol=1e-9)
        np.testing.assert_allclose(np.stack([dvl["vy_m_s"], dvl["vz_m_s"]])[:, here], 0, atol=1e-9)
        np.testing.assert_allclose(dvl["range_0_m"][0], 4 / math.cos(math.radians(30)), rtol=1e-12)

    def test_noise_of_depth_and_odometry(self):
        tables = self.sequence().navigation
        error = tables["depth"]["depth_m"] - 1
        self.assertTrue(0.005 < error.std() < 0.02, "40 samples of 0.01 m")
        np.testing.assert_allclose(tables["depth"]["pressure_pa"],
                                   101325 + 1025 * 9.80665 * tables["depth"]["depth_m"], rtol=1e-12)
        way = tables["odometry"]["x"][10]
        self.assertNotAlmostEqual(way, 4, places=4)
        self.assertLess(abs(way / 4 - 1), 0.05)

    def test_pings_threads_and_kills_do_not_matter(self):
        whole = self.sequence()
        part = SequenceFolder(program.fresh(SURVEY, "--pings", "4:9", "--threads", "1") / "sequences/000000")
        first, last = part[4].time_s, part[8].time_s
        for name, rows in part.navigation.items():
            if name == "imu_truth":
                continue
            t = whole.navigation[name]["time_s"]
            np.testing.assert_array_equal(rows, whole.navigation[name][(t >= first) & (t <= last)])
        self.assertGreater(len(part.navigation["imu"]), 90)
        out = self.folder / "again"
        shutil.copytree(whole.folder.parents[1], out)
        before = program.hashes(out)
        for name in ("dataset.json", "dataset.sha256", "sequences/000000/navigation/imu.csv"):
            (out / name).unlink()
        (self.folder / "s.yaml").write_text(SURVEY)
        result = program.run("generate", self.folder / "s.yaml", "-o", out, "--quiet")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(program.hashes(out), before)

    def test_sequences_differ(self):
        folder = program.fresh(SURVEY, "--set", "sequences=2", "--pings", "0:3")
        one, two = (SequenceFolder(folder / f"sequences/00000{i}").navigation for i in range(2))
        np.testing.assert_array_equal(one["altimeter"], two["altimeter"])
        for name, column in (("imu", "gyro_x_rad_s"), ("dvl", "vx_m_s"), ("depth", "depth_m"), ("usbl", "z")):
            self.assertTrue((one[name][column] != two[name][column]).any(), name)

    def test_damage_is_found(self):
        out = shutil.copytree(program.made(SURVEY), self.folder / "damaged")
        path = out / "sequences/000000/navigation/dvl.csv"
        path.write_text(path.read_text().replace("vx_m_s", "vx"))
        result = program.run("verify", out)
        self.assertEqual(result.returncode, 1)
        self.assertIn("sequences/000000/navigation/dvl.csv: ", result.stdout + result.stderr)

    def test_a_sequence_without_sensors(self):
        text = SONAR.split("trajectory")[0]
        folder = program.made(text)
        self.assertFalse((folder / "sequences/000000/navigation").exists())
        self.assertNotIn("navigation", json.loads((folder / "sequences/000000/sequence.json").read_text()))
        with self.assertRaisesRegex(DatasetError, "navigation sensors"):
            SequenceFolder(folder / "sequences/000000").navigation


class Input(program.Case):
    def check(self, sensors, *words, code=2):
        (self.folder / "s.yaml").write_text(SONAR + f"navigation: {sensors}\n")
        result = program.run("check", self.folder / "s.yaml")
        self.assertEqual(result.returncode, code, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)

    def test_errors(self):
        self.check("{}", "navigation: there is no sensor")
        self.check("{imu: {rate_hz: 0}}", "navigation.imu.rate_hz: `0` is out of range")
        self.check("{imu: {}}", "navigation.imu.rate_hz")
        self.check("{gyro: {rate_hz: 1}}", "navigation.gyro", "unknown key")
        self.check("{imu: {rate_hz: 1, gyroscope: {bias_instability_deg_h: -1}}}", "bias_instability_deg_h: `-1` is out of range")
        self.check("{dvl: {rate_hz: 1}}", "navigation.dvl.range_max_m")
        self.check("{altimeter: {rate_hz: 1, range_min_m: 3, range_max_m: 2}}", "navigation.altimeter",
                   "not below range_max_m")
        self.check("{usbl: {rate_hz: 1, transceiver_m: [0, 0, 0], dropped: 1}}", "dropped: `1` is out of range")
        self.check("{gps: {rate_hz: 1, longitude_deg: 0}}", "navigation.gps.latitude_deg")

    def test_too_many_samples(self):
        (self.folder / "s.yaml").write_text(SONAR.split("trajectory")[0] + "navigation: {imu: {rate_hz: 1e4}}\n"
                                            "trajectory: {ping_rate_hz: 1e-5, pings: 2}\n")
        result = program.run("check", self.folder / "s.yaml")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("navigation.imu.rate_hz: gives 1e+09 samples", result.stderr)

    def test_warnings(self):
        self.check("{dvl: {rate_hz: 1, range_max_m: 2}}", "warning: navigation.dvl: no beam meets a surface", code=0)
        self.check("{altimeter: {rate_hz: 1, range_max_m: 2}}", "warning: navigation.altimeter", code=0)
        self.check("{gps: {rate_hz: 1, latitude_deg: 0, longitude_deg: 0}}", "warning: navigation.gps", code=0)
        self.check("{depth: {rate_hz: 0.01, time_offset_s: 50}}", "warning: navigation.depth: there is no sample", code=0)


if __name__ == "__main__":
    unittest.main()
