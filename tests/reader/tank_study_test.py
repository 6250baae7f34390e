"""scripts/tank_study.py, whole but tiny, on frames that the test makes; and the roles of frames, masks and errors.

About 12 s of a core. Skips without PyTorch or Pillow.
"""
import contextlib
import importlib.util
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np

import small_data

SCRIPT = small_data.SOURCE / "scripts/tank_study.py"
ROWS, BEAMS, TIRE, WALL = 90, 32, 9, 11
SCENES = 6          # of made frames, in turn
SCENE = f"""
ensonify: 1
sonar:
  preset: blueview_p900_90
  range_min_m: 1
  range_max_m: 3
  beams: {{count: {BEAMS}}}
  rays: {{elevation: 24, min_per_cell: 0}}
materials: {{body: {{reflectivity: 0.02}}}}
objects:
  - name: wheel
    class: tyre
    material: body
    shape: {{sphere: {{radius_m: 0.2}}}}
    pose: {{position_m: [{{uniform: [1.5, 2.0]}}, 0, 0]}}
  - name: end
    class: wall
    material: body
    shape: {{box: {{size_m: [0.1, 4, 2]}}}}
    pose: {{position_m: [2.6, 0, 0]}}
trajectory: {{poses: [{{time_s: 0}}], ping_rate_hz: 1, pings: 2}}
noise: {{spectrum_level_db: 40}}
output: {{timeseries: none, cartesian: false, png: false}}
"""
MISSING = [name for name in ("torch", "PIL") if importlib.util.find_spec(name) is None]


def save(path, array):
    from PIL import Image
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(array.astype(np.uint8)).save(path)


def scene_of(number):
    """Each of SCENES once in twelve numbers, in an order that moves on by one."""
    return (number // 2 + number // 12) % SCENES


def made_frames(folder, numbers, settings=("far", "near"), beams=BEAMS):
    """Speckle on the background of a scene, which moves, with a bright disc and a bright end, in turn in two settings."""
    rng = np.random.default_rng(3)
    rows, columns = np.mgrid[:ROWS, :beams]
    grounds = np.kron(np.random.default_rng(4).choice([3, 70], (SCENES, 18, beams // 4)), np.ones((5, 4)))
    for number in numbers:
        name = settings[number % len(settings)]
        mask = np.zeros((ROWS, beams))
        mask[(rows - rng.integers(20, 50)) ** 2 / 9 + (columns - rng.integers(8, 24)) ** 2 < 16] = TIRE
        mask[75:] = WALL
        ground = np.roll(grounds[scene_of(number)], (5 * rng.integers(-2, 3), 2 * rng.integers(-2, 3)), (0, 1))
        save(folder / name / f"frames/{number:05}.png", np.clip(rng.rayleigh(ground + 60 * (mask > 0)), 0, 255))
        save(folder / name / f"masks/{number:05}.png", mask)
    for name in settings:
        (folder / name / "frames/recording.yaml").write_text("fan_deg: 30\nrange_m: [1.0, 3.0]\nscale: {db: [0, 80]}\n")


@unittest.skipIf(MISSING, f"no {' and no '.join(MISSING)}")
class WholeStudy(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.folder = pathlib.Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        made_frames(cls.folder / "real", range(32))
        (cls.folder / "tank.yaml").write_text(SCENE)
        cls.output = cls.study("--ablate", "noise", "--figure", cls.folder / "figure.png")
        cls.found = json.loads((cls.folder / "out.json").read_text())

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    @classmethod
    def study(cls, *more):
        command = [sys.executable, SCRIPT, "--real", cls.folder / "real", "--json", cls.folder / "out.json", "--quick",
                   "--scene", cls.folder / "tank.yaml", "--keep", cls.folder / "kept", "--program", small_data.PROGRAM,
                   "--folds", "2", "--block", "8", "--sequences", "4", "--steps", "4", *more]
        result = subprocess.run([*map(str, command)], capture_output=True, text=True)
        assert result.returncode == 0, result.stderr
        return result.stdout

    def test_all_arms_are_there_with_errors(self):
        arms = ["ours", "ours_and_1%", "ours_and_5%", "ours_and_10%", "ours_and_100%", "painted", "real", "copied"]
        self.assertEqual(sorted(self.found["miou"]), sorted(arms))
        self.assertEqual(self.found["frames"], {"real": 32, "fitting": 16, "scenes": 2 * SCENES, "simulated": 4})
        for arm, one in self.found["miou"].items():
            self.assertTrue(0 <= one["value"] <= 1 and one["standard_error"] >= 0, arm)
            self.assertEqual([name for name, value in self.found["iou_by_class"][arm].items() if value is not None],
                             ["background", "tire", "wall"])
        for pair in ("real_ours", "real_painted", "real_real", "ours_painted", "ours_painted_seen"):
            self.assertTrue(0 <= self.found[f"auc_{pair}"]["value"] <= 1)
        self.assertEqual(sorted(self.found["ablations"]["noise"]["gain"]), ["auc", "miou"])
        self.assertIn("without noise: AUC", self.output)
        self.assertGreater((self.folder / "figure.png").stat().st_size, 1000)

    def test_every_tested_frame_is_tested_once_by_each_arm(self):
        """16 of the 32 frames are never tested; the others have 144 x 64 cells each."""
        for arm in ("real", "ours_and_1%", "copied"):
            tables = [one["confusion"] for one in self.found["runs"] if one["arm"] == arm]
            self.assertEqual(np.sum(tables), 16 * 144 * 64)

    def test_all_seeds_of_simulated_frames_are_tested_on_all_folds(self):
        pairs = {(one["seed"], one["fold"]) for one in self.found["runs"] if one["arm"] == "painted"}
        self.assertEqual(pairs, {(0, 0), (0, 1), (1, 0), (1, 1)})
        self.assertEqual({arm: len(seeds) for arm, seeds in self.found["miou_by_seed"].items()}, {"ours": 2, "painted": 2})


@unittest.skipIf(MISSING, f"no {' and no '.join(MISSING)}")
class RealFrames(unittest.TestCase):
    def setUp(self):
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        self.folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        made_frames(self.folder, range(48))

    def read(self, block=8, folds=2):
        from real_frames.frames import real_frames
        from real_frames.scenes import ALIKE, give_scenes
        settings, frames = real_frames(self.folder, block)
        give_scenes(settings, frames, ALIKE, folds, self.folder)
        return frames

    def test_every_other_block_is_for_fitting(self):
        frames = self.read()
        self.assertEqual({f.number // 8 for f in frames if f.fitting}, {0, 2, 4})
        self.assertEqual({f.number // 8 for f in frames if not f.fitting}, {1, 3, 5})

    def test_frames_that_are_alike_are_one_scene_of_one_fold(self):
        """The backgrounds tell scenes of a setting, not the places of discs; both folds have as many frames."""
        frames = self.read()
        pairs = {((f.setting, scene_of(f.number)), f.scene) for f in frames}
        self.assertEqual([len(pairs), len({scene for _, scene in pairs})], [2 * SCENES, 2 * SCENES])
        self.assertEqual(len({(f.scene, f.block) for f in frames}), 2 * SCENES)
        self.assertEqual([sum(f.block == fold for f in frames) for fold in (0, 1)], [24, 24])

    def test_training_frames_show_no_tested_scene(self):
        from real_frames.frames import tested_frames, training_frames
        frames = self.read()
        self.assertEqual(sum(len(tested_frames(frames, fold)) for fold in (0, 1)), 24)
        for fold in (0, 1):
            tested, training = tested_frames(frames, fold), training_frames(frames, fold)
            self.assertEqual(len(training), 24)
            self.assertFalse({f.scene for f in tested} & {f.scene for f in training} or any(f.fitting for f in tested))

    def test_frames_that_others_connect_are_one_scene(self):
        from real_frames.scenes import groups_of
        linked = np.eye(6, dtype=bool)
        for a, b in ((0, 4), (4, 2), (1, 5)):
            linked[a, b] = linked[b, a] = True
        self.assertEqual(list(groups_of(linked)), [0, 1, 0, 2, 0, 1])

    def test_folds_share_kinds_evenly(self):
        """Scenes 0 to 3 have one class and 4 to 7 another: each of four folds gets one of both."""
        from real_frames.scenes import folds_of
        found = folds_of(np.kron(np.eye(2), np.ones((4, 1))) * 5, 4)
        self.assertEqual([sorted(found[:4]), sorted(found[4:])], [[0, 1, 2, 3]] * 2)

    def test_shares_take_scene_after_scene(self):
        from real_frames.frames import training_frames
        from real_frames.scenes import some_of
        frames = training_frames(self.read(), 1)
        for share, count, scenes in ((0.01, 1, 1), (0.3, 7, 2), (0.5, 12, 3), (1.0, 24, 6)):
            some = some_of(frames, share, 1)
            self.assertEqual([len(some), len({f.scene for f in some})], [count, scenes])
        first = {next(iter({f.scene for f in some_of(frames, 0.01, seed)})) for seed in range(9)}
        self.assertGreater(len(first), 1)

    def test_frames_are_compared_over_shifts(self):
        """A frame of speckle and its copy, 8 rows and 4 columns of cells farther: the shift is found, and moves masks."""
        from real_frames.frames import Frame
        from real_frames.scenes import CELLS, SHIFTS, copied_mask, likeness
        rng = np.random.default_rng(2)
        grays = rng.rayleigh(40, (3, *CELLS)).clip(0, 255).astype(np.uint8)
        grays[1] = np.roll(grays[0], (8, -4), (0, 1))
        alike, places = likeness(*[[Frame("", 0, 0, gray, gray) for gray in some] for some in (grays[:1], grays[1:])])
        self.assertGreater(alike[0, 0], 0.9)
        self.assertLess(alike[0, 1], 0.3)
        self.assertEqual(SHIFTS[places[0, 0]], (-4, 2))
        np.testing.assert_array_equal(copied_mask(grays[1], places[0, 0])[:-8, 4:], grays[0][:-8, 4:])
        self.assertFalse(copied_mask(grays[1], places[0, 0])[-8:].any())

    def test_networks_see_no_tested_scene(self):
        """Records what networks are trained on: no frame of a tested scene, and as many as there are of the others."""
        from real_frames import segmentation, trainings
        frames = self.read()
        study = object.__new__(trainings.Trainings)
        study.real, study.folds, study.shares = frames, range(2), (0.5, 1.0)
        study.effort = trainings.Effort((4, 4), 4, 1, 1, 1)
        numbers = np.array([f.number for f in frames])[:, None, None] * np.ones((1, 4, 4))
        study._real, study._simulated = (numbers, np.zeros((48, 4, 4), np.uint8)), {"ours": (-numbers, numbers)}
        seen = []
        with mock.patch.object(segmentation, "trained", lambda sources, *_: seen.append(sources)), \
                mock.patch.object(study, "_tested", lambda *_: []):
            study.from_real("real", 1)
            study.from_simulated("ours", 1)
        real = [{int(n) for images, _, _ in sources for n in images[:, 0, 0] if n > 0} for sources in seen]
        others = {f.number for f in frames if f.block != 1 and f.number > 0}
        self.assertEqual([real[0], real[1], real[3]], [others, set(), others])
        self.assertTrue(real[2] < others and len(real[2]) in (11, 12))

    def refused(self, words, **options):
        with self.assertRaisesRegex(ValueError, words) as caught:
            self.read(**options)
        self.assertNotIn("\n", str(caught.exception))

    def test_too_few_scenes(self):
        self.refused("only 12 of 13 folds have frames to test .12 scenes.", folds=13)

    def test_too_few_blocks(self):
        self.refused("has 1 block of 93 numbers; expected one for fitting and one for tests", block=93)

    def test_no_masks(self):
        shutil.rmtree(self.folder / "near/masks")
        self.refused("near/masks/00001.png: is not there; expected a mask for each frame")

    def test_no_frames(self):
        shutil.rmtree(self.folder / "near")
        shutil.rmtree(self.folder / "far")
        self.refused("has no folder with frames/")

    def test_two_files_of_a_number(self):
        shutil.copy(self.folder / "near/frames/00001.png", self.folder / "near/frames/b_00001.png")
        self.refused("b_00001.png: has the number of 00001.png; expected a number for each")

    def test_another_number_of_beams(self):
        made_frames(self.folder, [50], settings=("far",), beams=BEAMS + 8)
        self.refused("00050.png: has 90 rows and 40 beams; expected 90 and 32")

    def test_unknown_classes(self):
        save(self.folder / "far/masks/00004.png", np.full((ROWS, BEAMS), 12))
        self.refused("00004.png: has the unknown class 12; expected 0 to 11")

    def test_no_ranges(self):
        (self.folder / "far/frames/recording.yaml").write_text("fan_deg: 30\n")
        self.refused(r"recording.yaml: has no `range_m: \[first, last\]`")

    def test_no_fan(self):
        file = self.folder / "far/frames/recording.yaml"
        file.write_text(file.read_text().replace("fan_deg", "# fan"))
        self.refused("recording.yaml: has no `fan_deg: degrees`")


@unittest.skipIf(MISSING, f"no {' and no '.join(MISSING)}")
class SimulatedFrames(unittest.TestCase):
    def setting(self, name, first_m, last_m, rows=5):
        from real_frames.frames import Setting
        return Setting(name, rows, 32, (first_m, last_m), (0, 80), 32)

    def test_the_rows_and_beams_of_a_setting(self):
        """Samples of 1 mm from 0 on, and two beams in each of 32 degrees: rows have their range, and port is first."""
        from real_frames.simulated import on_rows

        class Sequence:
            range_m, azimuth_rad = 0.001 * np.arange(3000), np.radians(np.arange(-15.75, 16, 0.5))
        setting = self.setting("near", 1, 2, rows=1001)
        range_m = on_rows(setting, Sequence, np.repeat(Sequence.range_m[:, None], 64, 1))
        np.testing.assert_allclose(range_m, np.repeat(np.linspace(1, 2, 1001)[:, None], 32, 1), atol=0.0013)
        azimuth_rad = on_rows(setting, Sequence, np.repeat(Sequence.azimuth_rad[None], 3000, 0))
        np.testing.assert_allclose(azimuth_rad, np.repeat(np.radians(np.arange(15.5, -16, -1))[None], 1001, 0), atol=0.006)

    def test_a_record_has_the_setting_of_its_range(self):
        from real_frames.simulated import setting_of
        settings = [self.setting("far", 0.8, 3.4), self.setting("near", 1, 2.4)]
        self.assertEqual([setting_of(np.linspace(0, last, 50), 32, settings, "") for last in (3.3, 2.5)], [0, 1])
        with self.assertRaisesRegex(ValueError, "from 0.00 to 9.00 m; expected those of far, 0.80 to 3.40 m or near"):
            setting_of(np.linspace(0, 9, 50), 32, settings, "x")
        with self.assertRaisesRegex(ValueError, "has 48 beams, and the real frames 32"):
            setting_of(np.linspace(0, 3.4, 50), 48, settings, "x")

    def test_masks_as_people_draw_them(self):
        """A ring is filled, a chain is not; a standing bottle has its shadow, and a shampoo bottle is it; a wall reaches to
        the end."""
        from real_frames.frames import CLASSES
        from real_frames.simulated import mask_as_drawn
        ids = np.array([0, *map(CLASSES.index, ("tire", "chain", "standing bottle", "wall", "shampoo bottle"))], np.uint8)
        instance, shadow = np.zeros((9, 5), int), np.zeros((9, 5), int)
        for beam in range(5):
            instance[[1, 4], beam] = beam + 1
        shadow[5:7, 2], shadow[5:7, 4] = 3, 5

        class Polar:
            def has(self, name):
                return name == "shadow"
        polar = Polar()
        polar.instance, polar.semantic, polar.shadow = instance, instance, shadow
        expected = np.zeros((9, 5), int)
        expected[1:5, 0], expected[[1, 4], 1], expected[1:7, 2], expected[1:, 3] = 9, 3, 8, 11
        expected[5:7, 4] = 7
        np.testing.assert_array_equal(mask_as_drawn(polar, ids), expected)

    def test_frames_and_masks_move_together(self):
        """Protects labels: where a frame is 3, its mask is, and both have other places than before."""
        from real_frames.segmentation import varied, zoomed
        masks = np.zeros((6, 40, 20), np.uint8)
        masks[:, 12:20, 5:9] = 3
        images, moved = zoomed(masks.astype(np.float32), masks, np.random.default_rng(1))
        np.testing.assert_array_equal(images, moved)
        self.assertEqual(set(np.unique(moved)), {0, 3})
        self.assertEqual(len({mask.tobytes() for mask in moved}), 6)
        images, moved = varied(masks.astype(np.float32), masks, np.random.default_rng(2))
        for image, mask in zip(images, moved):
            self.assertLess(image[mask == 0].max(), image[mask == 3].min())

    def test_further_trainings_begin_with_the_weights_of_another_network(self):
        """Four steps change no weight by much more than four times the highest rate; weights of another seed are farther."""
        from real_frames.segmentation import trained
        source = np.random.default_rng(1).normal(size=(5, 16, 16)).astype(np.float32), np.ones((5, 16, 16), np.uint8), 4

        def weights(*more):
            return np.concatenate([p.detach().numpy().ravel() for p in trained([source], 4, *more).parameters()])
        first, other = trained([source], 3, 0, 4), weights(1, 4)
        before = np.concatenate([p.detach().numpy().ravel() for p in first.parameters()])
        further = weights(1, 4, first)
        self.assertTrue(0 < np.abs(further - before).max() < 0.01)
        self.assertGreater(np.abs(other - before).max(), 0.1)

    def test_overlap(self):
        """IoU 2/4 of class 1 and 1/3 of class 2; class 3 is not there, and 0 is the background."""
        from real_frames.segmentation import mean_iou
        table = np.array([[5, 1, 0, 0], [1, 2, 0, 0], [0, 0, 1, 2], [0, 0, 0, 0]])
        self.assertAlmostEqual(mean_iou(table), (2 / 4 + 1 / 3) / 2)
        self.assertAlmostEqual(mean_iou(table, background=True), (5 / 7 + 2 / 4 + 1 / 3) / 3)

    @unittest.skipUnless((small_data.SCENES / "watertank.yaml").exists(), "no scenes/watertank.yaml")
    def test_parts_are_keys_of_the_scene(self):
        from real_frames.parts import PARTS
        command = [small_data.PROGRAM, "check", small_data.SCENES / "watertank.yaml", "--set", "sequences=1"]
        for setting in (setting for part in PARTS.values() for setting in part.off):
            command += ["--set", setting]
        result = subprocess.run([*map(str, command)], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_an_unknown_part_is_an_error(self):
        from real_frames.parts import chosen_parts
        with self.assertRaisesRegex(ValueError, "no part 'nose'; expected all, or some of detector"):
            chosen_parts("noise,nose")


if __name__ == "__main__":
    unittest.main()
