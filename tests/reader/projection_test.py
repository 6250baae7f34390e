"""The projection of points, and images of motion."""
import os
import sys
import types
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(os.environ["SOURCE"]) / "scripts"))
from ensonify_dataset import flow_to_image, project, unproject  # noqa: E402

EQUAL = types.SimpleNamespace(azimuth_rad=np.radians(np.arange(-29.5, 30)), range_m=0.05 * np.arange(200))
UNEQUAL = types.SimpleNamespace(azimuth_rad=np.radians([-20.0, -11, -5, 0, 4, 12]), range_m=2 + 0.1 * np.arange(50))


class Projection(unittest.TestCase):
    def test_places_of_points_are_those_of_geometry(self):
        points = np.array([[3.0, 0, 0], [3, 3 * np.tan(np.radians(10)), 0], [3, 0, -4]])
        sample, beam, elevation = project(points, EQUAL)
        np.testing.assert_allclose(sample, np.array([3, 3 / np.cos(np.radians(10)), 5]) / 0.05)
        np.testing.assert_allclose(beam, [29.5, 39.5, 29.5])
        np.testing.assert_allclose(elevation, [0, 0, np.arcsin(-0.8)])

    def test_unequal_beams_and_places_outside_are_continued(self):
        azimuth = np.radians([-20, -8, 2, 12, 20, -29])
        points = np.stack([4 * np.cos(azimuth), 4 * np.sin(azimuth), 0 * azimuth], axis=-1)
        sample, beam, _ = project(points, UNEQUAL)
        np.testing.assert_allclose(sample, 20)
        np.testing.assert_allclose(beam, [0, 1.5, 3.5, 5, 6, -1], atol=1e-12)

    def test_one_beam_is_beam_0(self):
        one = types.SimpleNamespace(azimuth_rad=np.array([0.1]), range_m=0.05 * np.arange(200))
        sample, beam, elevation = project(np.array([[3.0, 0, 0], [3, 1, 0]]), one)
        np.testing.assert_array_equal(beam, [0, 0])
        np.testing.assert_allclose(np.arctan2(*unproject(sample, beam, elevation, one)[:, 1::-1].T), 0.1)

    def test_unprojecting_gives_the_points_back(self):
        points = np.random.default_rng(1).normal([6, 0, -1], 2, (500, 3))
        points[:, 0] = np.abs(points[:, 0]) + 0.1
        for axes in (EQUAL, UNEQUAL):
            np.testing.assert_allclose(unproject(*project(points, axes), axes), points, atol=1e-9)

    def test_colors_show_direction_and_length(self):
        samples, beams = np.array([[0, 0, 0, 3.0, np.nan]]), np.array([[0, 3.0, -3, 0, 1]])
        image = flow_to_image(samples, beams)
        self.assertEqual((image.shape, image.dtype), ((1, 5, 3), np.uint8))
        self.assertEqual(image[0, 0].tolist(), [255, 255, 255])
        self.assertEqual(image[0, 1].tolist(), [255, 0, 0])
        self.assertEqual(image[0, 2].tolist(), [0, 255, 255])
        self.assertEqual(image[0, 4].tolist(), [0, 0, 0])
        half = flow_to_image(samples, beams, largest=6)
        self.assertEqual(half[0, 1].tolist(), [255, 128, 128])
        self.assertEqual(flow_to_image(np.full((2, 2), np.nan), np.zeros((2, 2))).max(), 0)


if __name__ == "__main__":
    unittest.main()
