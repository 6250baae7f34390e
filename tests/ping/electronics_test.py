"""Data sets of an instrument with electronics, a detector and a recorder: counts against levels, masks against layers,
packed and by ping, one thread and two, frames dropped."""
import unittest

import numpy as np

from program import made
from ensonify_dataset import SonarDataset

SCENARIO = """ensonify: 1
seed: 3
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 6
  beams: {count: 24, fov_deg: 24, receive_width_deg: 2}
  rays: {elevation: 8, min_per_cell: 0}
  electronics:
    crosstalk_db: -30
    leakage: {level_db: 190, decay_m: 0.2}
    interference: {level_db: 185, ping_rate_hz: 200, duration_s: 2e-4, azimuth_deg: 4}
    blanking_m: 0.4
    saturation: {level_db: 180, streak_db: -6, streak_m: 1}
  recorder: {db: [90, 180]}
materials: {m: {reflectivity: 1e-3}, bright: {reflectivity: 1}}
objects:
  - {name: room, material: m, shape: {box: {size_m: [9, 9, 3], inward_facing: true}}}
  - {name: ball, material: bright, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [2, 0.2, 0]}}
noise: {spectrum_level_db: 60, correlated: true}
trajectory: {ping_rate_hz: 5, pings: 3}
output: {layers: true, cartesian: {height_px: 80}}
"""

DETECTOR = ("--set", "sonar.detector={looks: 2, floor_db: 95, noise_db: 1.5, integrate: 1.6, law: amplitude}")


class Electronics(unittest.TestCase):
    def make(self, *more):
        return SonarDataset(made(SCENARIO, *more))

    def test_counts_stand_for_the_levels_of_the_image(self):
        for ping in self.make():
            counts = ping.recorded
            self.assertEqual((counts.dtype, counts.shape), (np.uint8, ping.polar.level_db.shape))
            shown = np.clip(ping.polar.level_db, 90, 180)
            # Half a step of 90/255 dB, and half a step of the half floats of the image.
            self.assertLess(np.abs(ping.recorded_level_db - shown).max(), 0.5 * 90 / 255 + 0.0626)

    def test_row_gains_are_stored_and_taken_out(self):
        recorder = "sonar.recorder={bits: 16, scale: amplitude, db: [0, 185], gamma: 0.8, row_gain_db: 40}"
        ping = self.make("--set", recorder)[1]
        self.assertEqual(ping.recorded.dtype, np.uint16)
        heard = ping.polar.level_db > 100
        self.assertLess(np.abs(ping.recorded_level_db - ping.polar.level_db)[heard].max(), 0.2)
        loud = ping.recorded.max(axis=1)[ping.polar.level_db.max(axis=1) > 150]
        self.assertGreater(loud.min(), 65000)
        packed = self.make("--set", recorder, "--set", "output.one_file_per=sequence")[1]
        self.assertTrue((packed.recorded == ping.recorded).all() and (packed.row_gain == ping.row_gain).all())

    def test_masks_mark_what_the_layer_adds(self):
        for ping in self.make():
            artifact, extra = ping.polar.artifact, np.abs(ping.layer("electronics")).T
            rest = np.abs(ping.series - ping.layer("electronics")).T
            self.assertEqual(set(np.unique(artifact)) & {1, 2, 4, 8, 16}, {1, 2, 4, 8, 16})
            blanked = artifact == 16
            self.assertTrue((np.abs(ping.series.T)[blanked] == 0).all())
            clipped = artifact & 1 > 0
            np.testing.assert_allclose(np.abs(ping.series.T)[clipped], 1e3, rtol=1e-5)
            # Cross-talk moves a few percent of an amplitude, and leaves no mark.
            unmarked = (artifact == 0) & (extra > 0.5 * rest + 1)
            self.assertLess(unmarked.mean(), 0.01)
            marked = artifact & (2 | 4 | 8) > 0
            self.assertTrue((extra[marked] > 0).all())
            pixels = ping.sequence.cartesian_map
            mapped = np.where(pixels < 0, 0, artifact.ravel()[np.maximum(pixels, 0)])
            np.testing.assert_array_equal(ping.cartesian.artifact, mapped)

    def test_packed_and_by_thread_the_same_numbers(self):
        one = self.make()
        packed = self.make("--threads", "1", "--set", "output.one_file_per=sequence")
        for a, b in zip(one, packed):
            np.testing.assert_array_equal(a.recorded, b.recorded)
            np.testing.assert_array_equal(a.polar.artifact, b.polar.artifact)
            np.testing.assert_array_equal(a.series, b.series)

    def test_counts_without_images(self):
        alone = self.make("--set", "output={polar: false, cartesian: false, png: false}")
        whole = self.make()
        for a, b in zip(alone, whole):
            np.testing.assert_array_equal(a.recorded, b.recorded)

    # tests/independent works out the levels themselves.
    def test_a_detector_changes_levels_and_counts_alone(self):
        plain, detected = self.make(), self.make(*DETECTOR)
        alone = self.make(*DETECTOR, "--set", "output={polar: false, cartesian: false, png: false}")
        packed = self.make(*DETECTOR, "--threads", "1", "--set", "output.one_file_per=sequence")
        self.assertNotIn("detector", plain[0].sequence.info["sonar"])
        self.assertEqual(detected[0].sequence.info["sonar"]["detector"]["law"], "amplitude")
        for a, b, counts, single in zip(plain, detected, alone, packed):
            np.testing.assert_array_equal(a.series, b.series)
            np.testing.assert_array_equal(a.polar.clean_db, b.polar.clean_db)
            np.testing.assert_array_equal(a.polar.instance, b.polar.instance)
            self.assertGreater(np.abs(a.polar.level_db - b.polar.level_db).mean(), 1)
            shown = np.clip(b.polar.level_db, 90, 180)
            self.assertLess(np.abs(b.recorded_level_db - shown).max(), 0.5 * 90 / 255 + 0.0626)
            np.testing.assert_array_equal(counts.recorded, b.recorded)
            np.testing.assert_array_equal(single.polar.level_db, b.polar.level_db)
            pixels = b.sequence.cartesian_map
            mapped = np.where(pixels < 0, -99, b.polar.level_db.ravel()[np.maximum(pixels, 0)])
            np.testing.assert_array_equal(b.cartesian.level_db, mapped)

    def test_groups_of_beams_have_their_times_poses_and_levels(self):
        data = self.make(
            "--set", "sonar.transmit={groups: 4, order: [1, 0, 3, 2], interval_s: 0.02, level_error_db: 1}",
            "--set", "sonar.electronics.crosstalk_db=[-20, -30]", "--set", "motion_within_ping=true",
            "--set", "trajectory={poses: [{time_s: 0}, {time_s: 1, position_m: [0.5, 0, 0]}], ping_rate_hz: 5, pings: 3}")
        sonar = data[0].sequence.info["sonar"]
        after_s = [0.02, 0, 0.06, 0.04]
        np.testing.assert_allclose(sonar["transmit"]["after_s"], after_s, atol=1e-12)
        self.assertEqual(sonar["electronics"]["crosstalk_db"], [-20, -30])
        levels = []
        for ping in data:
            times = ping.time_s + np.array(after_s)
            np.testing.assert_allclose([group["time_s"] for group in ping.groups], times, atol=1e-12)
            np.testing.assert_allclose([group["position_m"][0] for group in ping.groups], 0.5 * times, atol=1e-9)
            levels += [group["level_db"] for group in ping.groups]
        self.assertEqual(len(set(levels)), 12)
        self.assertEqual(self.make()[0].groups, [])

    def test_dropped_frames_leave_gaps(self):
        data = self.make("--set", "sonar.recorder.dropped=0.6", "--set", "trajectory.pings=12")
        periods = np.diff([ping.time_s for ping in data]) * 5
        np.testing.assert_allclose(periods, np.round(periods), atol=1e-9)
        self.assertEqual((len(data), periods.min() > 0.5, periods.max() > 1.5), (12, True, True))


if __name__ == "__main__":
    unittest.main()
