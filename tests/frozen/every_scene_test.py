"""Every scene made at its full size, two pings by ping, once for all that is asked of each: its bytes and sums, the
schemas, what `verify` and `check` say, and images in which something is to be seen. Packed ones are of scenes that are
made quickly; `frozen.py PROGRAM --all`, a long test, packs all.

ENSONIFY is the program, SCENES the folder of scenes, SCHEMAS that of schemas. Run by ctest in --rest; by hand:
    ENSONIFY=build/release/ensonify SCENES=scenes SCHEMAS=output_schema python3 -m unittest every_scene_test
"""
import pathlib
import sys
import tempfile
import unittest

import frozen
import numpy as np
import sums

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "run"))
import schema_test  # noqa: E402
from sums import sonar_dataset  # noqa: E402

PROGRAM = schema_test.program.PROGRAM
DEAR = ("bubble_plume", "echo_trains", "fish_school", "rippled_seabed", "stony_seabed", "wreck_survey")
# A fan instead of azimuths that a preset gives for each beam.
REDUCED = ["--set", "sonar.beams.count=24", "--set", "sonar.beams.fov_deg=60", "--set", "sonar.rays.elevation=8"]


class EveryScene(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stored = sums.read()

    def test_every_scene(self):
        scenes = sorted(frozen.SCENES.glob("*.yaml"))
        self.assertGreater(len(scenes), 10)
        for scene in scenes:
            with self.subTest(scene.stem), tempfile.TemporaryDirectory(prefix="ensonify-frozen-") as folder:
                modes = ["by ping"] + ["packed"] * (scene.stem not in DEAR)
                made = {mode: frozen.made(PROGRAM, scene, mode, pathlib.Path(folder)) for mode in modes}
                by_ping = made["by ping"]
                self.check_bytes(scene, made)
                for out in made.values():
                    self.assertEqual(schema_test.faults(out), [])
                if list(by_ping.glob("sequences/*/png")):  # a study of speckle keeps none
                    self.check_display(by_ping / "sequences/000000")
                checked = schema_test.run("check", scene, *REDUCED)
                self.assertEqual(checked.returncode, 0, checked.stderr)

    def check_bytes(self, scene, made):
        found = {f"{scene.stem}, {mode}": frozen.one_hash(frozen.digests(out)) for mode, out in made.items()}
        key, by_ping = (scene.stem, "0:2"), made["by ping"]
        arrays = {key: sums.sums_of(by_ping, self.stored[key])}
        lines, differ = frozen.compare(frozen.class_of(by_ping), found, arrays, self.stored)
        print(f"{scene.stem}: {'; '.join(lines)}")
        self.assertEqual(differ, 0, "\n".join(lines))

    def check_display(self, sequence):
        """Default limits show what is in a scene: neither a bright wall nor noise makes its first image black or white."""
        grey = sonar_dataset.read_png(sequence / "png/000000_polar.png")
        seen = sonar_dataset.read_png(sequence / "png/000000_cartesian.png")
        level, labels = sonar_dataset.read_exr(sequence / "polar/000000.exr")
        noise = sonar_dataset.read_json(sequence / "sequence.json")["noise"]
        noise_db = 10 * np.log10(noise["power_pa2"]) + 120 if noise else -99
        channels = labels.channels
        heard = ~np.isnan(channels["elevation_rad"]) & (channels["clean_db"] >= noise_db) & (level.channels["Y"] > -99)
        self.assertGreaterEqual(np.median(grey[heard]), 64)
        self.assertGreater(np.mean(grey == 255), 0)
        self.assertLess(np.mean(grey == 255), 0.01)
        in_fan = seen[sonar_dataset.read_npy(sequence / "cartesian_map.npy") >= 0]
        self.assertLess(np.mean(in_fan == 255), 0.01)
        # Of an empty tank, too, 1 % of the image is bright.
        self.assertGreaterEqual(np.percentile(in_fan, 99), 128)


if __name__ == "__main__":
    unittest.main()
