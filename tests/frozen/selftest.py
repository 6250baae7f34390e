"""frozen.py finds what it is there to find: files of a data set are changed, and it must not call them equal.

ENSONIFY is the program. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify python3 -m unittest selftest
"""
import os
import pathlib
import shutil
import tempfile
import unittest

import frozen
import numpy as np
import sums
import writers  # of tests/independent, where sums looks for its readers

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SCENE = frozen.SCENES / "two_cylinders.yaml"
NOWHERE = "a_machine_without_a_list"
SERIES, LABELS, LEVELS = "timeseries/000000", "polar/000000_instance", "polar/000000/Y"


class Changed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-frozen-"))
        cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        cls.out = frozen.made(PROGRAM, SCENE, "one ping", folder)
        cls.sequence = cls.out / "sequences/000000"
        cls.arrays = dict(sums.arrays_of(cls.sequence))
        # Written here, so that what differs from it differs by pixels and not by the way of packing.
        (cls.sequence / f"{LABELS}.png").write_bytes(writers.png_bytes(cls.arrays[LABELS]))
        cls.digest = frozen.one_hash(frozen.digests(cls.out))
        cls.stored = sums.read()

    def changed(self, name, array):
        """The file of an array, other than it was until the test ends."""
        path = self.sequence / (name + (".png" if name == LABELS else ".npy"))
        self.addCleanup(path.write_bytes, path.read_bytes())
        path.write_bytes(writers.png_bytes(array)) if name == LABELS else np.save(path, array)

    def told_without_a_list(self):
        """How many arrays differ from their sums, and the text."""
        key = SCENE.stem, "0:1"
        got = sums.sums_of(self.out, self.stored[key])
        lines, differ = frozen.compare(NOWHERE, {}, {key: got}, self.stored)
        self.assertIn("there is no list", lines[0])
        return differ, "\n".join(lines)

    def test_unchanged_arrays_have_their_sums(self):
        differ, told = self.told_without_a_list()
        self.assertEqual(differ, 0, told)

    def test_one_bit_of_a_level_changes_the_hash(self):
        series = self.arrays[SERIES].copy()
        series.view(np.uint32)[40, 300] ^= 1
        self.changed(SERIES, self.arrays[SERIES])
        self.assertEqual(frozen.one_hash(frozen.digests(self.out)), self.digest)
        self.changed(SERIES, series)
        self.assertNotEqual(frozen.one_hash(frozen.digests(self.out)), self.digest)

    def test_one_pixel_of_a_label_changes_the_hash(self):
        labels = self.arrays[LABELS].copy()
        labels[200, 100] ^= 1
        self.changed(LABELS, labels)
        self.assertNotEqual(frozen.one_hash(frozen.digests(self.out)), self.digest)

    def test_sums_find_a_thousandth_in_one_beam(self):
        """The loudest, the faintest, and one of each group between."""
        power = np.abs(self.arrays[SERIES]).mean(axis=1)
        for beam in {int(power.argmax()), int(power.argmin()), *range(7, len(power), sums.GROUP)}:
            with self.subTest(beam=beam):
                series = self.arrays[SERIES].copy()
                series[beam] *= 1.001
                self.changed(SERIES, series)
                differ, told = self.told_without_a_list()
                self.assertGreater(differ, 0)
                self.assertIn(SERIES, told)
                # In an image, whose half floats are coarser, of the level itself.
                image = self.arrays[LEVELS].copy()
                image[:, beam] *= np.float16(1.001)
                known = self.stored[SCENE.stem, "0:1"][LEVELS]
                self.assertIsNotNone(sums.difference(sums.sum_of(LEVELS, image, known.floor), known))

    def test_sums_find_an_instance_that_has_anothers_label(self):
        values, counts = np.unique(self.arrays[LABELS], return_counts=True)
        smallest, other = values[counts.argmin()], values[counts.argmax()]
        self.assertNotEqual(smallest, other)
        self.changed(LABELS, np.where(self.arrays[LABELS] == smallest, other, self.arrays[LABELS]))
        differ, told = self.told_without_a_list()
        self.assertGreater(differ, 0)
        self.assertIn(f"{LABELS}: ", told)


if __name__ == "__main__":
    unittest.main()
