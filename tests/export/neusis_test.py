"""neusis: each pickle against the levels of the ping, and the pixels' places as the reader computes them."""
import json
import math
import pathlib
import pickle
import pickletools
import unittest

import numpy as np

import exported
import matrices

BLANKED_ROWS = 200  # that load_data.py of neusis sets to 0


def reader_axes(folder, shape):
    """Ranges of the middle and azimuths of pixels, as helpers.py of neusis samples them."""
    sensor = json.loads((folder / "Config.json").read_text())["agents"][0]["sensors"][0]
    assert sensor["sensor_type"] == "ImagingSonar"
    config, (rows, columns) = sensor["configuration"], shape
    step = (config["RangeMax"] - config["RangeMin"]) / rows
    fov = math.radians(config["Azimuth"])
    return (config["RangeMin"] + (np.arange(rows) + 0.5) * step, -fov / 2 + np.arange(columns) * fov / columns,
            config)


class Neusis(exported.Case):
    format_name = "neusis"
    options = ("--full-scale-db", "130")

    def pings(self, out):
        for sequence in exported.sequences():
            folder = out / f"{sequence.number:06}"
            names = sorted(path.name for path in (folder / "Data").iterdir())
            self.assertEqual(names, [f"{ping:04}.pkl" for ping in sequence.pings])
            for ping in sequence.pings:
                yield sequence, ping, pickle.loads((folder / f"Data/{ping:04}.pkl").read_bytes())

    def test_amplitudes_with_one_gain(self):
        largest = 0
        for sequence, ping, state in self.pings(exported.export("neusis", *self.options)):
            level = matrices.level_db(sequence, ping)
            image = state["ImagingSonar"]
            self.assertEqual(image.dtype, np.float32)
            self.assertEqual(image.shape, (level.shape[0] - 1 + BLANKED_ROWS, level.shape[1] + 1))
            expected = np.minimum(1, 10 ** ((level - 130) / 20))
            np.testing.assert_allclose(image[:-BLANKED_ROWS, 1:], expected[1:], rtol=1e-6)
            np.testing.assert_array_equal(image[:, 0], image[:, 1])
            self.assertFalse(image[-BLANKED_ROWS:].any())
            largest = max(largest, image.max())
        self.assertEqual(largest, 1, "no pixel reaches full scale: the limit would not be tested")

    def test_the_reader_samples_our_centers(self):
        out = exported.export("neusis", *self.options)
        for sequence, _, state in self.pings(out):
            folder = out / f"{sequence.number:06}"
            ranges, azimuths, config = reader_axes(folder, state["ImagingSonar"].shape)
            ours = sequence.npy("range_m.npy")
            np.testing.assert_allclose(ranges[:-BLANKED_ROWS], ours[1:], atol=1e-9)
            np.testing.assert_allclose(azimuths[1:], sequence.npy("azimuth_rad.npy"), atol=1e-12)
            self.assertGreaterEqual(config["RangeMin"], 0)
            self.assertEqual([config["RangeBins"], config["AzimuthBins"]], list(state["ImagingSonar"].shape))

    def test_poses(self):
        for sequence, ping, state in self.pings(exported.export("neusis", *self.options)):
            np.testing.assert_allclose(state["PoseSensor"], matrices.of_pose(sequence.pose(ping)), atol=1e-12)

    def test_the_arrays_can_be_written_to(self):
        """The reader sets pixels to 0 in place."""
        _, _, state = next(self.pings(exported.export("neusis", *self.options)))
        state["ImagingSonar"][0, 0] = 0.5

    def test_the_default_scale_is_white_in_the_images(self):
        white = exported.sequences()[0].head["png"]["db"][1]
        same = exported.hashes(exported.export("neusis", "--full-scale-db", white))
        self.assertEqual(exported.hashes(exported.export("neusis")), same)

    def test_a_pickle_calls_numpy_only(self):
        path = pathlib.Path(exported.export("neusis")) / "000000/Data/0000.pkl"
        called = {argument for code, argument, _ in pickletools.genops(path.read_bytes()) if code.name == "GLOBAL"}
        self.assertEqual(called, {"numpy.core.multiarray _reconstruct", "numpy ndarray", "numpy dtype"})

    def test_the_signed_distance_field_comes_along(self):
        source = exported.dataset("--set", "output.sdf.voxel_m=0.2", "--set", "trajectory.pings=1")
        out = exported.export("neusis", source=source)
        self.assertEqual((out / "000001/sdf.vdb").read_bytes(),
                         (source / "sequences/000001/sdf.vdb").read_bytes())

    def test_what_neusis_ngp_reads(self):
        """Heights with x along the rows, and the point under each ping, as run_sdf_2.5D.py takes them."""
        source = exported.dataset("--set", "output.height_map.spacing_m=0.25", "--set", "output.world=true")
        out = exported.export("neusis", source=source)
        for sequence in exported.sequences(source):
            folder, grid = out / f"{sequence.number:06}", sequence.head["height_map"]
            self.assertEqual((folder / "mesh.ply").read_bytes(), (sequence.folder / "world.ply").read_bytes())
            mesh = json.loads((folder / "Config.json").read_text())["mesh"]
            heights, ours = np.load(folder / "heightmap_gt.npy"), sequence.npy("height_map.npy")
            points = int((mesh["x_max"] - mesh["x_min"]) / mesh["res"])       # as the reader counts
            self.assertEqual(heights.shape, (points, points))
            self.assertEqual(points, int((mesh["y_max"] - mesh["y_min"]) / mesh["res"]))
            self.assertEqual(points, max(ours.shape))
            found = 0
            for row, column in np.argwhere(np.isfinite(ours)):
                x = grid["x_west_m"] + column * grid["spacing_m"]
                y = grid["y_north_m"] - row * grid["spacing_m"]
                i, j = round((x - mesh["x_min"]) / mesh["res"]), round((y - mesh["y_min"]) / mesh["res"])
                self.assertEqual(heights[i, j], ours[row, column])
                found += 1
            self.assertEqual(found, np.isfinite(heights).sum())
            self.assertEqual([mesh["z_min"], mesh["z_max"]], [np.nanmin(heights), np.nanmax(heights)])
            below = np.load(folder / "PC.npy")
            self.assertEqual(below.shape, (len(sequence.pings), 3))
            for ping, (x, y, z) in zip(sequence.pings, below):
                pose = sequence.pose(ping)
                self.assertLessEqual(max(abs(x - pose[0]), abs(y - pose[1])), 0.125 + 1e-9)
                self.assertEqual(z, -1)  # the floor of the room

    def test_without_these_files_there_are_none(self):
        folder = exported.export("neusis") / "000000"
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["Config.json", "Data"])
        self.assertNotIn("mesh", json.loads((folder / "Config.json").read_text()))


if __name__ == "__main__":
    unittest.main()
