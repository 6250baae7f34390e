"""speckle_seed: what differs between two values, and what does not, for every `scattering.speckle`.

ENSONIFY is the program.
"""
import unittest

import numpy as np

from program import fresh, run, scratch
from ensonify_dataset import SonarDataset
from ensonify_dataset.views import PLANES

# Everything that is random: worlds, places, textures, terrain, wave motion, volumes, bounces, noise.
SCENE = """ensonify: 1
name: moving
seed: 7
sequences: 2
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 4
  mount: {rotation_deg: [0, 20, 0]}
  beams: {count: 24, fov_deg: 40}
  rays: {elevation: 12}
materials:
  m: {reflectivity: {log_uniform: [1e-3, 1e-2]}, texture: {model: gamma, shape: 2, correlation_m: 0.2}}
bounces: 1
objects:
  - name: bed
    material: m
    shape: {heightfield: {size_m: [8, 8], cell_m: 0.1, roughness: {rms_m: 0.02, exponent: 3.3, outer_scale_m: 1}}}
    pose: {position_m: [2, 0, -1]}
  - {name: ball, count: 2, material: m, shape: {sphere: {radius_m: 0.3}}, place: {on: bed, area_m: [[1.5, -1], [3, 1]]}}
point_targets: [{name: p, target_strength_db: -40, position_m: [1, 0.3, 0]}]
volumes: [{name: silt, uniform: {strength_db: -40}}]
trajectory:
  pings: 2
  ping_rate_hz: 5
  poses: [{time_s: 0, position_m: [0, 0, 0]}, {time_s: 1, position_m: [0.5, 0.2, 0]}]
  wave_motion: {roll_deg: 1, pitch_deg: 1, yaw_deg: 1, heave_m: 0.02, period_s: 6}
noise: {spectrum_level_db: 50}
output: {layers: {targets: [ball]}, surfaces: true, motion: true, front: true, cartesian: {height_px: 60}}
"""
MODES = ("per_ping", "per_ray", "surface")
# The only stored values that a level enters, apart from pixels.
OF_LEVELS = {"level_db", "grey"}


def same(one, other):
    """Equal to the last bit, NaN included."""
    return one.tobytes() == other.tobytes()


def without_levels(info):
    return {key: value for key, value in info.items()
            if key not in ("speckle_seed", "files", "bytes", "png", "sha256")}


class SpeckleSeed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sets = {(mode, seed): SonarDataset(fresh(
            SCENE, "--set", f"scattering.speckle={mode}", *(["--speckle-seed", str(seed)] if seed else [])))
            for mode, seed in (("per_ping", None), *((mode, seed) for mode in MODES for seed in (1, 2)))}

    def pairs(self):
        for mode, one, other in (("per_ping", None, 1), *((mode, 1, 2) for mode in MODES)):
            yield mode, self.sets[mode, one], self.sets[mode, other]

    def test_only_what_follows_from_amplitudes_differs(self):
        for mode, first, second in self.pairs():
            self.assertEqual(len(first), 4)
            for one, other in zip(first, second, strict=True):
                with self.subTest(mode=mode, sequence=one.sequence.number, ping=one.number):
                    self.same_ping(one, other)
            folders = [data.folder for data in (first, second)]
            for name in ("objects.csv", "pings.csv", "poses.csv"):
                for path in folders[0].glob(f"sequences/*/{name}"):
                    self.assertEqual(path.read_bytes(), (folders[1] / path.relative_to(folders[0])).read_bytes())

    def same_ping(self, one, other):
        self.assertEqual(without_levels(one.sequence.info), without_levels(other.sequence.info))
        self.assertTrue(same(one.pose.position_m, other.pose.position_m))
        for name in PLANES:
            if not one.polar.has(name):
                continue
            equal = same(getattr(one.polar, name), getattr(other.polar, name))
            self.assertEqual(equal, name not in OF_LEVELS, name)
        self.assertTrue(same(one.front.range_m, other.front.range_m))
        for view in ("polar", "cartesian"):
            found, expected = getattr(one, view).annotations, getattr(other, view).annotations
            self.assertEqual([(a.name, a.bbox, a.area, a.occlusion, a.truncated, a.contrast_db) for a in found],
                             [(a.name, a.bbox, a.area, a.occlusion, a.truncated, a.contrast_db) for a in expected])
            for a, b in zip(found, expected):
                self.assertTrue(same(a.mask, b.mask))
        self.assertTrue(same(one.layer("noise"), other.layer("noise")))
        for name in ("volume", "target", "background"):
            apart = np.abs(one.layer(name) - other.layer(name)).sum()
            self.assertGreater(apart, 0.5 * np.abs(one.layer(name)).sum(), name)

    def normalized(self, data):
        """Of each pixel with an echo of a surface: its intensity over its expectation, less 1."""
        parts = []
        for ping in data:
            clean = 10 ** (ping.polar.clean_db.T / 10 - 12)
            echo = sum(ping.layer(name) for name in ("volume", "target", "background"))
            shows = ping.polar.clean_db.T > ping.polar.clean_db.max() - 40
            parts.append((np.abs(echo) ** 2 / clean)[shows] - 1)
        return np.concatenate(parts)

    def test_intensities_over_their_expectation_do_not_correlate(self):
        for mode, first, second in self.pairs():
            with self.subTest(mode=mode):
                a, b = self.normalized(first), self.normalized(second)
                self.assertGreater(len(a), 1500)
                # Neighbors correlate in I by about 0.4 over bins and 0.5 over beams; per_ray repeats each ping. The
                # sum over lags of its square is below 2.3, and below 4.6 there.
                error = np.sqrt(4.6 / len(a))
                self.assertLess(abs(np.mean(a * b)) / np.sqrt(np.mean(a * a) * np.mean(b * b)), 4 * error)
                self.assertLess(abs(np.mean(a)), 0.3)
                self.assertGreater(np.mean(a * a), 0.5)

    def test_no_other_seed_has_the_same_amplitudes(self):
        """Of a scene that samples nothing: `seed: 2` and `seed: 1` with `speckle_seed: 2`."""
        text = """ensonify: 1
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 3, beams: {count: 24, fov_deg: 24}, rays: {elevation: 8}}
materials: {m: {reflectivity: 1e-3}}
objects: [{name: room, material: m, shape: {box: {size_m: [5, 5, 2], inward_facing: true}}}]
trajectory: {pings: 1}
output: {cartesian: false, png: false}
"""
        series = [SonarDataset(fresh(text, *options))[0].series for options in
                  (["--seed", "1"], ["--seed", "2"], ["--seed", "1", "--speckle-seed", "2"],
                   ["--seed", "2", "--speckle-seed", "1"], ["--seed", "1", "--speckle-seed", "1"])]
        for i, one in enumerate(series):
            for other in series[:i]:
                shared = abs(np.vdot(one, other)) / np.linalg.norm(one) / np.linalg.norm(other)
                self.assertLess(shared, 0.4)  # 0.1 by chance, as the strongest 100 cells hold most of the energy

    def test_the_manifest_has_it_and_a_distribution_is_refused(self):
        self.assertEqual(self.sets["per_ping", 1][0].sequence.info["speckle_seed"], 1)
        self.assertNotIn("speckle_seed", self.sets["per_ping", None][0].sequence.info)
        folder = scratch(SCENE + "speckle_seed: {uniform: [1, 5]}\n")
        refused = run("check", folder / "scenario.yaml")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("speckle_seed: cannot be sampled", refused.stderr)


if __name__ == "__main__":
    unittest.main()
