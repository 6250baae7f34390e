"""Statistics of a data set by the reader, against its own pings."""
import pathlib
import shutil
import tempfile
import unittest

import numpy as np

import small_data
from ensonify_dataset import DatasetError, SonarDataset, merge

KEPT = "output={statistics: true, polar: false, cartesian: false, png: false}"
DERIVED = ("contrast", "fourth_moment", "bin_coherence", "beam_coherence")
PRIMARY = ("mean_pressure", "pressure_variance", "mean_intensity", "intensity_variance", "bin_covariance",
           "beam_covariance")


def study(folder, *more):
    command = [small_data.PROGRAM, "generate", small_data.SCENES / "speckle_wall.yaml", "-o", folder, "--quiet",
               "--set", "sonar.beams={count: 12, fov_deg: 12}", *more]
    result = small_data.subprocess.run([*map(str, command)], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return SonarDataset(folder)


class Statistics(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def test_they_are_numpys_of_the_series(self):
        data = study(self.folder / "kept", "--set", KEPT, "--set", "trajectory.pings=13")
        got = data.sequence(0).statistics
        p = np.array([ping.series for ping in data], complex).transpose(0, 2, 1)
        intensity = np.abs(p) ** 2
        mean, variance = intensity.mean(0), intensity.var(0, ddof=1)
        self.assertEqual(got.realisations, 13)
        scale = mean.max()
        np.testing.assert_allclose(got.mean_pressure, p.mean(0), rtol=0, atol=1e-12 * scale ** .5)
        np.testing.assert_allclose(got.mean_intensity, mean, rtol=1e-12, atol=1e-15 * scale)
        np.testing.assert_allclose(got.intensity_variance, variance, rtol=1e-9, atol=1e-15 * scale ** 2)
        loud = mean > 1e-6 * scale
        np.testing.assert_allclose(got.contrast[loud], (np.sqrt(variance) / mean)[loud], rtol=1e-9)
        np.testing.assert_allclose(got.fourth_moment[loud], ((intensity ** 2).mean(0) / mean ** 2)[loud], rtol=1e-9)
        q = p - p.mean(0)
        for name, shifted, own in (("bin", q[:, 1:], q[:, :-1]), ("beam", q[:, :, 1:], q[:, :, :-1])):
            covariance = (shifted * own.conj()).sum(0) / 12
            np.testing.assert_allclose(getattr(got, f"{name}_covariance"), covariance, atol=1e-11 * scale)
            self.assertLessEqual(np.nanmax(np.abs(getattr(got, f"{name}_coherence"))), 1 + 1e-9)

    def test_what_is_no_ensemble_is_not_merged(self):
        """Protects error bars: draws that count twice, or scenes that differ, give a confident wrong number."""
        def part(name, *more):
            return study(self.folder / name, "--set", "trajectory.pings=9", *more).sequence(0).statistics

        first, rest = part("first", "--pings", "0:5"), part("rest", "--pings", "4:9")
        with self.assertRaisesRegex(DatasetError, "pings 4 to 4 of seed 1 would count twice"):
            merge([first, rest])
        with self.assertRaisesRegex(DatasetError, "twice"):
            merge([merge([first, part("end", "--pings", "5:9")]), rest])
        brighter = part("brighter", "--pings", "5:9", "--set", "materials.concrete.reflectivity=2e-2")
        with self.assertRaisesRegex(DatasetError, "different scenes"):
            merge([first, brighter])
        self.assertEqual(merge([first, part("seed", "--seed", "2")]).realisations, 14)

    def test_ensembles_of_one_scene_are_merged(self):
        """Of three ranges of pings, unequal, against the whole."""
        whole = study(self.folder / "whole", "--set", "trajectory.pings=29").sequence(0).statistics
        parts = [study(self.folder / r.replace(":", "_"), "--set", "trajectory.pings=29", "--pings", r)
                 .sequence(0).statistics for r in ("0:5", "5:21", "21:29")]
        merged = merge(parts)
        self.assertEqual(merged.realisations, 29)
        for name in PRIMARY + DERIVED:
            expected = np.asarray(getattr(whole, name))
            scale = np.nanmax(np.abs(expected))
            np.testing.assert_allclose(getattr(merged, name), expected, rtol=1e-7, atol=1e-11 * scale, err_msg=name)

    def test_what_there_is_not(self):
        data = study(self.folder / "none", "--set", "output={timeseries: npy, polar: false, cartesian: false, png: false}",
                     "--set", "trajectory.pings=1")
        with self.assertRaisesRegex(DatasetError, "output.statistics"):
            data.sequence(0).statistics
        alone = study(self.folder / "alone", "--set", "trajectory.pings=2")
        with self.assertRaisesRegex(DatasetError, "output"):
            alone[0].series
        with self.assertRaises(AttributeError):
            alone.sequence(0).statistics.kurtosis


class Wall(unittest.TestCase):
    """Contrast of the wall, and that its standard error is what it is said to be: 24 ensembles of 100."""

    def test_contrast_is_one_within_its_stated_error(self):
        with tempfile.TemporaryDirectory() as folder:
            data = study(pathlib.Path(folder) / "out", "--set", "sequences=24", "--set", "trajectory.pings=100")
            found = []
            for number in data.sequences:
                s = data.sequence(number).statistics
                wall = np.asarray(s.mean_intensity) > 0.01 * np.max(s.mean_intensity)
                found.append(s.mean_contrast(wall))
            whole = merge([data.sequence(number).statistics for number in data.sequences])
        contrast, stated = np.array(found).T
        # E C is 1 - 1/n to first order, what is left is of order 1/n^2.
        self.assertLess(abs(contrast.mean() - 0.99), 4 * stated.mean() / np.sqrt(24))
        # A standard deviation of 24 values is good to 1/sqrt(46): 15 %; 4 of them.
        self.assertLess(abs(contrast.std(ddof=1) / stated.mean() - 1), 0.6)
        wall = np.asarray(whole.mean_intensity) > 0.01 * np.max(whole.mean_intensity)
        mean, error = whole.mean_contrast(wall)
        self.assertLess(abs(mean - (1 - 1 / 2400)), 4 * error)
        # One pixel's, over the pixels; they are some 60 independent ones at least.
        spread = np.asarray(whole.contrast)[wall].std()
        self.assertLess(abs(spread / whole.contrast_error - 1), 0.4)
        fourth = np.asarray(whole.fourth_moment)[wall].mean()
        self.assertLess(abs(fourth - 2 * 2400 / 2401), 8 * error)


if __name__ == "__main__":
    unittest.main()
