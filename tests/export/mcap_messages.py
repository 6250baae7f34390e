"""Checks of the ROS messages in an MCAP file, topic by topic, against the data set."""
import json
import math

import numpy as np

import exported
from mcap_records import pose_values, stamp_of
from sonar_dataset import read_exr

IMAGE, INFO = "marine_acoustic_msgs/msg/ProjectedSonarImage", "marine_interfaces/msg/SonarInfo"
TYPES = {"/tf": "tf2_msgs/msg/TFMessage", "/tf_static": "tf2_msgs/msg/TFMessage",
         "/sonar/pose": "geometry_msgs/msg/PoseStamped", "/sonar/image": IMAGE, "/sonar/levels": IMAGE,
         "/sonar/image/info": INFO, "/sonar/levels/info": INFO,
         "/sonar/cartesian/image": "sensor_msgs/msg/Image",
         **{f"/sonar/{view}/{plane}": "sensor_msgs/msg/Image"
            for view in ("polar", "cartesian") for plane in ("instance", "semantic")},
         **{f"/sonar/{view}/detections": "vision_msgs/msg/Detection2DArray" for view in ("polar", "cartesian")},
         "/sonar/points": "sensor_msgs/msg/PointCloud2"}
# Topics with a message for each sequence.
ONCE = {"/tf_static", "/sonar/image/info", "/sonar/levels/info"}


def matrix(quaternion):
    """The rotation of w, x, y, z."""
    w, x, y, z = quaternion
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class Messages(exported.Case):
    """Checks of one message each: `check_TOPIC(sequence, ping, message)`."""

    def check_message(self, sequence, ping, topic, message):
        header = message.get("header")
        if header:
            time = round(float(sequence.poses[ping]["time_s"]) * 1e9)
            frame = {"/sonar/pose": "world", "/sonar/image": "sonar_fan", "/sonar/levels": "sonar_fan",
                     "/sonar/image/info": "sonar_fan", "/sonar/levels/info": "sonar_fan"}.get(topic, "sonar")
            self.assertEqual(stamp_of(header), (time + self.later_ns, frame))
        part = topic.removeprefix("/sonar/").split("/")
        name = part[-1] if part[0] in ("polar", "cartesian") else "_".join(part).strip("_")
        if part[0] in ("polar", "cartesian"):
            getattr(self, f"check_{name}_of_view")(sequence, ping, part[0], message)
        else:
            getattr(self, f"check_{name}")(sequence, ping, message)

    later_ns = 0

    def check_pose(self, sequence, ping, message):
        self.assertEqual(pose_values(message["pose"]), sequence.pose(ping))

    def check_tf(self, sequence, ping, message):
        sonar, *objects = message["transforms"]
        self.assertEqual([sonar["header"]["frame_id"], sonar["child_frame_id"]], ["world", "sonar"])
        self.assertEqual(pose_values(sonar["transform"], "translation", "rotation"), sequence.pose(ping))
        rows = [row for row in sequence.objects if int(row["ping"]) == ping]
        self.assertEqual([t["child_frame_id"] for t in objects], ["object_1_room", "object_2_ball_1", "object_3_pole"])
        for transform, row in zip(objects, rows, strict=True):
            self.assertEqual(pose_values(transform["transform"], "translation", "rotation"),
                             [float(row[k]) for k in ("x", "y", "z", "qw", "qx", "qy", "qz")])

    def check_tf_static(self, sequence, ping, message):
        transform, = message["transforms"]
        self.assertEqual([transform["header"]["frame_id"], transform["child_frame_id"]], ["sonar", "sonar_fan"])
        values = pose_values(transform["transform"], "translation", "rotation")
        self.assertEqual(values[:3], [0, 0, 0])
        # The columns are the axes of the fan in the sonar: x up, y to starboard, z ahead.
        np.testing.assert_allclose(matrix(values[3:]), [[0, 0, 1], [0, -1, 0], [1, 0, 0]], atol=1e-15)

    def check_fan(self, sequence, message, beams):
        head, azimuth = sequence.head, sequence.npy("azimuth_rad.npy")
        image, ping_info = message["image"], message["ping_info"]
        self.assertEqual((image["is_bigendian"], image["beam_count"]), (0, beams))
        np.testing.assert_array_equal(message["ranges"], sequence.npy("range_m.npy").astype(np.float32))
        self.assertEqual(ping_info["frequency"], np.float32(head["sonar"]["frequency_hz"]))
        self.assertEqual(ping_info["sound_speed"], np.float32(head["water"]["sound_speed_m_s"]))
        widths = np.full(len(azimuth), head["sonar"]["beams"]["width_rad"], np.float32)
        np.testing.assert_array_equal(ping_info["rx_beamwidths"], widths)
        heights = np.full(len(azimuth), head["sonar"]["elevation"]["width_rad"], np.float32)
        np.testing.assert_array_equal(ping_info["tx_beamwidths"], heights)
        # z ahead, x up, y to starboard; beam 0 is the one to starboard.
        ahead, starboard = np.cos(azimuth), -np.sin(azimuth)
        directions = np.array([[d[k] for k in "xyz"] for d in message["beam_directions"]])
        np.testing.assert_allclose(directions, np.stack([0 * ahead, starboard, ahead], 1), atol=1e-15)
        self.assertGreater(directions[0, 1], 0)

    def check_image(self, sequence, ping, message):
        grey = sequence.png("png", ping, "_polar")
        self.assertEqual(message["image"]["dtype"], 0)
        np.testing.assert_array_equal(message["image"]["data"].reshape(grey.shape), grey)
        self.check_fan(sequence, message, grey.shape[1])

    def check_levels(self, sequence, ping, message):
        level = read_exr(sequence.folder / f"polar/{ping:06}.exr")[0].channels["Y"]
        self.assertEqual(message["image"]["dtype"], 8)
        np.testing.assert_array_equal(message["image"]["data"].view("<f4").reshape(level.shape), level)
        self.check_fan(sequence, message, level.shape[1])

    def check_levels_info(self, sequence, ping, message):
        sonar = sequence.head["sonar"]
        self.assertEqual([message[k] for k in ("intensity_quantity", "intensity_scale", "intensity_reference")],
                         [2, 2, 2], "amplitude, dB, re 1 uPa")
        self.assertEqual([message[k] for k in ("scale", "offset", "tvg_model", "angular_normalization")], [1, 0, 1, 1])
        self.assertEqual(message["source_level_db"], np.float32(sonar["source_level_db"]))
        self.assertTrue(math.isnan(message["tvg_absorption_db_per_km"]))
        self.assertEqual(message["bandwidths"].tolist(), [np.float32(sonar["bandwidth_hz"])])
        np.testing.assert_allclose(message["pulse_lengths"], [exported.gaussian_pulse_s(sonar["bandwidth_hz"])],
                                   rtol=1e-4)
        self.assertEqual(message["tx_signal_types"].tolist(), [1])

    def check_image_info(self, sequence, ping, message):
        """The map from 8-bit values gives the levels again, to half a step."""
        grey = sequence.png("png", ping, "_polar").astype(float)
        level = read_exr(sequence.folder / f"polar/{ping:06}.exr")[0].channels["Y"].astype(float)
        inside = (grey > 0) & (grey < 255)
        self.assertGreater(inside.sum(), 100)
        error = grey * message["scale"] + message["offset"] - level
        self.assertLess(np.abs(error[inside]).max(), 0.51 * message["scale"])
        self.assertEqual([message[k] for k in ("intensity_quantity", "intensity_scale", "intensity_reference")],
                         [2, 2, 2])

    def check_pixels(self, message, encoding, expected):
        self.assertEqual((message["height"], message["width"]), expected.shape)
        self.assertEqual((message["encoding"], message["is_bigendian"]), (encoding, 0))
        self.assertEqual(message["step"], expected.shape[1] * expected.itemsize)
        self.assertEqual(message["data"].tobytes(), expected.tobytes())

    def check_image_of_view(self, sequence, ping, view, message):
        self.check_pixels(message, "mono8", sequence.png("png", ping, f"_{view}"))

    def check_instance_of_view(self, sequence, ping, view, message):
        self.check_pixels(message, "16UC1", sequence.png(view, ping, "_instance").astype("<u2"))

    def check_semantic_of_view(self, sequence, ping, view, message):
        self.check_pixels(message, "8UC1", sequence.png(view, ping, "_semantic"))

    def check_detections_of_view(self, sequence, ping, view, message):
        lines = (sequence.folder / "annotations.jsonl").read_text().splitlines()
        images = next(line["images"] for line in map(json.loads, lines) if line["ping"] == ping)
        boxes = {a["instance"]: a["bbox"] for image in images if image["view"] == view
                 for a in image["annotations"] if a["instance"] != 1}  # the room is stuff
        found = message["detections"]
        self.detections = getattr(self, "detections", 0) + len(found)
        self.assertEqual([int(d["id"]) for d in found], sorted(boxes))
        for detection in found:
            x, y, width, height = boxes[int(detection["id"])]
            box, result = detection["bbox"], detection["results"][0]
            self.assertEqual([box["center"]["position"]["x"], box["center"]["position"]["y"], box["size_x"],
                              box["size_y"]], [x + width / 2, y + height / 2, width, height])
            self.assertEqual(result["hypothesis"], {"class_id": exported.CLASSES[int(detection["id"]) - 1], "score": 1})
            self.check_object_pose(sequence, ping, int(detection["id"]), pose_values(result["pose"]["pose"]))

    def check_object_pose(self, sequence, ping, instance, values):
        """The pose in the sonar, set on the sonar's pose, is that in the world."""
        row = next(r for r in sequence.objects if int(r["ping"]) == ping and int(r["instance"]) == instance)
        sonar = sequence.pose(ping)
        turn = matrix(sonar[3:])
        np.testing.assert_allclose(turn @ values[:3] + sonar[:3], [float(row[k]) for k in "xyz"], atol=1e-12)
        np.testing.assert_allclose(turn @ matrix(values[3:]),
                                   matrix([float(row[k]) for k in ("qw", "qx", "qy", "qz")]), atol=1e-12)

    def points(self, message):
        fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("instance", 16, 4), ("class", 18, 2)]
        self.assertEqual([(f["name"], f["offset"], f["datatype"]) for f in message["fields"]], fields)
        self.assertEqual({f["count"] for f in message["fields"]}, {1})
        kinds = {7: "<f4", 4: "<u2", 2: "u1"}
        kind = np.dtype({"names": [f[0] for f in fields], "offsets": [f[1] for f in fields],
                         "formats": [kinds[f[2]] for f in fields], "itemsize": message["point_step"]})
        points = np.frombuffer(message["data"].tobytes(), kind)
        self.assertEqual((message["height"], message["width"], message["is_dense"]), (1, len(points), 1))
        self.assertEqual(message["row_step"], len(message["data"]))
        return points

    def check_points(self, sequence, ping, message):
        points = self.points(message)
        echoes = sequence.npy(f"scatterers/{ping:06}.npy")
        self.assertGreater(len(echoes), 100)
        sonar = sequence.pose(ping)
        world = np.stack([echoes[k] for k in "xyz"], 1)
        own = (world - sonar[:3]) @ matrix(sonar[3:])
        np.testing.assert_allclose(np.stack([points[k] for k in "xyz"], 1), own, atol=1e-6)
        # The direction of a direct echo is that in which it arrives.
        azimuth = np.arctan2(points["y"], points["x"])
        np.testing.assert_allclose(azimuth, echoes["azimuth_rad"], atol=1e-5)
        np.testing.assert_array_equal(points["instance"], echoes["instance"])
        amplitude = np.hypot(echoes["amp_re"].astype(float), echoes["amp_im"]) * np.abs(echoes["gain"].astype(float))
        level = 20 * np.log10(amplitude) + sequence.head["sonar"]["source_level_db"]
        np.testing.assert_allclose(points["intensity"], level, atol=1e-4)
