"""`ensonify import` and `export --format aris|oculus` against logs written from the published layouts."""
import json
import math
import re
import subprocess
import unittest

import numpy as np

import write_logs as logs
from cases import PROGRAM, RANDOM, ROOT, Case, SonarDataset, ensonify

# Not equally spaced: finer at the edges.
BEARINGS = [round(6500 * math.sin(x)) for x in np.linspace(-1.3, 1.3, 31)]


def aris_counts(beams=128, samples=40):
    return RANDOM.integers(0, 256, (samples, beams), dtype=np.uint8)


class Aris(Case):
    def test_counts_axes_and_times_are_those_of_the_file(self):
        counts = [aris_counts() for _ in range(3)]
        frames = [logs.aris_frame(c, FrameIndex=i, sonarTimeStamp=10**15 + 125_003 * i, Depth=2.5 if i else 0)
                  for i, c in enumerate(counts)]
        data = self.imported(logs.aris(frames))
        sequence = data.sequence(0)
        for i, ping in enumerate(sequence):
            self.assertTrue((ping.recorded == counts[i]).all())
            self.assertEqual(ping.time_s, 0.125003 * i)
            expected = counts[i] / 255 * 80
            self.assertLess(abs(ping.polar.level_db - expected).max(), 0.033)  # steps of half precision
        # Beam 0 of the file is on the right: the most negative azimuth. Centers of the published table.
        self.assertAlmostEqual(math.degrees(sequence.azimuth_rad[0]), -15.0068, places=10)
        self.assertAlmostEqual(math.degrees(sequence.azimuth_rad[127]), 15.0156, places=10)
        speed = float(np.float32(1480.5))
        expected = (2700 + 10 * np.arange(40)) * 1e-6 * speed / 2
        np.testing.assert_allclose(sequence.range_m, expected, rtol=1e-14)
        self.assertEqual(sequence[1].pose.position_m[2], -2.5)
        self.assertEqual(sequence.info["recording"]["instrument"], "ARIS 3000")
        self.assertEqual(sequence.info["sonar"]["frequency_hz"], 3.0e6)

    def test_attitude(self):
        # Heading east, bow up by 10 degrees, starboard down by 20.
        frame = logs.aris_frame(aris_counts(), Heading=90, Pitch=10, Roll=20)
        rotation = self.imported(logs.aris([frame]))[0].pose.rotation
        np.testing.assert_allclose(rotation @ [1, 0, 0], [math.cos(math.radians(10)), 0, math.sin(math.radians(10))],
                                   atol=1e-7)
        self.assertGreater((rotation @ [0, 1, 0])[2], 0)  # port is up
        # The compass where the platform has none.
        frame = logs.aris_frame(aris_counts(), CompassHeading=180)
        pose = self.imported(logs.aris([frame]), out="compass")[0].pose
        np.testing.assert_allclose(pose.rotation @ [1, 0, 0], [0, -1, 0], atol=1e-7)

    def test_a_change_of_settings_begins_a_sequence(self):
        frames = [logs.aris_frame(aris_counts(), sonarTimeStamp=1000), logs.aris_frame(aris_counts(64), PingMode=6),
                  logs.aris_frame(aris_counts(64), PingMode=6), logs.aris_frame(aris_counts(64, 50), PingMode=6)]
        data = self.imported(logs.aris(frames))
        self.assertEqual([len(data.sequence(i)) for i in data.sequences], [1, 2, 1])
        self.assertIn("a new sequence begins", self.said)
        self.assertEqual(data.sequence(1).info["recording"]["first_frame"], 1)
        # A drifting sound speed does not.
        frames = [logs.aris_frame(aris_counts(), SoundSpeed=1480.5 + 0.1 * i) for i in range(3)]
        self.assertEqual(len(self.imported(logs.aris(frames), out="drift").sequences), 1)

    def test_some_frames(self):
        counts = [aris_counts() for _ in range(5)]
        data = self.imported(logs.aris([logs.aris_frame(c) for c in counts]), "log.aris", "--pings", "1:3")
        self.assertEqual(len(data), 2)
        self.assertTrue((data[0].recorded == counts[1]).all())
        self.assertEqual(data.name, "log")
        said = ensonify("import", self.folder / "log.aris", "-o", self.folder / "none", "--pings", "4:6", status=2)
        self.assertIn("frames 0 to 4", said)

    def test_a_last_frame_that_is_cut_off_is_left_out(self):
        log = logs.aris([logs.aris_frame(aris_counts()) for _ in range(3)])
        self.assertEqual(len(self.imported(log[:-7])), 2)
        self.assertIn("the last frame is cut off; used the 2 before it", self.said)

    def test_damage_is_refused_with_its_place(self):
        good = logs.aris_frame(aris_counts())
        cases = [(logs.aris([good, b"x" * len(good)]), f"byte {1024 + len(good) + 12}: no frame begins here"),
                 (logs.aris([logs.aris_frame(aris_counts(), PingMode=13)]), "byte 1460: ping mode 13"),
                 (logs.aris([logs.aris_frame(aris_counts(), ReorderedSamples=0)]), "byte 1540: the samples are in"),
                 (logs.aris([logs.aris_frame(aris_counts(), SoundSpeed=math.nan)]), "a sound speed of nan"),
                 (logs.aris([logs.aris_frame(aris_counts(), LargeLens=1)]), "no table of their azimuths"),
                 (logs.aris([]), "no whole frame"),
                 (b"DDF\x04" + bytes(2000), "DIDSON"), (b"BM" + bytes(2000), "neither an .aris file")]
        for log, words in cases:
            path = self.folder / "bad.aris"
            path.write_bytes(log)
            said = ensonify("import", path, "-o", self.folder / "bad", status=2)
            self.assertIn(words, said)
            self.assertFalse((self.folder / "bad").exists())


class Oculus(Case):
    def message(self, kind=np.uint8, **options):
        counts = RANDOM.integers(0, np.iinfo(kind).max, (20, len(BEARINGS)), dtype=kind, endpoint=True)
        return counts, logs.oculus_message(counts, BEARINGS, **options)

    def check(self, ping, counts):
        # Bearings are clockwise: the last beam of the message is to starboard, which is our beam 0.
        self.assertTrue((ping.recorded == counts[:, ::-1]).all())
        degrees = np.degrees(ping.sequence.azimuth_rad)
        np.testing.assert_allclose(degrees, [-b / 100 for b in BEARINGS[::-1]], atol=1e-12)

    def test_bits_versions_and_compression(self):
        for kind in (np.uint8, np.uint16):
            for version in (1, 2):
                for compressed in (False, True):
                    counts, message = self.message(kind, version=version)
                    items = [logs.oculus_item(b"settings", 1.6e9, kind=1),
                             logs.oculus_item(message, 1.6e9 + 0.5, compressed=compressed),
                             logs.oculus_item(message, 1.6e9 + 0.75, compressed=compressed)]
                    name = f"{kind.__name__}{version}{compressed}"
                    data = self.imported(logs.oculus(items), out=name)
                    self.check(data[0], counts)
                    self.assertEqual([ping.time_s for ping in data], [0, 0.25])
                    most = np.iinfo(kind).max
                    with np.errstate(divide="ignore"):
                        level = 20 * np.log10(counts[:, ::-1] / most)
                    expected = np.where(counts[:, ::-1] == 0, -99, level)
                    self.assertLess(abs(data[0].polar.level_db - expected).max(), 0.033)
                    np.testing.assert_allclose(data.sequence(0).range_m, 0.01 * np.arange(20), atol=1e-15)

    def test_row_gains_and_gamma(self):
        gains = [4 ** (i % 5) for i in range(20)]
        gains[3] = 0
        counts, message = self.message(np.uint16, gains=gains, gamma=127)
        ping = self.imported(logs.oculus([logs.oculus_item(message, 5)]))[0]
        self.check(ping, counts)
        self.assertEqual(list(ping.row_gain), gains)
        recorder = ping.sequence.info["recorder"]
        self.assertEqual((recorder["bits"], recorder["scale"], recorder["gamma"]), (16, "amplitude", 127 / 255))
        # The amplitude is count^(1/gamma) over the root of the row's gain.
        row, level = 7, ping.polar.level_db
        full_scale = 10 ** (recorder["db"][1] / 20)
        amplitude = full_scale * (counts[row, ::-1] / 65535.0) ** (255 / 127) / math.sqrt(gains[row])
        heard = counts[row, ::-1] > 0
        self.assertLess(abs(level[row, heard] - 20 * np.log10(amplitude[heard])).max(), 0.07)
        self.assertTrue((level[3] == -99).all())
        np.testing.assert_allclose(ping.recorded_level_db, level, atol=0.07)
        heard = counts[:, ::-1] * (np.array(gains)[:, None] > 0) > 0
        self.assertTrue(((level > -99) == heard).all())

    def test_a_stream_of_messages(self):
        first, second = self.message(start=100.0), self.message(start=100.125)
        data = self.imported(first[1] + second[1], "stream.raw")
        self.check(data[1], second[0])
        self.assertEqual(data[1].time_s, 0.125)
        # The clock of version 1 has 32 bits of nanoseconds.
        first, second = self.message(version=1, start=4.25), self.message(version=1, start=4.5)
        data = self.imported(first[1] + second[1], out="one")
        self.assertAlmostEqual(data[1].time_s, 0.25, places=6)

    def test_cartesian_image_shows_unequal_beams_where_they_are(self):
        counts = np.full((20, len(BEARINGS)), 10, np.uint8)
        counts[15, 26] = 255  # one echo to starboard
        data = self.imported(logs.oculus([logs.oculus_item(logs.oculus_message(counts, BEARINGS), 1)]))
        grid = data.sequence(0).info["cartesian"]
        image = data[0].cartesian.grey
        row, column = np.argwhere(image == image.max()).mean(axis=0)
        x = grid["x_top_m"] - (row + 0.5) * grid["metres_per_pixel"]
        y = grid["y_left_m"] - (column + 0.5) * grid["metres_per_pixel"]
        bearing = math.radians(BEARINGS[26] / 100)
        self.assertLess(math.hypot(x - 0.15 * math.cos(bearing), y + 0.15 * math.sin(bearing)), 0.004)
        # The reader makes the same image.
        self.assertTrue((data[0].cartesian.displayed(data.display()) == image).all())
        self.assertTrue((data[0].polar.displayed(data.display()) == data[0].polar.grey).all())

    def test_damage_is_refused_with_its_place(self):
        counts, message = self.message()
        item = logs.oculus_item(message, 1)
        wrong = bytearray(message)
        wrong[170:172] = b"\xff\xff"  # ranges
        falling = logs.oculus_message(counts, BEARINGS[:15] + BEARINGS[14:15] + BEARINGS[16:])
        cases = [(logs.oculus([item, b"?" * 50]), f"byte {48 + len(item)}: no item begins here"),
                 (logs.oculus([item], encryption=1), "byte 26: the log is encrypted"),
                 (logs.oculus([logs.oculus_item(bytes(wrong), 1)]), "an image of 620 bytes"),
                 (logs.oculus([logs.oculus_item(falling, 1)]), "rise or fall throughout"),
                 (logs.oculus([item[:24] + b"\x02" + item[25:]]), "compression 2"),
                 (logs.oculus([logs.oculus_item(message[:100], 1)]), "a ping of 100 bytes"),
                 (logs.oculus([logs.oculus_item(self.message(np.uint32)[1], 1)]), "counts of 32 bits"),
                 (logs.oculus([]), "no whole frame")]
        damaged = bytearray(logs.oculus_item(message, 1, compressed=True))
        damaged[60] ^= 255
        cases.append((logs.oculus([bytes(damaged)]), "the compressed data are damaged"))
        for log, words in cases:
            path = self.folder / "bad.oculus"
            path.write_bytes(log)
            self.assertIn(words, ensonify("import", path, "-o", self.folder / "bad", status=2))
            self.assertFalse((self.folder / "bad").exists())


class RoundTrip(Case):
    def again(self, data, kind):
        out = self.folder / "exported"
        ensonify("export", data.folder, "--format", kind, "-o", out)
        return self.imported((out / f"000000.{kind}").read_bytes(), out="again")

    def assert_same(self, one, two):
        for name in ("azimuth_rad.npy", "range_m.npy", "poses.csv"):
            self.assertEqual((one.sequence(0).folder / name).read_bytes(), (two.sequence(0).folder / name).read_bytes())
        for a, b in zip(one, two):
            self.assertTrue((a.recorded == b.recorded).all())
            self.assertTrue((a.polar.level_db == b.polar.level_db).all())

    def test_aris(self):
        for beams, system, mode, lens in ((48, 2, 1, 1), (96, 0, 4, 0), (128, 1, 12, 0)):
            frames = [logs.aris_frame(aris_counts(beams), TheSystemType=system, PingMode=mode, LargeLens=lens,
                                      sonarTimeStamp=10**15 + 99_991 * i, SamplePeriod=7, SoundSpeed=1435.93)
                      for i in range(3)]
            data = self.imported(logs.aris(frames), out=f"data{beams}")
            again = self.again(data, "aris")
            self.assert_same(data, again)
            self.assertEqual(again.sequence(0).info["recording"]["mode"], mode)
            for folder in ("exported", "again"):
                subprocess.run(["rm", "-r", self.folder / folder], check=True)

    def test_oculus(self):
        counts = RANDOM.integers(0, 65536, (20, len(BEARINGS)), dtype=np.uint16)
        messages = [logs.oculus_message(counts + i, BEARINGS, gains=[7 + i] * 20, gamma=127) for i in range(3)]
        items = [logs.oculus_item(message, 1.6e9 + i / 7) for i, message in enumerate(messages)]
        data = self.imported(logs.oculus(items))
        again = self.again(data, "oculus")
        self.assert_same(data, again)
        self.assertTrue((again[2].row_gain == 9).all())

    def test_simulated_data(self):
        ensonify("generate", ROOT / "scenes/sonar_tank.yaml", "-o", self.folder / "tank", "--pings", "0:2", "--quiet",
                 "--set", "sonar.preset=aris_3000_hf")
        tank = SonarDataset(self.folder / "tank")
        again = self.again(tank, "aris")
        level, white = tank[1].polar.level_db, tank.info["png"]["db"][1]
        shown = np.clip(level - white + 80, 0, 80)
        self.assertLess(abs(again[1].polar.level_db - shown).max(), 0.5 * 80 / 255 + 0.04)
        np.testing.assert_allclose(again.sequence(0).range_m, tank.sequence(0).range_m, rtol=1e-6)
        self.assertEqual(again[1].time_s, tank[1].time_s)
        ensonify("export", tank.folder, "--format", "oculus", "-o", self.folder / "as_oculus", "--full-scale-db", 110)
        log = (self.folder / "as_oculus/000000.oculus").read_bytes()
        levels = self.imported(log, out="oculus")[1].polar.level_db
        shown = (level > 60) & (level < 110)  # at least 200 counts
        self.assertGreater(shown.sum(), 1000)
        self.assertLess(abs(levels - (level - 110))[shown].max(), 0.08)

    def test_simulated_counts(self):
        # 128.2 - 48.2 is not 80 in floating point.
        ensonify("generate", ROOT / "scenes/sonar_tank.yaml", "-o", self.folder / "tank", "--pings", "0:1", "--quiet",
                 "--set", "sonar.preset=aris_3000_hf",
                 "--set", "sonar.recorder={bits: 8, scale: db, db: [48.2, 128.2]}")
        tank = SonarDataset(self.folder / "tank")
        self.assertTrue((self.again(tank, "aris")[0].recorded == tank[0].recorded).all())

    def test_what_a_log_cannot_hold_is_refused(self):
        ensonify("generate", ROOT / "scenes/sonar_tank.yaml", "-o", self.folder / "tank", "--pings", "0:1", "--quiet")
        said = ensonify("export", self.folder / "tank", "--format", "aris", "-o", self.folder / "x", status=2)
        self.assertIn("Use --format oculus", said)
        data = self.imported(logs.aris([logs.aris_frame(aris_counts())]))
        said = ensonify("export", data.folder, "--format", "oculus", "-o", self.folder / "x", status=2)
        self.assertIn("those of an Oculus begin at 0", said)
        ensonify("generate", ROOT / "scenes/sonar_tank.yaml", "-o", self.folder / "early", "--quiet",
                 "--set", "sonar.preset=aris_3000_hf", "--set", "trajectory={poses: [{time_s: -5}], pings: 1}")
        said = ensonify("export", self.folder / "early", "--format", "aris", "-o", self.folder / "x", status=2)
        self.assertIn("ping 0 is at -5 s", said)

    def test_times_that_fall(self):
        frames = [logs.aris_frame(aris_counts(), sonarTimeStamp=10**15 + after) for after in (0, 200_000, 100_000)]
        data = self.imported(logs.aris(frames))
        said = ensonify("export", data.folder, "--format", "mcap", "-o", self.folder / "x", status=2)
        self.assertIn("earlier", said)
        self.assertNotIn("damaged", said)


class Commands(Case):
    def setUp(self):
        super().setUp()
        self.data = self.imported(logs.aris([logs.aris_frame(aris_counts(), sonarTimeStamp=100_000 * i + 1)
                                             for i in range(3)]))

    def test_other_commands_take_a_recording(self):
        folder = self.data.folder
        ensonify("figure", folder, "-o", self.folder / "figure.png")
        ensonify("figure", folder, "-o", self.folder / "polar.svg", "--view", "polar")
        ensonify("report", folder, "-o", self.folder / "report.html")
        ensonify("render", folder, "--name", "gain", "--tvg", 30, "--scale", "amplitude", "--gamma", 0.5)
        ensonify("verify", folder)
        data = SonarDataset(folder)
        for view in (data[1].polar, data[1].cartesian):
            self.assertTrue((view.render("gain") == view.displayed(data.display("gain"))).all())
        for kind in ("tum", "hdf5", "webdataset", "mcap"):
            ensonify("export", folder, "--format", kind, "-o", self.folder / kind)

    def test_there_are_no_labels(self):
        folder, ping = self.data.folder, self.data[0]
        self.assertFalse(ping.polar.has("instance") or ping.polar.has("clean_db"))
        self.assertTrue(ping.polar.has("level_db"))
        said = ensonify("export", folder, "--format", "coco", "-o", self.folder / "coco", status=2)
        possible = re.search(r"expected one of ([\w, ]*)", said)[1].split(", ")
        self.assertLess({"tum", "hdf5", "webdataset", "mcap", "aris", "oculus"}, set(possible))
        help_text = subprocess.run([PROGRAM, "export", "--help"], capture_output=True, text=True, check=True).stdout
        kinds = re.search(r"--format TEXT:\{([^}]*)\}", help_text)[1].split(",")
        self.assertGreater(len(set(kinds) - set(possible)), 10)
        for kind in set(kinds) - set(possible):
            self.assertIn("expected one of", ensonify("export", folder, "--format", kind, "-o", self.folder / kind, status=2))
        said = ensonify("figure", folder, "-o", self.folder / "x.png", "--outlines", status=2)
        self.assertIn("levels and no labels", said)
        self.assertEqual(json.loads((folder / "coco.json").read_text())["annotations"], [])

    def test_an_import_is_resumed_and_repeated(self):
        files = {path.relative_to(self.data.folder): path.read_bytes()
                 for path in self.data.folder.rglob("*") if path.is_file() and path.name != "provenance.json"}
        log = self.folder / "log.bin"
        said = ensonify("import", log, "-o", self.data.folder, "--height-px", 200)
        self.assertIn("already complete", said)
        (self.data.folder / "dataset.sha256").unlink()
        (self.data.folder / "sequences/000000/polar/000001.exr").unlink()
        ensonify("import", log, "-o", self.data.folder, "--height-px", 200, "--threads", 1)
        for name, content in files.items():
            self.assertEqual((self.data.folder / name).read_bytes(), content, name)
        said = ensonify("import", log, "-o", self.data.folder, status=2)  # other rows of Cartesian images
        self.assertTrue(said)

    def test_damage_to_the_data_set_is_found(self):
        path = self.data.folder / "sequences/000000/recorded/000001_8bit.png"
        path.write_bytes(path.read_bytes()[:-1])
        ensonify("verify", self.data.folder, status=1)


if __name__ == "__main__":
    unittest.main()
