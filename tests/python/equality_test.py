"""Pings without files are the same bytes as those that are read from a data set, of a scene of each kind."""
import contextlib
import tempfile
import unittest
from pathlib import Path

import numpy as np

import ensonify as en
from ensonify.dataset import SonarDataset
from ensonify.wants import _FRONT, planes
from ensonify_dataset import DatasetError
from ensonify_dataset.views import PLANES
from small_data import KINDS, SCENES

# Scenes at a size that makes all of them in a minute; what they are about stays.
SMALL = {"sonar.beams.count": 48, "sonar.rays.elevation": 24, "output.cartesian": {"height_px": 60}}
OWN = {"speckle_wall": {"trajectory.pings": 4}, "random_debris": {"sequences": 3}, "watertank": {"sonar.beams.fov_deg": 30}}
# With every label that a ping can have. Each group of planes has a key of its name.
GROUPS = {row["group"] for row in PLANES.values()} - {""}
ALL_LABELS = {"sequences": 2, **{f"output.{group}": True for group in sorted(GROUPS)}, "output.front": True, "output.elevation.volumes": True,
              "output.layers": True, "output.cartesian": {"height_px": 60, "exr": True}, "sonar.receiver.mode": "array"}


def same(found, expected):
    """Equal to the last bit, NaN included, and of one type and shape."""
    expected = np.asarray(expected)
    return found.dtype == expected.dtype and found.shape == expected.shape and found.tobytes() == expected.tobytes()


class Comparison(unittest.TestCase):
    def compare_views(self, found, expected):
        names = [name for name in [*planes(), "grey"] if expected.has(name)]
        self.assertEqual(names, [name for name in [*planes(), "grey"] if found.has(name)])
        for name in names:
            self.assertTrue(same(getattr(found, name), getattr(expected, name)), f"{expected.kind} {name}")
        masks = zip(found.annotations, expected.annotations, strict=True)
        for own, read in masks if names else ():
            for member in ("instance", "name", "class_id", "bbox", "area", "occlusion", "truncated", "contrast_db"):
                self.assertEqual(getattr(own, member), getattr(read, member), member)
            self.assertTrue(same(own.mask, read.mask))
            self.assertEqual(own.amodal_mask is None, read.amodal_mask is None)
            if own.amodal_mask is not None:
                self.assertTrue(same(own.amodal_mask, read.amodal_mask))

    def compare_ping(self, found, expected):
        self.assertEqual((found.sequence.number, found.number), (expected.sequence.number, expected.number))
        self.assertEqual(found.time_s, expected.time_s)
        self.assertTrue(same(found.first_return_m, expected.first_return_m))
        self.assertEqual(set(found.object_poses), set(expected.object_poses))
        poses = [(found.pose, expected.pose)] + [(found.object_poses[i], pose) for i, pose in
                                                 expected.object_poses.items()]
        for own, read in poses:
            self.assertTrue(same(own.position_m, read.position_m) and
                            same(own.quaternion_wxyz, read.quaternion_wxyz))
        files = expected.sequence.folder
        if (files / "timeseries").exists() or (files / "timeseries.npy").exists():
            self.assertTrue(same(found.series, expected.series))
        if "recorder" in expected.sequence.info:
            self.assertTrue(same(found.recorded, expected.recorded))
            self.assertTrue(same(found.recorded_level_db, expected.recorded_level_db))
        for name in _FRONT:
            self.assertEqual(found.front.has(name), expected.front.has(name))
            if expected.front.has(name):
                self.assertTrue(same(getattr(found.front, name), getattr(expected.front, name)), f"front {name}")
        if (files / "elevation").exists():
            self.assertTrue(same(found.elevation.rows, expected.elevation.rows))
            if expected.sequence.power_spread:
                self.assertTrue(same(found.elevation.expected_power(), expected.elevation.expected_power()))
        self.compare_views(found.polar, expected.polar)
        self.compare_views(found.cartesian, expected.cartesian)

    def compare_sequence(self, found, expected):
        for name in ("azimuth_rad", "range_m"):
            self.assertTrue(same(getattr(found, name), getattr(expected, name)))
        if (expected.folder / "front_azimuth_rad.npy").exists():
            for name in ("front_azimuth_rad", "front_elevation_rad"):
                self.assertTrue(same(getattr(found, name), getattr(expected, name)))
        if expected.map_path.exists():
            self.assertTrue(same(found.cartesian_map, expected.cartesian_map))
        only_files = {"files", "bytes", "each_ping", "png", "arrays", "axes", "statistics"}
        for key in set(expected.info) - only_files:
            self.assertEqual(found.info[key], expected.info[key], key)

    def compare_set(self, scene, settings, threads):
        scenario = en.Scenario.load(SCENES / f"{scene}.yaml", set=settings)
        with tempfile.TemporaryDirectory() as folder:
            en.generate(scenario, Path(folder) / "set", threads=2)
            data = SonarDataset(Path(folder) / "set")
            self.assertGreater(len(data), 0)
            for found, expected in zip(scenario.stream(threads=threads), data, strict=True):
                self.compare_ping(found, expected)
                self.compare_sequence(found.sequence, expected.sequence)

    def compare_scenes(self, scenes):
        for i, scene in enumerate(scenes):
            with self.subTest(scene=scene):
                self.compare_set(scene, {**SMALL, "trajectory.pings": 1, **OWN.get(scene, {})}, 1 + i % 2)


class Equality(Comparison):
    def test_scenes_are_the_same_with_and_without_files(self):
        self.compare_scenes(KINDS)

    def test_every_label_is_the_same(self):
        scenario = en.Scenario.load(SCENES / "random_debris.yaml", set={**SMALL, **ALL_LABELS})
        with tempfile.TemporaryDirectory() as folder:
            en.generate(scenario, Path(folder) / "set")
            for found, expected in zip(scenario.stream(threads=2), SonarDataset(Path(folder) / "set"), strict=True):
                self.compare_ping(found, expected)
                self.assertTrue(expected.polar.has("surface_range_m") and expected.cartesian.has("surface_range_m"))
                for layer in expected.sequence.info["layers"]:
                    self.assertTrue(same(found.layer(layer), expected.layer(layer)), layer)

    def test_recorded_counts_come_from_the_ping_and_not_from_files(self):
        recorders = [{"bits": 8, "scale": "db", "db": [40, 120]},
                     {"bits": 16, "scale": "amplitude", "db": [40, 140], "row_gain_db": 30}]
        for recorder in recorders:
            settings = {**SMALL, "sequences": 1, "sonar.recorder": recorder}
            scenario = en.Scenario.load(SCENES / "random_debris.yaml", set=settings)
            with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
                # A data set of another seed lies where the names of the scenario lead.
                en.generate(en.Scenario.load(SCENES / "random_debris.yaml", set={**settings, "seed": 99}), scenario.name)
                en.generate(scenario, "set")
                found, expected = scenario.ping(0, 0), SonarDataset("set")[0, 0]
                self.compare_ping(found, expected)
                if "row_gain_db" in recorder:
                    self.assertTrue(same(found.row_gain, expected.row_gain))
                for read in (lambda: found.sequence.pose_rows, lambda: found.sequence.annotated_images(0)):
                    self.assertRaisesRegex(DatasetError, "finished data sets", read)
        plain = en.Scenario.load(SCENES / "random_debris.yaml", set=SMALL).ping(0, 0)
        self.assertRaisesRegex(DatasetError, "sonar.recorder", lambda: plain.recorded_level_db)
        self.assertRaisesRegex(DatasetError, "row_gain_db", lambda: plain.row_gain)

    def test_what_is_wanted_does_not_change_what_comes(self):
        scenario = en.Scenario.load(SCENES / "random_debris.yaml", set={**SMALL, "sequences": 1, "output.elevation": True})
        whole = scenario.ping(0, 1)
        echoes = scenario.ping(0, 1, want=["elevation"]).elevation
        with tempfile.TemporaryDirectory() as folder:
            en.generate(scenario, Path(folder) / "set")
            expected = SonarDataset(Path(folder) / "set")[0, 1].elevation
            self.assertTrue(same(echoes.rows, expected.rows))
            self.assertTrue(same(echoes.expected_power(), expected.expected_power()))
        with self.assertRaisesRegex(DatasetError, "want"):
            scenario.ping(0, 1, want=["level_db"]).sequence.power_spread
        for names in (["level_db"], ["series"], ["instance", "shadow"], ["cartesian.grey"], ["clean_db", "annotations"]):
            part = scenario.ping(0, 1, want=names)
            for name in names:
                view, _, plane = name.rpartition(".")
                if name == "series":
                    self.assertTrue(same(part.series, whole.series))
                elif name == "annotations":
                    self.assertEqual([a.bbox for a in part.polar.annotations], [a.bbox for a in whole.polar.annotations])
                else:
                    self.assertTrue(same(getattr(getattr(part, view or "polar"), plane),
                                         getattr(getattr(whole, view or "polar"), plane)), name)


if __name__ == "__main__":
    unittest.main()
