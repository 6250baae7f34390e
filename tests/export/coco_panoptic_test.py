"""coco_panoptic: segments against the instance masks of the data set, whose colors Pillow reads."""
import json
import unittest

import numpy as np
from PIL import Image

import exported
from sonar_dataset import read_png

STUFF = 65536


def ids_of(path):
    """The ids of segments, from the colors of a PNG."""
    with Image.open(path) as image:
        assert image.mode == "RGB", image.mode
        return np.array(image).astype(int) @ [1, 256, 65536]


class CocoPanoptic(exported.Case):
    format_name = "coco_panoptic"

    def check(self, view, source=None, *options, kinds=("stuff", "thing", "thing")):
        out = exported.export("coco_panoptic", "--view", view, *options, source=source)
        segments = 0
        for split in ("train", "val", "test"):
            head = json.loads((out / f"annotations/panoptic_{split}.json").read_text())
            self.assertEqual([(c["id"], c["name"], c["isthing"]) for c in head["categories"]],
                             [(i + 1, name, int(kinds[i] == "thing")) for i, name in enumerate(exported.CLASSES)])
            self.assertEqual(len({tuple(c["color"]) for c in head["categories"]} - {(0, 0, 0)}), 3)
            images = {i["id"]: i for i in head["images"]}
            self.assertEqual([a["image_id"] for a in head["annotations"]], list(range(1, len(images) + 1)))
            for kind in (f"annotations/panoptic_{split}", f"annotations/semantic_{split}", f"images/{split}"):
                self.assertEqual(len(list((out / kind).iterdir())), len(images))
            pings = [(s, p) for s in exported.sequences(source) if s.split == split for p in s.pings]
            self.assertEqual(len(pings), len(images))
            for (sequence, ping), a in zip(pings, head["annotations"]):
                name, image = f"{sequence.number:06}_{ping:06}.png", images[a["image_id"]]
                self.assertEqual([a["file_name"], image["file_name"]], [name, name])
                grey = read_png(out / "images" / split / name)
                np.testing.assert_array_equal(grey, sequence.png("png", ping, f"_{view}"))
                self.assertEqual((image["height"], image["width"]), grey.shape)
                ids = ids_of(out / f"annotations/panoptic_{split}" / name)
                classes = read_png(out / f"annotations/semantic_{split}" / name)
                segments += self.check_segments(sequence, ping, view, ids, classes, a["segments_info"], kinds)
        return segments

    def check_segments(self, sequence, ping, view, ids, classes, segments, kinds):
        instance = sequence.png(view, ping, "_instance")
        semantic = sequence.png(view, ping, "_semantic").astype(int)
        is_stuff = np.array([False, *(kind == "stuff" for kind in kinds)])[semantic]
        np.testing.assert_array_equal(ids, np.where(is_stuff, STUFF + semantic, instance))
        np.testing.assert_array_equal(classes, np.where(semantic == 0, 255, semantic))
        self.assertEqual([s["id"] for s in segments], sorted(set(np.unique(ids)) - {0}))
        for s in segments:
            rows, columns = np.nonzero(ids == s["id"])
            self.assertEqual(s["area"], len(rows))
            self.assertEqual(s["bbox"], [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1])
            self.assertEqual(set(semantic[rows, columns]), {s["category_id"]})
            self.assertEqual(s["iscrowd"], 0)
        return len(segments)

    def test_cartesian(self):
        self.assertGreater(self.check("cartesian"), 12)

    def test_polar(self):
        self.assertGreater(self.check("polar"), 12)

    def test_all_stuff_of_a_class_is_one_segment(self):
        """Two instances of a class that is stuff, in one image."""
        source = exported.dataset("--set", "objects.1.class=pole", "--set",
                                  "classes={pole: {kind: stuff}}")
        out = exported.export("coco_panoptic", source=source)
        merged = 0
        for sequence in exported.sequences(source):
            for ping in sequence.pings:
                name = f"{sequence.number:06}_{ping:06}.png"
                ids = ids_of(out / f"annotations/panoptic_{sequence.split}" / name)
                instance = sequence.png("cartesian", ping, "_instance")
                pole = STUFF + {i["name"]: i["class_id"] for i in sequence.head["instances"]}["pole"]
                np.testing.assert_array_equal(ids == pole, instance > 1)
                merged += len(np.unique(instance[ids == pole])) == 2
        self.assertGreater(merged, 0)

    def test_options_that_choose_objects_are_refused(self):
        result = exported.run("export", exported.dataset(), "--format", "coco_panoptic", "-o", exported.scratch() / "o",
                              "--min-pixels", "9")
        self.assertEqual(result.returncode, 2)
        self.assertIn("--min-pixels: not an option of --format coco_panoptic", result.stderr)


if __name__ == "__main__":
    unittest.main()
