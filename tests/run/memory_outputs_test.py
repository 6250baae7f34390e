"""As memory_test, for every output that holds much.

ENSONIFY is the program. Run by ctest in --rest, without sanitizers; by hand:
    ENSONIFY=build/release/ensonify PYTHONPATH=scripts:tests/cli python3 -m unittest memory_outputs_test
"""
import unittest

import memory_test
from memory_test import MESH, ROOM

OUTPUTS = {
    "large Cartesian images": (ROOM, "output.cartesian.height_px=3000", "output.png.tvg=true"),
    "series alone": (ROOM, "output.polar=false", "output.cartesian=false", "output.png=false", "sonar.range_max_m=60"),
    "many rays": (ROOM, "sonar.rays.elevation=500", "output.scatterers=true"),
    "front views of many rays": (ROOM, "sonar.rays.elevation=1500", "output.front=true"),
    "echoes over elevation": (ROOM, "sonar.rays.elevation=1500", "output.elevation=true"),
    "volumes over elevation": (ROOM, "volumes=[{name: water, uniform: {strength_db: -60}}]", "sonar.range_max_m=12",
                               "output.elevation={step_deg: 1, volumes: true}"),
    # Pings enough that two of them hold most at the same time.
    "motion within the ping": (
        ROOM, "motion_within_ping=true",
        "trajectory={poses: [{time_s: 0}, {time_s: 2, position_m: [3, 0.5, 0]}], ping_rate_hz: 8, pings: 16}"),
    "layers": (ROOM, "output.layers=true", "sonar.range_max_m=40", "noise={spectrum_level_db: 30}"),
    "a large mesh in every sequence": (MESH, "sequences=4", "trajectory.pings=1",
                                       "materials.m.reflectivity={uniform: [1e-3, 2e-3]}"),
    "a distance field that takes more than the pings": (ROOM, "output.sdf.voxel_m=0.03", "sonar.range_max_m=10",
                                                        "output.cartesian=false"),
}


class Outputs(memory_test.Announced):
    def test_every_output(self):
        (self.folder / "floor.obj").write_text(memory_test.floor(340))
        for name, (text, *overrides) in OUTPUTS.items():
            with self.subTest(name):
                self.check_announced(text, *overrides)


if __name__ == "__main__":
    unittest.main()
