"""Presets against the recordings that they come from, by the rule of plain_patches.py: a bed alone, five seeds, the
recording's beams, samples and ranges. All numbers are printed, and must be within TOLERANCES."""
import unittest

import numpy as np

import plain_patches as rule
from provenance_test import ROWS, TOLERANCES, Folder, SonarDataset, describe, run

SCENE = """ensonify: 1
name: law
water: {{sound_speed_m_s: {speed}}}
sonar: {{preset: {preset}, range_min_m: {near_m}, range_max_m: {far_m}{more}}}
materials: {{sand: {{reflectivity: 3e-3}}}}
objects:
  - {{name: bed, class: bed, material: sand, shape: {{plane: {{}}}}, pose: {{position_m: [0, 0, -{height}]}}}}
trajectory:
  poses: [{{time_s: 0, rotation_deg: [0, 22, 0]}}, {{time_s: 1, position_m: [1, 0, 0], rotation_deg: [0, 22, 0]}}]
  ping_rate_hz: 1
output: {{cartesian: false, png: false, timeseries: none, shadow: false, amodal: false}}
"""
FAR = ", detector: {looks: 1, noise_db: 4.1, integrate: 1.2, floor_db: 84}"
# Preset, nearest and farthest range, sound speed, height over the bed, further keys, and the recording's row.
PRESETS = (
    ("aris_3000_hf", 0.96, 2.36, 1477, 0.7, "", "tank near"),
    ("aris_3000_hf", 0.82, 3.39, 1477, 1, FAR, "tank far"),
    ("aris_1200_48", 3.2976, 23.3906, 1435.93, 4, "", "ARIS 1200"),
    ("oculus_m1200d_hf", 0.1, 2, 1490.66, 0.6, ", beams: {count: 256}", "Oculus"),
)
SEEDS = 5


class Presets(Folder):
    def test_presets_have_the_law_of_their_recordings(self):
        missed = []
        for preset, near_m, far_m, speed, height, more, row in PRESETS:
            expected, _ = ROWS[row]
            for seed in range(1, SEEDS + 1):
                scene = self.folder / "scene.yaml"
                scene.write_text(SCENE.format(preset=preset, near_m=near_m, far_m=far_m, speed=speed, height=height,
                                              more=more))
                data = self.folder / f"{row}_{seed}".replace(" ", "_")
                run("generate", scene, "-o", data, "--seed", seed, "--quiet")
                pings = SonarDataset(data)
                count, found = rule.medians([np.asarray(pings[k].polar.level_db, float) for k in range(len(pings))])
                off = [name for name in rule.NAMES if abs(found[name] - expected[name]) > TOLERANCES[name]]
                print(describe(f"{preset} for {row}, seed {seed}", count, found), "; off: ", ", ".join(off) or "none")
                missed += [(row, seed, name, found[name]) for name in off]
        self.assertEqual(missed, [])


if __name__ == "__main__":
    unittest.main()
