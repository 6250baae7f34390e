"""voc: XML by Python's own parser, indexed PNG by Pillow, against the data set."""
import unittest
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image

import exported
from sonar_dataset import read_png, read_png_chunk_names
from yolo_test import box_of, pictures


def read_indexed(path):
    """Indices and palette of an 8-bit indexed PNG."""
    assert not {"tIME", "tEXt"} & set(read_png_chunk_names(path))
    with Image.open(path) as image:
        assert image.mode == "P", image.mode
        return np.array(image), np.array(image.getpalette(), np.uint8).reshape(-1, 3)


class Voc(exported.Case):
    format_name = "voc"

    def check(self, view, *options, stuff=True):
        out = exported.export("voc", *options, *(exported.ALL_CLASSES if stuff else ()))
        listed = {"train": [], "val": [], "test": []}
        class_names = exported.CLASSES
        for sequence, ping, everything in pictures(view):
            expected = [(c, mask) for c, mask in everything if stuff or class_names[c - 1] != "room"]
            name = f"{sequence.number:06}_{ping:06}"
            listed[sequence.split].append(name)
            picture = read_png(out / "JPEGImages" / f"{name}.png")
            np.testing.assert_array_equal(picture, sequence.png("png", ping, f"_{view}"))
            root = ElementTree.parse(out / "Annotations" / f"{name}.xml").getroot()
            self.assertEqual(root.findtext("filename"), f"{name}.png")
            size = [int(root.findtext(f"size/{key}")) for key in ("height", "width", "depth")]
            self.assertEqual(size, [*picture.shape, 1])
            objects = root.findall("object")
            self.assertEqual([o.findtext("name") for o in objects], [class_names[c - 1] for c, _ in expected])
            for found, (_, mask) in zip(objects, expected):
                left, top, right, bottom = box_of(mask)
                box = [int(found.findtext(f"bndbox/{key}")) for key in ("xmin", "ymin", "xmax", "ymax")]
                self.assertEqual(box, [left + 1, top + 1, right, bottom])
                cut = left == 0 or top == 0 or right == mask.shape[1] or bottom == mask.shape[0]
                self.assertEqual(found.findtext("truncated"), str(int(cut)))
            classes, palette = read_indexed(out / "SegmentationClass" / f"{name}.png")
            semantic = sequence.png(view, ping, "_semantic")
            if not stuff:
                semantic[semantic == 1 + class_names.index("room")] = 0
            np.testing.assert_array_equal(classes, semantic)
            # The colours that VOC's own masks have: aeroplane, bicycle, bird, and what is void.
            self.assertEqual(palette[[0, 1, 2, 3, 255]].tolist(),
                             [[0, 0, 0], [128, 0, 0], [0, 128, 0], [128, 128, 0], [224, 224, 192]])
            numbers, _ = read_indexed(out / "SegmentationObject" / f"{name}.png")
            wanted = np.zeros(picture.shape, np.uint8)
            for number, (_, mask) in enumerate(expected, 1):
                wanted[mask] = number
            np.testing.assert_array_equal(numbers, wanted)
        for kind in ("Main", "Segmentation"):
            for split, names in listed.items():
                self.assertEqual((out / f"ImageSets/{kind}/{split}.txt").read_text().split(), names)

    def test_cartesian(self):
        self.check("cartesian")

    def test_polar(self):
        self.check("polar", "--view", "polar")

    def test_a_room_is_no_object_unless_it_is_asked_for(self):
        self.check("cartesian", stuff=False)


if __name__ == "__main__":
    unittest.main()
