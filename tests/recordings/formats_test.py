"""`ensonify import` of MCAP and of folders of images."""
import math
import re
import unittest

import numpy as np
from PIL import Image

import write_logs as logs
from cases import RANDOM, ROOT, Case, SonarDataset, ensonify


class Mcap(Case):
    def test_sonar_images_of_ros_2(self):
        counts = RANDOM.integers(0, 65536, (20, 15), dtype=np.uint16)
        bearings = np.radians(np.linspace(-30, 30, 15) + np.sin(np.arange(15)))
        for big, chunked, order in ((False, True, 1), (True, False, -1)):
            ranges = 3 + 0.05 * np.arange(20)
            messages = [logs.projected_image(counts + i, bearings[::order], ranges, 10**12 + 125_000 * i, big)
                        for i in range(3)]
            data = self.imported(logs.mcap(messages, chunked=chunked), "bag.mcap", out=f"mcap{order}")
            expected = counts[:, ::-1] if order == 1 else counts  # bearings are to starboard
            for i, ping in enumerate(data):
                self.assertTrue((ping.recorded == expected + i).all())
                self.assertEqual(ping.time_s, 0.125 * i)
            np.testing.assert_allclose(data.sequence(0).azimuth_rad, -bearings[::-1], atol=1e-12)
            np.testing.assert_allclose(data.sequence(0).range_m, ranges, atol=1e-6)

    def test_raw_images_of_ros_2(self):
        """Ranges by (sample + first) c / (2 rate), angles to starboard."""
        counts = RANDOM.integers(0, 256, (20, 15), dtype=np.uint8)
        angles = np.radians(np.linspace(-40, 40, 15))
        messages = [logs.raw_image(counts + i, angles, 3e4, 40, 10**12 + 125_000 * i) for i in range(2)]
        data = self.imported(logs.mcap(messages, kind="RawSonarImage"), "raw.mcap", out="raw")
        for i, ping in enumerate(data):
            self.assertTrue((ping.recorded == (counts + i)[:, ::-1]).all())
            self.assertEqual(ping.time_s, 0.125 * i)
        np.testing.assert_allclose(data.sequence(0).azimuth_rad, -angles[::-1], atol=1e-6)
        np.testing.assert_allclose(data.sequence(0).range_m, (40 + np.arange(20)) * 1490 / 6e4, atol=1e-6)
        silent = logs.raw_image(counts.astype(np.uint16), angles[::-1], 3e4, 0, 0, True, sound_speed=0)
        data = self.imported(logs.mcap([silent], kind="RawSonarImage", chunked=False), "big.mcap", out="big")
        self.assertTrue((data[0].recorded == counts).all())
        self.assertAlmostEqual(data.sequence(0).range_m[1], 0.025, places=9)
        for bad, words in ((logs.raw_image(counts, angles, 0, 0, 0), "20 samples at 0 Hz"),
                           (logs.raw_image(counts, angles, 3e4, 0, 0, samples=10**6), "1000000 samples"),
                           (logs.raw_image(counts, angles, 3e4, 0, 0, samples=19), "bytes of data"),
                           (logs.raw_image(counts, np.linspace(-1, 1, 4097), 3e4, 0, 0),
                            "4097 receive angles; expected at most 4096")):
            (self.folder / "bad.mcap").write_bytes(logs.mcap([bad], kind="RawSonarImage"))
            self.assertIn(words, ensonify("import", self.folder / "bad.mcap", "-o", self.folder / "bad", status=2))

    def test_compressed_chunks(self):
        counts, bearings = RANDOM.integers(0, 256, (20, 15), dtype=np.uint8), np.radians(np.linspace(-30, 30, 15))
        message = logs.projected_image(counts, bearings, 0.05 * np.arange(20), 0)
        data = self.imported(logs.mcap([message, message], compression="zstd"), "zstd.mcap", out="zstd")
        self.assertEqual(len(data), 2)
        self.assertTrue((data[1].recorded == counts[:, ::-1]).all())

    def test_our_own_export_comes_back(self):
        ensonify("generate", ROOT / "scenes/sonar_tank.yaml", "-o", self.folder / "tank", "--pings", "0:2", "--quiet")
        tank = SonarDataset(self.folder / "tank")
        ensonify("export", tank.folder, "--format", "mcap", "-o", self.folder / "mcap")
        black, white = tank.info["png"]["db"]
        data = self.imported((self.folder / "mcap/000000.mcap").read_bytes(), "tank.mcap", "--db", f"{black}:{white}")
        for a, b in zip(tank, data):
            self.assertTrue((a.polar.grey == b.recorded).all())
            self.assertTrue((b.polar.grey == b.recorded).all())
            self.assertAlmostEqual(a.time_s, b.time_s, places=6)
        np.testing.assert_allclose(data.sequence(0).azimuth_rad, tank.sequence(0).azimuth_rad, atol=1e-12)

    def image(self, values, time_us=0):
        return logs.projected_image(values, np.radians(np.linspace(30, -30, 15)), 0.05 * np.arange(20), time_us)

    def test_counts_mean_what_the_file_says(self):
        """Levels by SonarInfo: in dB between its limits, amplitudes, or powers."""
        for kind in (np.uint8, np.uint16):
            most = np.iinfo(kind).max
            counts = RANDOM.integers(1, most, (20, 15), dtype=kind, endpoint=True)
            amplitude = 20 * np.log10(counts / most)
            for name, info, expected in (("db", logs.sonar_info(2, 2, 45 / most, 92), 92 + 45 * (counts / most)),
                                         ("linear", logs.sonar_info(2, 1, 0.01, 0), amplitude),
                                         ("power", logs.sonar_info(3, 1, 0.01, 0), amplitude / 2),
                                         ("unknown", logs.sonar_info(0, 0, 0, 0), amplitude)):
                log = logs.mcap([self.image(counts)] * 2, infos=[info])
                data = self.imported(log, "of.mcap", out=f"{name}{most}")
                for ping in data:
                    self.assertTrue((ping.recorded == counts).all())
                    offset = 0 if name == "db" else np.median(ping.polar.level_db - expected)
                    self.assertLess(np.abs(ping.polar.level_db - expected - offset).max(), 0.07, name)
        self.assertEqual(data.sequence(0).info["recorder"]["scale"], "amplitude")
        self.assertIn("/sonar/info does not say what the counts mean; used them as amplitudes", self.said)

    def test_levels_in_floats(self):
        levels = np.round(RANDOM.uniform(-40, 180, (20, 15)), 2).astype(np.float32)
        levels[3, 4], levels[3, 5] = -np.inf, -99
        expected = np.maximum(levels.astype(np.float16), -99)
        data = self.imported(logs.mcap([self.image(levels)], infos=[logs.sonar_info(2, 2, 1, 0)]), "of.mcap", out="db")
        self.assertLess(np.abs(data[0].polar.level_db - expected).max(), 0.13)  # a step of half precision
        self.assertEqual(data[0].polar.level_db[3, 4], -99)
        pressure = (10 ** (levels.astype(float) / 20)).astype(np.float32)
        data = self.imported(logs.mcap([self.image(pressure)], infos=[logs.sonar_info(2, 1, 1, 0)]), "of.mcap", out="pa")
        self.assertLess(np.abs(data[0].polar.level_db - expected).max(), 0.13)
        # The limits of its 8-bit image are those of its levels, not of all that counts can hold.
        self.assertGreater(data[0].polar.grey.std(), 20)

    def test_what_a_file_says_is_not_contradicted(self):
        counts, floats = np.full((20, 15), 9, np.uint8), np.full((20, 15), 9, np.float32)
        db = logs.sonar_info(2, 2, 45 / 255, 92)
        said = self.imported(logs.mcap([self.image(counts)], infos=[db]), "of.mcap", "--db", "92:137.01")
        self.assertAlmostEqual(said.sequence(0).info["recorder"]["db"][1], 137, places=3)
        cases = [(counts, [db], ("--db", "90:137"), "SonarInfo of /sonar says 92 to 137 dB, but --db 90:137"),
                 (counts, [logs.sonar_info(2, 1, 1, 0)], ("--db", "90:137"), "says that the counts are linear"),
                 (counts, [logs.sonar_info(2, 1, 1, -3)], (), "says that a count of 0 is -3"),
                 (counts, [logs.sonar_info(2, 2, 0, 0)], (), "not between which levels; expected --db LOW:HIGH"),
                 (counts, [logs.sonar_info(2, 2, math.nan, 0)], (), "not a finite number"),
                 (counts, [db[:60]], (), "a SonarInfo that is shorter than its members"),
                 (counts, [None, db], (), "in dB, after 1 images without it; expected --db LOW:HIGH"),
                 (floats, [], (), "no message of /sonar/info (marine_interfaces/msg/SonarInfo)"),
                 (floats, [db], ("--db", "1:2"), "are floats, and --db is the scale of counts"),
                 (floats * np.nan, [db], (), "a level of nan dB"), (floats * 1e9, [db], (), "expected at most 227.675")]
        for values, infos, options, words in cases:
            path = self.folder / "bad.mcap"
            path.write_bytes(logs.mcap([self.image(values), self.image(values, 10**6)], infos=infos))
            self.assertIn(words, ensonify("import", path, "-o", self.folder / "bad", *options, status=2))
            self.assertFalse((self.folder / "bad").exists())

    def test_recordings_of_other_kinds_name_the_way(self):
        folder = self.folder / "bag"
        folder.mkdir()
        (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
        (folder / "bag_0.db3").write_bytes(b"SQLite format 3\0" + bytes(100))
        (self.folder / "old.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(100))
        refused = lambda path: ensonify("import", path, "-o", self.folder / "bad", status=2)  # noqa: E731
        self.assertIn(f"`mcap convert {folder}/bag_0.db3 FILE.mcap`", refused(folder))
        self.assertIn("`mcap convert FILE.db3 FILE.mcap`", refused(folder / "bag_0.db3"))
        self.assertIn("`rosbags-convert --src FILE.bag --dst FOLDER --dst-storage mcap`", refused(self.folder / "old.bag"))
        (folder / "bag_10.mcap").write_bytes(b"")
        self.assertIn(f"expected the file in it, {folder}/bag_10.mcap", refused(folder))
        (folder / "bag_9.mcap").write_bytes(b"")
        self.assertIn(f"{folder}/bag_9.mcap, {folder}/bag_10.mcap", refused(folder))

    def test_what_cannot_be_read_is_refused_with_its_place(self):
        counts, bearings = np.zeros((20, 15), np.uint8), np.radians(np.linspace(-30, 30, 15))
        message = logs.projected_image(counts, bearings, 0.05 * np.arange(20), 0)
        uneven = logs.projected_image(counts, bearings, 0.05 * np.arange(20) ** 1.1, 0)
        far = logs.projected_image(counts, bearings, 0.05 * np.arange(65537), 0)
        nowhere = logs.projected_image(counts, np.where(bearings > 0, -bearings, math.nan), 0.05 * np.arange(20), 0)
        cases = [(logs.mcap([message], compression="bz2"), "mcap decompress"),
                 (logs.mcap([message], compression="lz4"), "a damaged chunk (lz4)"),
                 (logs.mcap([message], compression="zstd", size=3000), "a damaged chunk (zstd)"),
                 (logs.mcap([message], compression="zstd", size=2**40), "a chunk of 1099511627776 bytes"), (logs.mcap([]), "no message of type"),
                 (logs.mcap([uneven]), "not equally spaced"), (logs.mcap([nowhere]), "is not a number"),
                 (logs.mcap([far]), "65537 ranges; expected at most 65536"),
                 (logs.mcap([message[:200]]), "shorter than its members")]
        for log, words in cases:
            path = self.folder / "bad.mcap"
            path.write_bytes(log)
            self.assertIn(words, ensonify("import", path, "-o", self.folder / "bad", status=2))
        cut = logs.mcap([message, message], chunked=False)
        self.assertEqual(len(self.imported(cut[:-500])), 1)
        self.assertIn("cut off", self.said)
        (self.folder / "other.mcap").write_bytes(cut)
        said = ensonify("import", self.folder / "other.mcap", "-o", self.folder / "x", "--topic", "/none", status=2)
        self.assertIn("on topic /none", said)


class Images(Case):
    ABOUT = """files: "ping_*.npy"
fan_deg: 60
range_m: [0.5, 4.3]
ping_rate_hz: 4
frequency_hz: 900e3
scale: {db: [-10, 70]}
instrument: Blueprint
"""

    def write(self, about=ABOUT, shape=(20, 30), kind=np.uint8):
        folder = self.folder / "images"
        folder.mkdir(exist_ok=True)
        (folder / "recording.yaml").write_text(about)
        images = [RANDOM.integers(0, np.iinfo(kind).max, shape, dtype=kind, endpoint=True) for _ in range(3)]
        for i, image in enumerate(images):
            np.save(folder / f"ping_{i:02}.npy", image)
        np.save(folder / "other.npy", np.zeros(3))
        return folder, images

    def test_counts_axes_times_and_levels(self):
        folder, images = self.write()
        ensonify("import", folder, "-o", self.folder / "data")
        ensonify("verify", self.folder / "data")
        data = SonarDataset(self.folder / "data")
        self.assertEqual(data.name, "images")
        for i, ping in enumerate(data):
            self.assertTrue((ping.recorded == images[i][:, ::-1]).all())  # columns are port first
            self.assertEqual(ping.time_s, 0.25 * i)
            self.assertLess(abs(ping.polar.level_db - (-10 + images[i][:, ::-1] / 255 * 80)).max(), 0.033)
        np.testing.assert_allclose(np.degrees(data.sequence(0).azimuth_rad), np.arange(30) * 2 - 29, atol=1e-12)
        np.testing.assert_allclose(data.sequence(0).range_m, np.linspace(0.5, 4.3, 20), atol=1e-12)

    def test_names_are_ordered_by_their_numbers(self):
        folder, _ = self.write()
        for path in folder.glob("ping_*.npy"):
            path.unlink()
        for i in (1, 2, 9, 10, 100):
            np.save(folder / f"ping_{i}.npy", np.full((20, 30), i, np.uint8))
        ensonify("import", folder, "-o", self.folder / "data")
        self.assertEqual([int(ping.recorded[0, 0]) for ping in SonarDataset(self.folder / "data")], [1, 2, 9, 10, 100])

    def test_png_files_with_other_orders(self):
        folder, images = self.write(kind=np.uint16)
        ensonify("import", folder, "-o", self.folder / "first")
        for path in folder.glob("*.npy"):
            path.unlink()
        for path in (self.folder / "first/sequences/000000/recorded").glob("*.png"):  # starboard first
            (folder / path.name).write_bytes(path.read_bytes())
        azimuths = ", ".join(str(a) for a in range(-45, 45, 3))
        about = self.ABOUT.replace('"ping_*.npy"', '"*_16bit.png"').replace("fan_deg: 60", f"azimuth_deg: [{azimuths}]")
        about = about.replace("ping_rate_hz: 4", "times_s: [3, 4, 7]").replace("{db: [-10, 70]}", "{gamma: 0.5}")
        (folder / "recording.yaml").write_text(about + "columns: starboard_first\nrows: far_first\n")
        ensonify("import", folder, "-o", self.folder / "data")
        data = SonarDataset(self.folder / "data")
        self.assertEqual([ping.time_s for ping in data], [0, 1, 4])
        for i, ping in enumerate(data):
            self.assertTrue((ping.recorded == images[i][::-1, ::-1]).all())
        self.assertAlmostEqual(math.degrees(data.sequence(0).azimuth_rad[0]), -45, places=12)
        self.assertEqual(data.sequence(0).info["recorder"]["gamma"], 0.5)

    def test_mistakes_in_the_description(self):
        cases = [(self.ABOUT + "azimuth_deg: [1, 2]\n", "one of azimuth_deg and fan_deg"),
                 (self.ABOUT.replace("fan_deg: 60", "fan_deg: wide"), "fan_deg: is not a value"),
                 (self.ABOUT.replace("ping_rate_hz: 4", "times_s: [1]"), "one for each of the 1 times_s"),
                 (self.ABOUT + "gain: 3\n", "gain: unknown key"), (self.ABOUT.replace("db", "log"), "scale"),
                 (self.ABOUT.replace("ping_*", "none*"), "0 files match"), ("a: [", "line"),
                 (self.ABOUT.replace("[0.5, 4.3]", "[4.3, 0.5]"), "range_m")]
        for about, words in cases:
            folder, _ = self.write(about)
            self.assertIn(words, ensonify("import", folder, "-o", self.folder / "bad", status=2))
        # The last image is bad: nothing is written of the others.
        folder, images = self.write()
        np.save(folder / "ping_02.npy", images[0][:-1])
        self.assertIn("the first image has 30 x 20", ensonify("import", folder, "-o", self.folder / "bad", status=2))
        self.assertFalse((self.folder / "bad").exists())
        (folder / "recording.yaml").unlink()
        self.assertIn("has neither recording.yaml", ensonify("import", folder, "-o", self.folder / "bad", status=2))

    def display(self, height_px):
        """A simulated ping's Cartesian image, its data set, and a recording.yaml for it."""
        tank = self.folder / "tank"
        ensonify("generate", ROOT / "scenes/sonar_tank.yaml", "-o", tank, "--pings", "0:1", "--quiet",
                 "--set", f"output.cartesian={{height_px: {height_px}}}", "--set", "sonar.beams.count=64")
        data = SonarDataset(tank)
        sequence, grid = data.sequence(0), data.sequence(0).info["cartesian"]
        pixel = grid["metres_per_pixel"]
        black, white = data.info["png"]["db"]
        azimuths = ", ".join(f"{a:.12g}" for a in np.degrees(sequence.azimuth_rad)[::-1])
        about = f"""files: "*.png"
azimuth_deg: [{azimuths}]
range_m: [{sequence.range_m[20]:.12g}, {sequence.range_m[-1]:.12g}]
ping_rate_hz: 1
frequency_hz: {sequence.info["sonar"]["frequency_hz"]}
scale: {{db: [{black}, {white}]}}
display:
  apex_px: [{grid["y_left_m"] / pixel:.12g}, {grid["x_top_m"] / pixel:.12g}]
  pixels_per_m: {1 / pixel:.12g}
  samples: {len(sequence.range_m) - 20}
"""
        folder = self.folder / "display"
        folder.mkdir()
        return data, folder, about

    def test_a_display_of_a_fan_becomes_polar(self):
        data, folder, about = self.display(1500)
        image, truth = data[0].cartesian.grey, data[0].polar.grey[20:].astype(int)
        sequence = data.sequence(0)
        # By another route: the pixels around the places of the cells, all at once.
        column, row = (float(x) for x in re.search(r"apex_px: \[(.*), (.*)\]", about).groups())
        scale = float(re.search(r"pixels_per_m: (.*)", about)[1])
        range_px = sequence.range_m[20:, None] * scale
        down = row - range_px * np.cos(sequence.azimuth_rad) - 0.5
        across = np.clip(column - range_px * np.sin(sequence.azimuth_rad) - 0.5, 0, image.shape[1] - 1.001)
        down = np.clip(down, 0, image.shape[0] - 1.001)
        expected = 0
        for y, x in ((0, 0), (0, 1), (1, 0), (1, 1)):
            weight = np.abs(1 - y - down % 1) * np.abs(1 - x - across % 1)
            expected += weight * image[down.astype(int) + y, across.astype(int) + x]
        turned = {"up": image, "right": np.rot90(image, -1), "down": np.rot90(image, 2), "left": np.rot90(image)}
        rows, columns = image.shape
        apexes = {"up": (column, row), "right": (rows - row, column), "down": (columns - column, rows - row),
                  "left": (row, columns - column)}
        for look, mirrored in (("up", False), ("right", False), ("down", False), ("left", False), ("up", True)):
            shown, at = turned[look], apexes[look]
            if mirrored:
                shown, at = shown[:, ::-1], (columns - at[0], at[1])
            Image.fromarray(np.ascontiguousarray(shown)).save(folder / "1.png")
            text = re.sub(r"apex_px: .*", f"apex_px: [{at[0]}, {at[1]}]", about)
            (folder / "recording.yaml").write_text(text + f"  looks: {look}\n  mirrored: {str(mirrored).lower()}\n")
            said = ensonify("import", folder, "-o", self.folder / "data", "--height-px", 50, "--overwrite")
            self.assertIn(f"warning: {folder}: made {len(truth)} x 64 polar cells of displays", said)
            imported = SonarDataset(self.folder / "data")
            counts = imported[0].recorded.astype(int)
            self.assertLess(abs(counts - expected).max(), 0.51, look)
        np.testing.assert_allclose(imported.sequence(0).azimuth_rad, sequence.azimuth_rad, atol=1e-10)
        np.testing.assert_allclose(imported.sequence(0).range_m, sequence.range_m[20:], rtol=1e-9)
        # The polar levels themselves, of a display with 1 to 30 pixels for a beam and 4 for a sample.
        black, white = data.info["png"]["db"]
        lit = (truth > 25) & (truth < 255)
        error = (counts - truth)[lit] * (white - black) / 255
        self.assertGreater(lit.sum(), 2000)
        self.assertLess(abs(np.median(error)), 0.2)
        self.assertLess(np.sqrt(np.mean(error ** 2)), 1.5)  # found: 1.1 dB, most of it in the nulls of speckle

    def test_what_a_display_says_of_its_levels(self):
        data, folder, about = self.display(300)
        image = data[0].cartesian.grey
        colors = np.repeat(image[:, :, None], 3, 2)
        for name, shown in (("gray.png", image), ("colors.png", colors), ("gray.jpg", image)):
            Image.fromarray(shown).save(folder / name, **({"quality": 100} if name.endswith("jpg") else {}))
            text = about.replace('"*.png"', f'"{name}"')
            (folder / "recording.yaml").write_text(re.sub("scale: .*\n", "", text))
            said = ensonify("import", folder, "-o", self.folder / "grays", "--height-px", 50, "--overwrite")
            self.assertIn("levels are gray levels from 0 to 255, not dB", said)
            ping = SonarDataset(self.folder / "grays")[0]
            self.assertLess(abs(ping.polar.level_db - ping.recorded).max(), 0.07)
            if name == "gray.png":
                gray = ping.recorded.astype(int)
            self.assertLess(abs(gray - ping.recorded).max(), 3 if name.endswith("jpg") else 1, name)
        cases = [(about + "rows: far_first\n", "rows: is of polar images"),
                 (about + "  looks: north\n", "display.looks: expected up, right, down or left"),
                 (about + "  beams: 64\n", "display.beams: unknown key"),
                 (about.replace("  samples", "  sample"), "display.samples: expected 2 to 65536"),
                 (re.sub("apex_px: .*", "apex_px: [3]", about), "display.apex_px: expected the column and the row"),
                 (re.sub("pixels_per_m: .*", "pixels_per_m: 9999", about), "expected another display.apex_px")]
        for text, words in cases:
            (folder / "recording.yaml").write_text(text.replace('"*.png"', '"gray.png"'))
            self.assertIn(words, ensonify("import", folder, "-o", self.folder / "bad", status=2))
            self.assertFalse((self.folder / "bad").exists())

    def test_a_fan_that_no_aris_has_is_not_written_as_one(self):
        folder, _ = self.write(self.ABOUT.replace("fan_deg: 60", "fan_deg: 90").replace("Blueprint", "ARIS 3000"),
                               shape=(20, 128))
        ensonify("import", folder, "-o", self.folder / "wide")
        told = ensonify("export", self.folder / "wide", "--format", "aris", "-o", self.folder / "log", status=2)
        self.assertIn("Use --format oculus", told)


if __name__ == "__main__":
    unittest.main()
