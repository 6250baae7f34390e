"""The comb of scenes/watertank.yaml by the rule of plain_patches.py, on fewer frames than docs/compare.md reports.

The level by beam modulo 8 of 16 frames has a standard error of 0.03 dB, without levels that change from ping to ping."""
import pathlib
import unittest

import numpy as np
from PIL import Image

import plain_patches as rule
from provenance_test import COMB, Folder, run

SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes" / "watertank.yaml"
ALIKE = ("sonar.transmit={groups: 1}",)
STEADY = ("sonar.transmit.level_error_db=0",)
FIRST_RANGE_M = {"near": 0.9555, "far": 0.8191}
COUNTS_DB = {"near": 159 - 67, "far": 160 - 64}
RANGE_STEP_M = {"near": 1477 / (2 * 282865), "far": 1477 / (2 * 171297)}


class TankComb(Folder):
    def comb(self, which, settings=()):
        data = self.folder / f"{which}_{len(list(self.folder.iterdir()))}"
        words = (f"variables.far={int(which == 'far')}", "variables.display=1", "sonar.beams.fov_deg=29.96", "sequences=4", "trajectory.pings=4",
                 "output.polar=false", "output.shadow=false", "output.amodal=false", *settings)
        run("generate", SCENE, "-o", data, "--quiet", *(word for setting in words for word in ("--set", setting)))
        first = round(FIRST_RANGE_M[which] / RANGE_STEP_M[which])
        paths = sorted(data.glob("sequences/*/recorded/*.png"))
        frames = [np.asarray(Image.open(path), float)[first:] * COUNTS_DB[which] / 255 for path in paths]
        share, level = rule.comb(frames, 8)
        print(f"{which}, {settings}: comb in {100 * share:.0f} % of {len(frames)} frames, {level:.3f} dB")
        return share, level

    def test_groups_make_the_comb(self):
        for which in ("near", "far"):
            share, level = self.comb(which, STEADY)
            self.assertLess(abs(level - COMB[f"tank {which}"][1]), 0.2)
            self.assertEqual(share, 0)

    def test_levels_that_change_show_in_single_frames(self):
        share, _ = self.comb("far", ("sonar.transmit.level_error_db=2",))
        self.assertGreater(share, 0.5)

    def test_without_groups_there_is_none(self):
        share, level = self.comb("far", ALIKE)
        self.assertLess(level, 0.15)
        self.assertEqual(share, 0)


if __name__ == "__main__":
    unittest.main()
