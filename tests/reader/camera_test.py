"""The camera of a data set, read by scripts/ensonify_dataset: files against closed forms and against the sonar."""
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

import small_data
from ensonify_dataset import DatasetError, SonarDataset

SCENARIO = """ensonify: 1
name: camera
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 6, beams: {count: 48, fov_deg: 60},
        rays: {elevation: 40}, mount: {position_m: [0.1, 0, 0.05], rotation_deg: [0, 5, 0]}}
camera:
  mount: {position_m: [0, 0.2, -0.1], rotation_deg: [4, 6, 3]}
  width_px: 160
  height_px: 120
  fov_deg: 70
  distortion: {k1: -0.15, k2: 0.02, p1: 0.001, p2: 0.002}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: wall, class: wall, material: m, shape: {box: {size_m: [0.2, 9, 9]}}, pose: {position_m: [5, 0, 0], rotation_deg: [0, 0, 20]}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [3, 0.3, 0.1]}}
trajectory: {poses: [{time_s: 0}, {time_s: 1, position_m: [0.3, 0.2, 0.1], rotation_deg: [0, 5, 10]}], ping_rate_hz: 1, pings: 2}
output: {cartesian: false, png: false, timeseries: none, camera: {flow: true}}
"""


class CameraTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="ensonify-")
        cls.addClassCleanup(folder.cleanup)
        cls.root = pathlib.Path(folder.name)
        (cls.root / "camera.yaml").write_text(SCENARIO)
        for name, more in (("pings", []), ("packed", ["--set", "output.one_file_per=sequence"])):
            subprocess.run([small_data.PROGRAM, "generate", cls.root / "camera.yaml", "-o", cls.root / name, "--quiet", *more],
                           check=True)
            subprocess.run([small_data.PROGRAM, "verify", cls.root / name], check=True, capture_output=True)

    def ping(self, folder="pings", number=0):
        return SonarDataset(self.root / folder)[number]

    def test_points_are_on_the_ball(self):
        for number in (0, 1):
            image = self.ping(number=number).camera
            points = image.position_m @ image.pose.rotation.T + image.pose.position_m
            on_ball = points[image.instance == 2]
            self.assertGreater(len(on_ball), 200)
            np.testing.assert_allclose(np.linalg.norm(on_ball - [3, 0.3, 0.1], axis=-1), 0.3, atol=2e-5)

    def test_rays_and_projection_are_inverse(self):
        camera = self.ping().sequence.camera
        pixels = np.stack(np.meshgrid(np.arange(160.0), np.arange(120.0)), axis=-1)
        np.testing.assert_allclose(camera.project(2.5 * camera.rays(pixels)), pixels, atol=1e-8)
        self.assertTrue(np.isnan(camera.project(np.array([0, 0, -1.0]))).all())

    def test_flow_carries_points_to_the_next_image(self):
        now, then = self.ping(number=0).camera, self.ping(number=1).camera
        points = now.position_m @ now.pose.rotation.T + now.pose.position_m
        expected = now.camera.project((points - then.pose.position_m) @ then.pose.rotation)
        pixels = np.stack(np.meshgrid(np.arange(160.0), np.arange(120.0)), axis=-1)
        seen = now.instance > 0
        np.testing.assert_allclose((pixels + now.flow_px)[seen], expected[seen], atol=1e-3)
        self.assertGreater(np.abs(now.flow_px[seen]).max(), 5)
        self.assertTrue(np.isnan(then.flow_px).all())

    def test_pixels_of_sonar_and_camera_agree(self):
        ping = self.ping()
        place = ping.camera.to_sonar()
        seen = ping.camera.instance > 0
        rows, columns = np.nonzero(seen)
        pixels, is_seen = ping.camera.from_sonar(place.sample[seen], place.beam[seen], place.elevation_rad[seen])
        np.testing.assert_allclose(pixels, np.stack([columns, rows], axis=-1), atol=1e-6)
        self.assertTrue(is_seen.all())
        # What the sonar says of the ball is on the ball of the camera.
        samples, beams = np.nonzero(ping.polar.instance == 2)
        pixels, is_seen = ping.camera.from_sonar(samples, beams, ping.polar.elevation_rad[samples, beams])
        column, row = np.rint(pixels[is_seen]).astype(int).T
        self.assertGreater(is_seen.sum(), 20)
        self.assertGreater((ping.camera.instance[row, column] == 2).mean(), 0.7)

    def test_packed_arrays_are_the_files(self):
        for number in (0, 1):
            files, packed = self.ping("pings", number).camera, self.ping("packed", number).camera
            for name in ("depth_m", "normal", "instance", "semantic", "color", "flow_px"):
                self.assertTrue(files.has(name) and packed.has(name), name)
                np.testing.assert_array_equal(getattr(files, name), getattr(packed, name), name)
        self.assertEqual(files.color.shape, (120, 160, 3))
        self.assertEqual(files.color.dtype, np.uint8)

    def test_a_data_set_without_a_camera_is_told(self):
        folder = small_data.generate("sonar_tank", self.root / "without", "--pings", "0:1")
        ping = SonarDataset(folder)[0]
        self.assertFalse(ping.camera.has("depth_m"))
        with self.assertRaisesRegex(DatasetError, "has no camera"):
            ping.camera.camera
        with self.assertRaisesRegex(DatasetError, "camera depth_m"):
            ping.camera.depth_m


if __name__ == "__main__":
    unittest.main()
