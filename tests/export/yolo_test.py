"""yolo: outlines and boxes against the instance masks, pixel by pixel and box by box."""
import json
import unittest

import numpy as np

import exported
from sonar_dataset import read_png


def filled(points, height, width):
    """The pixels whose centre lies in a closed polygon by the even-odd rule."""
    x, y = np.arange(width) + 0.5, np.arange(height) + 0.5
    inside = np.zeros((height, width), bool)
    for (xa, ya), (xb, yb) in zip(points, np.roll(points, -1, axis=0)):
        rows = (ya > y) != (yb > y)
        if rows.any():
            crossing = xa + (y[rows] - ya) / (yb - ya) * (xb - xa)
            inside[rows] ^= x[None, :] < crossing[:, None]
    return inside


def box_of(mask):
    """left, top, right, bottom; the last two outside."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return columns[0], rows[0], columns[-1] + 1, rows[-1] + 1


def pictures(view):
    """(sequence, ping, picture of instances, [(class id, mask) in the order of ids])."""
    for sequence in exported.sequences():
        classes = {i["id"]: i["class_id"] for i in sequence.head["instances"]}
        for ping in sequence.pings:
            instance = sequence.png(view, ping, "_instance")
            ids = [i for i in np.unique(instance) if i]
            yield sequence, ping, [(classes[i], instance == i) for i in ids]


class Yolo(exported.Case):
    format_name = "yolo"

    def check_pictures(self, out, view):
        names = {"train": [], "val": [], "test": []}
        for sequence, ping, _ in pictures(view):
            name = f"{sequence.number:06}_{ping:06}"
            np.testing.assert_array_equal(read_png(out / "images" / sequence.split / f"{name}.png"),
                                          sequence.png("png", ping, f"_{view}"))
            names[sequence.split].append(name)
        for split, listed in names.items():
            self.assertEqual(sorted(p.stem for p in (out / "images" / split).iterdir()), listed)
            self.assertEqual(sorted(p.stem for p in (out / "labels" / split).iterdir()), listed)
        self.assertTrue(names["train"] and names["val"])

    def check_outlines(self, view, *options):
        out = exported.export("yolo", *options, *exported.ALL_CLASSES)
        self.check_pictures(out, view)
        parts = 0
        for sequence, ping, expected in pictures(view):
            text = (out / f"labels/{sequence.split}/{sequence.number:06}_{ping:06}.txt").read_text()
            lines = [line.split(" ") for line in text.splitlines()]
            self.assertEqual([int(line[0]) for line in lines], [c - 1 for c, _ in expected])
            for line, (_, mask) in zip(lines, expected):
                points = np.array(line[1:], float).reshape(-1, 2)
                self.assertTrue(((points >= 0) & (points <= 1)).all())
                height, width = mask.shape
                np.testing.assert_array_equal(filled(points * [width, height], height, width), mask)
                edges = np.abs(np.diff(mask.astype(int), axis=0)).sum()
                parts += edges > 2 * mask.any(axis=0).sum()
        self.assertGreater(parts, 0, "no mask is in parts: bridges would not be tested")

    def test_outlines_of_cartesian_pictures(self):
        self.check_outlines("cartesian")

    def test_outlines_of_polar_pictures(self):
        self.check_outlines("polar", "--view", "polar", "--labels", "segments")

    def test_boxes(self):
        for view in ("cartesian", "polar"):
            out = exported.export("yolo", "--labels", "boxes", "--view", view, *exported.ALL_CLASSES)
            for sequence, ping, expected in pictures(view):
                text = (out / f"labels/{sequence.split}/{sequence.number:06}_{ping:06}.txt").read_text()
                lines = [[float(word) for word in line.split(" ")] for line in text.splitlines()]
                self.assertEqual([line[0] for line in lines], [c - 1 for c, _ in expected])
                for (_, x, y, w, h), (_, mask) in zip(lines, expected):
                    height, width = mask.shape
                    found = [(x - w / 2) * width, (y - h / 2) * height, (x + w / 2) * width,
                             (y + h / 2) * height]
                    np.testing.assert_allclose(found, box_of(mask), atol=1e-3)

    def test_names(self):
        lines = (exported.export("yolo") / "data.yaml").read_text().splitlines()
        self.assertIn("train: images/train", lines)
        self.assertIn("val: images/val", lines)
        self.assertIn("nc: 3", lines)
        names = lines[lines.index("names:") + 1:]
        self.assertEqual([json.loads(line.split(": ", 1)[1]) for line in names], exported.CLASSES)

    def test_a_room_has_no_label_unless_it_is_asked_for(self):
        out = exported.export("yolo")
        for sequence, ping, expected in pictures("cartesian"):
            text = (out / f"labels/{sequence.split}/{sequence.number:06}_{ping:06}.txt").read_text()
            self.assertEqual([int(line.split(" ")[0]) for line in text.splitlines()],
                             [c - 1 for c, _ in expected if exported.CLASSES[c - 1] != "room"])


if __name__ == "__main__":
    unittest.main()
