"""Data sets from strangers: whatever is in a file, the reader gives arrays or a DatasetError that names
the file, in a second of CPU time, in little memory, and opens nothing outside of the folder.
"""
import json
import os
import pathlib
import random
import shutil
import struct
import tempfile
import time
import tracemalloc
import unittest
import zlib

import numpy as np

import small_data
from ensonify_dataset import DatasetError, SequenceFolder, SonarDataset, decode_rle, read_exr, read_png
from ensonify_dataset.files import read_npy

MUTATIONS = int(os.environ.get("MUTATIONS", "100"))  # of each file
MOST_BYTES = 100_000_000
NUMBERS = (b"-1", b"0", b"4294967295", b"99999999999999999999", b"1e308", b"null", b'"../../x"', b"[]", b"{}")


def mutated(data, draw):
    """A byte, a stretch or a number of it is another; or something is gone or doubled."""
    data = bytearray(data)
    for _ in range(draw.choice((1, 1, 1, 2, 5))):
        at, size = draw.randrange(len(data)), draw.choice((1, 2, 4, 8, 40))
        kind = draw.randrange(6)
        if kind == 0:
            data[at] ^= 1 << draw.randrange(8)
        elif kind == 1:
            data[at : at + size] = draw.choice((b"\0", b"\xff", b"\x7f")) * size
        elif kind == 2:
            del data[at : at + size]
        elif kind == 3:
            data[at:at] = data[at : at + size]
        elif kind == 4 and len(data) > 100:
            del data[at:]
        else:
            data[at : at + draw.randrange(4)] = draw.choice(NUMBERS)
        if not data:
            break
    return bytes(data)


def read_tables(folder):
    data = SonarDataset(folder)
    data.split("train")
    ping = data[0]
    return ping.polar.annotations, ping.pose, ping.time_s, ping.object_poses


def read_arrays(folder):
    ping = SonarDataset(folder)[0]
    axes = ping.sequence.range_m, ping.sequence.azimuth_rad
    return ping.series, ping.first_return_m, *axes, ping.cartesian.level_db


class Folder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        cls.addClassCleanup(shutil.rmtree, cls.scratch, ignore_errors=True)
        cls.data = small_data.copied(cls.scratch / "data", "seabed_and_target", "--pings", "0:1")
        cls.sequence = cls.data / "sequences/000000"

    def refused_or_read(self, path, read):
        """Whether it was read. Any other exception than DatasetError is the test's failure."""
        tracemalloc.start()
        started = time.process_time()
        try:
            read()
            return True
        except DatasetError as told:
            self.assertIn(path.name, str(told))
            return False
        finally:
            took, (_, most) = time.process_time() - started, tracemalloc.get_traced_memory()
            tracemalloc.stop()
            self.assertLess(most, MOST_BYTES)
            self.assertLess(took, 20)  # CPU time: a loaded machine does not count


class Mutations(Folder):
    def bear(self, relative, read, refused_at_least):
        path = self.data / relative
        whole, draw, refused = path.read_bytes(), random.Random(relative), 0
        self.addCleanup(path.write_bytes, whole)
        for number in range(MUTATIONS):
            data = mutated(whole, draw)
            path.write_bytes(data)
            with self.subTest(file=relative, number=number):
                try:
                    refused += not self.refused_or_read(path, read)
                except IndexError:
                    # Of a ping or sequence that the manifest no longer lists.
                    self.assertIn(".json", relative)
                    refused += 1
        path.write_bytes(whole)
        self.assertTrue(self.refused_or_read(path, read))
        self.assertGreaterEqual(refused, refused_at_least)

    def test_files_of_a_data_set(self):
        for relative in ("dataset.json", "sequences/000000/sequence.json", "sequences/000000/annotations.jsonl",
                         "sequences/000000/poses.csv", "sequences/000000/objects.csv", "splits/train.txt"):
            # A digit more or less in a table is another number, and no fault that can be seen.
            self.bear(relative, lambda: read_tables(self.data), MUTATIONS // 15)

    def test_arrays(self):
        for relative in ("timeseries/000000.npy", "first_return_m.npy", "range_m.npy", "cartesian_map.npy"):
            path = self.sequence / relative
            whole = path.read_bytes()
            self.addCleanup(path.write_bytes, whole)
            draw, refused = random.Random(relative), 0
            for number in range(MUTATIONS):
                head = mutated(whole[:128], draw)
                path.write_bytes(head + whole[128:])
                with self.subTest(file=relative, number=number):
                    refused += not self.refused_or_read(path, lambda: read_arrays(self.data))
            path.write_bytes(whole)
            self.assertGreaterEqual(refused, MUTATIONS // 2)

    def test_pictures(self):
        self.bear("sequences/000000/polar/000000.exr",
                  lambda: [read_exr(self.sequence / "polar/000000.exr", part) for part in (0, 1)], MUTATIONS // 5)
        self.bear("sequences/000000/polar/000000_instance.png",
                  lambda: read_png(self.sequence / "polar/000000_instance.png"), MUTATIONS // 5)


class MadeToHurt(Folder):
    """What no mutation is likely to find."""

    def test_names_that_leave_the_folder(self):
        """The numbers of sequences and pings become names of folders and files."""
        outside = self.scratch / "outside"
        shutil.copytree(self.sequence, outside)
        copy = self.scratch / "copy"
        shutil.copytree(self.data, copy)
        manifest = json.loads((copy / "dataset.json").read_text())
        for number in ("../../outside", str(outside), "000000", -1, 0.0, True, None):
            manifest["sequences"][0]["sequence"] = number
            (copy / "dataset.json").write_text(json.dumps(manifest))
            with self.subTest(number=number):
                with self.assertRaisesRegex(DatasetError, "dataset.json: cannot be read"):
                    SonarDataset(copy)
        for pings in ([0, 10**30], [5, 1], ["0", "1"], [0], 7, [-3, 1]):
            manifest["sequences"][0].update({"sequence": 0, "pings": pings})
            (copy / "dataset.json").write_text(json.dumps(manifest))
            with self.subTest(pings=pings):
                with self.assertRaisesRegex(DatasetError, "dataset.json: cannot be read"):
                    SonarDataset(copy)

    def test_a_list_of_a_trillion_pings_takes_no_memory(self):
        copy = self.scratch / "trillion"
        shutil.copytree(self.data, copy)
        manifest = json.loads((copy / "dataset.json").read_text())
        manifest["sequences"][0]["pings"] = [0, 10**12]
        (copy / "dataset.json").write_text(json.dumps(manifest))
        self.assertTrue(self.refused_or_read(copy, lambda: SonarDataset(copy)))
        self.assertEqual(len(SonarDataset(copy)), 10**12)

    def png(self, width, height, rows):
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        head = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
        path = self.scratch / "bomb.png"
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows))
                         + chunk(b"IEND", b""))
        return path

    def test_pictures_that_claim_or_unfold_to_more_than_they_are(self):
        for width, height, rows in ((2_000_000_000, 2_000_000_000, b"\0"), (4, 4, bytes(200_000_000)), (0, 4, b"")):
            path = self.png(width, height, rows)
            with self.subTest(width=width):
                self.assertRaisesRegex(DatasetError, "bomb.png: cannot be read", read_png, path)
                self.assertFalse(self.refused_or_read(path, lambda: read_png(path)))
        whole = (self.sequence / "polar/000000.exr").read_bytes()
        path = self.scratch / "bomb.exr"
        window = whole.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
        for corner in ((2**31 - 1, 2**31 - 1), (-5, 3), (2**31 - 1, 0)):
            path.write_bytes(whole[: window + 8] + struct.pack("<ii", *corner) + whole[window + 16 :])
            with self.subTest(corner=corner):
                self.assertFalse(self.refused_or_read(path, lambda: read_exr(path)))

    def test_a_header_without_end(self):
        """Sizes that lead back to where the header began."""
        path = self.scratch / "loop.exr"
        path.write_bytes(struct.pack("<iI", 20000630, 2) + b"a\0b\0" + struct.pack("<i", -8) + bytes(400))
        self.assertFalse(self.refused_or_read(path, lambda: read_exr(path)))

    def test_an_archive_in_place_of_an_array(self):
        path = self.sequence / "range_m.npy"
        whole = path.read_bytes()
        self.addCleanup(path.write_bytes, whole)
        np.savez(self.scratch / "a.npz", whole=np.zeros(3))
        path.write_bytes((self.scratch / "a.npz").read_bytes())
        self.assertFalse(self.refused_or_read(path, lambda: SequenceFolder(self.sequence).range_m))

    def test_an_array_whose_header_claims_gigabytes(self):
        path = self.scratch / "head.npy"
        for version in (b"\2", b"\3"):
            path.write_bytes(b"\x93NUMPY" + version + b"\0" + struct.pack("<I", 4_000_000_000) + b"{" * 200)
            self.assertFalse(self.refused_or_read(path, lambda: read_npy(path)))

    def test_run_lengths_of_other_sizes(self):
        def encode(runs):
            """COCO's letters, by their definition."""
            text = ""
            for i, run in enumerate(runs):
                value = run - runs[i - 2] if i > 2 else run
                more = True
                while more:
                    bits, value = value & 31, value >> 5
                    more = value != (-1 if bits & 16 else 0)
                    text += chr((bits | 32 if more else bits) + 48)
            return text

        np.testing.assert_array_equal(decode_rle(encode([2, 3, 1]), 2, 3), [[0, 1, 1], [0, 1, 0]])
        for runs, height, width in (([2, 3], 2, 3), ([2, 3, 2], 2, 3), ([8, -2], 2, 3), ([10**17], 10**9, 10**8),
                                    ([], 2, 3), ([6], -2, -3)):
            with self.subTest(runs=runs):
                self.assertRaises(ValueError, decode_rle, encode(runs), height, width)
        self.assertRaises(ValueError, decode_rle, "o" * 1_000_000, 2, 3)


if __name__ == "__main__":
    unittest.main()
