"""`ensonify compare` from outside: equal data sets agree, changed ones differ, crops and the page, and its errors."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SCENE = pathlib.Path(__file__).resolve().parent / "seabed.yaml"
sys.path.insert(0, str(SCENE.parents[2] / "scripts"))
from ensonify_dataset import SonarDataset  # noqa: E402

# Changes of a tenth, and the statistics that must show them.
CHANGES = {
    "bandwidth": ("sonar.bandwidth_hz=33000", ["range_width", "range_length"]),
    "width": ("sonar.beams.receive_width_deg=1.1", ["azimuth_width", "azimuth_length", "azimuth_correlation"]),
    "noise": ("noise.spectrum_level_db=32.83", ["quantiles", "level_range"]),
}


def run(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)


def write_gray(path, rows):
    Image.fromarray(np.asarray(rows, np.uint8)).save(path)


class DataSets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-compare-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)

    def data_set(self, name, seed, *options):
        folder = self.folder / name
        if not folder.exists():
            made = run("generate", SCENE, "-o", folder, "--seed", seed, "--quiet", *options)
            self.assertEqual(made.returncode, 0, made.stderr)
        return folder

    def compared(self, real, simulated, *options):
        output = self.folder / "numbers.json"
        result = run("compare", real, simulated, "--json", output, "--quiet", *options)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""))
        numbers = json.loads(output.read_text())
        return numbers, {s["id"]: s for s in numbers["statistics"]}

    def equal_scenes(self, pairs):
        """How many statistics differ in pairs of data sets of one scene; the classifier has nothing to find."""
        differs, aucs = 0, []
        for pair in range(pairs):
            numbers, statistics = self.compared(self.data_set(f"s{2 * pair}", 2 * pair + 1),
                                                self.data_set(f"s{2 * pair + 1}", 2 * pair + 2))
            self.assertEqual(numbers["real"], {"folder": str(self.folder / f"s{2 * pair}"), "images": 96, "blocks": 12})
            left_out = [s["id"] for s in statistics.values() if s["verdict"] == "left out"]
            self.assertEqual(left_out, ["level_grazing"])
            differs += sum(s["verdict"] == "differs" for s in statistics.values())
            aucs.append((numbers["classifier"]["auc"], numbers["classifier"]["standard_error"]))
        for auc, error in aucs:
            self.assertLess(abs(auc - 0.5), 3 * error)
        return differs

    def changes_are_found(self, *names):
        for name in names:
            key, found = CHANGES[name]
            _, statistics = self.compared(self.data_set("s0", 1), self.data_set(name, 101, "--set", key))
            self.assertEqual([i for i in found if statistics[i]["verdict"] != "differs"], [], name)


class Compare(DataSets):
    def test_equal_scenes_agree(self):
        # Each statistic differs in one of 20 pairs by chance: of 38 statistics 1.9 are expected to. chance_test.py has
        # more pairs.
        self.assertLess(self.equal_scenes(1), 6)

    def test_a_change_of_a_tenth_is_found(self):
        self.changes_are_found("width")  # chance_test.py has the others

    def test_table_page_and_heights(self):
        page = self.folder / "page.html"
        result = run("compare", self.data_set("s0", 1), self.data_set("s1", 2), "--report", page, "--pings", 24,
                     "--bottom-real", -2, "--bottom-simulated", -2)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = result.stdout.splitlines()
        self.assertEqual(lines[0], "real: 24 pings in 12 blocks; simulated: 24 pings in 12 blocks")
        rows = [line for line in lines if line.endswith(("agrees", "differs")) or "left out" in line]
        self.assertGreaterEqual(len(rows), 30)
        self.assertRegex(result.stdout, r"level against grazing angle, dB +curve +curve .* (agrees|differs)")
        self.assertIn(f"{page}: written", result.stderr)
        text = page.read_text()
        self.assertTrue(text.startswith("<!-- a page of ensonify compare -->\n<!doctype html>"))
        self.assertEqual(text.count("<img "), 6)
        self.assertGreaterEqual(text.count("<svg "), 9)
        for outside in ("http://", "https://", "<script", "@"):
            self.assertNotIn(outside, text.replace("@media", ""))
        # The page is replaced, another file is not.
        self.assertEqual(run("compare", self.folder / "s0", self.folder / "s1", "--report", page, "--quiet").returncode, 0)
        page.write_text("mine")
        refused = run("compare", self.folder / "s0", self.folder / "s1", "--report", page, "--quiet")
        self.assertEqual((refused.returncode, page.read_text()), (2, "mine"))
        self.assertIn("--overwrite", refused.stderr)

    def test_json_replaces_its_own_files_alone(self):
        words = ["compare", self.data_set("s0", 1), self.data_set("s1", 2), "--pings", 24, "--quiet", "--json"]
        found = self.folder / "found.json"
        for _ in range(2):
            self.assertEqual(run(*words, found).returncode, 0)
        found.write_text('{"mine": 1}')
        refused = run(*words, found)
        self.assertEqual((refused.returncode, found.read_text()), (2, '{"mine": 1}'))
        self.assertEqual(run(*words, found, "--overwrite").returncode, 0)
        self.assertIn("two files", run(*words, found, "--report", found).stderr)

    def test_page_in_a_browser(self):
        browser = shutil.which("chromium")
        if browser is None:
            self.skipTest("chromium is missing")
        page = self.folder / "shown.html"
        made = run("compare", self.data_set("s0", 1), self.data_set("s1", 2), "--report", page, "--quiet")
        self.assertEqual(made.returncode, 0, made.stderr)
        shown = subprocess.run(
            [browser, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--dump-dom",
             f"--user-data-dir={self.folder / 'profile'}", page.as_uri()],
            capture_output=True, text=True, timeout=600)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertEqual([line for line in shown.stderr.splitlines() if "CONSOLE" in line], [])
        self.assertEqual(shown.stdout.count("<img "), 6)
        self.assertIn("Classifier", shown.stdout)

    def test_threads_do_not_matter(self):
        one, _ = self.compared(self.data_set("s0", 1), self.data_set("s1", 2), "--threads", 1)
        two, _ = self.compared(self.data_set("s0", 1), self.data_set("s1", 2), "--threads", 2)
        self.assertEqual(one, two)

    def test_mask(self):
        real = self.data_set("s0", 1)
        mask = self.folder / "mask.png"
        write_gray(mask, [[255 * (row > 200)] * 96 for row in range(360)])
        numbers, statistics = self.compared(real, self.data_set("s1", 2), "--mask-real", mask, "--mask-simulated", mask)
        self.assertTrue(all(v is None for v in statistics["level_range"]["real"]["values"][:12]))
        write_gray(mask, [[255] * 96] * 10)
        refused = run("compare", real, real, "--mask-real", mask)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("360 rows", refused.stderr)

    def test_classes_by_masks_and_by_labels(self):
        real, simulated = self.data_set("s0", 1), self.data_set("s1", 2)
        few = ("--pings", 12)
        without, _ = self.compared(real, simulated, *few)
        self.assertNotIn("object_share", [s["id"] for s in without["statistics"]])
        _, labels = self.compared(real, simulated, "--objects", "rock", *few)
        self.assertGreater(labels["object_share"]["real"]["value"], 0)
        self.assertEqual(labels["shadow_level"]["verdict"], "left out")  # the scene has no labels of shadows
        # The same from masks that another program makes of the labels.
        masks = self.folder / "masks"
        masks.mkdir()
        data = SonarDataset(real)
        number = 0
        for s in data.sequences:
            rocks = [i["id"] for i in data.sequence(s).info["instances"] if i["class"] == "rock"]
            for ping in data.sequence(s):
                write_gray(masks / f"{number}.png", np.isin(ping.polar.instance, rocks) * 7)
                number += 1
        _, found = self.compared(real, simulated, "--objects", "rock", "--classes-real", masks, *few)
        for name in ("object_share", "object_level", "object_spread", "object_emd", "background_emd"):
            self.assertEqual(found[name], labels[name])
        (masks / "0.png").unlink()
        for options, words in ((("--classes-real", masks), "has 95 PNG files; expected one for each of the 96 pings"),
                               (("--objects", "rock,tire"), "has no class tire; expected one of")):
            refused = run("compare", real, simulated, *options)
            self.assertEqual(refused.returncode, 2)
            self.assertIn(words, refused.stderr)

    def test_crops(self):
        folders = []
        for name, seed in (("a", 1), ("b", 2)):
            crops = self.folder / f"crops_{name}"
            crops.mkdir()
            draw = np.random.default_rng(seed)
            for i in range(20):
                write_gray(crops / f"{i:03}.png", draw.integers(0, 64, (64, 64)))
            folders.append(crops)
        numbers, statistics = self.compared(*folders)
        self.assertTrue(numbers["crops"])
        self.assertEqual(numbers["real"]["images"], 20)
        self.assertEqual(statistics["level_spread"]["verdict"], "agrees")
        self.assertEqual(statistics["distinct_levels"]["real"]["value"], 6)  # 64 gray levels
        self.assertNotIn("level_range", statistics)
        mixed = run("compare", folders[0], self.data_set("s0", 1))
        self.assertEqual(mixed.returncode, 2)
        self.assertIn("is a data set and", mixed.stderr)
        (folders[0] / "000.png").write_bytes(b"\x89PNG")
        broken = run("compare", *folders)
        self.assertEqual(broken.returncode, 2)
        self.assertIn("000.png", broken.stderr)

    def test_errors(self):
        real, empty = self.data_set("s0", 1), self.folder / "empty"
        empty.mkdir()
        series = self.data_set("series", 1, "--set", "sequences=1", "--set", "sonar.detector={noise_db: 1}", "--set",
                               "output={timeseries: npy, polar: false, cartesian: false, png: false}")
        for options, words in (((series, real), "those of sonar.detector do not follow from time series"),
                               ((empty, real), "compare two data sets or two folders"),
                               ((empty, empty), "neither a finished data set"),
                               ((real, real, "--json", real / "x.json"), "lies in"),
                               ((real, real, "--bottom-real", "-2"), "give both"),
                               ((real, real, "--gamma", "2"), "crops"),
                               ((real, real, "--pings", "1"), "--pings")):
            result = run("compare", *options)
            self.assertEqual(result.returncode, 2, options)
            self.assertIn(words, result.stderr)


if __name__ == "__main__":
    unittest.main()
