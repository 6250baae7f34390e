"""mcap: the records by a reader of this folder, written from the format's specification, and the
messages by npm's @mcap/core and @foxglove/rosmsg2-serialization, against the data set.

MCAP_BUILD is a folder for npm's packages; without npm, or a registry, the part that needs them skips.
"""
import json
import math
import os
import pathlib
import shutil
import subprocess
import unittest

import numpy as np

import exported
from mcap_messages import ONCE, TYPES, Messages
from mcap_records import Reader
from sonar_dataset import read_exr


class Files(Messages):
    format_name = "mcap"

    def check_sequence(self, reader, sequence, messages, absent=()):
        expected = {topic: kind for topic, kind in TYPES.items() if topic not in absent}
        self.assertEqual(dict(reader.topics.values()), expected)
        counts = dict.fromkeys(expected, 0)
        for topic, _, number, time, message in messages:
            ping = sequence.pings[counts[topic]]
            counts[topic] += 1
            self.assertEqual(time, round(float(sequence.poses[ping]["time_s"]) * 1e9) + self.later_ns)
            self.check_message(sequence, ping, topic, message)
        self.assertEqual(counts, {topic: 1 if topic in ONCE else len(sequence.pings) for topic in expected})

    def check(self, source, absent=()):
        out = exported.export("mcap", source=source)
        chunks = []
        for sequence in exported.sequences(source):
            reader = Reader(self)
            messages = reader.read((out / f"{sequence.number:06}.mcap").read_bytes())
            self.assertEqual([number for topic, _, number, *_ in messages if topic == "/tf"],
                             list(range(len(sequence.pings))))
            self.check_sequence(reader, sequence, messages, absent)
            self.assertEqual([name for name, _ in reader.metadata], ["sequence"])
            self.assertEqual(reader.metadata[0][1],
                             {"dataset": "exported", "sequence": str(sequence.number), "split": sequence.split,
                              "first_ping": "0", "pings": str(len(sequence.pings)), "later_by_s": "0"})
            self.assertIn("durability: 1", reader.qualities["/tf_static"]["offered_qos_profiles"])
            chunks.append(reader.chunks)
        self.assertEqual(len(list(out.iterdir())), 2)
        return chunks

    def test_structure_and_messages(self):
        self.detections = 0
        self.check(exported.dataset("--export-scatterers"))
        self.assertGreater(self.detections, 0)

    def test_only_topics_of_existing_files(self):
        """Several chunks, and one topic of images alone."""
        big = ("--set", "sonar.beams.count=1536", "--set", "sonar.rays.elevation=1",
               "--set", "output={timeseries: none, polar: false, cartesian: false}", "--set", "trajectory.pings=5")
        absent = [topic for topic in TYPES if topic.startswith(("/sonar/polar", "/sonar/cartesian", "/sonar/levels",
                                                                "/sonar/points"))]
        self.assertGreater(min(self.check(exported.dataset(*big), absent)), 1, "there is one chunk only")

    def check_image_info(self, sequence, ping, message):
        if (sequence.folder / "polar").is_dir():
            super().check_image_info(sequence, ping, message)

    def test_levels_without_8_bit_images(self):
        source = exported.dataset("--set", "output.png=false")
        absent = ["/sonar/image", "/sonar/image/info", "/sonar/cartesian/image", "/sonar/points"]
        self.check(source, absent)

    def test_points_of_surfaces(self):
        """With planes of surfaces, each pixel of an instance is a point at its strongest echo."""
        source = exported.dataset("--set", "output.surfaces=true")
        sequence = exported.sequences(source)[0]
        messages = Reader(self).read((exported.export("mcap", source=source) / "000000.mcap").read_bytes())
        clouds = [m for topic, *_, m in messages if topic == "/sonar/points"]
        azimuth = sequence.npy("azimuth_rad.npy")
        for ping, message in zip(sequence.pings, clouds, strict=True):
            points = self.points(message)
            planes = read_exr(sequence.folder / f"polar/{ping:06}_surfaces.exr")[0].channels
            level = read_exr(sequence.folder / f"polar/{ping:06}.exr")[0].channels["Y"]
            here = np.isfinite(planes["surface_range_m"])
            self.assertGreater(here.sum(), 100)
            r, elevation = (planes[k][here].astype(float) for k in ("surface_range_m", "surface_elevation_rad"))
            beam = np.nonzero(here)[1]
            np.testing.assert_allclose(points["x"], r * np.cos(elevation) * np.cos(azimuth[beam]), atol=1e-6)
            np.testing.assert_allclose(points["y"], r * np.cos(elevation) * np.sin(azimuth[beam]), atol=1e-6)
            np.testing.assert_allclose(points["z"], r * np.sin(elevation), atol=1e-6)
            np.testing.assert_array_equal(points["intensity"], level[here])
            np.testing.assert_array_equal(points["instance"], sequence.png("polar", ping, "_instance")[here])
            np.testing.assert_array_equal(points["class"], sequence.png("polar", ping, "_semantic")[here])

    def test_one_file_for_all_sequences(self):
        """The second sequence begins a whole number of seconds later, after the end of the first."""
        source = exported.dataset("--export-scatterers")
        out = exported.export("mcap", "--one-file", source=source)
        self.assertEqual([path.name for path in out.iterdir()], ["dataset.mcap"])
        reader = Reader(self)
        messages = reader.read((out / "dataset.mcap").read_bytes())
        first, second = exported.sequences(source)
        self.assertEqual([m[1]["later_by_s"] for m in reader.metadata], ["0", "2"])
        middle = next(i for i, m in enumerate(messages) if i and m[0] == "/tf_static")
        self.check_sequence(reader, first, messages[:middle])
        end, begin = messages[middle - 1][3], messages[middle][3]
        self.assertTrue(10**9 <= begin - end < 2 * 10**9)
        self.later_ns = 2 * 10**9
        self.check_sequence(reader, second, messages[middle:])

    def info_of(self, source, topic="/sonar/image/info"):
        messages = Reader(self).read((exported.export("mcap", source=source) / "000000.mcap").read_bytes())
        return next(m for found, *_, m in messages if found == topic)

    def test_what_8_bit_values_mean(self):
        axes = ("intensity_scale", "intensity_reference", "tvg_model")
        for display, expected in (("{automatic_gain: true}", [2, 1, 1]), ("{scale: amplitude}", [0, 1, 1]),
                                  ("{automatic_gain: true, tvg: {spreading: 20}}", [2, 1, 2])):
            with self.subTest(display=display):
                info = self.info_of(exported.dataset("--set", f"output.png={display}"))
                self.assertEqual([info[k] for k in axes], expected)
                self.assertEqual(info["scale"], 0, "there is a map although the gain is unknown")

    def test_8_bit_values_with_time_varied_gain(self):
        source = exported.dataset("--set", "output.png={tvg: {spreading: 40}, gain_db: 3}")
        info, sequence = self.info_of(source), exported.sequences(source)[0]
        alpha, r = sequence.head["water"]["absorption_db_m"], sequence.npy("range_m.npy")[:, None]
        self.assertEqual([info["tvg_model"], info["intensity_reference"]], [3, 1])
        self.assertEqual(info["tvg_absorption_db_per_km"], np.float32(1000 * alpha))
        grey = sequence.png("png", 0, "_polar").astype(float)
        level = read_exr(sequence.folder / "polar/000000.exr")[0].channels["Y"].astype(float)
        inside = (grey > 0) & (grey < 255)
        self.assertGreater(inside.sum(), 100)
        with np.errstate(divide="ignore"):
            error = grey * info["scale"] + info["offset"] - (level + 40 * np.log10(r) + 2 * alpha * r)
        self.assertLess(np.abs(error[inside]).max(), 0.51 * info["scale"])

    def test_recordings_have_images_alone(self):
        log = exported.export("oculus")
        folder = exported.scratch() / "recording"
        made = exported.run("import", log / "000000.oculus", "-o", folder, "--quiet")
        self.assertEqual(made.returncode, 0, made.stderr)
        reader = Reader(self)
        messages = reader.read((exported.export("mcap", source=folder) / "000000.mcap").read_bytes())
        self.assertEqual({topic for topic, _ in reader.topics.values()},
                         {topic for topic in TYPES if not topic.endswith(("instance", "semantic", "detections", "points"))})
        info = next(m for topic, *_, m in messages if topic == "/sonar/levels/info")
        self.assertEqual((info["intensity_reference"], info["tvg_model"], info["sonar_model"]), (1, 0, "Oculus"))
        self.assertTrue(math.isnan(info["source_level_db"]))
        self.assertEqual(len(info["pulse_lengths"]), 0)
        image = next(m for topic, *_, m in messages if topic == "/sonar/image/info")
        self.assertEqual(image["tvg_model"], 0, "the gain of the instrument is not known")

    def test_chosen_classes(self):
        out = exported.export("mcap", "--classes", "pole")
        messages = Reader(self).read((out / "000000.mcap").read_bytes())
        ids = {d["id"] for topic, *_, m in messages if topic.endswith("detections") for d in m["detections"]}
        self.assertEqual(ids, {"3"})

    def with_times(self, *times_s):
        """A copy of the data set whose first sequence has other times in poses.csv."""
        folder = exported.scratch() / "copy"
        shutil.copytree(exported.dataset(), folder)
        table = folder / "sequences/000000/poses.csv"
        head, *rows = table.read_text().splitlines()
        column = head.split(",").index("time_s")
        for i, time_s in enumerate(times_s):
            words = rows[i].split(",")
            words[column] = str(time_s)
            rows[i] = ",".join(words)
        table.write_text("\n".join([head, *rows]) + "\n")
        return folder

    def test_times_rise_or_stay(self):
        messages = Reader(self).read((exported.export("mcap", source=self.with_times(1, 1, 1.5)) /
                                      "000000.mcap").read_bytes())
        self.assertEqual([time for topic, _, _, time, _ in messages if topic == "/tf"],
                         [10**9, 10**9, 15 * 10**8])
        result = exported.run("export", self.with_times(1, 0.5), "--format", "mcap", "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("the time of ping 1 is earlier than that of the ping before it", result.stderr)

    def test_times_before_zero_are_refused(self):
        source = exported.dataset("--set", "trajectory.poses.0.time_s=-1")
        result = exported.run("export", source, "--format", "mcap", "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 2)
        self.assertIn("-1 s", result.stderr)


class ByOtherHands(unittest.TestCase):
    """The authors' own libraries read the file, index, checksums, schemas and messages."""

    @classmethod
    def setUpClass(cls):
        if not shutil.which("npm") or not shutil.which("node"):
            raise unittest.SkipTest("npm or node is not here")
        here = pathlib.Path(__file__).parent / "mcap_reader"
        cls.folder = pathlib.Path(os.environ.get("MCAP_BUILD", exported.scratch())) / "mcap_reader"
        cls.folder.mkdir(parents=True, exist_ok=True)
        for name in ("package.json", "package-lock.json", "read.js"):
            shutil.copy(here / name, cls.folder / name)
        if not (cls.folder / "node_modules/@mcap/core").is_dir():
            made = subprocess.run(["npm", "ci", "--no-audit", "--no-fund", "--fetch-retries=1",
                                   "--fetch-timeout=20000"], cwd=cls.folder, capture_output=True, text=True)
            if made.returncode != 0:
                raise unittest.SkipTest("npm ci failed, is there a registry? " + made.stderr[-300:])

    def read(self, path):
        result = subprocess.run(["node", "read.js", str(path)], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [json.loads(line) for line in result.stdout.splitlines()]
        return lines[0], lines[1:]

    def test_everything(self):
        source = exported.dataset("--export-scatterers")
        out = exported.export("mcap", source=source)
        for sequence in exported.sequences(source):
            index, messages = self.read(out / f"{sequence.number:06}.mcap")
            self.assertEqual(index["header"]["profile"], "ros2")
            self.assertEqual(index["statistics"]["messageCount"], str(len(messages)))
            self.assertEqual({s["name"] for s in index["schemas"]}, set(TYPES.values()))
            images = [m for m in messages if m["topic"] == "/sonar/image"]
            poses = [m for m in messages if m["topic"] == "/sonar/pose"]
            clouds = [m for m in messages if m["topic"] == "/sonar/points"]
            for ping, image, pose, cloud in zip(sequence.pings, images, poses, clouds, strict=True):
                points = len(sequence.npy(f"scatterers/{ping:06}.npy"))
                self.assertEqual((cloud["message"]["width"], cloud["message"]["point_step"]), (points, 20))
                self.check_image(sequence, ping, image)
                self.check_pose(sequence, ping, pose)

    def check_image(self, sequence, ping, found):
        message, grey = found["message"], sequence.png("png", ping, "_polar")
        time = float(sequence.poses[ping]["time_s"])
        stamp = message["header"]["stamp"]
        self.assertEqual(stamp["sec"], math.floor(time))
        self.assertEqual(stamp["nanosec"], round(time % 1 * 1e9))
        self.assertEqual(int(found["logTime"]), round(time * 1e9))
        image = message["image"]
        self.assertEqual((image["is_bigendian"], image["dtype"], image["beam_count"]), (False, 0, grey.shape[1]))
        np.testing.assert_array_equal(np.array(image["data"], np.uint8).reshape(grey.shape), grey)
        np.testing.assert_array_equal(np.float32(message["ranges"]), sequence.npy("range_m.npy").astype(np.float32))
        azimuth = sequence.npy("azimuth_rad.npy")
        directions = [[d["x"], d["y"], d["z"]] for d in message["beam_directions"]]
        np.testing.assert_allclose(directions, np.stack([0 * azimuth, -np.sin(azimuth), np.cos(azimuth)], 1),
                                   atol=1e-15)
        self.assertEqual(len(message["ping_info"]["rx_beamwidths"]), len(azimuth))
        self.assertEqual(message["ping_info"]["frequency"], sequence.head["sonar"]["frequency_hz"])

    def check_pose(self, sequence, ping, found):
        pose = found["message"]["pose"]
        values = [pose["position"][k] for k in "xyz"] + [pose["orientation"][k] for k in "wxyz"]
        self.assertEqual(values, sequence.pose(ping))


if __name__ == "__main__":
    unittest.main()
