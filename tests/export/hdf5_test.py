"""hdf5: every array by h5py against the files of the data set, value by value."""
import time
import unittest

import h5py
import numpy as np

import exported
from exported import run, scratch
from sonar_dataset import read_exr


def expected_arrays(sequence, ping):
    """{name: array} of one ping, from the data set's own files."""
    row = ping - sequence.pings[0]
    pose = sequence.pose(ping)
    objects = np.full((len(sequence.head["instances"]), 7), np.nan)
    for line in sequence.objects:
        if int(line["ping"]) == ping:
            objects[int(line["instance"]) - 1] = [float(line[k]) for k in ("x", "y", "z", "qw", "qx", "qy", "qz")]
    arrays = {
        "sequence": sequence.number, "ping": ping, "time_s": float(sequence.poses[ping]["time_s"]),
        "sonar_position_m": pose[:3], "sonar_quaternion_wxyz": pose[3:],
        "object_position_m": objects[:, :3], "object_quaternion_wxyz": objects[:, 3:],
        "first_return_m": sequence.npy("first_return_m.npy")[row],
        "timeseries": sequence.npy(f"timeseries/{ping:06}.npy"),
    }
    level, labels = read_exr(sequence.folder / f"polar/{ping:06}.exr")
    seen_from = sequence.npy("cartesian_map.npy")
    for name, channel in {"level_db": level.channels["Y"], **labels.channels}.items():
        outside = channel.dtype.type(-99 if name.endswith("_db") else np.nan if name.endswith("_rad") else 0)
        arrays[f"polar/{name}"] = channel
        arrays[f"cartesian/{name}"] = np.where(seen_from < 0, outside, channel.ravel()[seen_from])
    for view in ("polar", "cartesian"):
        arrays[f"{view}/instance"] = sequence.png(view, ping, "_instance")
        arrays[f"{view}/semantic"] = sequence.png(view, ping, "_semantic")
        arrays[f"{view}/shadow"] = sequence.png(view, ping, "_shadow")
        arrays[f"{view}/grey"] = sequence.png("png", ping, f"_{view}")
    return {name: np.asarray(array) for name, array in arrays.items()}


TYPES = {"sequence": "<u4", "ping": "<u4", "first_return_m": "<f4", "timeseries": "<c8"}


def type_of(name):
    last = name.split("/")[-1]
    if last in ("semantic", "grey"):
        return "u1"
    if last in ("instance", "shadow"):
        return "<u2"
    return "<f2" if "/" in name else TYPES.get(name, "<f8")


class Apart(exported.Case):
    format_name = "hdf5"

    @classmethod
    def setUpClass(cls):
        cls.file = h5py.File(exported.export("hdf5"), "r")

    @classmethod
    def tearDownClass(cls):
        cls.file.close()

    def test_every_array(self):
        sizes = set()
        for sequence in exported.sequences():
            group = self.file[f"sequences/{sequence.number:06}"]
            for row, ping in enumerate(sequence.pings):
                arrays = expected_arrays(sequence, ping)
                self.assertIn("polar/clean_db", arrays)
                for view in ("polar", "cartesian"):
                    self.assertEqual({f"{view}/{name}" for name in group[view]},
                                     {name for name in arrays if name.startswith(f"{view}/")})
                for name, expected in arrays.items():
                    with self.subTest(name=name, ping=ping):
                        self.assertEqual(group[name].dtype, np.dtype(type_of(name)))
                        self.assertEqual(group[name].shape, (len(sequence.pings), *expected.shape))
                        np.testing.assert_array_equal(group[name][row], expected)
            sizes.add(group["timeseries"].shape)
        self.assertEqual(len(sizes), 2, "the sequences should differ in shape")

    def test_cartesian_planes_are_those_of_the_exr_files(self):
        with_exr = exported.dataset("--set", "output.cartesian.exr=true")
        sequence = next(iter(exported.sequences(with_exr)))
        level, labels = read_exr(sequence.folder / f"cartesian/{sequence.pings[0]:06}.exr")
        with h5py.File(exported.export("hdf5", source=with_exr), "r") as file:
            for name, channel in {"level_db": level.channels["Y"], **labels.channels}.items():
                for source in (file, self.file):
                    stored = source[f"sequences/{sequence.number:06}/cartesian/{name}"][0]
                    self.assertEqual(stored.tobytes(), channel.tobytes(), name)

    def test_without_polar_images_there_are_ids_and_grey(self):
        source = exported.dataset("--set", "output.polar=false")
        with h5py.File(exported.export("hdf5", source=source), "r") as file:
            self.assertEqual(set(file["sequences/000000/cartesian"]), {"instance", "semantic", "shadow", "grey"})

    def test_chunks_hold_one_ping(self):
        def look(name, item):
            if isinstance(item, h5py.Dataset) and item.ndim > 1:
                self.assertEqual(item.chunks, (1, *item.shape[1:]), name)

        self.file.visititems(look)

    def test_no_times_are_written(self):
        """HDF5 counts times in seconds: two exports in different seconds have the same bytes."""
        first = exported.hashes(exported.export("hdf5"))
        time.sleep(1.1)
        self.assertEqual(exported.hashes(exported.export("hdf5")), first)

    def test_axes_and_units(self):
        for sequence in exported.sequences():
            group = self.file[f"sequences/{sequence.number:06}"]
            for name in ("azimuth_rad", "range_m"):
                np.testing.assert_array_equal(group[name], sequence.npy(f"{name}.npy"))
            series = group["timeseries"]
            np.testing.assert_array_equal(series.dims[1][0], group["azimuth_rad"])
            np.testing.assert_array_equal(series.dims[2][0], group["range_m"])
            np.testing.assert_array_equal(group["polar/level_db"].dims[1][0], group["range_m"])
            self.assertEqual(series.attrs["units"], b"Pa (rms)")
            self.assertEqual(group["range_m"].attrs["units"], b"m")
            head = sequence.head
            self.assertEqual(group.attrs["split"].decode(), sequence.split)
            self.assertEqual(group.attrs["seed"], head["seed"])
            self.assertEqual(group.attrs["frequency_hz"], head["sonar"]["frequency_hz"])
            self.assertEqual(group.attrs["sound_speed_m_s"], head["water"]["sound_speed_m_s"])
            self.assertEqual(group.attrs["cartesian_metres_per_pixel"], head["cartesian"]["metres_per_pixel"])
            self.assertEqual([n.decode() for n in group["instance_name"]], [i["name"] for i in head["instances"]])
            self.assertEqual(list(group["instance_class_id"]), [i["class_id"] for i in head["instances"]])
        self.assertEqual([n.decode() for n in self.file["classes"]], ["room", "ball & net", "pole"])


class Stacked(exported.Case):
    format_name = "hdf5"
    options = ("--stack", "--pad")

    def test_mixed_shapes_are_refused_with_advice(self):
        out = scratch() / "out.h5"
        result = run("export", exported.dataset(), "--format", "hdf5", "--stack", "-o", out)
        self.assertEqual(result.returncode, 2)
        self.assertIn("200 samples", result.stderr)
        self.assertIn("160 samples", result.stderr)
        self.assertIn("--pad", result.stderr)
        self.assertEqual(list(out.parent.iterdir()), [])

    def test_equal_shapes_need_no_padding(self):
        source = exported.dataset("--set", "sonar.range_max_m=4")
        with h5py.File(exported.export("hdf5", "--stack", source=source), "r") as file:
            row = 0
            for sequence in exported.sequences(source):
                for ping in sequence.pings:
                    np.testing.assert_array_equal(file["timeseries"][row],
                                                  sequence.npy(f"timeseries/{ping:06}.npy"))
                    row += 1
            self.assertEqual(file["timeseries"].shape[0], row)

    def test_every_array_and_what_pads_it(self):
        padded = 0
        with h5py.File(exported.export("hdf5", *self.options), "r") as file:
            row = 0
            for sequence in exported.sequences():
                for ping in sequence.pings:
                    for name, expected in expected_arrays(sequence, ping).items():
                        found = file[name][row]
                        self.assertEqual(file[name].dtype, np.dtype(type_of(name)))
                        inside = tuple(slice(0, n) for n in expected.shape)
                        np.testing.assert_array_equal(found[inside], expected, name)
                        rest = np.ones(found.shape, bool)
                        rest[inside] = False
                        last = name.split("/")[-1]
                        fill = -99 if last.endswith("_db") else 0
                        if last.endswith("_rad") or last == "first_return_m":
                            fill = np.nan
                        np.testing.assert_array_equal(found[rest], np.full(rest.sum(), fill, found.dtype))
                        padded += rest.sum()
                    row += 1
                axes = file[f"sequences/{sequence.number:06}"]
                np.testing.assert_array_equal(axes["range_m"], sequence.npy("range_m.npy"))
            self.assertEqual(len(file["time_s"]), row)
        self.assertGreater(padded, 0, "nothing was padded")


if __name__ == "__main__":
    unittest.main()
