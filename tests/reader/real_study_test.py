"""scripts/real_study.py, whole but tiny, on crops that the test makes; and its measures on images with known answers.

About 20 s of a core. Skips without PyTorch or Pillow.
"""
import argparse
import contextlib
import importlib.util
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np

import small_data

SCRIPT = small_data.SOURCE / "scripts/real_study.py"
CLASSES = ("big_propeller", "cylinder", "small_propeller", "soft_pipeline")
TINY = ["--sequences", "2", "--folds", "2", "--window-epochs", "1", "--class-epochs", "1", "--without", "array",
        "--set", "sonar.beams.count=96", "--set", "sonar.rays.elevation=32", "--set", "sonar.rays.min_per_cell=4",
        "--set", "output.cartesian.height_px=300"]
MISSING = [name for name in ("torch", "PIL") if importlib.util.find_spec(name) is None]


def speckle(rng, shape, exponent=1.0, level=20.0):
    return level * rng.rayleigh(size=shape) ** exponent


def crop_with_echoes(rng, rows, shape=(60, 50), height=110.0):
    """Speckle with a bright bar at each of the rows."""
    image = speckle(rng, shape, 0.7)
    for row in rows:
        image[row:row + 4, 12:38] += height * rng.rayleigh(size=(4, 26)) ** 0.3
    return np.clip(image, 0, 255).astype(np.uint8)


def made_crops(folder, count=6):
    """`count` crops for each class, which differ by the places of their echoes."""
    from PIL import Image
    rng = np.random.default_rng(5)
    for place, kind in enumerate(CLASSES):
        pathlib.Path(folder, kind).mkdir(parents=True)
        for number in range(1, count + 1):
            image = crop_with_echoes(rng, [15] if place % 2 else [12, 30])
            Image.fromarray(image).save(pathlib.Path(folder, kind, f"img_{number}.png"))


@unittest.skipIf(MISSING, f"no {' and no '.join(MISSING)}")
class WholeStudy(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.folder = pathlib.Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        made_crops(cls.folder / "real")
        cls.found = cls.study("all")

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    @classmethod
    def study(cls, name, *more):
        output = cls.folder / f"{name}.json"
        command = [sys.executable, SCRIPT, "--real", cls.folder / "real", "--json", output,
                   "--keep", cls.folder / "kept", "--program", small_data.PROGRAM,
                   "--sheet", cls.folder / "sheet.png", *TINY, *more]
        result = subprocess.run([*map(str, command)], capture_output=True, text=True)
        assert result.returncode == 0, result.stderr
        return json.loads(output.read_text())

    def assert_estimate(self, found, low, high):
        self.assertTrue(low <= found["value"] <= high, found)
        self.assertGreaterEqual(found["standard_error"], 0)

    def test_all_members_are_there(self):
        for kind in ("ours", "painted", "real"):
            self.assert_estimate(self.found[f"auc_real_{kind}"], 0, 1)
        for kind in ("ours", "painted", "clean", "real"):
            self.assert_estimate(self.found[f"macro_f1_{kind}_to_real"], 0, 1)
        for name in ("level_behind_peak_db", "target_contrast", "saturated_share", "background_contrast"):
            self.assertEqual(sorted(self.found[name]), ["ours", "painted", "real"])
            self.assert_estimate(self.found[name]["real"], -60, 60)
        self.assertEqual(sorted(self.found["two_echo_share_by_class"]), sorted(CLASSES))
        self.assert_estimate(self.found["display"]["ours"]["contrast_error"], -0.9, 9)
        self.assertTrue((self.folder / "sheet.png").stat().st_size > 1000)

    def test_real_crops_have_the_echoes_that_they_were_made_with(self):
        for place, kind in enumerate(CLASSES):
            share = self.found["two_echo_share_by_class"][kind]["real"]["value"]
            self.assertAlmostEqual(share, 0 if place % 2 else 1, delta=0.2, msg=kind)

    def test_the_difference_of_two_macro_f1_is_theirs(self):
        values = [self.found[f"macro_f1_{name}"]["value"] for name in ("ours_to_real", "clean_to_real", "ours_minus_clean")]
        self.assertAlmostEqual(values[0] - values[1], values[2], places=9)

    def test_every_real_crop_is_tested_once(self):
        tested = [name for fold in self.found["predictions"]["macro_f1_ours_to_real"] for name in fold["crops"]]
        self.assertEqual(len(tested), 6 * len(CLASSES))
        self.assertEqual(len(set(tested)), len(tested))

    def test_a_whole_block_of_numbers_is_held_out(self):
        first = self.found["predictions"]["macro_f1_ours_to_real"][0]["crops"]
        self.assertEqual([name for name in first if name.startswith("cylinder")],
                         [f"cylinder/img_{number}.png" for number in (1, 2, 3)])

    def test_data_sets_are_used_again_and_a_part_left_out_has_others(self):
        again = self.study("again", "--measures-only")
        self.assertEqual(again["level_behind_peak_db"], self.found["level_behind_peak_db"])
        self.assertEqual(len([*(self.folder / "kept").glob("cylinder_hf_*")]), 1)
        self.assertNotIn("predictions", again)
        without = self.study("without", "--measures-only", "--without", "texture")
        self.assertEqual(set(self.found["parts"]) - set(without["parts"]), {"texture"})
        self.assertEqual(len([*(self.folder / "kept").glob("cylinder_hf_*")]), 2)

    def test_an_unknown_part_is_an_error(self):
        command = [sys.executable, SCRIPT, "--real", "x", "--json", "x", "--without", "bounce"]
        result = subprocess.run([*map(str, command)], capture_output=True, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn("there is no part 'bounce'; expected some of bounces, texture", result.stderr)


@unittest.skipIf(MISSING, f"no {' and no '.join(MISSING)}")
class KnownAnswers(unittest.TestCase):
    def test_contrast_of_a_power_of_rayleigh_speckle(self):
        """sqrt(G(1 + p) / G(1 + p/2)^2 - 1); 300 crops of about 6 patches, standard error 0.002."""
        from real_crops.display import median_contrast
        rng = np.random.default_rng(3)
        for exponent in (0.6, 1.0):
            images = [np.clip(speckle(rng, (40, 40), exponent, 60), 0, 255).astype(np.uint8) for _ in range(300)]
            exact = math.sqrt(math.gamma(1 + exponent) / math.gamma(1 + exponent / 2) ** 2 - 1)
            self.assertAlmostEqual(median_contrast(images), exact, delta=0.06 * exact)

    def test_the_fit_finds_the_exponent_of_the_display(self):
        from real_crops.crops import RealCrop, SimulatedCrop
        from real_crops.display import PowerLaw, fit_power_law, shown
        rng = np.random.default_rng(4)

        def levels_db():
            return 20 * np.log10(speckle(rng, (50, 50)))

        real = [RealCrop(0, "", 0, 0, shown(levels_db(), PowerLaw(0.7, []), 40.0), None) for _ in range(60)]
        crops = [SimulatedCrop(0, "", 0, {"ours": levels_db()}) for _ in range(60)]
        self.assertAlmostEqual(fit_power_law(real, crops, "ours", 0).exponent, 0.7, delta=0.06)

    def test_a_crop_is_compressed_with_its_frame_and_alone(self):
        """Tables that leave the mean of each block alone: first of the blocks of the frame, then of those of the crop."""
        from real_crops.display import PowerLaw, shown

        def blocks(image):
            size = [side // 8 * 8 for side in image.shape]
            means = image[:size[0], :size[1]].astype(float).reshape(size[0] // 8, 8, size[1] // 8, 8).mean((1, 3))
            return np.kron(means, np.ones((8, 8)))

        level_db = 20 * np.log10(speckle(np.random.default_rng(8), (64, 64)))
        tables = {table: [1] + [255] * 63 for table in (0, 1)}
        plain = shown(level_db, PowerLaw(0.7, []), 40.0)
        frame = blocks(np.pad(plain, [(3, 8), (5, 8)], mode="edge"))[3:67, 5:69]
        found = shown(level_db, PowerLaw(0.7, [], tables), 40.0, (3, 5))
        np.testing.assert_allclose(found, blocks(frame), atol=2)
        self.assertGreater(np.abs(blocks(frame) - blocks(plain)).max(), 4)

    def test_the_soft_limit_of_the_display(self):
        """The crop gets its mean gray level, and x times the power of a gray level g gets 255 (1 - (1 - g/255)^x)."""
        from real_crops.display import PowerLaw, shown
        level_db = np.full((60, 60), 60.0)
        level_db[:, 40:] += 20      # a power of 10^0.8 with the exponent 0.8
        gray = shown(level_db, PowerLaw(0.8, []), 80.0)
        self.assertAlmostEqual(gray.mean(), 80, delta=0.6)
        background = 3 * 80 / 2 - gray[0, 50] / 2       # of two thirds of the pixels, before it is rounded
        self.assertAlmostEqual(gray[0, 50], 255 * (1 - (1 - background / 255) ** 10 ** 0.8), delta=2)

    def test_echoes_along_range(self):
        from real_crops.measures import echoes_along_range, measures_of
        rng = np.random.default_rng(6)
        for rows in ([20], [10, 30], [8, 24, 42]):
            image = crop_with_echoes(rng, rows)
            self.assertEqual(echoes_along_range(image), len(rows))
            self.assertEqual(measures_of(image)["two_echoes"], float(len(rows) > 1))

    def test_area_under_the_curve_and_macro_f1(self):
        from real_crops.networks import area_under_curve, macro_f1
        self.assertEqual(area_under_curve([0, 0, 1, 1], [1, 2, 3, 4]), 1)
        self.assertEqual(area_under_curve([0, 1, 0, 1], [1, 1, 1, 1]), 0.5)
        self.assertEqual(area_under_curve([0, 1, 0, 1], [1, 2, 3, 4]), 0.75)
        self.assertAlmostEqual(macro_f1([0, 0, 1, 1], [0, 1, 1, 1], 2), (2 / 3 + 4 / 5) / 2)

    def test_meshes_are_closed_where_they_shall_be(self):
        """Every edge of a hose belongs to two triangles, in opposite directions."""
        from real_crops.meshes import hose
        _, triangles = hose(np.random.default_rng(1))
        edges = [tuple(triangle[[k, (k + 1) % 3]]) for triangle in triangles for k in range(3)]
        self.assertEqual(len(set(edges)), len(edges))
        self.assertEqual({(b, a) for a, b in edges}, set(edges))

    def test_a_mirrored_beam_shows_what_its_mirror_image_would(self):
        """A pixel off the middle of its beam has the sample of the pixel as far on the other side, in the same row."""
        from real_crops.crops import mirrored_pixels
        azimuth_rad, range_m, pixel_m = np.radians([-20.0, -10, 0, 10, 20]), 0.01 * np.arange(1, 500), 0.02
        rows, columns = 200, 160
        ahead_m = 4.2 - (np.arange(rows)[:, None] + 0.5) * pixel_m
        port_m = 1.6 - (np.arange(columns)[None] + 0.5) * pixel_m
        azimuth = np.arctan2(port_m, ahead_m)

        def sample_at(angle):
            return np.rint((ahead_m / np.cos(angle) - range_m[0]) / 0.01).astype(int)

        beam = np.rint((azimuth - azimuth_rad[0]) / np.radians(10)).astype(int)
        inside = (np.abs(beam - 2) <= 2) & (sample_at(azimuth) < 490)
        pixels = np.where(inside, sample_at(azimuth) * 5 + beam, -1).astype(np.int32)
        sequence = argparse.Namespace(
            cartesian_map=pixels, azimuth_rad=azimuth_rad, range_m=range_m,
            info={"cartesian": {"x_top_m": 4.2, "y_left_m": 1.6, "metres_per_pixel": pixel_m}})
        found = mirrored_pixels(sequence)
        np.testing.assert_array_equal(found < 0, ~inside)
        np.testing.assert_array_equal(found[inside] % 5, beam[inside])
        mirrored = sample_at(2 * azimuth_rad[np.clip(beam, 0, 4)] - azimuth)
        np.testing.assert_array_equal(found[inside] // 5, np.minimum(mirrored, len(range_m) - 1)[inside])
        off = inside & (beam == 4) & (azimuth - azimuth_rad[4] > np.radians(3))
        self.assertTrue((found[off] // 5 < pixels[off] // 5).all())

    def test_parts(self):
        from real_crops.parts import PARTS, chosen_parts, part_settings
        target = argparse.Namespace(name="cylinder")
        self.assertEqual(chosen_parts(None, ["bounces"]), [name for name in PARTS if name != "bounces"])
        self.assertIn("bounces=2", part_settings(["bounces"], target))
        self.assertNotIn("bounces=2", part_settings(["texture"], target))

    def test_a_missing_package_is_named(self):
        import real_study
        with mock.patch("importlib.util.find_spec", side_effect=lambda name: None if name == "torch" else name):
            with self.assertRaisesRegex(SystemExit, "apt install python3-torch"):
                real_study.need_packages()


if __name__ == "__main__":
    unittest.main()
