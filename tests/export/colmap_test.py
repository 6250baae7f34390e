"""colmap: the text model read by the format's documentation, against the masks of a ball, and by COLMAP itself where
it is installed."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

import camera_scene
import exported

# The names of the parameters of each model, in order.
MODELS = {"PINHOLE": "fx fy cx cy", "OPENCV": "fx fy cx cy k1 k2 p1 p2",
          "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"}


def camera_of(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    number, model, width, height, *values = lines[0].split()
    assert (len(lines), number, width, height) == (1, "1", "640", "480")
    names = MODELS[model].split()
    assert len(names) == len(values)
    return model, dict(zip(names, map(float, values)))


def images_of(path):
    """{name: (quaternion, translation)}; a second line of each image holds its points."""
    lines = [line for line in path.read_text().split("\n") if not line.startswith("#")]
    images = {}
    assert sorted(int(line.split()[0]) for line in lines[0::2] if line) == list(range(1, len(lines[1::2]) + 1))
    for line, points in zip(lines[0::2], lines[1::2]):
        assert points == ""
        words = line.split()
        assert words[8] == "1"
        images[words[9]] = np.array(words[1:5], float), np.array(words[5:8], float)
    return images


def rotation(w, x, y, z):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def through_colmap(model):
    """camera_of and images_of what COLMAP has read and written again."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["colmap", "model_converter", "--input_path", model, "--output_path", folder, "--output_type", "TXT"],
                       check=True, stdout=subprocess.DEVNULL)
        return camera_of(pathlib.Path(folder, "cameras.txt")), images_of(pathlib.Path(folder, "images.txt"))


class Colmap(unittest.TestCase):
    def test_the_ball_is_where_the_poses_say(self):
        no_k3 = {key: value for key, value in camera_scene.DISTORTION.items() if key != "k3"}
        for model, distortion in (("PINHOLE", {}), ("OPENCV", no_k3), ("FULL_OPENCV", camera_scene.DISTORTION)):
            with self.subTest(model):
                source = camera_scene.dataset(**distortion)
                out = exported.export("colmap", source=source) / "000000"
                found, camera = camera_of(out / "sparse/0/cameras.txt")
                self.assertEqual(found, model)
                images = images_of(out / "sparse/0/images.txt")
                self.assertEqual(sorted(images), [path.name for path in sorted((out / "images").iterdir())])
                sequence = exported.sequences(source)[0]
                for ping, (quaternion, translation) in enumerate(images.values()):
                    p = rotation(*quaternion) @ camera_scene.BALL + translation
                    x, y = camera_scene.distorted(*camera_scene.middle_of_outline(*p),
                                                  *(camera.get(key, 0) for key in ("k1", "k2", "p1", "p2", "k3")))
                    place = np.array([camera["fx"] * x + camera["cx"], camera["fy"] * y + camera["cy"]])
                    np.testing.assert_allclose(place - 0.5, camera_scene.middle_of_ball(sequence, ping), atol=0.1)
                if shutil.which("colmap"):
                    again = through_colmap(out / "sparse/0")
                    self.assertEqual(again[0], (found, camera))
                    self.assertEqual(sorted(again[1]), sorted(images))
                    for name, places in again[1].items():
                        np.testing.assert_allclose(np.concatenate(places), np.concatenate(images[name]), atol=1e-14)
                points = (out / "sparse/0/points3D.txt").read_text()
                self.assertTrue(all(line.startswith("#") for line in points.splitlines()))


if __name__ == "__main__":
    unittest.main()
