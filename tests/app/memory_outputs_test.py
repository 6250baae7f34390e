"""As memory_test, for every output that holds much.

ENSONIFY is the program. Run by ctest in --rest, without sanitizers; by hand:
    ENSONIFY=build/release/ensonify python3 -m unittest memory_outputs_test
"""
import unittest

import memory_test


class Outputs(memory_test.Announced):
    def test_large_cartesian_images(self):
        self.check_announced(memory_test.ROOM, "output.cartesian.height_px=3000", "output.png.tvg=true")

    def test_series_alone(self):
        self.check_announced(
            memory_test.ROOM, "output.polar=false", "output.cartesian=false", "output.png=false",
            "sonar.range_max_m=60",
        )

    def test_many_rays(self):
        self.check_announced(memory_test.ROOM, "sonar.rays.elevation=500", "output.scatterers=true")

    def test_front_views_of_many_rays(self):
        self.check_announced(memory_test.ROOM, "sonar.rays.elevation=1500", "output.front=true")

    def test_echoes_over_elevation(self):
        self.check_announced(memory_test.ROOM, "sonar.rays.elevation=1500", "output.elevation=true")

    def test_volumes_over_elevation(self):
        self.check_announced(memory_test.ROOM, "volumes=[{name: water, uniform: {strength_db: -60}}]",
                             "sonar.range_max_m=12", "output.elevation={step_deg: 1, volumes: true}")

    def test_motion_within_the_ping(self):
        # Pings enough that two of them hold most at the same time.
        self.check_announced(
            memory_test.ROOM, "motion_within_ping=true",
            "trajectory={poses: [{time_s: 0}, {time_s: 2, position_m: [3, 0.5, 0]}], ping_rate_hz: 8, pings: 16}",
        )

    def test_layers(self):
        self.check_announced(memory_test.ROOM, "output.layers=true", "sonar.range_max_m=40",
                             "noise={spectrum_level_db: 30}")

    def test_large_mesh_in_every_sequence(self):
        (self.folder / "floor.obj").write_text(memory_test.floor(340))
        self.check_announced(
            memory_test.MESH, "sequences=4", "trajectory.pings=1", "materials.m.reflectivity={uniform: [1e-3, 2e-3]}"
        )

    def test_distance_field_that_takes_more_than_the_pings(self):
        self.check_announced(memory_test.ROOM, "output.sdf.voxel_m=0.03", "sonar.range_max_m=10", "output.cartesian=false")


if __name__ == "__main__":
    unittest.main()
