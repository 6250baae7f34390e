"""Other scenes on a device, which is the host, than device_test has: each preset, pulse, receiver and output of scenes/
once. What a world holds, the device does not see; it is given echoes.

ENSONIFY, SCENES and HOST_DEVICE as there. Run by ctest in --rest.
"""
import unittest

import device_test
from program import SCENES


class Scenes(device_test.Compared):
    def test_other_scenes(self):
        for name in ("echo_trains", "pile_inspection", "seabed_and_target", "sonar_tank", "speckle_wall"):
            with self.subTest(name):
                self.same_scene(SCENES / f"{name}.yaml")


if __name__ == "__main__":
    unittest.main()
