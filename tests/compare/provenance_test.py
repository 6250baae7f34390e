"""The rule for plain patches and the comb: laws in closed form, recordings, and the same numbers from `ensonify compare`.

Recordings are in the folder ENSONIFY_REAL_DATA; without it their tests skip. ROWS holds what they have."""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

import plain_patches as rule

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from ensonify_dataset import SonarDataset  # noqa: E402

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
REAL = os.environ.get("ENSONIFY_REAL_DATA")
# How far a simulation may be from the recording of its sonar.
TOLERANCES = {"std": 0.3, "skew": 0.15, "beams": 0.06, "samples": 0.06}
# Recording: medians over its plain patches, and the period of its comb in beams.
ROWS = {
    "tank near": ({"std": 4.69, "skew": -0.20, "beams": 0.23, "samples": 0.50}, 8),
    "tank far": ({"std": 5.55, "skew": -0.17, "beams": 0.27, "samples": 0.34}, 8),
    "ARIS 1200": ({"std": 4.02, "skew": -0.40, "beams": 0.04, "samples": 0.17}, 3),
    "Oculus": ({"std": 5.75, "skew": -1.13, "beams": 0.60, "samples": 0.08}, 8),
}
# The comb of the tanks: share of frames that show it, and range of the level by beam modulo 8 in dB.
COMB = {"tank near": (0.03, 0.77), "tank far": (0.16, 0.57)}
LOGS = {"ARIS 1200": "recordings/aris1200_telephoto.aris", "Oculus": "recordings/three_pings_8bit.raw"}
# `compare` counts medians in tables of 800 steps, of which this is half a one.
ROUNDING = {"std": 0.01, "skew": 0.005, "beams": 0.00125, "samples": 0.00125}
# A test on a part of the frames of a tank: four standard errors of a median over 1000 patches.
FEWER = {"std": 0.15, "skew": 0.06, "beams": 0.03, "samples": 0.04}


def run(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, (arguments, done.stderr)


def tank_frames(which, step):
    """Levels in dB of frames of the tank set, whose gray levels are 0 to 80 dB."""
    paths = sorted(pathlib.Path(REAL, "watertank", which, "frames").glob("*.png"))[::step]
    return [np.asarray(Image.open(path), float) * 80 / 255 for path in paths]


def describe(name, count, found):
    return f"{name}: {count} patches, " + ", ".join(f"{key} {value:.3f}" for key, value in found.items())


def gamma_law(looks):
    """Standard deviation in dB and skewness of the level of the mean of so many exponential powers: with psi of the
    first and second derivative, 10/ln 10 sqrt(psi_1) and psi_2 / psi_1^1.5."""
    first = math.pi ** 2 / 6 - sum(1 / k ** 2 for k in range(1, looks))
    second = -2 * 1.2020569031595942 + 2 * sum(1 / k ** 3 for k in range(1, looks))
    return 10 / math.log(10) * math.sqrt(first), second / first ** 1.5


class Folder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="ensonify-rule-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)

    def compared(self, data, period):
        """Values of `compare` of a data set with itself, which measures all its pixels."""
        numbers = self.folder / "numbers.json"
        run("compare", data, data, "--json", numbers, "--quiet", "--comb", period, "--pings", 1000)
        values = {s["id"]: s["real"].get("value") for s in json.loads(numbers.read_text())["statistics"]}
        return dict(zip(rule.NAMES, (values[k] for k in ("plain_spread", "plain_skewness", "plain_beams", "plain_samples")))), \
            (values["comb_share"], values["comb_level"])


class Laws(Folder):
    LOW, HIGH = -60, 60  # dB of counts of 16 bits

    def frames(self, looks, count, shape=(256, 96)):
        """Counts and their levels. Levels rise by 20 dB over the samples: that, and not chance, decides which patches are
        bright enough. Among patches of one mean level the rule takes those with few nulls, whose spread is 0.1 dB smaller."""
        draw = np.random.default_rng(looks)
        power = draw.standard_exponential((looks, count, *shape)).mean(0)
        levels = 10 * np.log10(power) + np.linspace(0, 20, shape[0])[:, None]
        counts = np.round((levels - self.LOW) / (self.HIGH - self.LOW) * 65535).clip(0, 65535).astype(np.uint16)
        return counts, self.levels_of(counts)

    def levels_of(self, counts):
        return [self.LOW + image / 65535 * (self.HIGH - self.LOW) for image in counts]

    def test_gamma_laws_of_looks(self):
        # A patch of 768 pixels of one look has errors of 0.19 dB and 0.13; half of its pixels are those of the next one.
        # The errors of the medians are a twelfth of that. Fitting a plane takes 0.2 % of the spread.
        for looks in (1, 2, 3):
            count, found = rule.medians(self.frames(looks, 6)[1])
            print(describe(f"{looks} looks", count, found))
            self.assertGreater(count, 200)
            std, skew = gamma_law(looks)
            self.assertLess(abs(found["std"] - std), 0.05)
            self.assertLess(abs(found["skew"] - skew), 0.06)
            self.assertLess(max(abs(found["beams"]), abs(found["samples"])), 0.02)

    def test_compare_has_the_same_numbers(self):
        # Copies of one frame: every block has its medians, so that the mean of the jackknife's pseudo-values is theirs.
        counts, _ = self.frames(1, 1)
        counts[:, :, 2::8] += round(6 / (self.HIGH - self.LOW) * 65535)
        levels = self.levels_of(counts)
        images = self.folder / "images"
        images.mkdir()
        for i in range(3):
            np.save(images / f"{i}.npy", counts[0])
        (images / "recording.yaml").write_text(
            'files: "*.npy"\nfan_deg: 60\ncolumns: starboard_first\nrange_m: [1, 9]\nping_rate_hz: 5\n'
            f"frequency_hz: 900e3\nscale: {{db: [{self.LOW}, {self.HIGH}]}}\n")
        run("import", images, "-o", self.folder / "data", "--quiet", "--height-px", 50)
        count, expected = rule.medians(levels)
        found, (share, level) = self.compared(self.folder / "data", 8)
        self.assertGreater(count, 10)
        for name in rule.NAMES:
            self.assertLess(abs(found[name] - expected[name]), 1.01 * ROUNDING[name], (name, found, expected))
        expected_share, expected_level = rule.comb(levels, 8)
        self.assertEqual((share, expected_share), (100, 1))
        self.assertGreater(level, 5)
        self.assertAlmostEqual(level, expected_level, delta=1e-4)


@unittest.skipUnless(REAL, "ENSONIFY_REAL_DATA is not set")
class Recordings(Folder):
    def test_tank(self):
        for which, step in (("near", 3), ("far", 4)):
            all_frames = tank_frames(which, step)
            share, level = rule.comb(all_frames, 8)
            print(f"tank {which}, {len(all_frames)} frames: comb in {100 * share:.1f} %, {level:.3f} dB")
            self.assertLess(abs(share - COMB[f"tank {which}"][0]), 0.006)  # COMB is rounded
            self.assertLess(abs(level - COMB[f"tank {which}"][1]), 0.006)
            frames = all_frames[::3]
            count, found = rule.medians(frames)
            print(describe(f"tank {which}, {len(frames)} frames", count, found))
            for name, expected in ROWS[f"tank {which}"][0].items():
                self.assertLess(abs(found[name] - expected), FEWER[name], (which, name))

    def test_logs_and_compare(self):
        for name, log in LOGS.items():
            data = self.folder / name.replace(" ", "_")
            run("import", pathlib.Path(REAL, log), "-o", data, "--quiet", "--height-px", 50)
            expected, period = ROWS[name]
            pings = SonarDataset(data)
            frames = [np.asarray(pings[k].polar.level_db, float) for k in range(len(pings))]
            count, found = rule.medians(frames)
            print(describe(name, count, found))
            of_compare, (share, level) = self.compared(data, period)
            for key in rule.NAMES:
                self.assertLess(abs(found[key] - expected[key]), 0.006, (name, key))  # ROWS are rounded
                self.assertLess(abs(of_compare[key] - found[key]), ROUNDING[key] + 0.002, (name, key, of_compare, found))
            by_rule = rule.comb(frames, period)
            self.assertAlmostEqual(share, 100 * by_rule[0], delta=0.01)


if __name__ == "__main__":
    unittest.main()
