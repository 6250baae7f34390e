"""index_mask: pictures and masks against those of the data set, pixel by pixel."""
import unittest

import numpy as np

import exported
from sonar_dataset import read_png


class IndexMask(exported.Case):
    format_name = "index_mask"

    def check(self, view, *options):
        out = exported.export("index_mask", *options)
        seen = []
        for sequence in exported.sequences():
            for ping in sequence.pings:
                name = f"{sequence.number:06}_{ping:06}.png"
                folder = out / sequence.split
                instance = read_png(folder / "instances" / name)
                self.assertEqual(instance.dtype, np.uint16)
                np.testing.assert_array_equal(instance, sequence.png(view, ping, "_instance"))
                mask = read_png(folder / "masks" / name)
                self.assertEqual(mask.dtype, np.uint8)
                np.testing.assert_array_equal(mask, sequence.png(view, ping, "_semantic"))
                np.testing.assert_array_equal(read_png(folder / "images" / name),
                                              sequence.png("png", ping, f"_{view}"))
                seen.append((sequence.split, instance.max()))
        self.assertEqual({split for split, _ in seen}, {"train", "val"})
        self.assertEqual(max(most for _, most in seen), 3)
        self.assertEqual(len(exported.hashes(out)), 3 * len(seen) + 1)

    def test_cartesian(self):
        self.check("cartesian")

    def test_polar(self):
        self.check("polar", "--view", "polar")

    def test_names(self):
        self.assertEqual((exported.export("index_mask") / "classes.txt").read_text(),
                         "none\n" + "".join(name + "\n" for name in exported.CLASSES))


if __name__ == "__main__":
    unittest.main()
