"""mcap: navigation sensors next to the sonar, by the reader of this folder, against the tables of the data set."""
import csv
import math
import shutil
import unittest

import numpy as np

import exported
from mcap_messages import TYPES, matrix
from mcap_records import Reader, pose_values, stamp_of

SENSORS = """{
  imu: {rate_hz: 100, mount: {position_m: [0.1, 0, 0], rotation_deg: [0, 0, 90]},
        gyroscope: {angle_random_walk_deg_sqrth: 0.3}, accelerometer: {velocity_random_walk_m_s_sqrth: 0.06}},
  dvl: {rate_hz: 8, range_max_m: 20, beam_angle_deg: 25, velocity_noise_m_s: 0.01, range_noise_percent: 1,
        mount: {position_m: [0, 0, -0.1]}},
  depth: {rate_hz: 10, surface_z_m: 2, noise_m: 0.01},
  altimeter: {rate_hz: 10, range_max_m: 0.5, time_offset_s: 0.03},
  usbl: {rate_hz: 20, transceiver_m: [0, 0, 3], range_noise_m: 0.1, angle_noise_deg: 1},
  gps: {rate_hz: 5, latitude_deg: 54, longitude_deg: 10, surface_z_m: -1, horizontal_noise_m: 2},
  odometry: {rate_hz: 20, scale_error_percent: 2}}"""
MOUNT = "sonar.mount={position_m: [0.5, 0, 0.2], rotation_deg: [0, 30, 0]}"
TOPICS = {"imu": ("/imu/data_raw", "sensor_msgs/msg/Imu", "imu_link"),
          "dvl": ("/dvl/data", "marine_acoustic_msgs/msg/Dvl", "dvl_link"),
          "depth": ("/depth/pressure", "sensor_msgs/msg/FluidPressure", "depth_link"),
          "altimeter": ("/altimeter/range", "sensor_msgs/msg/Range", "altimeter_link"),
          "usbl": ("/usbl/fix", "geometry_msgs/msg/PoseWithCovarianceStamped", "world"),
          "gps": ("/gps/fix", "sensor_msgs/msg/NavSatFix", "gps_link"),
          "odometry": ("/odometry", "nav_msgs/msg/Odometry", "odom")}


def xyz(vector):
    return [vector[k] for k in "xyz"]


class Sensors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.source = exported.dataset("--set", f"navigation={SENSORS}", "--set", MOUNT)
        cls.sequence = exported.sequences(cls.source)[0]
        cls.reader = Reader(cls())
        out = exported.export("mcap", source=cls.source)
        cls.messages = cls.reader.read((out / "000000.mcap").read_bytes())

    def runTest(self):
        """For the reader, which asks a test."""

    def of(self, topic):
        return [message for found, *_, message in self.messages if found == topic]

    def rows(self, name):
        with open(self.sequence.folder / f"navigation/{name}.csv", newline="") as file:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]

    def pairs(self, name):
        """Messages and rows of a sensor."""
        messages, rows = self.of(TOPICS[name][0]), self.rows(name)
        self.assertGreater(len(rows), 2)
        return zip(messages, rows, strict=True)

    def test_topics_types_and_times(self):
        absent = {"/sonar/points"}
        expected = {topic: kind for topic, kind in TYPES.items() if topic not in absent}
        expected.update({topic: kind for topic, kind, _ in TOPICS.values()})
        self.assertEqual(dict(self.reader.topics.values()), expected)
        times = [time for *_, time, _ in self.messages]
        self.assertEqual(times, sorted(times))
        for name, (topic, _, frame) in TOPICS.items():
            expected = [round(row["time_s"] * 1e9) for row in self.rows(name)]
            self.assertEqual([time for found, _, _, time, _ in self.messages if found == topic], expected)
            self.assertEqual([stamp_of(m["header"]) for m in self.of(topic)], [(t, frame) for t in expected])
        pings = [round(float(row["time_s"]) * 1e9) for row in self.sequence.poses.values()]
        self.assertEqual([time for found, _, _, time, _ in self.messages if found == "/sonar/image"], pings)

    def test_frames(self):
        static = {t["child_frame_id"]: t for t in self.of("/tf_static")[0]["transforms"]}
        self.assertEqual({(t["header"]["frame_id"], child) for child, t in static.items()},
                         {("sonar", "sonar_fan"), ("base_link", "sonar"), *(
                             ("base_link", f"{name}_link") for name in TOPICS if name not in ("odometry",))})
        for tf, ping in zip(self.of("/tf"), self.sequence.pings, strict=True):
            body = tf["transforms"][0]
            self.assertEqual([body["header"]["frame_id"], body["child_frame_id"]], ["world", "base_link"])
            outer = pose_values(body["transform"], "translation", "rotation")
            inner = pose_values(static["sonar"]["transform"], "translation", "rotation")
            expected = self.sequence.pose(ping)
            np.testing.assert_allclose(outer[:3] + matrix(outer[3:]) @ inner[:3], expected[:3], atol=1e-12)
            np.testing.assert_allclose(matrix(outer[3:]) @ matrix(inner[3:]), matrix(expected[3:]), atol=1e-12)
        turn = {name: matrix(pose_values(static[f"{name}_link"]["transform"], "translation", "rotation")[3:])
                for name in ("imu", "dvl", "altimeter")}
        np.testing.assert_allclose(turn["imu"], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
        np.testing.assert_allclose(turn["dvl"], np.diag([1, -1, -1]), atol=1e-12)
        np.testing.assert_allclose(turn["altimeter"][:, 0], [0, 0, -1], atol=1e-12)

    def test_imu(self):
        for message, row in self.pairs("imu"):
            self.assertEqual(xyz(message["angular_velocity"]), [row[f"gyro_{a}_rad_s"] for a in "xyz"])
            self.assertEqual(xyz(message["linear_acceleration"]), [row[f"accel_{a}_m_s2"] for a in "xyz"])
            self.assertEqual(message["orientation_covariance"][0], -1, "no orientation")
            np.testing.assert_allclose(message["angular_velocity_covariance"],
                                       np.eye(3).ravel() * (math.radians(0.3) / 60) ** 2 * 100, rtol=1e-12)
            np.testing.assert_allclose(message["linear_acceleration_covariance"],
                                       np.eye(3).ravel() * (0.06 / 60) ** 2 * 100, rtol=1e-12)

    def test_dvl(self):
        for message, row in self.pairs("dvl"):
            self.assertEqual(xyz(message["velocity"]), [row["vx_m_s"], -row["vy_m_s"], -row["vz_m_s"]])
            self.assertEqual((message["velocity_mode"], message["num_good_beams"]), (1, 4))
            self.assertEqual(message["altitude"], row["altitude_m"])
            self.assertEqual(list(message["range"]), [row[f"range_{k}_m"] for k in range(4)])
            beams = np.array([xyz(b) for b in message["beam_unit_vec"]])
            np.testing.assert_allclose(beams[:, 2], math.cos(math.radians(25)), rtol=1e-12)
            self.assertTrue(beams[0, 0] > 0 > beams[0, 1], "beam 0 is ahead, to port")
            found = np.linalg.lstsq(beams, message["beam_velocity"], rcond=None)[0]
            np.testing.assert_allclose(found, xyz(message["velocity"]), atol=1e-6)
            np.testing.assert_allclose(np.reshape(message["velocity_covar"], (3, 3)),
                                       1e-4 * np.linalg.inv(beams.T @ beams), atol=1e-12)

    def test_depth_and_altimeter(self):
        density = 1025
        for message, row in self.pairs("depth"):
            self.assertEqual(message["fluid_pressure"], row["pressure_pa"])
            self.assertAlmostEqual(message["variance"], (density * 9.80665 * 0.01) ** 2)
        for message, row in self.pairs("altimeter"):
            self.assertTrue(math.isnan(row["range_m"]), "the floor is 1 m below")
            self.assertEqual((message["range"], message["max_range"]), (math.inf, 0.5))

    def test_fixes(self):
        for message, row in self.pairs("usbl"):
            pose = message["pose"]
            place = np.array(xyz(pose["pose"]["position"]))
            self.assertEqual(list(place), [row[a] for a in "xyz"])
            covariance = np.reshape(pose["covariance"], (6, 6))
            way = place - [0, 0, 3]
            across = (math.radians(1) * np.linalg.norm(way)) ** 2
            np.testing.assert_allclose(covariance[:3, :3] @ way, 0.01 * way, rtol=1e-9, atol=1e-12)
            self.assertAlmostEqual(np.trace(covariance[:3, :3]), 0.01 + 2 * across)
        for message, row in self.pairs("gps"):
            self.assertEqual([message[k] for k in ("latitude", "longitude", "altitude")],
                             [row[k] for k in ("latitude_deg", "longitude_deg", "altitude_m")])
            self.assertEqual((message["status"]["status"], message["position_covariance_type"]), (0, 2))
            self.assertEqual(list(message["position_covariance"][[0, 4, 8]]), [4, 4, 0])

    def test_odometry(self):
        for message, row in self.pairs("odometry"):
            self.assertEqual(message["child_frame_id"], "base_link")
            self.assertEqual(pose_values(message["pose"]["pose"]), [row[k] for k in ("x", "y", "z", "qw", "qx", "qy", "qz")])
            twist = message["twist"]["twist"]
            self.assertEqual(xyz(twist["linear"]), [row[f"v{a}_m_s"] for a in "xyz"])
            self.assertEqual(xyz(twist["angular"]), [row[f"w{a}_rad_s"] for a in "xyz"])

    def test_damaged_tables(self):
        folder = exported.scratch() / "copy"
        shutil.copytree(self.source, folder)
        table = folder / "sequences/000000/navigation/depth.csv"
        whole = table.read_text().splitlines()
        for lines in (whole[1:], [*whole[:2], "1,2"], [whole[0], whole[2], whole[1]], [whole[0], "nan,1,1"]):
            table.write_text("\n".join(lines) + "\n")
            result = exported.run("export", folder, "--format", "mcap", "-o", exported.scratch() / "out")
            self.assertEqual(result.returncode, 4, result.stderr)
            self.assertIn("depth.csv", result.stderr)

    def test_sequences_in_one_file(self):
        out = exported.export("mcap", "--one-file", source=self.source)
        messages = Reader(self).read((out / "dataset.mcap").read_bytes())
        times = [time for topic, _, _, time, _ in messages if topic == "/imu/data_raw"]
        self.assertEqual(times, sorted(times))
        self.assertEqual(len(times), sum(len(self.rows_of(s)) for s in exported.sequences(self.source)))

    @staticmethod
    def rows_of(sequence):
        return (sequence.folder / "navigation/imu.csv").read_text().splitlines()[1:]


if __name__ == "__main__":
    unittest.main()
