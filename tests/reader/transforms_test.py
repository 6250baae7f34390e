"""Transforms against their formulas, and against what the program itself made of the same ping."""
import copy
import dataclasses
import importlib.util
import unittest

import numpy as np

import small_data
from ensonify_dataset import Display, SonarDataset, Viewer, normalise, redrawn, to_amplitude, to_db, to_grey
from ensonify_dataset.footprints import Footprints


class Formulas(unittest.TestCase):
    def test_level_of_a_series(self):
        """1 uPa is 0 dB, 1 Pa 120 dB; -99 dB is the floor."""
        series = np.array([1e-6, 1, 3 + 4j, 0, 1e-12j], np.complex64)
        np.testing.assert_allclose(to_db(series), [0, 120, 120 + 20 * np.log10(5), -99, -99], atol=1e-4)

    def test_amplitude_is_the_inverse(self):
        np.testing.assert_allclose(to_amplitude([120, 126.0206, 0, -99]), [1, 2, 1e-6, 0], rtol=1e-6)
        series = np.geomspace(1e-9, 1e5, 50).astype(np.complex64)
        np.testing.assert_allclose(to_amplitude(to_db(series)), abs(series), rtol=3e-6)

    def test_grey_has_its_limits_and_its_middle(self):
        np.testing.assert_array_equal(to_grey([50, 64, 96, 128, 200, -99], 64, 128), [0, 0, 128, 255, 255, 0])

    def test_normalised_pictures_have_mean_0_and_deviation_1(self):
        level = np.random.default_rng(1).normal(100, 7, (40, 30)).astype(np.float32)
        level[:10] = -99
        done = normalise(level)
        self.assertAlmostEqual(float(done[10:].mean(dtype=float)), 0, places=5)
        self.assertAlmostEqual(float(done[10:].std(dtype=float)), 1, places=5)
        self.assertTrue((done[:10] == done[10:].min()).all())
        np.testing.assert_allclose(normalise(2 * level[10:] + 5), normalise(level[10:]), atol=1e-4)
        self.assertFalse(normalise(np.full((3, 3), -99)).any())
        self.assertFalse(normalise(np.full((3, 3), 80.0)).any())


class AfterTheRecorder(unittest.TestCase):
    """Viewer: gain, display, lost beams and JPEG."""

    level_db = np.random.default_rng(5).uniform(70, 100, (40, 300))

    def test_gain_is_that_of_the_display(self):
        """A gain of 3 dB moves levels by 3 dB; 1 dB is 255/60 gray levels."""
        plain = Viewer(Display((60, 120))).image(self.level_db).astype(int)
        np.testing.assert_array_equal(plain, to_grey(self.level_db, 60, 120))
        louder = Viewer(Display((60, 120)), gain_db=(3, 3)).image(self.level_db)
        np.testing.assert_array_equal(louder, to_grey(self.level_db + 3, 60, 120))

    def test_gains_are_uniform(self):
        """Of 400 images, of one level each: mean (low + high)/2, and the deviation of a uniform number."""
        viewer = Viewer(Display((0, 255)), gain_db=(-20, 20))
        found = np.array([viewer.image(np.full((1, 1), 120.0), (7, k))[0, 0] for k in range(400)], float)
        spread = 40 / np.sqrt(12)
        self.assertAlmostEqual(found.mean(), 120, delta=4 * spread / 20)
        self.assertAlmostEqual(found.std(), spread, delta=4 * spread * np.sqrt(0.8 / 4 / 400))

    def test_the_share_of_lost_beams(self):
        """Of 100 images with 300 beams; lost beams are black as a whole and the others as they were."""
        viewer, plain = Viewer(Display((60, 120)), lost_beams=0.1), to_grey(self.level_db, 60, 120)
        lost = []
        for k in range(100):
            image = viewer.image(self.level_db, (3, k))
            lost.append((image == 0).all(0))
            np.testing.assert_array_equal(image[:, ~lost[-1]], plain[:, ~lost[-1]])
        self.assertAlmostEqual(np.mean(lost), 0.1, delta=4 * np.sqrt(0.09 / 30000))
        self.assertFalse((lost[0] == lost[1]).all())

    def test_the_key_decides(self):
        """The same key gives the same image, and the gain is the same with and without lost beams."""
        viewer = Viewer(Display((60, 120)), (-6, 6), lost_beams=0.2)
        image = viewer.image(self.level_db, (1, 2, 3))
        np.testing.assert_array_equal(viewer.image(self.level_db, (1, 2, 3)), image)
        self.assertTrue((viewer.image(self.level_db, (1, 2, 4)) != image).any())
        kept = ~(image == 0).all(0)
        np.testing.assert_array_equal(Viewer(Display((60, 120)), (-6, 6)).image(self.level_db, (1, 2, 3))[:, kept],
                                      image[:, kept])

    @unittest.skipIf(importlib.util.find_spec("PIL") is None, "no PIL")
    def test_jpeg(self):
        """A table of ones keeps gray levels within the rounding of color and block; a low quality does not."""
        plain = to_grey(self.level_db, 60, 120).astype(int)
        ones = Viewer(Display((60, 120)), jpeg_tables={0: [1] * 64, 1: [1] * 64}).image(self.level_db)
        self.assertLessEqual(abs(ones - plain).max(), 2)
        errors = [abs(Viewer(Display((60, 120)), jpeg_quality=(q, q)).image(self.level_db) - plain).mean()
                  for q in (95, 50, 10)]
        self.assertTrue(0.5 < errors[0] < errors[1] < errors[2], errors)

    def test_samples_longer_than_pixels_appear_twice(self):
        """Straight ahead, with pixels of 0.9 samples: one sample of nine appears twice."""
        samples = np.repeat(np.arange(1000)[:, None], 3, 1)
        found = redrawn(samples, 0.013 + 0.1 * np.arange(1000), np.array([-0.1, 0, 0.1]), 0.09 * np.arange(1000),
                        np.zeros(1))
        np.testing.assert_array_equal(found[:, 0], np.maximum(np.rint(0.9 * np.arange(1000) - 0.13), 0))
        self.assertEqual((np.diff(found[:, 0]) == 0).sum(), 100)

    def test_places_have_the_value_of_a_square_pixel(self):
        """Pixels of 1 m: (4, 3) and (3, 4) m have ranges of 5 m, and 5 m at 30 degrees, which is (4.33, 2.5), is shown by
        (4, 2) m at 4.47 m and 26.6 degrees, one at 35 degrees, (4.10, 2.87), by (4, 3) m at 36.9 degrees."""
        range_m, azimuth_rad = 0.01 * np.arange(1000), np.radians(np.arange(-90, 91))
        rows_m, columns_rad = np.array([5.0, 6]), np.radians([53, 35, 30, -35])
        distance = redrawn(np.repeat(range_m[:, None], 181, 1), range_m, azimuth_rad, rows_m, columns_rad)
        np.testing.assert_allclose(distance[0], [5, 5, 4.47, 5], atol=0.005)
        azimuth = redrawn(np.repeat(np.arange(-90, 91)[None], 1000, 0), range_m, azimuth_rad, rows_m, columns_rad)
        np.testing.assert_array_equal(azimuth[0], [53, 37, 27, -37])

    def test_pixels_show_the_nearest_sample_and_beam(self):
        """Values are those of a place within half a diagonal of a pixel, half a sample and half a beam."""
        range_m, azimuth_rad = 1 + 0.004 * np.arange(500), np.cumsum(np.linspace(0.003, 0.006, 128)) - 0.28
        rows_m, columns_rad = np.linspace(1.1, 2.9, 400), np.linspace(azimuth_rad[0], azimuth_rad[-1], 100)
        places = np.stack(np.meshgrid(range_m, azimuth_rad, indexing="ij"), 2)
        found = np.stack([redrawn(places[:, :, k], range_m, azimuth_rad, rows_m, columns_rad) for k in (0, 1)], 2)
        diagonal_m = (rows_m[1] - rows_m[0]) / np.sqrt(2)
        self.assertLess(abs(found[:, :, 0] - rows_m[:, None]).max(), diagonal_m + 0.002)
        across_m = rows_m[:, None] * abs(found[:, :, 1] - columns_rad)
        self.assertLess((across_m - rows_m[:, None] * 0.003).max(), 1.01 * diagonal_m)

    def test_bad_values(self):
        for words, values in (("gain_db", {"gain_db": (3, 0)}), ("lost_beams", {"lost_beams": 1.5}),
                              ("jpeg_quality", {"jpeg_quality": (0, 50)}),
                              ("one of them", {"jpeg_quality": (50, 50), "jpeg_tables": {}})):
            with self.assertRaisesRegex(ValueError, words):
                Viewer(**values)


class ARealPing(unittest.TestCase):
    """The program's pictures are transforms of its series."""

    def test_level_and_grey(self):
        ping = SonarDataset(small_data.shared("seabed_and_target", "--pings", "0:1"))[0]
        level = to_db(ping.series).T
        # Half floats of 64 to 128 dB and more stand 1/16 and 1/8 dB apart.
        self.assertLess(abs(level - ping.polar.level_db).max(), 1 / 16 + 1e-3)
        grey = to_grey(ping.polar.level_db, *ping.sequence.info["png"]["db"])
        np.testing.assert_array_equal(grey, ping.polar.grey)


class Cartesian(unittest.TestCase):
    """8-bit images seen from above."""

    @classmethod
    def setUpClass(cls):
        cls.ping = SonarDataset(small_data.shared("seabed_and_target", "--pings", "0:1"))[0]
        cls.info, cls.map = cls.ping.sequence.info, cls.ping.sequence.cartesian_map
        cls.grey, cls.level = cls.ping.cartesian.grey, cls.ping.polar.level_db
        cls.display = Display.of(cls.info["png"])
        cls.nearest = cls.ping.cartesian.displayed(dataclasses.replace(cls.display, resampling="nearest"))

    def test_both_resamplings(self):
        self.assertEqual(self.display.resampling, "bilinear")
        footprints = Footprints(self.info, self.map)
        np.testing.assert_array_equal(self.display.cartesian_grey(self.level, footprints), self.grey)
        polar = to_grey(self.level, *self.display.limits_db).ravel()
        np.testing.assert_array_equal(self.nearest, np.where(self.map < 0, 0, polar[np.maximum(self.map, 0)]))

    def test_a_level_that_is_everywhere(self):
        mean = Footprints(self.info, self.map).mean_intensity(np.full(self.level.shape, 60), -99)
        np.testing.assert_allclose(10 * np.log10(mean), 60, atol=1e-5)

    def test_other_sizes_are_refused(self):
        footprints = Footprints(self.info, self.map)
        self.assertRaises(ValueError, footprints.mean_intensity, self.level[1:], -99)
        self.assertRaises(ValueError, Footprints, self.info, self.map[1:])
        for group, member, value in (("cartesian", "metres_per_pixel", 1e300), ("cartesian", "metres_per_pixel", 0),
                                     ("water", "sound_speed_m_s", 1e-9), ("sonar", "bandwidth_hz", -1)):
            info = copy.deepcopy(self.info)
            info[group][member] = value
            self.assertRaisesRegex(ValueError, "larger than the fan", Footprints, info, self.map)


if __name__ == "__main__":
    unittest.main()
