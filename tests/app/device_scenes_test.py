"""Every scene on a device, which is the host, as device_test has some.

ENSONIFY, SCENES and HOST_DEVICE as there. Run by ctest in --rest.
"""
import unittest

import device_test
from program import SCENES


class Scenes(device_test.Compared):
    def test_every_scene(self):
        for scene in sorted(SCENES.glob("*.yaml")):
            with self.subTest(scene.name):
                self.same_scene(scene)


if __name__ == "__main__":
    unittest.main()
