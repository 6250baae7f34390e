"""ply: every point against the scatterer that it comes from, by a parser of this file."""
import unittest

import numpy as np

import exported

TYPES = {"double": "<f8", "float": "<f4", "uint": "<u4", "uchar": "u1"}


def read_ply(path):
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    lines = data[:end].decode("ascii").splitlines()
    assert lines[0] == "ply" and lines[1] == "format binary_little_endian 1.0", lines[:2]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    fields = [(line.split()[2], TYPES[line.split()[1]]) for line in lines if line.startswith("property")]
    points = np.frombuffer(data[end:], np.dtype(fields))
    assert len(points) == count, (len(points), count)
    return points


class Ply(exported.Case):
    format_name = "ply"
    scatterers = ("--export-scatterers",)

    def test_the_same_data_set_gives_the_same_bytes(self):
        source = exported.dataset(*self.scatterers)
        self.assertEqual(exported.hashes(exported.export("ply", source=source)),
                         exported.hashes(exported.export("ply", source=source)))

    def test_every_point(self):
        source = exported.dataset(*self.scatterers)
        out = exported.export("ply", source=source)
        seen = set()
        for sequence in exported.sequences(source):
            class_of = np.array([0] + [i["class_id"] for i in sequence.head["instances"]])
            for ping in sequence.pings:
                points = read_ply(out / f"{sequence.number:06}/{ping:06}.ply")
                echoes = sequence.npy(f"scatterers/{ping:06}.npy")
                self.assertGreater(len(echoes), 100)
                for axis in "xyz":
                    np.testing.assert_array_equal(points[axis], echoes[axis])
                np.testing.assert_array_equal(points["instance"], echoes["instance"])
                np.testing.assert_array_equal(points["class"], class_of[echoes["instance"]])
                amplitude = echoes["amp_re"].astype(float) + 1j * echoes["amp_im"]
                np.testing.assert_allclose(points["intensity"],
                                           np.abs(amplitude * echoes["gain"].astype(float)) ** 2, rtol=1e-6)
                seen |= set(points["instance"])
        self.assertEqual(seen, {1, 2, 3})


if __name__ == "__main__":
    unittest.main()
