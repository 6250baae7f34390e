"""nerfstudio: transforms.json read by its data conventions, against the masks of a ball."""
import json
import unittest

import numpy as np

import camera_scene
import exported
import sonar_dataset


class Nerfstudio(unittest.TestCase):
    def test_the_ball_is_where_the_poses_say(self):
        source = camera_scene.dataset(**camera_scene.DISTORTION)
        out = exported.export("nerfstudio", source=source) / "000000"
        scene = json.loads((out / "transforms.json").read_text())
        self.assertEqual((scene["camera_model"], scene["w"], scene["h"]), ("OPENCV", 640, 480))
        sequence = exported.sequences(source)[0]
        self.assertEqual(len(scene["frames"]), 3)
        for ping, frame in enumerate(scene["frames"]):
            matrix = np.array(frame["transform_matrix"])
            np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-12)
            self.assertGreater(np.linalg.det(matrix[:3, :3]), 0)
            right, up, back = np.linalg.inv(matrix)[:3] @ np.append(camera_scene.BALL, 1)
            depth = -back
            x, y = camera_scene.distorted(*camera_scene.middle_of_outline(right, -up, depth),
                                          *(scene[key] for key in ("k1", "k2", "p1", "p2", "k3")))
            place = np.array([scene["fl_x"] * x + scene["cx"], scene["fl_y"] * y + scene["cy"]])
            np.testing.assert_allclose(place - 0.5, camera_scene.middle_of_ball(sequence, ping), atol=0.1)
            color = (out / frame["file_path"]).read_bytes()
            self.assertEqual(color, (sequence.folder / f"camera/{ping:06}_color.png").read_bytes())
            millimeters = sonar_dataset.read_png(out / frame["depth_file_path"])
            self.assertEqual(scene["depth_unit_scale_factor"], 1e-3)
            column, row = np.rint(place - 0.5).astype(int)
            self.assertAlmostEqual(millimeters[row, column] * 1e-3, depth - camera_scene.RADIUS_M, delta=0.01)
            self.assertEqual(millimeters[0, 0], 0)

    def test_the_same_data_set_gives_the_same_bytes(self):
        source = camera_scene.dataset()
        self.assertEqual(exported.hashes(exported.export("nerfstudio", source=source)),
                         exported.hashes(exported.export("nerfstudio", source=source)))

    def test_a_data_set_without_a_camera_is_an_error(self):
        result = exported.run("export", exported.dataset(), "--format", "nerfstudio", "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("camera", result.stderr)


if __name__ == "__main__":
    unittest.main()
