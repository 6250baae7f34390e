"""`ensonify render` from outside, and the same images by the reader on the fly and in exports."""
import json
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "reader"))
import small_data  # noqa: E402
from ensonify_dataset import DatasetError, Display, SonarDataset  # noqa: E402

DISPLAYS = {
    "plain": [],
    "limits": ["--db", "80:121.5"],
    "automatic": ["--auto", "--gain-db", "-2"],
    "tvg": ["--tvg", "30", "--absorption"],
    "amplitude": ["--scale", "amplitude", "--gamma", "0.45", "--db", "0:150", "--tvg", "17.5"],
    "nearest": ["--resampling", "nearest", "--tvg", "20"],
    "all": ["--scale", "amplitude", "--gamma", "1.7", "--auto", "--tvg", "40", "--absorption", "--gain-db", "4",
            "--color-map", "viridis", "--flip", "both"],
    "window": ["--range", "4.5:8", "--auto", "--tvg", "20", "--flip", "vertical"],
    "pick": ["--every-sample", "3", "--every-beam", "2"],
    "max": ["--every-sample", "4", "--decimation", "max", "--tvg", "30", "--auto", "--range", "0.7:9.3"],
    "max_nearest": ["--every-sample", "5", "--every-beam", "3", "--decimation", "max", "--resampling", "nearest",
                    "--range", "3:7", "--flip", "horizontal"],
}
# Formats that copy images of a ping, and where an image of this name is.
COPIES = {"yolo": "images/*/{}", "voc": "JPEGImages/{}", "index_mask": "*/images/{}", "coco": "images/*/{}"}


def run(*words, expected=0):
    done = subprocess.run([small_data.PROGRAM, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == expected, done.stderr
    return done.stderr


class Renders(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.data = small_data.generate("seabed_and_target", cls.folder / "data", "--set", "sequences=2",
                                       "--pings", "0:2")
        cls.before = {path: path.read_bytes() for path in cls.data.rglob("*") if path.is_file()}
        for name, options in DISPLAYS.items():
            run("render", cls.data, "--name", name, "--quiet", *options)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_data_set_is_untouched_and_whole(self):
        for path, content in self.before.items():
            self.assertEqual(path.read_bytes(), content, path)
        self.assertIn("complete and undamaged", run("verify", self.data))

    def test_without_options_the_images_are_those_of_the_data_set(self):
        for ping in SonarDataset(self.data):
            for view in (ping.polar, ping.cartesian):
                np.testing.assert_array_equal(view.render("plain"), view.grey)

    def test_the_reader_makes_the_same_images_of_the_levels(self):
        """Every value, of every option."""
        data = SonarDataset(self.data)
        self.assertEqual(data.renders, sorted(data.renders))
        self.assertLessEqual(set(DISPLAYS), set(data.renders))
        for name in DISPLAYS:
            display = data.display(name)
            for ping in data:
                for view in (ping.polar, ping.cartesian):
                    stored = view.render(name)
                    self.assertGreater(len(np.unique(stored)), 20)
                    np.testing.assert_array_equal(view.displayed(display), stored, name)
        own = data.display()
        for view in (data[0].polar, data[0].cartesian):
            np.testing.assert_array_equal(view.displayed(own), view.grey)

    def test_nearest_shows_the_polar_pixels(self):
        ping = SonarDataset(self.data)[0]
        pixels = ping.sequence.cartesian_map
        shown = ping.polar.render("nearest").ravel()[np.maximum(pixels, 0)]
        np.testing.assert_array_equal(ping.cartesian.render("nearest"), np.where(pixels < 0, 0, shown))
        self.assertEqual(SonarDataset(self.data).display("nearest").resampling, "nearest")
        self.assertEqual(SonarDataset(self.data).display("plain").resampling, "bilinear")

    def test_a_generated_set_can_have_nearest_images(self):
        sets = [small_data.generate("seabed_and_target", self.folder / name, "--pings", "0:1", "--set",
                                    f"output.png={{resampling: {name}}}") for name in ("nearest", "bilinear")]
        run("render", sets[1], "--name", "nearest", "--resampling", "nearest")
        nearest, bilinear = (SonarDataset(folder)[0].cartesian for folder in sets)
        np.testing.assert_array_equal(nearest.grey, bilinear.render("nearest"))
        self.assertGreater(np.mean(nearest.grey != bilinear.grey), 0.2)
        np.testing.assert_array_equal(nearest.displayed(SonarDataset(sets[0]).display()), nearest.grey)

    def test_what_is_not_there_is_named(self):
        data = SonarDataset(self.data)
        with self.assertRaisesRegex(DatasetError, "ensonify render"):
            data[0].polar.render("other")
        with self.assertRaisesRegex(DatasetError, "no name"):
            data[0].polar.render("../png")

    def test_a_display_can_be_made_by_hand(self):
        display = Display((80, 121.5))
        np.testing.assert_array_equal(SonarDataset(self.data)[1].polar.displayed(display),
                                      SonarDataset(self.data)[1].polar.render("limits"))

    def test_exports_take_the_images_of_a_render(self):
        for form, place in COPIES.items():
            out = self.folder / form
            run("export", self.data, "--format", form, "-o", out, "--view", "polar", "--render", "limits")
            found = sorted(out.glob(place.format("*.png")))
            self.assertEqual(len(found), 4)
            for path in found:
                sequence, ping = path.stem.split("_")
                want = self.data / f"renders/limits/sequences/{sequence}/{ping}_polar.png"
                self.assertEqual(path.read_bytes(), want.read_bytes())
        run("export", self.data, "--format", "mcap", "-o", self.folder / "mcap", "--render", "tvg")
        run("export", self.data, "--format", "webdataset", "-o", self.folder / "tar", "--render", "tvg")

    def test_parts_have_the_places_that_their_manifest_gives(self):
        """Nearest images of a window are cut out of those of all ranges; blocks hold their largest gray level."""
        run("render", self.data, "--name", "cut", "--range", "4:7", "--resampling", "nearest", "--db", "80:121.5")
        run("render", self.data, "--name", "whole", "--resampling", "nearest", "--db", "80:121.5")
        run("render", self.data, "--name", "loud", "--every-sample", "4", "--decimation", "max", "--db", "80:121.5")
        places = json.loads((self.data / "renders/cut/render.json").read_text())["sequences"][0]
        ping = SonarDataset(self.data)[0]
        range_m = ping.sequence.range_m
        for view in (ping.polar, ping.cartesian):
            part, whole = view.render("cut"), view.render("whole")
            top, left, height, width = (places[view.kind][f"{key}_px"] for key in ("top", "left", "height", "width"))
            self.assertEqual(part.shape, (height, width))
            same = whole[top:top + height, left:left + width]
            if view.kind == "cartesian":
                sample = ping.sequence.cartesian_map[top:top + height, left:left + width] // ping.polar.level_db.shape[1]
                inside = (sample >= 0) & (range_m[sample] >= 4) & (range_m[sample] <= 7)
                same = np.where(inside, same, 0)
                self.assertTrue(inside.any(axis=0)[[0, -1]].all() and inside.any(axis=1)[[0, -1]].all())
            np.testing.assert_array_equal(part, same)
        self.assertAlmostEqual(range_m[places["polar"]["top_px"]], 4, delta=range_m[1] - range_m[0])
        loud, whole = ping.polar.render("loud"), ping.polar.render("whole")
        blocks = np.split(whole, np.arange(4, len(whole), 4))
        np.testing.assert_array_equal(loud, [block.max(axis=0) for block in blocks])

    def test_jpeg_files_are_read_and_exported(self):
        """Within the error of JPEG at this quality; exports keep the end of the name."""
        run("render", self.data, "--name", "jpeg", "--jpeg-quality", "98", "--db", "80:121.5")
        ping = SonarDataset(self.data)[0]
        for view in (ping.polar, ping.cartesian):
            error = view.render("jpeg").astype(int) - view.displayed(Display((80, 121.5)))
            self.assertLess(np.sqrt(np.mean(error**2)), 3)
        stored = (self.data / "renders/jpeg/sequences/000000/000001_polar.jpg").read_bytes()
        for form, place in COPIES.items():
            out = self.folder / f"{form}_jpeg"
            run("export", self.data, "--format", form, "-o", out, "--view", "polar", "--render", "jpeg")
            images = out.glob(place.format("000000_000001.jpg"))
            self.assertEqual([path.read_bytes() for path in images], [stored], form)
        self.assertIn("<filename>000000_000001.jpg</filename>",
                      (self.folder / "voc_jpeg/Annotations/000000_000001.xml").read_text())
        run("export", self.data, "--format", "webdataset", "-o", self.folder / "tar_jpeg", "--view", "polar",
            "--render", "jpeg")
        with tarfile.open(next((self.folder / "tar_jpeg").glob("*.tar"))) as tar:
            self.assertIn("000000_000001.jpg", tar.getnames())
        out = self.folder / "mot_jpeg"
        run("export", self.data, "--format", "mot", "-o", out, "--view", "polar", "--render", "jpeg")
        self.assertEqual([path.read_bytes() for path in out.glob("*/000000/img1/000002.jpg")], [stored])
        self.assertEqual(list(out.glob("*/*/img1/*.png")), [])
        for told in out.glob("*/*/seqinfo.ini"):
            self.assertIn("imExt=.jpg", told.read_text())
        for form in ("crops", "mcap", "sdpr"):
            run("export", self.data, "--format", form, "-o", self.folder / f"{form}_jpeg", "--render", "jpeg")
        self.assertIn("complete and undamaged", run("verify", self.data))

    def test_exports_refuse_renders_that_do_not_fit(self):
        run("render", self.data, "--name", "lossy", "--jpeg-quality", "90")
        for form, name, what in (("yolo", "all", "flipped"), ("yolo", "pick", "masks and boxes are of all"),
                                 ("coco", "max", "without --range, --every-sample"), ("yolo", "none", "expected one of all"),
                                 ("hdf5", "limits", "not an option"), ("pairs", "lossy", "render without --jpeg-quality")):
            told = run("export", self.data, "--format", form, "-o", self.folder / "refused", "--render", name,
                       expected=2)
            self.assertIn(what, told)
        run("render", self.data, "--name", "part", "--sequences", "1:2", "--view", "polar", "--color-map", "magma")
        for form, view, what in (("yolo", "polar", "lacks sequences"), ("yolo", "cartesian", "no cartesian images"),
                                 ("mcap", None, "is in color")):
            told = run("export", self.data, "--format", form, "-o", self.folder / "refused", "--render", "part",
                       *(["--view", view] if view else []), expected=2)
            self.assertIn(what, told)

    def test_limits_that_do_not_fit_are_warned_of(self):
        told = run("render", self.data, "--name", "white", "--db", "0:20", "--quiet")
        self.assertIn("of the pixels are white with limits of 0 and 20 dB", told)
        self.assertEqual(run("render", self.data, "--name", "fits", "--quiet"), "")

    def test_packed_sequences_are_rendered_alike(self):
        packed = small_data.generate("seabed_and_target", self.folder / "packed", "--set", "sequences=2",
                                     "--pings", "0:2", "--set", "output.one_file_per=sequence")
        run("render", packed, "--name", "all", *DISPLAYS["all"])
        for path in (self.data / "renders/all/sequences").rglob("*.png"):
            twin = packed / path.relative_to(self.data)
            self.assertEqual(path.read_bytes(), twin.read_bytes(), path)
        self.assertIn("complete and undamaged", run("verify", packed))

    def test_levels_are_needed(self):
        bare = small_data.generate("seabed_and_target", self.folder / "bare", "--pings", "0:1", "--set",
                                   "output.polar=false", "--set", "output.cartesian=false")
        self.assertIn("output.polar: true", run("render", bare, "--name", "a", expected=2))

    def test_growing_a_data_set_keeps_its_renders(self):
        data = small_data.generate("seabed_and_target", self.folder / "grown", "--pings", "0:1", "--set", "sequences=1")
        run("render", data, "--name", "a")
        small_data.generate("seabed_and_target", data, "--pings", "0:1", "--set", "sequences=2")
        self.assertIn("complete and undamaged", run("verify", data))


class AGeneratedSet(unittest.TestCase):
    def test_limits_that_do_not_fit_are_warned_of_at_the_end(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [small_data.PROGRAM, "generate", small_data.SCENES / "seabed_and_target.yaml", "-o",
                       f"{folder}/d", "--quiet", *small_data.SMALL, "--pings", "0:1"]
            for limits, warned in (("[0, 20]", "are white"), ("[200, 220]", "are black"), (None, "")):
                words = command if limits is None else [*command, "--set", f"output.png={{db: {limits}}}"]
                done = subprocess.run([*map(str, words), "--overwrite"], capture_output=True, text=True, check=True)
                lines = [line for line in done.stderr.splitlines() if "8-bit images" in line]
                self.assertEqual(bool(lines), bool(warned), done.stderr)
                self.assertIn(warned, "".join(lines))


if __name__ == "__main__":
    unittest.main()
