"""Arrays by sequence beside the files by ping that they replace: names, sizes and the places that COCO gives.

What each array holds, bit for bit, is tested in tests/dataset/packed_test.cpp and read_pictures_test.cpp, and by the
reader in tests/reader/reader_test.py.
"""
import fnmatch
import json
import re
import unittest

import numpy as np

from program import made, run, scratch, settings
import sonar_dataset

SCENARIO = """ensonify: 1
sequences: 2
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 24, fov_deg: 24}
  rays: {elevation: 8}
  receiver: {adc: {bits: 14, full_scale_db: 190}}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, material: m, shape: {box: {size_m: [5, 5, 2], inward_facing: true}}}
  - {name: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [1.5, 0, 0]}}
trajectory: {ping_rate_hz: 5, pings: 4}
noise: {spectrum_level_db: 40}
output: {cartesian: {height_px: 60, exr: true}, layers: true, scatterers: true, points: true}
"""


class Packed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = {pack: made(SCENARIO, "--pings", "1:4", *settings(f"output.one_file_per={pack}"))
                    for pack in ("ping", "sequence")}

    def test_arrays_have_the_types_and_shapes_that_are_said_of_them(self):
        for sequence in (self.made["sequence"] / "sequences").iterdir():
            about = json.loads((sequence / "sequence.json").read_text())
            self.assertEqual(about["pack"], "sequence")
            for name in ("polar_clean_db.npy", "cartesian_instance.npy", "layers_noise.npy"):
                self.assertIn(name, about["arrays"])
            for name, told in about["arrays"].items():
                array = np.load(sequence / name)
                self.assertEqual((array.dtype.str, list(array.shape), len(array)), (told["dtype"], told["shape"], 3), name)

    def test_files_that_are_not_packed_are_the_same(self):
        for name in ("poses.csv", "objects.csv", "first_return_m.npy", "scatterers/000002.npy"):
            files = [folder / "sequences/000001" / name for folder in self.made.values()]
            self.assertEqual(files[0].read_bytes(), files[1].read_bytes())

    def test_coco_points_into_the_arrays(self):
        by_file, by_array = (json.loads((self.made[pack] / "coco.json").read_text())
                             for pack in ("ping", "sequence"))
        self.assertEqual(by_file["annotations"], by_array["annotations"])
        self.assertEqual(len(by_array["images"]), 2 * 3 * 2)
        for picture, place in zip(by_file["images"], by_array["images"]):
            seen = sonar_dataset.read_png(self.made["ping"] / picture["file_name"])
            held = np.load(self.made["sequence"] / place["array"])[place["index"]]
            self.assertTrue(np.array_equal(seen, held))
            self.assertEqual((place["height"], place["width"]), held.shape)
            self.assertEqual(place["ping"], 1 + place["index"])

    def test_the_data_card_names_every_file_of_a_sequence(self):
        for pack, folder in self.made.items():
            words = re.findall(r"`([^`\n]+)`", (folder / "README.md").read_text())
            globs = [word.replace("PPPPPP", "[0-9]" * 6) for word in words]
            globs += [word + ".npy" for word in words if "." not in word]
            sequence = folder / "sequences/000000"
            files = [path.relative_to(sequence).as_posix() for path in sequence.rglob("*") if path.is_file()]
            unnamed = [name for name in files if not any(fnmatch.fnmatchcase(name, glob) for glob in globs)]
            self.assertEqual(unnamed, [], pack)

    def test_check_tells_the_number_of_files(self):
        for pack, folder in self.made.items():
            # `check` is asked for all pings, of which one was left out.
            told = run("check", scratch(SCENARIO) / "scenario.yaml", *settings(f"output.one_file_per={pack}")).stdout
            files = int(re.search(r"# files: (\d+)", told).group(1))
            found = sum(path.is_file() for path in folder.rglob("*"))
            self.assertEqual(files - found, 2 * (2 if pack == "sequence" else 17), pack)


if __name__ == "__main__":
    unittest.main()
