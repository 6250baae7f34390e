"""kitti: poses and calibration read as the development kit of KITTI odometry, against the masks of a ball."""
import unittest

import numpy as np

import camera_scene
import exported
import sonar_dataset


class Kitti(unittest.TestCase):
    def test_the_ball_is_where_the_poses_say(self):
        source = camera_scene.dataset()
        out = exported.export("kitti", source=source)
        calib = dict(line.split(": ") for line in (out / "sequences/00/calib.txt").read_text().splitlines())
        self.assertEqual(sorted(calib), ["P0", "P1", "P2", "P3"])
        projection = np.array(calib["P2"].split(), float).reshape(3, 4)
        poses = np.loadtxt(out / "poses/00.txt").reshape(-1, 3, 4)
        np.testing.assert_allclose(np.loadtxt(out / "sequences/00/times.txt"), [0, 0.5, 1])
        np.testing.assert_allclose(poses[0], np.eye(4)[:3], atol=1e-12)
        sequence = exported.sequences(source)[0]
        # The ball in the first camera's frame, by pixel and depth of its nearest point.
        column, row = middle = camera_scene.middle_of_ball(sequence, 0)
        ray = np.linalg.inv(projection[:, :3]) @ [*middle, 1]
        depth = sonar_dataset.read_png(out / "sequences/00/depth_2/000000.png")[round(row), round(column)] / 256
        ball = ray * (depth + camera_scene.RADIUS_M / np.linalg.norm(ray))
        for ping, pose in enumerate(poses):
            p = projection @ np.append(np.linalg.inv(pose[:, :3]) @ (ball - pose[:, 3]), 1)
            np.testing.assert_allclose(p[:2] / p[2], camera_scene.middle_of_ball(sequence, ping), atol=0.3)
            color = (out / f"sequences/00/image_2/{ping:06}.png").read_bytes()
            self.assertEqual(color, (sequence.folder / f"camera/{ping:06}_color.png").read_bytes())
        # The way of the camera is that of its mount.
        self.assertGreater(np.linalg.norm(poses[2][:, 3]), 0.2)

    def test_distorted_images_are_an_error(self):
        result = exported.run("export", camera_scene.dataset(**camera_scene.DISTORTION), "--format", "kitti",
                              "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("distorted", result.stderr)


if __name__ == "__main__":
    unittest.main()
