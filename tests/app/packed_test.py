"""Arrays by sequence against the files by ping that they replace, read by readers of another hand."""
import fnmatch
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "independent"))
import sonar_dataset  # noqa: E402

ENSONIFY = os.environ["ENSONIFY"]

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


def run(*arguments):
    return subprocess.run([ENSONIFY, *map(str, arguments)], check=True, capture_output=True,
                          text=True)


def bits(array):
    return np.ascontiguousarray(array).tobytes()


class Packed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.scenario = Path(cls.folder.name, "scene.yaml")
        cls.scenario.write_text(SCENARIO)
        cls.made = {}
        for pack in ("ping", "sequence"):
            cls.made[pack] = Path(cls.folder.name, pack)
            run("generate", cls.scenario, "-o", cls.made[pack], "--quiet", "--pings", "1:4",
                "--set", f"output.one_file_per={pack}")
            run("verify", cls.made[pack])

    def unpacked(self, sequence, name, ping):
        """The part of an array that a ping's own files hold."""
        stem = f"{ping:06d}"
        name = name.removesuffix(".npy")
        if name == "timeseries":
            return np.load(sequence / f"timeseries/{stem}.npy")
        view, what = name.split("_", 1)
        if view == "layers":
            return np.load(sequence / f"layers/{stem}_{what}.npy")
        if what == "grey":
            return sonar_dataset.read_png(sequence / f"png/{stem}_{view}.png")
        ids = sequence / f"{view}/{stem}_{what}.png"
        if ids.exists():
            return sonar_dataset.read_png(ids)
        level, labels = sonar_dataset.read_exr(sequence / f"{view}/{stem}.exr")
        return level.channels["Y"] if what == "level_db" else labels.channels[what]

    def arrays_of(self, sequence, stem="000001"):
        """The names of the arrays that replace the files of a ping."""
        names = {"timeseries.npy"}
        names |= {f"layers_{path.stem[7:]}.npy" for path in sequence.glob(f"layers/{stem}_*.npy")}
        for view in ("polar", "cartesian"):
            labels = sonar_dataset.read_exr(sequence / f"{view}/{stem}.exr")[1].channels
            ids = [path.stem[7:] for path in sequence.glob(f"{view}/{stem}_*.png")]
            names |= {f"{view}_{what}.npy" for what in ("level_db", "grey", *labels, *ids)}
        return names

    def test_arrays_equal_the_files_bit_for_bit(self):
        for number in ("000000", "000001"):
            files = self.made["ping"] / "sequences" / number
            sequence = self.made["sequence"] / "sequences" / number
            about = json.loads((sequence / "sequence.json").read_text())
            self.assertEqual(about["pack"], "sequence")
            self.assertEqual(set(about["arrays"]), self.arrays_of(files))
            for name in ("polar_clean_db.npy", "cartesian_instance.npy", "layers_noise.npy"):
                self.assertIn(name, about["arrays"])
            for name, told in about["arrays"].items():
                array = np.load(sequence / name)
                self.assertEqual(array.dtype.str, told["dtype"], name)
                self.assertEqual(list(array.shape), told["shape"], name)
                self.assertEqual(len(array), 3)
                for row in range(3):
                    own = self.unpacked(files, name, 1 + row)
                    self.assertEqual(own.shape, array[row].shape, name)
                    self.assertEqual(bits(own.astype(array.dtype)), bits(array[row]), (name, row))
            for name in ("poses.csv", "objects.csv", "first_return_m.npy", "scatterers/000002.npy"):
                self.assertEqual((files / name).read_bytes(), (sequence / name).read_bytes())

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
            told = run("check", self.scenario, "--set", f"output.one_file_per={pack}").stdout
            files = int(re.search(r"# files: (\d+)", told).group(1))
            found = sum(path.is_file() for path in folder.rglob("*"))
            self.assertEqual(files - found, 2 * (2 if pack == "sequence" else 17), pack)

    def test_interrupted_work_goes_on(self):
        whole = self.made["sequence"]
        other = Path(self.folder.name, "other")
        command = ["generate", self.scenario, "-o", other, "--quiet", "--pings", "1:4",
                   "--threads", "1", "--set", "output.one_file_per=sequence"]
        process = subprocess.Popen([ENSONIFY, *map(str, command)])
        while process.poll() is None and not list(other.glob("sequences/*/pieces/*.bin")):
            pass
        process.kill()
        process.wait()
        run(*command)
        run("verify", other)
        for path in whole.rglob("*"):
            if path.is_file() and path.name != "provenance.json":
                self.assertEqual(path.read_bytes(), (other / path.relative_to(whole)).read_bytes())


if __name__ == "__main__":
    unittest.main()
