"""`ensonify fit` as a user runs it: what it finds, resuming, and what it refuses."""
import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ENSONIFY = os.environ["ENSONIFY"]
TWIN = Path(__file__).resolve().parents[2] / "scripts" / "twin"
# Simulations without it would have other levels than the recording.
DETECTOR = "  detector: {noise_db: 3, integrate: 1.4, law: logarithm}\n"
WIDTH = "sonar.beams.receive_width_deg"
SOME = ["--pings", "48", "--blocks", "24"]


def run(*arguments):
    return subprocess.run([ENSONIFY, *map(str, arguments)], capture_output=True, text=True)


class Fit(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="ensonify-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        (cls.folder / "twin").mkdir()
        shutil.copy(TWIN / "path.csv", cls.folder / "twin")
        cls.scenario = cls.folder / "twin/scenario.yaml"
        text = (TWIN / "scenario.yaml").read_text()
        cls.scenario.write_text(text.replace("sonar:\n", "sonar:\n" + DETECTOR))
        made = run("generate", cls.scenario, "-o", cls.folder / "real", "--seed", 7, "--quiet", "--set", f"{WIDTH}=0.9")
        assert made.returncode == 0, made.stderr

    def fit(self, name, *more, keys=(f"{WIDTH}=0.6:2:log",), scenario=None, real=None):
        given = [part for key in keys for part in ("--key", key)]
        return run("fit", scenario or self.scenario, real or self.folder / "real", "-o", self.folder / name, *SOME, *given, *more)

    def test_the_hidden_width_is_found_and_the_fit_resumes(self):
        whole = self.fit("whole")
        self.assertEqual(whole.returncode, 0, whole.stderr)
        fit = json.loads((self.folder / "whole/fit.json").read_text())
        key = fit["keys"][0]
        self.assertTrue(key["identified"])
        self.assertAlmostEqual(key["value"], 0.9, delta=0.03)
        self.assertLess(key["interval"][1] - key["interval"][0], 0.1)
        self.assertLess(fit["rms_misfit"], 2)
        self.assertEqual([point["deviance"] for point in key["profile"] if point["value"] == key["value"]], [0])
        card = (self.folder / "whole/card.yaml").read_text()
        self.assertIn("sonar:\n  beams:\n    receive_width_deg: ", card)

        # As if it had been interrupted in one of the last simulations.
        (self.folder / "cut").mkdir()
        lines = (self.folder / "whole/evaluations.jsonl").read_text().splitlines(keepends=True)
        self.assertGreater(len(lines), 12)
        (self.folder / "cut/evaluations.jsonl").write_text("".join(lines[:-5]) + lines[-5][:40])
        cut = self.fit("cut", "--threads", "1")
        self.assertEqual(cut.returncode, 0, cut.stderr)
        for name in ("fit.json", "card.yaml"):
            self.assertEqual((self.folder / "cut" / name).read_text(), (self.folder / "whole" / name).read_text())
        self.assertEqual(cut.stdout, whole.stdout)

        # Other ends with the same middle.
        other = self.fit("whole", keys=(f"{WIDTH}=0.5:2.4:log",))
        self.assertEqual(other.returncode, 2)
        self.assertIn("another fit", other.stderr)

    def test_what_cannot_be_fitted_is_refused(self):
        (self.folder / "full").mkdir()
        (self.folder / "full/notes.txt").write_text("mine")
        for arguments, words in [
            (dict(keys=("sonar.beams.width=1:2",)), "sonar.beams.width"),
            (dict(keys=(f"{WIDTH}=2:1",)), "expected PATH=LOW:HIGH"),
            (dict(keys=(f"{WIDTH}=1:2", f"{WIDTH}=1:3")), "given twice"),
            (dict(keys=("noise.spectrum_level_db=30:400",)), "noise.spectrum_level_db"),
            (dict(real=TWIN), "is not a data set"),
            (dict(keys=("sonar.detector.integrate=0.5:2",)), "sonar.detector.integrate"),
            (dict(scenario=TWIN / "none.yaml"), "none.yaml"),
        ]:
            refused = self.fit("refused", **arguments)
            self.assertEqual(refused.returncode, 2, (arguments, refused.stderr))
            self.assertIn(words, refused.stderr)
        self.assertFalse((self.folder / "refused/fit.json").exists())
        refused = self.fit("full")
        self.assertEqual((refused.returncode, os.listdir(self.folder / "full")), (2, ["notes.txt"]))


if __name__ == "__main__":
    unittest.main()
