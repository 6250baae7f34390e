"""Rigs: several sonars in one world. Their clocks, their folders, what is refused, and that all of them hear the same
scatterers: coherence, and a point target where the mounts say.

ENSONIFY is the program.
"""
import json
import re

import numpy as np
from program import Case, hashes, run

SONAR = """{frequency_hz: 500e3, bandwidth_hz: 10e3, source_level_db: 200, range_min_m: 1, range_max_m: 6,
    beams: {count: 24, fov_deg: 48, receive_width_deg: 1.5}, elevation: {width_deg: 20}, rays: {elevation: 8}"""
PAIR = f"""ensonify: 1
name: pair
seed: 4
sequences: 2
rig:
  - {{name: left, sonar: {SONAR}, mount: {{position_m: [0, 0.4, 0]}}}}}}
  - {{name: right, sonar: {SONAR}, mount: {{position_m: [0, -0.4, 0.1], rotation_deg: [0, 5, 10]}}}},
     ping_rate_hz: 10, time_offset_s: 0.05}}
scattering: {{speckle: surface}}
materials: {{m: {{reflectivity: 1e-3}}}}
objects:
  - {{name: room, class: room, material: m, shape: {{box: {{size_m: [9, 9, 3], inward_facing: true}}}}}}
  - {{name: ball, class: ball, material: m, shape: {{sphere: {{radius_m: 0.3}}}},
     pose: {{position_m: [{{uniform: [2, 3]}}, 0, 0]}}}}
point_targets: [{{name: tip, target_strength_db: 10, position_m: [4, 0.7, 0.1]}}]
trajectory: {{ping_rate_hz: 5, pings: 4}}
noise: {{spectrum_level_db: 20}}
output: {{cartesian: false, png: false}}
"""


def series(folder, sequence=0, ping=0):
    return np.load(folder / f"sequences/{sequence:06d}/timeseries/{ping:06d}.npy")


def times(folder):
    lines = (folder / "index.csv").read_text().splitlines()[1:]
    return [float(line.split(",")[2]) for line in lines]


def scene_files(folder):
    """All but what names the run."""
    return {name: value for name, value in hashes(folder).items() if name not in ("provenance.json", "work.json",
                                                                                    "dataset.json", "dataset.sha256")}


class RigCase(Case):
    def make(self, text, *options, name="rig"):
        self.scenario.write_text(text)
        out = self.folder / name
        done = run("generate", self.scenario, "-o", out, "--quiet", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(run("verify", out).returncode, 0)
        return out


class Rig(RigCase):
    def test_instruments_have_clocks_and_data_sets_of_their_own(self):
        out = self.make(PAIR)
        self.assertEqual(sorted(path.name for path in out.iterdir()), ["left", "rig.json", "right"])
        np.testing.assert_allclose(times(out / "left"), 2 * [0, 0.2, 0.4, 0.6])
        np.testing.assert_allclose(times(out / "right"), 2 * [0.05 + 0.1 * k for k in range(8)])
        rig = json.loads((out / "rig.json").read_text())["instruments"]
        self.assertEqual([entry["name"] for entry in rig], ["left", "right"])
        self.assertEqual([entry["mount"]["position_m"] for entry in rig], [[0, 0.4, 0], [0, -0.4, 0.1]])
        self.assertEqual([(entry["ping_rate_hz"], entry["time_offset_s"]) for entry in rig], [(5, 0), (10, 0.05)])
        for name in ("left", "right"):
            # Alone, and from its own resolved text.
            alone = self.make(PAIR, "--set", f"instrument={name}", name=f"{name} alone")
            again = self.make((out / name / "scenario.yaml").read_text(), name=f"{name} again")
            self.assertEqual(scene_files(alone), scene_files(out / name))
            self.assertEqual(scene_files(again), scene_files(out / name))
        damaged = out / "right/sequences/000001/sequence.json"
        damaged.write_text(damaged.read_text() + " ")
        self.assertIn("right/sequences/000001/sequence.json", run("verify", out).stderr)

    def test_ranges_count_by_time(self):
        out = self.make(PAIR, "--pings", "1:3", "--sequences", "1:2")
        np.testing.assert_allclose(times(out / "left"), [0.2, 0.4])
        np.testing.assert_allclose(times(out / "right"), [0.25, 0.35, 0.45, 0.55])
        whole = self.make(PAIR, name="whole")
        np.testing.assert_array_equal(series(out / "right", 1, 3), series(whole / "right", 1, 3))

    def test_other_commands_say_which_folder_to_give(self):
        out = self.make(PAIR, "--sequences", "0:1")
        done = run("export", out, "-o", self.folder / "x", "--format", "tum")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn(f"{out}/left, {out}/right", done.stderr)
        done = run("preview", self.scenario, "-o", self.folder / "page.html")
        self.assertIn("instrument: missing", done.stderr)

    def test_bad_rigs_are_refused_before_anything_is_written(self):
        inside = ("objects:\n", "objects:\n  - {name: hull, class: hull, material: m, shape: {sphere: {radius_m: 0.2}}, "
                  "pose: {position_m: [0, -0.4, 0]}}\n")
        for old, new, error in ((": right", ": Left", "rig.1.name: .*another instrument has the folder"),
                                (": right", ": sequences", "rig.1.name: .*is a folder of data sets"),
                                (": right", ": a/b", "rig.1.name: .*is not the name of a folder"),
                                ("0.05}", "0.8}", "rig.1.time_offset_s: right has no ping"),
                                ("rays: {elevation: 8}, mount: {position_m: [0, -0.4",
                                 "rayz: {elevation: 8}, mount: {position_m: [0, -0.4", r"rig.1.sonar.rayz: unknown"),
                                ("scattering:", f"sonar: {SONAR}}}\nscattering:", "rig: cannot be combined with sonar"),
                                ("scattering:", "instrument: middle\nscattering:", "instrument: `middle` names no"),
                                (*inside, "rig.1.sonar.mount: .*inside hull"),
                                ("{position_m: [0, 0.4", "{position_m: [0, 0.4, 9], position: [0, 0.4", "rig.0.sonar.mount")):
            self.assertIn(old, PAIR)
            self.scenario.write_text(PAIR.replace(old, new))
            out = self.folder / "refused"
            done = run("generate", self.scenario, "-o", out)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertRegex(done.stderr, "(?m)^" + re.escape(str(self.scenario)) + r":\d+:\d+: " + error)
            self.assertFalse(out.exists(), error)
        done = run("generate", self.scenario, "-o", self.folder)
        self.assertEqual(done.returncode, 2)
        self.scenario.write_text(PAIR)
        done = run("check", self.scenario, "--set", "rig.right.ping_rate_hz=0")
        self.assertTrue(done.stderr.startswith("--set rig.right.ping_rate_hz: rig.1.ping_rate_hz: `0` is"), done.stderr)

    def test_a_folder_of_something_else_is_left_alone(self):
        out = self.make(PAIR, "--sequences", "0:1")
        before = hashes(out)
        self.scenario.write_text(PAIR.replace("name: right", "name: other"))
        for options in ([], ["--overwrite"]):
            done = run("generate", self.scenario, "-o", out, *options)
            self.assertEqual(done.returncode, 2)
            self.assertIn("rig of other instruments (left, right)", done.stderr)
        self.assertEqual(hashes(out), before)
        self.scenario.write_text(PAIR.replace("seed: 4", "seed: 5"))
        self.assertIn("it differs in", run("generate", self.scenario, "-o", out).stderr)
        self.assertEqual(hashes(out), before)
        self.make(PAIR.replace("seed: 4", "seed: 5"), "--overwrite", "--sequences", "0:1")
        self.assertNotEqual(hashes(out), before)

    def test_a_point_target_is_where_the_mounts_say(self):
        quiet = PAIR.replace("m: {reflectivity: 1e-3}", "m: {reflectivity: 1e-9}").replace("20}\noutput", "-100}\noutput")
        out = self.make(quiet, "--sequences", "0:1", "--pings", "0:1")
        yaw, pitch = np.radians([10, 5])
        turn = (np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
                @ np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]]))
        for name, at, rotation in (("left", [0, 0.4, 0], np.eye(3)), ("right", [0, -0.4, 0.1], turn)):
            seen = rotation.T @ (np.array([4, 0.7, 0.1]) - at)
            level = 20 * np.log10(np.abs(series(out / name)) + 1e-12)
            beam, sample = np.unravel_index(np.argmax(level), level.shape)
            wanted_beam = (np.degrees(np.arctan2(seen[1], seen[0])) + 24) / 2 - 0.5
            wanted_sample = np.linalg.norm(seen) / (1500 / 2 / 10e3)
            self.assertLess(abs(peak(level[beam], sample) - wanted_sample), 0.1, name)
            # In an ideal beam cell a target is heard in the direction of its cell.
            self.assertEqual(beam, round(wanted_beam), name)


def peak(levels, at):
    """Of a parabola through three levels."""
    a, b, c = levels[at - 1 : at + 2]
    return at + 0.5 * (a - c) / (a - 2 * b + c)


if __name__ == "__main__":
    import unittest

    unittest.main()
