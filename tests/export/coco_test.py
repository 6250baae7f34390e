"""coco: images, boxes and masks against those that the Python reader takes from the data set."""
import json
import unittest

import numpy as np

import exported
from ensonify_dataset import SonarDataset
from sonar_dataset import decode_rle, read_png

SPLITS = ("train", "val", "test")


def visible_share(annotation):
    return annotation.area / annotation.amodal_mask.sum()


def between(values):
    """A number with some of the values on either side."""
    known = sorted(set(values))
    assert len(known) > 1, known
    return (known[len(known) // 2 - 1] + known[len(known) // 2]) / 2


class Coco(exported.Case):
    format_name = "coco"

    def setUp(self):
        self.data = SonarDataset(exported.dataset())

    def stored(self, view="cartesian"):
        """Of all pictures, the room's among them."""
        return [a for ping in self.data for a in getattr(ping, view).annotations]

    def check(self, view, wanted, *options, splits=SPLITS):
        """Every picture of the view, and the annotations that wanted(annotation) is true of; how many these are."""
        out = exported.export("coco", "--view", view, *options)
        self.assertEqual(sorted(p.name for p in (out / "annotations").iterdir()),
                         sorted(f"instances_{split}.json" for split in splits))
        self.assertEqual(sorted(p.name for p in (out / "images").iterdir()), sorted(splits))
        count = 0
        for split in splits:
            head = json.loads((out / f"annotations/instances_{split}.json").read_text())
            found = {i["id"]: [] for i in head["images"]}
            self.assertEqual(list(found), list(range(1, len(found) + 1)))
            self.assertEqual([a["id"] for a in head["annotations"]], list(range(1, len(head["annotations"]) + 1)))
            for a in head["annotations"]:
                found[a["image_id"]].append(a)
            pings = self.data.split(split)
            files = [f"{sequence:06}_{ping:06}.png" for sequence, ping in pings.index]
            self.assertEqual([i["file_name"] for i in head["images"]], files)
            self.assertEqual(sorted(p.name for p in (out / "images" / split).iterdir()), files)
            for image, ping in zip(head["images"], pings):
                stored = getattr(ping, view)
                np.testing.assert_array_equal(read_png(out / "images" / split / image["file_name"]), stored.grey)
                self.assertEqual([image["height"], image["width"]], list(stored.grey.shape))
                expected = [a for a in stored.annotations if wanted(a)]
                self.check_annotations(found[image["id"]], expected)
                count += len(expected)
        return count

    def check_annotations(self, found, expected):
        self.assertEqual([(a["instance_id"], a["category_id"], tuple(a["bbox"]), a["area"]) for a in found],
                         [(a.instance, a.class_id, a.bbox, a.area) for a in expected])
        for a, stored in zip(found, expected):
            code = a["segmentation"]
            np.testing.assert_array_equal(decode_rle(code["counts"], *code["size"]), stored.mask)

    def check_choice(self, wanted, *options):
        """That the options drop some objects of the Cartesian pictures, and keep those that are wanted."""
        everything = len(self.stored())
        kept = self.check("cartesian", wanted, *options)
        self.assertGreater(kept, 0)
        self.assertLess(kept, everything)

    def test_things_alone_have_boxes(self):
        for view in ("cartesian", "polar"):
            self.assertIn("room", {self.data.classes[a.class_id - 1] for a in self.stored(view)})
            self.assertGreater(self.check(view, lambda a: a.class_id != 1), 0)

    def test_classes(self):
        self.check_choice(lambda a: a.class_id == 1, "--classes", "room")
        self.assertEqual(self.check("polar", lambda a: True, *exported.ALL_CLASSES), len(self.stored("polar")))
        self.check_choice(lambda a: a.class_id == 2, "--exclude", "pole")
        self.check_choice(lambda a: a.class_id == 1, *exported.ALL_CLASSES, "--exclude", "pole,ball & net")

    def test_names_of_classes_end_before_the_folder(self):
        out = exported.scratch() / "out"
        result = exported.run("export", "--exclude", "room", "--classes", "pole", exported.dataset(), "--format",
                              "coco", "-o", out)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_size(self):
        least = int(between([a.area for a in self.stored() if a.class_id != 1])) + 1
        self.check_choice(lambda a: a.class_id != 1 and a.area >= least, "--min-pixels", least)

    def test_visible_share(self):
        things = [a for a in self.stored() if a.class_id != 1]
        least = between([visible_share(a) for a in things])
        self.check_choice(lambda a: a.class_id != 1 and visible_share(a) >= least, "--min-visible", least)

    def test_one_split(self):
        self.assertGreater(self.check("cartesian", lambda a: a.class_id != 1, "--split", "val", splits=["val"]), 0)

    def test_categories_keep_the_ids_of_the_data_set(self):
        def categories(*options):
            head = json.loads((exported.export("coco", *options) / "annotations/instances_val.json").read_text())
            return [(c["id"], c["name"], c["isthing"]) for c in head["categories"]]

        self.assertEqual(self.data.class_kinds, ["stuff", "thing", "thing"])
        self.assertEqual(categories(), [(2, "ball & net", 1), (3, "pole", 1)])
        self.assertEqual(categories("--classes", "pole,room"), [(1, "room", 0), (3, "pole", 1)])
        own = json.loads((exported.dataset() / "coco.json").read_text())["categories"]
        self.assertEqual([(c["id"], c["isthing"]) for c in own], [(1, 0), (2, 1), (3, 1)])


if __name__ == "__main__":
    unittest.main()
