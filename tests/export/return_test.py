"""Every export that `import` accepts comes back equal: axes, times, poses, and levels within one step.

The formats are those of the program, so that a new one is tested without a line here.
"""
import re
import unittest

import numpy as np

import exported
from ensonify_dataset import SonarDataset

# A fan that an ARIS has; amplitudes as an instrument stores them, so that every format can have counts.
SCENARIO = """ensonify: 1
name: returned
seed: 5
sonar: {preset: aris_3000_hf, range_max_m: 4, bandwidth_hz: 2e4, rays: {elevation: 24}}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [6, 6, 2], inward_facing: true}}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [2, 0.1, 0]}}
trajectory:
  poses: [{time_s: 0, position_m: [0, 0, 0]}, {time_s: 1, position_m: [0.1, 0.2, 0]}]
  ping_rate_hz: 2
output: {cartesian: {height_px: 60}}
"""

# Some formats need equally spaced beams, which an ARIS does not have. What comes back at least of each kind; others are
# refused with a message.
EQUAL = ("--set", "sonar={preset: paper_table1, bandwidth_hz: 2e4, range_max_m: 4, beams: {count: 64}, rays: {elevation: 24}}")
ACCEPTED = {(): {"aris", "mcap", "oculus"}, EQUAL: {"mcap", "oculus"}}

# Made for the sampling of another reader, with rows and a column that are no part of the data set (docs/export.md).
ADAPTED = {"neusis"}


def formats():
    said = exported.run("export", "--help").stdout
    listed = re.search(r"--format TEXT:\{([^}]*)\}", said)
    assert listed, said
    return listed.group(1).split(",")


def candidates(out):
    """The files and folders of an export that may be logs."""
    if out.is_file():
        return [out]
    return [out, *sorted(p for p in out.rglob("*") if p.is_dir() or p.suffix in (".aris", ".oculus", ".mcap", ".pkl"))]


class Return(unittest.TestCase):
    def compare(self, name, log, made, options=()):
        """Whether the log was accepted; if so, it is equal."""
        back = exported.scratch() / "back"
        result = exported.run("import", log, "-o", back, "--height-px", "60", "--quiet", *options)
        if result.returncode != 0:
            self.assertEqual(result.returncode, 2, (name, result.stderr))
            self.assertIn("expected", result.stderr.replace("; use", "expected").replace("neither", "expected"), name)
            return False
        with self.subTest(format=name, log=log.name, options=options):
            one, two = made.sequence(0), SonarDataset(back).sequence(0)
            self.assertEqual(len(one), len(two))
            np.testing.assert_allclose(two.azimuth_rad, one.azimuth_rad, atol=2e-4)
            np.testing.assert_allclose(two.range_m, one.range_m, atol=1e-3 * (one.range_m[1] - one.range_m[0]) + 1e-6)
            recorder = two.info["recorder"]
            for a, b in zip(one, two):
                self.assertAlmostEqual(a.time_s, b.time_s, places=5)
                self.check_levels(np.asarray(a.polar.level_db, float), np.asarray(b.polar.level_db, float), recorder)
        return True

    def check_levels(self, level, again, recorder):
        """Levels of counts between the limits, apart from the reference of a log with relative levels."""
        low, high = recorder["db"]
        most = 2 ** recorder["bits"] - 1
        count = (again - low) / (high - low) * most
        if recorder["scale"] != "db":
            count = most * 10 ** (recorder["gamma"] * (again - high) / 20)
        inside = (level > -90) & (again > -98) & (count > 30) & (count < most - 0.5)
        self.assertGreater(np.mean(inside), 0.05)
        step_db = (high - low) / most if recorder["scale"] == "db" else 20 / recorder["gamma"] * np.log10(31 / 30)
        apart = (again - level)[inside]
        reference = 0 if recorder["scale"] == "db" and high - low != 80 else np.median(apart)
        # And the steps of half precision, twice.
        self.assertLess(np.abs(apart - reference).max(), step_db + 0.13)

    def test_every_export_that_import_accepts(self):
        self.assertGreater(len(formats()), 12)
        for options, expected in ACCEPTED.items():
            source = exported.made(SCENARIO, *options)
            made, accepted = SonarDataset(source), set()
            for name in sorted(set(formats()) - ADAPTED):
                out = exported.scratch() / "out"
                result = exported.run("export", source, "--format", name, "-o", out, "--quiet")
                if result.returncode != 0:
                    self.assertEqual(result.returncode, 2, result.stderr)
                elif any([self.compare(name, log, made) for log in candidates(out)]):
                    accepted.add(name)
            self.assertLessEqual(expected, accepted)

    def test_levels_in_floats(self):
        source = exported.made(SCENARIO)
        out = exported.scratch() / "out"
        exported.run("export", source, "--format", "mcap", "-o", out, "--quiet", check=True)
        log = out / "000000.mcap"
        self.assertTrue(self.compare("mcap", log, SonarDataset(source), ("--topic", "/sonar/levels")))

    def test_other_displays_of_an_mcap(self):
        """With a gain, the levels are those before it; where no line of levels leads to the counts, none is made up."""
        gained = exported.made(SCENARIO, "--set", "output.png={gain_db: -6, db: [60, 120]}")
        out = exported.scratch() / "out"
        exported.run("export", gained, "--format", "mcap", "-o", out, "--quiet", check=True)
        self.assertTrue(self.compare("mcap", out / "000000.mcap", SonarDataset(gained)))
        automatic = exported.made(SCENARIO, "--set", "output.png={automatic_gain: true}")
        out = exported.scratch() / "out"
        exported.run("export", automatic, "--format", "mcap", "-o", out, "--quiet", check=True)
        said = exported.run("import", out / "000000.mcap", "-o", out / "back")
        self.assertEqual(said.returncode, 2)
        self.assertIn("not between which levels; expected --db LOW:HIGH, or the --topic of levels", said.stderr)


if __name__ == "__main__":
    unittest.main()
