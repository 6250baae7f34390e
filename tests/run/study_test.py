"""The example of a speckle study, over a thousand seeds.

ENSONIFY is the program, SWEEPS the folder of sweeps. Run by ctest in --rest; by hand:
    ENSONIFY=build/release/ensonify SWEEPS=configs/sweeps PYTHONPATH=scripts:tests/cli python3 -m unittest study_test
"""
import csv
import os
import pathlib
import unittest

import program
from program import run
from ensonify_dataset import SonarDataset, merge

SWEEPS = pathlib.Path(os.environ.get("SWEEPS", "configs/sweeps"))


class Study(program.Case):
    def test_the_study_over_a_thousand_seeds(self):
        """Protects the example: fully developed speckle, within 0.01 and within its stated errors."""
        study = self.folder / "study"
        for words in ([], ["--finalize"]):
            done = run("sweep", SWEEPS / "speckle_study.yaml", "-o", study, "--quiet", *words)
            self.assertEqual(done.returncode, 0, done.stderr)
        with open(study / "runs.csv", newline="", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual(sum(int(row["pings"]) for row in rows), 1000)
        away = [(float(row["contrast"]) - 1) / float(row["contrast_se"]) for row in rows]
        # Ten normal numbers: each within 4, and the sum of squares below the 1 - 1e-4 quantile of chi^2 (10).
        self.assertLess(max(map(abs, away)), 4, away)
        self.assertLess(sum(x * x for x in away), 35.6, away)
        draws = merge([SonarDataset(study / row["folder"]).sequence(0).statistics for row in rows])
        wall = draws.mean_intensity > 0.01 * draws.mean_intensity.max()
        contrast, error = draws.mean_contrast(wall)
        self.assertEqual(draws.realisations, 1000)
        self.assertLess(error, 0.002)
        self.assertLess(abs(contrast - 1), 0.01)
        self.assertLess(abs(contrast - 1), 4 * error)


if __name__ == "__main__":
    unittest.main()
