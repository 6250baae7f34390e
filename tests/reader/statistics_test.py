"""Statistics of a data set by the reader: against its own pings, and estimates against closed forms."""
import pathlib
import shutil
import tempfile
import unittest
import zlib

import numpy as np

import small_data
from ensonify_dataset import DatasetError, SonarDataset, Worlds, merge, statistics

KEPT = "output={statistics: true, polar: false, cartesian: false, png: false}"
DERIVED = ("contrast", "fourth_moment", "third_moment", "bin_coherence", "beam_coherence")
PRIMARY = ("mean_pressure", "pressure_variance", "mean_intensity", "intensity_variance", "bin_covariance",
           "beam_covariance", "expected_intensity", "intensity_histogram", "bin_lag_products", "bin_lag_intensities",
           "beam_lag_products", "beam_lag_intensities")


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
        np.testing.assert_allclose(got.third_moment[loud], ((intensity ** 3).mean(0) / mean ** 3)[loud], rtol=1e-9)
        np.testing.assert_allclose(got.contrast[loud], (np.sqrt(variance) / mean)[loud], rtol=1e-9)
        np.testing.assert_allclose(got.fourth_moment[loud], ((intensity ** 2).mean(0) / mean ** 2)[loud], rtol=1e-9)
        q = p - p.mean(0)
        for name, shifted, own in (("bin", q[:, 1:], q[:, :-1]), ("beam", q[:, :, 1:], q[:, :, :-1])):
            covariance = (shifted * own.conj()).sum(0) / 12
            np.testing.assert_allclose(getattr(got, f"{name}_covariance"), covariance, atol=1e-11 * scale)
            self.assertLessEqual(np.nanmax(np.abs(getattr(got, f"{name}_coherence"))), 1 + 1e-9)

    def test_histogram_and_lags_are_numpys_of_the_series(self):
        """Within 10 dB of the largest expected intensity, which is not that of the realizations."""
        kept = "output={statistics: {lags: 3, within_db: 10}, polar: false, cartesian: false, png: false}"
        data = study(self.folder / "kept", "--set", kept, "--set", "trajectory.pings=13")
        got = data.sequence(0).statistics
        p = np.array([ping.series for ping in data], complex).transpose(0, 2, 1)
        expected = np.asarray(got.expected_intensity)
        mask = expected >= 0.1 * expected.max()
        np.testing.assert_array_equal(got.pooled_pixels(), mask)
        self.assertTrue(50 < mask.sum() < mask.size)
        u = np.where(mask, p / np.sqrt(expected), 0)
        x = np.abs(u) ** 2
        edges = np.append(np.arange(201) * 0.1, np.inf)
        for beam in range(mask.shape[1]):
            counts = np.histogram(x[:, mask[:, beam], beam], edges)[0]
            np.testing.assert_array_equal(got.intensity_histogram[:, beam], counts)
        # Centered by hand, in one sum over all pairs.
        for lag in range(4):
            for axis, ahead, behind in (("range", np.s_[..., lag:, :], np.s_[..., :mask.shape[0] - lag, :]),
                                        ("beams", np.s_[..., lag:], np.s_[..., :mask.shape[1] - lag])):
                pairs = mask[ahead] & mask[behind]
                for of, value in ((u, got.coherence(lag, axis)[0]), (x, got.intensity_correlation(lag, axis)[0])):
                    q = of - of.mean(0)
                    spread = np.sqrt((np.abs(q) ** 2).sum(0))
                    wanted = ((q[ahead] * q[behind].conj()).sum(0)[pairs].sum()
                              / (spread[ahead] * spread[behind])[pairs].sum())
                    self.assertLess(abs(value - wanted), 1e-9, (axis, lag))
        with self.assertRaisesRegex(DatasetError, "lag 4 is not kept"):
            got.coherence(4)

    def test_expected_levels_have_single_precision(self):
        """Of a scene with noise, as files of each ping and as arrays; `clean_db` is rounded to half precision."""
        noise = ("--set", "noise.spectrum_level_db=40", "--set", "trajectory.pings=2", "--set", "output.pings=true")
        for packing in ("ping", "sequence"):
            kept = (f"output={{statistics: true, clean_single: true, cartesian: false, png: false, "
                    f"one_file_per: {packing}}}")
            data = study(self.folder / packing, "--set", kept, *noise)
            clean = np.asarray(data[0].polar.clean_single_db)
            self.assertEqual(clean.dtype, np.float32)
            np.testing.assert_array_equal(np.asarray(data[0].polar.clean_db), clean.astype(np.float16))
            noise_power = data.sequence(0).info["noise"]["power_pa2"]
            power = np.asarray(data.sequence(0).statistics.expected_intensity) - noise_power
            loud = clean > clean.max() - 60
            np.testing.assert_allclose(clean[loud], 10 * np.log10(power[loud]) + 120, rtol=0, atol=2e-5)
            self.assertGreater(np.abs(np.asarray(data[0].polar.clean_db, float) - clean)[loud].max(), 0.02)

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
        more = ("--set", "trajectory.pings=29", "--set", "output={statistics: {lags: 2}, pings: false}")
        whole = study(self.folder / "whole", *more).sequence(0).statistics
        parts = [study(self.folder / r.replace(":", "_"), *more, "--pings", r)
                 .sequence(0).statistics for r in ("0:5", "5:21", "21:29")]
        merged = merge(parts)
        self.assertEqual(merged.realisations, 29)
        for name in PRIMARY + DERIVED:
            expected = np.asarray(getattr(whole, name))
            scale = np.nanmax(np.abs(expected))
            np.testing.assert_allclose(getattr(merged, name), expected, rtol=1e-7, atol=1e-11 * scale, err_msg=name)

    def test_worlds_of_a_scenario_are_not_realizations_of_one_scene(self):
        texture = ("--set", "materials.concrete={reflectivity: 1e-2, texture: {model: gamma, shape: 1.5, "
                   "correlation_m: 0.5}}", "--set", "sequences=3", "--set", "trajectory.pings=4")
        data = study(self.folder / "whole", *texture)
        first = [data.sequence(k).statistics for k in range(3)]
        again = [study(self.folder / r[0], *texture, "--pings", r, "--set", "name=other").sequence(1).statistics
                 for r in ("0:2", "2:4")]
        self.assertEqual(len({s.sources[0].scene for s in first}), 3)
        self.assertEqual({s.sources[0].scene for s in again}, {first[1].sources[0].scene})
        worlds = merge([first[0], *again, first[2]])
        self.assertIsInstance(worlds, Worlds)
        self.assertEqual((worlds.worlds, worlds.realisations), (3, 12))
        for name in PRIMARY[:6]:
            np.testing.assert_allclose(getattr(worlds, name), getattr(merge(first), name), rtol=1e-6,
                                       atol=1e-9 * np.max(np.abs(getattr(worlds, name))), err_msg=name)
        means = np.array([s.mean_intensity for s in first])
        inside = np.mean([s.intensity_variance for s in first], 0)
        between = means.var(0, ddof=1) - inside / 4
        scale = inside.max()
        np.testing.assert_allclose(worlds.within_variance, inside, rtol=1e-6, atol=1e-9 * scale)
        np.testing.assert_allclose(worlds.between_variance, between, rtol=1e-6, atol=1e-9 * scale)
        with self.assertRaisesRegex(DatasetError, "twice"):
            merge([*first, again[1]])
        other = study(self.folder / "seed", *texture, "--seed", "2", "--sequences", "1:2").sequence(1).statistics
        self.assertNotIn(other.sources[0].scene, {s.sources[0].scene for s in first})
        self.assertEqual(merge([*first, other]).worlds, 4)

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


def drawn(p, scene="one", **more):
    """Statistics of series [realizations, samples, beams] that no data set holds."""
    n, intensity, q = len(p), np.abs(p) ** 2, p - p.mean(0)
    mean = intensity.mean(0)
    arrays = dict(mean_pressure=p.mean(0), mean_intensity=mean, fourth_moment=(intensity ** 2).mean(0) / mean ** 2,
                  third_moment=(intensity ** 3).mean(0) / mean ** 3, **more)
    with np.errstate(invalid="ignore", divide="ignore"):
        arrays["intensity_variance"] = ((intensity - mean) ** 2).sum(0) / (n - 1)
        arrays["pressure_variance"] = variance = (np.abs(q) ** 2).sum(0) / (n - 1)
        arrays["contrast"] = np.sqrt(arrays["intensity_variance"]) / mean
        for name, ahead, own in (("bin", np.s_[1:], np.s_[:-1]), ("beam", np.s_[:, 1:], np.s_[:, :-1])):
            covariance = (q[(slice(None), *np.index_exp[ahead])] * q[(slice(None), *np.index_exp[own])].conj()).sum(0)
            arrays[f"{name}_covariance"] = covariance / (n - 1)
            arrays[f"{name}_coherence"] = covariance / (n - 1) / np.sqrt(variance[ahead] * variance[own])
    source = statistics.Source("scenario", scene, zlib.crc32(scene.encode()), 0, 0, n)
    return statistics.Statistics(n, arrays, [source])


class Laws(unittest.TestCase):
    """Estimates against closed forms, from numbers of numpy. Tolerances are 4 standard errors."""

    def setUp(self):
        self.random = np.random.default_rng(7)

    def speckle(self, *shape):
        return self.random.normal(size=(*shape, 2)).view(complex)[..., 0] * np.sqrt(0.5)

    def test_a_few_realizations_have_no_bias(self):
        """For n = 3, 5 and 20: the mean contrast of single pixels is 0.80, 0.87 and 0.958."""
        for n in (3, 5, 20):
            s = drawn(self.speckle(n, 200, 100))
            everywhere = np.ones((200, 100), bool)
            self.assertLess(s.contrast.mean(), 1 - 0.6 / n)
            for got, expected in ((s.mean_contrast(everywhere), 1), (s.looks(everywhere), 1),
                                  (s.normalised_moment(2, everywhere), 2), (s.normalised_moment(3, everywhere), 6)):
                self.assertLess(abs(got.value - expected), 4 * got.error, (n, expected))
                self.assertLess(got.error, 0.2)

    def test_averaged_intensities_have_their_number_of_looks(self):
        """Four looks: a gamma distribution. As intensities have no phase, these are of magnitudes."""
        intensity = self.random.gamma(4, size=(10, 200, 100))
        got = drawn(np.sqrt(intensity) * np.exp(2j * np.pi * self.random.random(intensity.shape))).looks(
            np.ones((200, 100), bool))
        # Relative variance of the squared contrast by (24a): 2 (1 + 1 / looks), against 4 of one look.
        self.assertLess(abs(got.value - 4), 4 * got.error)
        self.assertGreater(abs(got.value - 4.1), 4 * got.error)

    def test_worlds_follow_the_k_law(self):
        """Texture of shape 1.5 that 8 x 8 pixels share; 60 worlds of 3 realizations, 12 studies."""
        mask = np.ones((64, 24), bool)
        found = []
        for study_number in range(12):
            scenes = []
            for world in range(60):
                texture = np.kron(self.random.gamma(1.5, 1 / 1.5, size=(8, 3)), np.ones((8, 8)))
                scenes.append(drawn(self.speckle(3, 64, 24) * np.sqrt(texture), f"world {study_number} {world}"))
            worlds = merge(scenes)
            within, between = worlds.variances(mask)
            found.append([worlds.mean_contrast(mask), worlds.k_shape(mask), within, between,
                          worlds.normalised_moment(2, mask), worlds.normalised_moment(3, mask)])
        laws = [np.sqrt(1 + 2 / 1.5), 1.5, 1 + 1 / 1.5, 1 / 1.5, 2 * (1 + 1 / 1.5), 6 * (1 + 1 / 1.5) * (1 + 2 / 1.5)]
        for (values, errors), law in zip(np.array(found).transpose(1, 2, 0), laws):
            self.assertLess(abs(values.mean() - law), 4 * errors.mean() / np.sqrt(12), law)
            # The stated errors are those that studies have: 12 of them tell it to 21 %.
            self.assertLess(abs(np.log(values.std(ddof=1) / errors.mean())), 0.6, law)

    def test_worlds_of_one_realization_each(self):
        scenes = [drawn(self.speckle(1, 40, 30) * np.sqrt(self.random.gamma(1.5, 1 / 1.5, size=(40, 30))), str(world))
                  for world in range(200)]
        worlds, mask = merge(scenes), np.ones((40, 30), bool)
        got = worlds.mean_contrast(mask)
        self.assertLess(abs(got.value - np.sqrt(1 + 2 / 1.5)), 4 * got.error)
        self.assertLess(got.error, 0.05)
        intensity = np.array([s.mean_intensity for s in scenes])
        np.testing.assert_allclose(worlds.intensity_variance, intensity.var(0, ddof=1), rtol=1e-9)
        self.assertTrue(np.isnan(worlds.variances(mask).within.value))

    def test_speckle_has_no_texture(self):
        got = drawn(self.speckle(400, 40, 30)).k_shape(np.ones((40, 30), bool))
        self.assertTrue(got.value > 50)

    def test_coherence_of_known_speckle(self):
        """Each pixel shares a number with the next one: coherence 2/5 i along range, none along beams."""
        white = self.speckle(50, 101, 40)
        p = white[:, 1:] + 0.5j * white[:, :-1]
        expected = np.full((100, 40), 1.25)
        u = p / np.sqrt(1.25)
        x = np.abs(u) ** 2
        products, intensities = np.zeros((3, 40), complex), np.zeros((3, 40))
        for lag in range(3):
            products[lag] = (u[:, lag:] * u[:, :100 - lag].conj()).mean((0, 1))
            intensities[lag] = (x[:, lag:] * x[:, :100 - lag]).mean((0, 1))
        counts = np.array([np.histogram(x[..., beam], np.append(np.arange(201) * 0.1, np.inf))[0] for beam in range(40)]).T
        s = drawn(p, expected_intensity=expected, bin_lag_products=products, bin_lag_intensities=intensities,
                  intensity_histogram=counts)
        s.pooling = statistics.Pooling(2)
        for lag, rho in ((0, 1), (1, 0.4j), (2, 0)):
            value, error = s.coherence(lag)
            self.assertLess(abs(value - rho), 4 * error + 1e-9)
            value, error = s.intensity_correlation(lag)
            self.assertLess(abs(value - abs(rho) ** 2), 4 * error + 1e-9)
        h = s.histogram()
        law = -np.diff(np.exp(-h.edges)) / 0.1
        likely = law > 0.001
        deviation = (h.density - law)[likely] / h.error[likely]
        # 69 bins, errors from 10 groups of beams: Student's t of 9 degrees, whose variance is 9/7.
        self.assertLess(np.mean(deviation ** 2), 2)
        self.assertGreater(np.mean(deviation ** 2), 0.5)


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
        self.assertLess(abs(contrast.mean() - 1), 4 * stated.mean() / np.sqrt(24))
        # A standard deviation of 24 values is good to 1/sqrt(46): 15 %; 4 of them.
        self.assertLess(abs(contrast.std(ddof=1) / stated.mean() - 1), 0.6)
        wall = np.asarray(whole.mean_intensity) > 0.01 * np.max(whole.mean_intensity)
        mean, error = whole.mean_contrast(wall)
        self.assertLess(abs(mean - 1), 4 * error)
        # One pixel's, over the pixels; they are some 60 independent ones at least.
        spread = np.asarray(whole.contrast)[wall].std()
        self.assertLess(abs(spread / whole.contrast_error - 1), 0.4)
        fourth = np.asarray(whole.fourth_moment)[wall].mean()
        self.assertLess(abs(fourth - 2 * 2400 / 2401), 8 * error)
        third = whole.normalised_moment(3, wall)
        self.assertLess(abs(third.value - 6), 4 * third.error)
        expected = np.asarray(whole.expected_intensity)[wall]
        ratio = np.mean(np.asarray(whole.mean_intensity)[wall] / expected)
        self.assertLess(abs(ratio - 1), 4 * error)


if __name__ == "__main__":
    unittest.main()
