"""Transforms against their formulas, and against what the program itself made of the same ping."""
import pathlib
import tempfile
import unittest

import numpy as np

import small_data
from ensonify_dataset import SonarDataset, normalise, to_amplitude, to_db, to_grey


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


class ARealPing(unittest.TestCase):
    """The program's pictures are transforms of its series."""

    def test_level_and_grey(self):
        with tempfile.TemporaryDirectory() as folder:
            ping = SonarDataset(small_data.generate("seabed_and_target", pathlib.Path(folder) / "d"))[0]
            level = to_db(ping.series).T
            # Half floats of 64 to 128 dB and more stand 1/16 and 1/8 dB apart.
            self.assertLess(abs(level - ping.polar.level_db).max(), 1 / 16 + 1e-3)
            grey = to_grey(ping.polar.level_db, *ping.sequence.info["png"]["db"])
            np.testing.assert_array_equal(grey, ping.polar.grey)


if __name__ == "__main__":
    unittest.main()
