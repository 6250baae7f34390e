"""crops: every crop against the 8-bit image and the boxes that the Python reader takes from the data set."""
import unittest

import numpy as np

import exported
from ensonify_dataset import SonarDataset
from sonar_dataset import read_png

FOLDERS = {2: "ball___net", 3: "pole"}


def crops(data, view, margin, folders=FOLDERS):
    """{path below the export: pixels} of the objects of these class ids."""
    expected = {}
    for split in ("train", "val", "test"):
        for ping in data.split(split):
            pictures = getattr(ping, view)
            for a in pictures.annotations:
                if a.class_id not in folders:
                    continue
                x, y, width, height = a.bbox
                name = f"{ping.sequence.number:06}_{ping.number:06}_{a.instance:05}.png"
                rows = slice(max(y - margin, 0), y + height + margin)
                columns = slice(max(x - margin, 0), x + width + margin)
                expected[f"{split}/{folders[a.class_id]}/{name}"] = pictures.grey[rows, columns]
    return expected


class Crops(exported.Case):
    format_name = "crops"

    def check(self, out, expected):
        self.assertGreater(len(expected), 0)
        self.assertEqual(sorted(str(p.relative_to(out)) for p in out.rglob("*.png")), sorted(expected))
        for name, pixels in expected.items():
            np.testing.assert_array_equal(read_png(out / name), pixels, name)

    def test_around_the_boxes_of_things(self):
        data = SonarDataset(exported.dataset())
        self.check(exported.export("crops"), crops(data, "cartesian", 8))
        self.check(exported.export("crops", "--view", "polar", "--margin-px", 0), crops(data, "polar", 0))
        # Beyond every edge of the image.
        self.check(exported.export("crops", "--margin-px", 500), crops(data, "cartesian", 500))

    def test_a_render_in_color_is_refused(self):
        made = exported.run("render", exported.dataset(), "--name", "colored", "--color-map", "viridis", "--quiet")
        self.assertEqual(made.returncode, 0, made.stderr)
        refused = exported.run("export", exported.dataset(), "--format", "crops", "--render", "colored",
                               "-o", exported.scratch() / "out")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("render without --color-map", refused.stderr)

    def test_chosen_objects(self):
        data = SonarDataset(exported.dataset())
        self.check(exported.export("crops", "--classes", "room,pole", "--exclude", "pole"),
                   crops(data, "cartesian", 8, {1: "room"}))

    def test_every_split_has_the_folders_of_all_classes(self):
        """ImageFolder numbers the folders that it finds."""
        for splits, options in ((["test", "train", "val"], ()), (["val"], ("--split", "val"))):
            out = exported.export("crops", *options)
            self.assertEqual(sorted(p.name for p in out.iterdir()), splits)
            for split in splits:
                self.assertEqual(sorted(p.name for p in (out / split).iterdir()), sorted(FOLDERS.values()))

    def test_classes_whose_folders_would_be_one(self):
        source = exported.dataset("--set", "objects.pole.class=ball___net")
        out = exported.export("crops", source=source)
        self.check(out, crops(SonarDataset(source), "cartesian", 8, {2: "ball___net_2", 3: "ball___net_3"}))

    def test_letters_of_any_script_stay(self):
        names = {2: "водолаз_潜水员_é", 3: "pole"}
        source = exported.dataset("--set", f"objects.ball/1.class={names[2].replace('_', ' ')}")
        self.check(exported.export("crops", source=source), crops(SonarDataset(source), "cartesian", 8, names))
        # A name is cut between characters: 150 letters of two bytes do not fit into 100 bytes.
        source = exported.dataset("--set", "objects.ball/1.class=" + "я" * 60)
        self.check(exported.export("crops", source=source),
                   crops(SonarDataset(source), "cartesian", 8, {2: "я" * 50, 3: "pole"}))

    def test_folders_that_no_number_keeps_apart_are_refused(self):
        source = exported.dataset("--set", "objects.room.class=ball___net_2", "--set", "objects.pole.class=ball___net")
        result = exported.run("export", source, "--format", "crops", "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 2)
        self.assertIn("would both have the folder ball___net_2", result.stderr)


if __name__ == "__main__":
    unittest.main()
