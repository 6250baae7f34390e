"""Planes of motion, held against the projection of their points computed here from poses and surfaces alone, and against
lines through boxes."""
import unittest

import numpy as np

from program import made
from ensonify_dataset import SonarDataset

SONAR = """ensonify: 1
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 9
  beams: {count: 40, fov_deg: 60}
  rays: {elevation: 80, min_per_cell: 0}
materials: {m: {reflectivity: 1e-2}}
"""
RESTING = SONAR + """objects:
  - {name: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -2]}}
  - {name: ball, material: m, shape: {sphere: {radius_m: 0.5}}, pose: {position_m: [5, 0.5, -1.2]}}
  - {name: wall, material: m, shape: {box: {size_m: [0.2, 1.5, 2]}}, pose: {position_m: [4, -1, -1.2]}}
trajectory:
  ping_rate_hz: 2
  pings: 5
  poses:
    - {time_s: 0, position_m: [0, 0, 0], rotation_deg: [0, 10, 0]}
    - {time_s: 2, position_m: [0.6, 0.8, 0.1], rotation_deg: [3, 14, -12]}
output: {surfaces: true, motion: {pings: 2}}
"""
# The box `mover` goes behind `front` in one ping.
MOVING = SONAR + """objects:
  - {name: front, material: m, shape: {box: {size_m: [0.2, 2, 4]}}, pose: {position_m: [3, 0, 0]}}
  - name: mover
    material: m
    shape: {box: {size_m: [0.6, 0.6, 0.6]}}
    trajectory: {poses: [{time_s: 0, position_m: [5, 2.2, 0]}, {time_s: 1, position_m: [5, 0.1, 0]}]}
trajectory: {ping_rate_hz: 1, pings: 2}
output: {motion: true}
"""
# Turns of a quarter of the fan, and a look up into open water.
TURNING = SONAR + """objects:
  - {name: floor, material: m, shape: {plane: {}}, pose: {position_m: [0, 0, -1]}}
trajectory:
  ping_rate_hz: 1
  pings: 4
  poses:
    - {time_s: 0, position_m: [0, 0, 0], rotation_deg: [0, 0, 0]}
    - {time_s: 1, position_m: [0, 0, 0], rotation_deg: [0, 0, 15]}
    - {time_s: 2, position_m: [0, 0, 0], rotation_deg: [0, 0, 30]}
    - {time_s: 3, position_m: [0, 0, 0], rotation_deg: [0, -80, 30]}
output: {covisibility: true, timeseries: none}
"""


def direction(azimuth, elevation):
    return np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], -1)


def meets_box(start, ends, center, size):
    """Whether the line from start to each end passes the box before the end."""
    with np.errstate(divide="ignore"):
        a = (center - size / 2 - start) / (ends - start)
        b = (center + size / 2 - start) / (ends - start)
    enters, leaves = np.minimum(a, b).max(-1), np.maximum(a, b).min(-1)
    return (enters < leaves) & (enters < 1 - 1e-4) & (leaves > 0)


class PointMotion(unittest.TestCase):
    def make(self, scenario, *more):
        return SonarDataset(made(scenario, *more))

    def points(self, ping):
        """World points of the pixels that have one, from elevation, range and beam; and where these pixels are."""
        polar, sequence = ping.polar, ping.sequence
        where = polar.motion_state > 0
        beams = np.arange(len(sequence.azimuth_rad))
        azimuth = np.interp(polar.point_beam[where], beams, sequence.azimuth_rad)
        step = sequence.range_m[1] - sequence.range_m[0]
        points = (polar.point_sample[where] * step)[:, None] * direction(azimuth, polar.surface_elevation_rad[where])
        return where, points @ ping.pose.rotation.T + ping.pose.position_m

    def test_a_world_at_rest_moves_as_its_points_project(self):
        data = self.make(RESTING)
        compared = 0
        for k in range(3):
            ping, other = data[k], data[k + 2]
            where, points = self.points(ping)
            x, y, z = ((points - other.pose.position_m) @ other.pose.rotation).T
            sequence = ping.sequence
            samples = np.sqrt(x * x + y * y + z * z) / (sequence.range_m[1] - sequence.range_m[0])
            step = sequence.azimuth_rad[1] - sequence.azimuth_rad[0]
            beams = (np.arctan2(y, x) - sequence.azimuth_rad[0]) / step
            polar = ping.polar
            self.assertLess(np.abs(polar.point_sample[where] + polar.motion_samples[where] - samples).max(), 0.02)
            self.assertLess(np.abs(polar.point_beam[where] + polar.motion_beams[where] - beams).max(), 0.02)
            self.assertLess(np.abs(polar.point_sample - np.arange(len(where))[:, None])[where].max(), 1.01)
            compared += where.sum()
        self.assertGreater(compared, 4000)
        self.assertEqual(data[3].polar.motion_state.max(), 0)  # the sequence ends before the other ping
        self.assertTrue(np.isnan(data[3].polar.motion_beams).all())

    def test_points_are_hidden_where_a_line_meets_the_wall(self):
        ping, other = (data := self.make(RESTING))[0], data[2]
        where, points = self.points(ping)
        state, occluder = ping.polar.motion_state[where], ping.polar.motion_occluder[where]
        floor = ping.polar.instance[where] == 1
        inside = floor & (state != 3)
        behind = meets_box(other.pose.position_m, points[inside], np.array([4, -1, -1.2]), np.array([0.2, 1.5, 2]))
        hidden = (state[inside] == 2) & (occluder[inside] == 3)
        self.assertGreater(behind.sum(), 50)
        self.assertLess((behind != hidden).mean(), 0.002)  # at edges, points are rounded
        self.assertTrue(((occluder > 0) == (state == 2)).all())
        self.assertGreater((state == 3).sum(), 20)

    def test_a_box_that_goes_behind_another_is_hidden_by_it(self):
        polar = self.make(MOVING)[0].polar
        mover = polar.instance == 2
        self.assertGreater(mover.sum(), 10)
        self.assertTrue((polar.motion_state[mover] == 2).all())
        self.assertTrue((polar.motion_occluder[mover] == 1).all())
        step = np.radians(60 / 40)
        expected = (np.arctan2(0.1, 5) - np.arctan2(2.2, 5)) / step
        self.assertLess(abs(np.median(polar.motion_beams[mover]) - expected), 1)
        self.assertTrue((polar.motion_state[polar.instance == 1] == 1).all())
        self.assertLess(np.abs(polar.motion_samples[polar.instance == 1]).max(), 1e-6)

    def test_covisibility_is_the_overlap_of_turned_fans(self):
        shares = self.make(TURNING)[0].sequence.covisibility
        self.assertEqual((shares.dtype, shares.shape), (np.float32, (4, 4)))
        expected = [[1, 0.75, 0.5, 0], [0.75, 1, 0.75, 0], [0.5, 0.75, 1, 0]]
        np.testing.assert_allclose(shares[:3], expected, atol=1e-6)
        self.assertTrue(np.isnan(shares[3]).all())

    def test_covisibility_counts_what_is_hidden(self):
        data = self.make(MOVING.replace("motion: true", "covisibility: true, timeseries: none"))
        there, back = data[0].sequence.covisibility[0, 1], data[0].sequence.covisibility[1, 0]
        self.assertLess(there, 1)  # the box goes behind the other
        self.assertGreater(there, 0.5)
        self.assertEqual(back, 1)  # the box in front stays

    def test_packed_arrays_and_other_threads_hold_the_same(self):
        one = self.make(RESTING)
        packed = self.make(RESTING.replace("motion: {", "one_file_per: sequence, motion: {"), "--threads", 1)
        for a, b in zip(one, packed):
            for name in ("point_sample", "point_beam", "motion_samples", "motion_beams", "motion_state",
                         "motion_occluder"):
                np.testing.assert_array_equal(getattr(a.polar, name), getattr(b.polar, name), name)
        self.assertEqual(packed[0].sequence.info["motion"], {"pings": 2})


if __name__ == "__main__":
    unittest.main()
