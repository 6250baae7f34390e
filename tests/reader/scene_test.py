"""Tracks and height maps of the reader, against the tables and masks that they come from."""
import csv
import pathlib
import shutil
import tempfile
import unittest

import numpy as np

import small_data
from ensonify_dataset import DatasetError, SonarDataset


class Scene(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.data = SonarDataset(small_data.generate("wreck_survey", cls.folder / "set", "--pings", "2:6", "--set",
                                                    "output.height_map.spacing_m=0.5"))
        cls.sequence = cls.data.sequence(0)

    def rows(self, name):
        with open(self.sequence.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def test_a_track_has_the_masks_of_all_pings(self):
        for view in ("polar", "cartesian"):
            tracks = self.sequence.tracks(view)
            self.assertEqual(list(tracks), [i["id"] for i in self.sequence.info["instances"]])
            seen = 0
            for number, track in tracks.items():
                self.assertEqual((track.instance, list(track.pings)), (number, [2, 3, 4, 5]))
                self.assertEqual(track.class_name, self.data.classes[track.class_id - 1])
                for i, ping in enumerate(self.sequence):
                    picture = getattr(ping, view)
                    mask = picture.instance == number
                    self.assertEqual(track.area[i], mask.sum())
                    self.assertEqual(track.seen[i], mask.any())
                    self.assertGreaterEqual(track.amodal_area[i], 0)
                    known = {a.instance: a for a in picture.annotations}
                    expected = known[number].bbox if number in known else (0, 0, 0, 0)
                    self.assertEqual(tuple(track.bbox[i]), tuple(expected))
                    if number in known and known[number].amodal_mask is not None:
                        self.assertEqual(track.amodal_area[i], known[number].amodal_mask.sum())
                    seen += mask.any()
            self.assertGreater(seen, 4)

    def test_a_track_has_poses_and_boxes_of_the_tables(self):
        tracks = self.sequence.tracks()
        for ping in self.sequence:
            for number, track in tracks.items():
                pose = ping.object_poses.get(number)
                expected = np.full(3, np.nan) if pose is None else pose.position_m
                np.testing.assert_array_equal(track.position_m[ping.row], expected)
                self.assertEqual(track.time_s[ping.row], ping.time_s)
        boxed = set()
        for row in self.rows("boxes.csv"):
            track, i = tracks[int(row["instance"])], int(row["ping"]) - 2
            self.assertEqual(list(track.box_size_m[i]), [float(row[k]) for k in ("size_x", "size_y", "size_z")])
            self.assertEqual(list(track.box_position_m[i]), [float(row[k]) for k in "xyz"])
            boxed.add(track.instance)
        self.assertGreater(len(boxed), 0)
        for number in set(tracks) - boxed:
            self.assertTrue(np.isnan(tracks[number].box_size_m).all())

    def test_a_view_that_is_not_there(self):
        with self.assertRaises(DatasetError):
            self.sequence.tracks("from above")

    def test_without_images_there_are_poses_and_boxes(self):
        folder = small_data.generate("wreck_survey", self.folder / "series", "--pings", "2:4", "--set",
                                     "output={polar: false, cartesian: false, png: false}")
        tracks = SonarDataset(folder).sequence(0).tracks()
        self.assertTrue(any(np.isfinite(track.position_m).all() for track in tracks.values()))
        self.assertFalse(any(track.seen.any() for track in tracks.values()))
        with self.assertRaisesRegex(DatasetError, "polar"):
            SonarDataset(folder).sequence(0).tracks("polar")

    def test_rows_of_other_pings_are_damage(self):
        copy = self.folder / "other_ping"
        shutil.copytree(self.data.folder, copy)
        path = copy / "sequences/000000/boxes.csv"
        lines = path.read_text().splitlines()
        ping = lines[0].split(",").index("ping")
        row = lines[1].split(",")
        row[ping] = "-1"
        path.write_text("\n".join([lines[0], ",".join(row), *lines[2:], ""]))
        with self.assertRaisesRegex(DatasetError, "ping -1"):
            SonarDataset(copy).sequence(0).tracks()

    def test_height_map(self):
        heights = self.sequence.height_map
        self.assertEqual(heights.height_m.shape, (len(heights.y_m), len(heights.x_m)))
        self.assertTrue((np.diff(heights.x_m) > 0).all() and (np.diff(heights.y_m) < 0).all())
        np.testing.assert_array_equal(heights.height_m, np.load(self.sequence.folder / "height_map.npy"))
        self.assertTrue(np.isfinite(heights.height_m).any())

    def test_a_height_map_of_another_shape_is_damage(self):
        copy = self.folder / "damaged"
        shutil.copytree(self.data.folder, copy)
        np.save(copy / "sequences/000000/height_map.npy", np.zeros((2, 3), np.float32))
        with self.assertRaises(DatasetError):
            SonarDataset(copy).sequence(0).height_map


if __name__ == "__main__":
    unittest.main()
