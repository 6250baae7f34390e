"""scripts/elevation_study.py: a quick run in which a network learns elevation, and its parts on known answers.

About 35 s of a core. Skips without PyTorch or the package `ensonify`.
"""
import importlib.util
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import small_data

SCRIPT = small_data.SOURCE / "scripts/elevation_study.py"
MISSING = [name for name in ("torch", "ensonify") if importlib.util.find_spec(name) is None]


@unittest.skipIf(MISSING, f"no {' and no '.join(MISSING)}")
class QuickStudy(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            output = pathlib.Path(folder, "out.json")
            command = [sys.executable, SCRIPT, "--json", output, "--quick"]
            result = subprocess.run([*map(str, command)], capture_output=True, text=True)
            assert result.returncode == 0, result.stderr
            cls.found = json.loads(output.read_text())

    def test_networks_learn_elevation(self):
        """2.3 degrees better than by range alone (standard error 0.4). Without the image, a network can learn no more
        than that."""
        for kinds in ("known", "other"):
            error = self.found["tests"][kinds]["mean_deg"]
            for arm in ("ensonify", "painted"):
                self.assertLess(error[arm]["value"], error["by_range"]["value"] - 1, (kinds, arm, error))

    def test_front_views_are_better_than_by_range(self):
        for kinds in ("known", "other"):
            share = self.found["tests"][kinds]["front_within_0.1_m"]
            self.assertGreater(share["ensonify"]["value"], share["by_range"]["value"] + 0.1, share)

    def test_true_elevations_give_the_front_view(self):
        """All but the sides of solids, where a pixel stands for several directions."""
        for errors in self.found["tests"].values():
            self.assertEqual(errors["mean_deg"]["truth"]["value"], 0)
            self.assertGreater(errors["front_within_0.1_m"]["truth"]["value"], 0.8)
            self.assertLess(errors["front_median_m"]["truth"]["value"], 0.06)


@unittest.skipIf(MISSING, f"no {' and no '.join(MISSING)}")
class KnownAnswers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        import elevation_study
        cls.study = elevation_study

    def test_painted_images_have_the_power_and_the_places_of_the_real_ones(self):
        """They have independent speckle; in the real one, beams overlap."""
        example = self.study.Example(self.study.ARMS, 9)
        scenario = self.study.ensonify.Scenario.load(self.study.SCENE)
        ping = next(iter(scenario.stream([3], 1, self.study.WANT)))
        expected, painted = self.study.expected_power(ping), self.study.painted_power(ping)
        self.assertAlmostEqual(painted.sum() / expected.sum(), 1)
        seen = np.isfinite(ping.polar.surface_elevation_rad)
        self.assertGreater((painted > 0)[seen].mean(), 0.95)
        self.assertGreater((painted == 0).mean(), (expected == 0).mean() + 0.2)  # no side lobes
        self.assertGreater(painted[seen].sum() / painted.sum(), 0.95)
        images = example(ping)["images"]
        self.assertEqual(images.shape, (3, *expected.shape))
        for image in images:
            self.assertAlmostEqual(image.mean(), 0, places=3)
        # Differences between neighboring beams are smaller than those across three only if speckle is correlated.
        seen = seen[:, 3:] & seen[:, :-3]
        ratios = [np.square(image[:, 1:-2] - image[:, :-3])[seen].mean()
                  / np.square(image[:, 3:] - image[:, :-3])[seen].mean() for image in images]
        self.assertLess(ratios[0], 0.6, ratios)
        for ratio in ratios[1:]:
            self.assertTrue(0.85 < ratio < 1.05, ratios)

    def test_front_view_of_a_level_bed_and_of_what_stands_before_it(self):
        range_m = np.arange(1, 161) * 0.0375
        rows = np.radians(np.linspace(-13, 13, 104))
        elevation = np.arcsin(np.clip(0.5 / range_m, 0, 1))[:, None] * -1 + np.zeros((160, 3))
        seen = np.abs(elevation) < np.radians(13)
        front = self.study.front_of(elevation, seen, range_m, rows)
        below = (rows < np.radians(-5)) & (rows > np.radians(-12.5))
        exact = 0.5 / np.sin(-rows[below])
        self.assertLess(np.abs(front[below, 0] / exact - 1).max(), 0.04)
        self.assertTrue(np.isinf(front[rows > 0]).all())
        elevation[60, 1], seen[60, 1] = np.radians(-6), True
        nearer = self.study.front_of(elevation, seen, range_m, rows)
        row = np.abs(rows - np.radians(-6)).argmin()
        self.assertEqual(nearer[row, 1], range_m[60])
        self.assertEqual(nearer[row, 2], front[row, 2])

    def test_constants_are_medians_by_what_they_know(self):
        rng = np.random.default_rng(2)
        by_range = np.linspace(-0.2, 0.2, 40)[:, None]
        constants = self.study.Constants(40)
        late = np.arange(40)[:, None] < np.where(np.arange(10) < 5, 0, 20)
        truth = np.where(late, np.nan, by_range + np.where(np.arange(10) < 5, 0, 0.02))[None]
        for _ in range(20):
            constants.learn(truth + rng.normal(0, 1e-4, truth.shape))
        answers = constants.answers(truth)
        bin_rad = 2 * self.study.HALF_FAN_RAD / 104
        self.assertLess(np.nanmax(np.abs(answers["by_range_and_first_echo"] - truth)), 0.6 * bin_rad)
        self.assertLess(np.abs(answers["by_range"][0, :20] - by_range[:20]).max(), 0.6 * bin_rad)
        self.assertAlmostEqual(answers["constant"][0, 0, 0], np.nanmedian(truth), delta=by_range[1, 0] - by_range[0, 0])

    def test_estimates_add_the_spread_of_worlds_and_of_seeds(self):
        found = self.study.estimate([[1, 3, np.nan], [3, 5, 1]])
        self.assertEqual((found["value"], found["by_seed"]), (3, [2, 4]))
        self.assertAlmostEqual(found["standard_error"], 2 ** 0.5)
        self.assertIsNone(self.study.estimate([[np.nan]])["value"])


if __name__ == "__main__":
    unittest.main()
