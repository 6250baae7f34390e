"""Grey pictures redone from the EXR picture with nothing but what sequence.json says of them."""
import json
import unittest

import numpy as np

import program
import sonar_dataset

SCENARIO = """ensonify: 1
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 6
  beams: {count: 32, fov_deg: 32}
  rays: {elevation: 12}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, material: m, shape: {box: {size_m: [9, 9, 3], inward_facing: true}}}
  - {name: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [1.5, 0, 0]}}
water: {absorption: {fixed_db_m: 0.35}}
noise: {spectrum_level_db: 40}
"""


def made(*pairs):
    return program.made(SCENARIO, *program.settings("output.cartesian.height_px=120", *pairs)) / "sequences/000000"


def exr_level(path):
    return sonar_dataset.read_exr(path)[0].channels["Y"].astype(float)


def redone(sequence, level_db, range_m):
    """Grey and the most that half a step of the EXR's level can change it."""
    png = json.loads((sequence / "sequence.json").read_text())["png"]
    tvg = png.get("tvg", {"spreading": 0, "absorption_db_m": 0})
    range_m = range_m.copy()
    range_m[0] = range_m[1]
    shown = (level_db + png.get("gain_db", 0)
             + (tvg["spreading"] * np.log10(range_m) + 2 * tvg["absorption_db_m"] * range_m)[:, None])
    half_step_db = np.spacing(np.abs(level_db).astype(np.float16)).astype(float) / 2
    if png["scale"] == "amplitude":
        grey = 255 * 10 ** (png["gamma"] * (shown - png["db"][1]) / 20)
        slack = grey * (10 ** (png["gamma"] * half_step_db / 20) - 1)
    else:
        grey = 255 * (shown - png["db"][0]) / (png["db"][1] - png["db"][0])
        slack = 255 * half_step_db / (png["db"][1] - png["db"][0])
    grey[level_db <= -99] = 0
    return np.clip(grey, 0, 255), slack


class Grey(unittest.TestCase):
    def check(self, *settings):
        sequence = made(*settings)
        level_db = exr_level(sequence / "polar/000000.exr")
        picture = sonar_dataset.read_png(sequence / "png/000000_polar.png").astype(float)
        grey, slack = redone(sequence, level_db, np.load(sequence / "range_m.npy"))
        self.assertLessEqual(np.max(np.abs(grey - picture) - slack), 0.5 + 1e-3)
        # A picture of one grey would agree with anything.
        self.assertGreater(len(np.unique(picture)), 40)
        series = np.load(sequence / "timeseries/000000.npy").T
        with np.errstate(divide="ignore"):
            from_series = 20 * np.log10(np.abs(series)) + 120
        self.assertLess(np.max(np.abs(from_series - level_db)[level_db > 0]), 0.07)
        return picture, json.loads((sequence / "sequence.json").read_text())["png"]

    def test_as_it_comes(self):
        _, png = self.check()
        self.assertEqual(set(png), {"scale", "db", "resampling", "pixels"})

    def test_tvg_and_gain_in_db(self):
        plain, _ = self.check("output.png.db=[60, 150]")
        picture, png = self.check(
            "output.png={db: [60, 150], tvg: {spreading: 20, absorption: true}, gain_db: 4.5}")
        self.assertEqual(png["tvg"], {"spreading": 20, "absorption_db_m": 0.35})
        self.assertGreater(np.mean(picture[-40:]), np.mean(plain[-40:]) + 20)

    def test_a_constant_gain_makes_images_brighter(self):
        """Limits that followed it would take it out again."""
        dark, plain = self.check()
        bright, png = self.check("output.png={gain_db: 17}")
        self.assertEqual(png["db"], plain["db"])
        self.assertGreater(np.mean(bright), np.mean(dark) + 5)
        self.check("output.png={tvg: true}")

    def test_amplitude(self):
        self.check("output.png={scale: amplitude}")
        self.check("output.png={scale: amplitude, db: [0, 130], tvg: {spreading: 40, absorption: false}}")
        self.check("output.png={scale: amplitude, gamma: 0.4}")

    def cartesian(self, *settings):
        """Polar and Cartesian picture, limits, and the Cartesian pixels clear of rounding: place in samples and beams,
        where in the fan, width of a pixel in beams."""
        sequence = made(*settings)
        about = json.loads((sequence / "sequence.json").read_text())
        polar = sonar_dataset.read_png(sequence / "png/000000_polar.png")
        seen = sonar_dataset.read_png(sequence / "png/000000_cartesian.png")
        level_db = exr_level(sequence / "polar/000000.exr")
        grid, beams = about["cartesian"], about["sonar"]["beams"]
        row, column = np.mgrid[:grid["height_px"], :grid["width_px"]]
        x = grid["x_top_m"] - (row + 0.5) * grid["metres_per_pixel"]
        y = grid["y_left_m"] - (column + 0.5) * grid["metres_per_pixel"]
        step_m = about["record"]["range_step_m"]
        sample = np.hypot(x, y) / step_m
        beam = np.arctan2(y, x) / beams["spacing_rad"] + beams["count"] / 2
        inside = (beam > 0) & (beam < beams["count"]) & (sample < polar.shape[0] - 0.5)
        # Beside an edge between two samples or sectors rounding decides.
        clear = np.minimum(np.abs(sample % 1 - 0.5), np.abs((beam + 0.5) % 1 - 0.5)) > 1e-6
        width = grid["metres_per_pixel"] / step_m / sample / beams["spacing_rad"]
        return polar, seen, level_db, about, sample, beam, inside, clear, width

    def test_a_nearest_cartesian_picture_shows_the_polar_one(self):
        polar, seen, _, about, sample, beam, inside, clear, _ = self.cartesian(
            "output.png={scale: amplitude, tvg: true, resampling: nearest}")
        self.assertEqual(about["png"]["resampling"], "nearest")
        use = inside & clear
        expected = polar[np.rint(sample[use]).astype(int), beam[use].astype(int)]
        self.assertTrue(np.array_equal(seen[use], expected))
        self.assertEqual(np.max(seen[~inside & clear]), 0)

    def test_a_cartesian_picture_is_interpolated(self):
        """Where a pixel is no larger than a cell: the level of the mean intensity between beams and samples."""
        _, seen, level_db, about, sample, beam, inside, clear, width = self.cartesian()
        png, beam = about["png"], beam - 0.5
        self.assertEqual(png["resampling"], "bilinear")
        self.assertEqual(np.max(seen[~inside & clear]), 0)
        samples, beams = level_db.shape
        length = about["cartesian"]["metres_per_pixel"] / about["record"]["range_step_m"]
        use = inside & (width < 1) & (sample < samples - 1) & (beam > 0) & (beam < beams - 1)
        parts = int(np.ceil(length))
        sample, beam = sample[use], beam[use]
        intensity, mean = np.where(level_db > -99, 10 ** (level_db / 10), 0), 0
        column, right = beam.astype(int), beam % 1
        for k in range(parts):
            at = np.clip(sample + length * ((k + 0.5) / parts - 0.5), 0, samples - 1.001)
            row, up = at.astype(int), at % 1
            mean = mean + ((1 - up) * ((1 - right) * intensity[row, column] + right * intensity[row, column + 1])
                           + up * ((1 - right) * intensity[row + 1, column]
                                   + right * intensity[row + 1, column + 1])) / parts
        black, white = png["db"]
        grey = np.clip(255 * (10 * np.log10(mean) - black) / (white - black), 0, 255)
        self.assertLess(np.max(np.abs(grey - seen[use])), 0.51)
        self.assertGreater(np.count_nonzero(use), 1000)
        self.assertGreater(len(np.unique(seen)), 40)

    def test_pixels_are_counted(self):
        picture, png = self.check("output.png.db=[70, 120]")
        self.assertEqual(png["pixels"]["all"], picture.size)
        self.assertEqual(png["pixels"]["white"], np.count_nonzero(picture == 255))
        self.assertLessEqual(png["pixels"]["black"], np.count_nonzero(picture == 0))


DRAWN = """ensonify: 1
name: drawn
seed: 5
sequences: 5
trajectory: {pings: 2}
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 5
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 8}
materials:
  m: {reflectivity: {log_uniform: [1e-5, 1e-1]}}
objects:
  - {name: room, material: m, shape: {box: {size_m: [8, 8, 3], inward_facing: true}}}
output: {timeseries: none, cartesian: false, shadow: false, amodal: false}
"""


class OneDisplay(program.Case):
    """Limits of a data set follow from fixed probe pings, whoever makes which of its sequences."""

    def setUp(self):
        super().setUp()
        self.scenario.write_text(DRAWN)

    def generate(self, name, *options):
        out = self.folder / name
        done = program.run("generate", self.scenario, "-o", out, "--quiet", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return out

    def test_all_sequences_of_all_processes_have_the_same_limits(self):
        whole = self.generate("whole")
        files = program.hashes(whole)
        png = json.loads((whole / "dataset.json").read_text())["png"]
        told = [json.loads((whole / f"sequences/{k:06}/sequence.json").read_text())["png"] for k in range(5)]
        self.assertEqual({tuple(one["db"]) for one in told}, {tuple(png["db"])})
        self.assertEqual(png["pixels"], {key: sum(one["pixels"][key] for one in told) for key in png["pixels"]})
        self.assertEqual(program.hashes(self.generate("threads", "--threads", "3")), files)
        for shard in ("1/2", "0/2"):
            self.generate("shards", "--shard", shard)
        self.assertEqual(program.hashes(self.generate("shards", "--finalize")), files)
        for count in (1, 5):
            grown = self.generate("grown", "--set", f"sequences={count}")
        self.assertEqual(program.hashes(grown), files)

    def test_later_pings_alone_have_the_limits_of_the_first(self):
        whole = self.generate("whole", "--sequences", "0:1")
        late = self.generate("late", "--sequences", "0:1", "--pings", "1:2")
        limits = [json.loads((out / "dataset.json").read_text())["png"]["db"] for out in (whole, late)]
        self.assertEqual(*limits)
        name = "sequences/000000/png/000001_polar.png"
        self.assertEqual((whole / name).read_bytes(), (late / name).read_bytes())


if __name__ == "__main__":
    unittest.main()
