"""The reader against independent readers of the same files: every scene, every array, every table."""
import json
import pathlib
import pickle
import shutil
import struct
import tempfile
import unittest
import zlib

import numpy as np

import small_data
import sonar_dataset as independent
from physics import trigonometric_sums
from ensonify_dataset import DatasetError, ElevationEchoes, SequenceFolder, SonarDataset, read_exr, read_png
from ensonify_dataset.views import PLANES


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)


def quaternion_product(a, b):
    w, v = a[0] * b[0] - np.dot(a[1:], b[1:]), a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([w, *v])


class SceneFiles(Folder):
    """What the reader gives of a scene is what lies in its files."""

    def same(self, ours, theirs, kind):
        self.assertEqual(ours.dtype, kind)
        np.testing.assert_array_equal(ours, theirs)

    def pictures_are_those_of_the_files(self, view, folder, stem):
        level, labels = independent.read_exr(folder / view.kind / f"{stem}.exr")
        self.same(view.level_db, level.channels["Y"], np.float32)
        self.assertIn("clean_db", labels.channels)
        for name, channel in labels.channels.items():
            self.same(getattr(view, name), channel, np.float32)
        for name in ("instance", "semantic", "shadow", "multipath", "artifact"):
            path = folder / view.kind / f"{stem}_{name}.png"
            self.assertEqual(view.has(name), path.exists())
            if view.has(name):
                self.same(getattr(view, name), independent.read_png(path), np.int32)
        self.same(view.grey, independent.read_png(folder / "png" / f"{stem}_{view.kind}.png"), np.uint8)

    def masks_are_those_of_the_pictures(self, view):
        self.assertEqual([a.instance for a in view.annotations], sorted(set(np.unique(view.instance)) - {0}))
        for a in view.annotations:
            np.testing.assert_array_equal(a.mask, view.instance == a.instance)
            self.assertEqual(a.area, a.mask.sum())
            self.assertEqual({a.class_id}, set(np.unique(view.semantic[a.mask])))

    def tables_are_those_of_the_files(self, ping, folder):
        header, rows = independent.read_csv(folder / "poses.csv")
        row = dict(zip(header, map(float, rows[ping.row])))
        self.assertEqual(row["ping"], ping.number)
        self.assertEqual(ping.time_s, row["time_s"])
        self.assertEqual(list(ping.pose.position_m), [row[k] for k in "xyz"])
        turned = quaternion_product(quaternion_product(ping.pose.quaternion_wxyz, np.array([0, 1., 2, 3])),
                                    ping.pose.quaternion_wxyz * [1, -1, -1, -1])[1:]
        np.testing.assert_allclose(ping.pose.rotation @ [1, 2, 3], turned, atol=1e-12)
        header, rows = independent.read_csv(folder / "objects.csv")
        poses = {int(r[1]): list(map(float, r[2:])) for r in rows if int(r[0]) == ping.number}
        self.assertEqual({k: [*p.position_m, *p.quaternion_wxyz] for k, p in ping.object_poses.items()}, poses)
        returns = independent.read_npy(folder / "first_return_m.npy")
        np.testing.assert_array_equal(ping.first_return_m, returns[ping.row])

    def compare(self, scenes):
        for scene in scenes:
            with self.subTest(scene):
                data = SonarDataset(small_data.generate(scene, self.folder / scene, "--sequences", "0:1",
                                                        "--pings", "1:2", "--set", "output.cartesian.exr=true"))
                self.assertEqual(data.index, [(0, 1)])
                ping, folder = data[0], self.folder / scene / "sequences/000000"
                if not ping.sequence.info["each_ping"]:
                    self.tables_are_those_of_the_files(ping, folder)
                    continue  # statistics_test.py reads what it has
                if (folder / "timeseries").is_dir():
                    self.same(ping.series, independent.read_npy(folder / "timeseries/000001.npy"), np.complex64)
                self.same(ping.sequence.azimuth_rad, independent.read_npy(folder / "azimuth_rad.npy"), float)
                self.same(ping.sequence.range_m, independent.read_npy(folder / "range_m.npy"), float)
                self.tables_are_those_of_the_files(ping, folder)
                for view in (ping.polar, ping.cartesian):
                    self.pictures_are_those_of_the_files(view, folder, "000001")
                    self.masks_are_those_of_the_pictures(view)


class Scenes(SceneFiles):
    def test_a_scene_of_each_kind(self):
        self.compare(small_data.KINDS)


class Forms(Folder):
    """Other ways to write the same pings give the same arrays."""

    NAMES = ("level_db", "instance", "semantic", "grey")

    def compare(self, *settings, scene="seabed_and_target"):
        changes = [part for setting in settings for part in ("--set", setting)]
        plain = SonarDataset(small_data.shared(scene, "--pings", "1:3"))
        other = SonarDataset(small_data.shared(scene, "--pings", "1:3", *changes))
        self.assertEqual(plain.index, other.index)
        names = [*self.NAMES, *read_exr(plain.folder / "sequences/000000/polar/000001.exr", 1)]
        self.assertIn("clean_db", names)
        for a, b in zip(plain, other):
            np.testing.assert_array_equal(a.series, b.series)
            self.assertEqual(b.series.dtype, np.complex64)
            np.testing.assert_array_equal(a.sequence.cartesian_map, b.sequence.cartesian_map)
            for ours, theirs in ((a.polar, b.polar), (a.cartesian, b.cartesian)):
                for name in ("shadow", "multipath"):
                    self.assertEqual(ours.has(name), theirs.has(name))
                for name in names + [n for n in ("shadow", "multipath") if ours.has(n)]:
                    np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name), name)
                    self.assertEqual(getattr(ours, name).dtype, getattr(theirs, name).dtype)
                self.assertEqual([x.bbox for x in ours.annotations], [x.bbox for x in theirs.annotations])
        return plain, other

    def test_packed_by_sequence(self):
        self.compare("output.one_file_per=sequence")

    def test_series_as_exr(self):
        self.compare("output.timeseries=exr")

    def test_cartesian_float_planes_of_files_and_through_the_map(self):
        """Of scenes with noise, shadows and multipath: the map gives what the EXR files hold."""
        seen = set()
        for scene in ("seabed_and_target", "shallow_water"):
            plain, other = self.compare("output.cartesian.exr=true", scene=scene)
            files = [list((data.folder / "sequences/000000").glob("cartesian/*.exr")) for data in (plain, other)]
            self.assertEqual([len(found) for found in files], [0, 2])
            view, inside = plain[0].cartesian, plain[0].sequence.cartesian_map >= 0
            self.assertTrue(0 < inside.sum() < inside.size)
            self.assertIsNotNone(plain[0].sequence.info["noise"])
            silent = inside & np.isnan(view.elevation_rad)
            self.assertTrue(0 < silent.sum() < inside.sum())
            seen |= {name for name in ("instance", "shadow", "multipath") if view.has(name) and getattr(view, name).any()}
        self.assertEqual(seen, {"instance", "shadow", "multipath"})

    def test_cartesian_float_planes_of_arrays_and_through_the_map(self):
        self.compare("output.cartesian.exr=true", "output.one_file_per=sequence", scene="shallow_water")

    SURFACES = [name for name, row in PLANES.items() if row["group"] == "surfaces"]

    # Three tests read these, as files of their own and packed.
    RICH = ("output.surfaces=true", "output.front=true", "output.elevation={step_deg: 0.4, volumes: true}")

    def packed(self):
        settings = (*self.RICH, "output.one_file_per=sequence", "output.cartesian.exr=true")
        return SonarDataset(small_data.shared("seabed_and_target", "--pings", "1:3",
                                              *(part for setting in settings for part in ("--set", setting))))

    def test_surfaces_of_files_of_arrays_and_through_the_map(self):
        plain, files = self.compare(*self.RICH)
        self.assertFalse(plain[0].polar.has("surface_count"))
        self.assertRaisesRegex(DatasetError, "surfaces.exr", lambda: plain[0].polar.surface_count)
        packed, polar = self.packed(), files[0].polar
        stored, = independent.read_exr(files.folder / "sequences/000000/polar/000001_surfaces.exr")
        self.assertEqual(sorted(stored.channels), sorted(self.SURFACES))
        for view, other in ((polar, packed[0].polar), (files[0].cartesian, packed[0].cartesian)):
            for name in self.SURFACES:
                self.assertTrue(view.has(name) and other.has(name))
                np.testing.assert_array_equal(getattr(view, name), getattr(other, name), name)
                self.assertEqual(getattr(view, name).dtype, np.float32)
            np.testing.assert_array_equal(view.second_instance, other.second_instance)
            self.assertEqual(view.second_instance.dtype, np.int32)
        for name, channel in stored.channels.items():
            np.testing.assert_array_equal(getattr(polar, name), channel, name)
        self.assertTrue(((polar.second_instance > 0) == (polar.second_fraction > 0)).all())
        self.assertTrue((polar.layover_count >= polar.surface_count).all())
        self.assertGreater((polar.layover_count > polar.surface_count).sum(), 10)
        has = polar.surface_count > 0
        np.testing.assert_array_equal(has, polar.instance > 0)
        np.testing.assert_array_equal(has, np.isfinite(polar.surface_range_m))
        # The reference has no normal, being a point.
        normal = polar.surface_normal[has & (polar.instance != 4)]
        np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1, atol=5e-4)

    def test_echoes_over_elevation(self):
        """The operator against the sum of docs/dataset.md term by term, and against clean_db, which is stored to half
        of 1/8 dB."""
        plain, some = self.compare(*self.RICH)
        self.assertRaisesRegex(DatasetError, "npy: is not there", lambda: plain[0].elevation)
        self.assertRaisesRegex(DatasetError, "npy: is not there", lambda: plain[0].sequence.power_spread)
        ping = some[0]
        echoes, shape = ping.elevation, ping.polar.level_db.shape
        rows = np.load(ping.sequence.folder / "elevation" / f"{ping.stem}.npy")
        np.testing.assert_array_equal(echoes.rows, rows)
        self.assertAlmostEqual(echoes.step_rad, np.radians(0.4))
        power = echoes.expected_power()
        self.assertEqual(power.shape, shape)
        beam_power, pulse_power = ping.sequence.power_spread
        period, sample = len(pulse_power), shape[0] // 2
        cells = np.zeros(shape[1])
        for cell in range(shape[1]):
            mine = echoes[echoes.beam == cell]
            cycles = (mine.sample + mine.offset.astype(float)) / period
            a = pulse_power * trigonometric_sums(mine.diffuse_pa2.astype(float), cycles, period)
            a[1:] *= 2
            cells[cell] = (a * np.exp(2j * np.pi * np.arange(period) / period * sample)).real.sum()
        np.testing.assert_allclose(power[sample], beam_power @ cells, atol=1e-6 * power.max())
        dense, elevation = echoes.dense()
        last = round(np.ceil(ping.sequence.info["sonar"]["elevation"]["fan_rad"] / 2 / echoes.step_rad - 1e-6))
        inside = (rows["sample"] >= 0) & (rows["sample"] < shape[0]) & (rows["step"] >= -last) & (rows["step"] < last)
        self.assertEqual(dense.shape, (*shape, 2 * last))
        self.assertAlmostEqual(elevation[0], (0.5 - last) * echoes.step_rad)
        sums = {}
        for row in rows[inside]:
            cell = sums.setdefault((row["sample"], row["beam"], row["step"] + last), [0.0, 0j])
            cell[0] += row["diffuse_pa2"]
            cell[1] += row["coherent_pa"]
        self.assertEqual((dense > 0).sum(), len(sums))
        for cell, (diffuse, pressure) in list(sums.items())[::97]:
            np.testing.assert_allclose(dense[cell], diffuse + abs(pressure) ** 2, rtol=1e-4)
        np.testing.assert_array_equal(echoes.dense(range(-2, 3))[0], dense[..., last - 2:last + 3])
        fixed = rows.copy()
        fixed["diffuse_pa2"] = np.abs(rows["coherent_pa"]) ** 2
        random = (power > 1e-4 * power.max()) & (ElevationEchoes(ping.sequence, fixed).expected_power() < 1e-5 * power)
        self.assertGreater(random.sum(), 1000)
        difference = 10 * np.log10(power[random]) + 120 - ping.polar.clean_db[random]
        self.assertLess(np.abs(difference).max(), 0.07)

    def test_front_views_of_files_and_of_arrays(self):
        """Against the files themselves, and points against the surfaces that the scene has."""
        plain, files = self.compare(*self.RICH)
        self.assertFalse(plain[0].front.has("range_m"))
        self.assertRaisesRegex(DatasetError, "exr: is not there", lambda: plain[0].front.range_m)
        front, other = files[0].front, self.packed()[0].front
        folder = files.folder / "sequences/000000"
        stored, = independent.read_exr(folder / "front/000001.exr")
        self.assertEqual(sorted(stored.channels), ["backscatter_db", "normal_x", "normal_y", "normal_z", "range_m"])
        np.testing.assert_array_equal(front.range_m, stored.channels["range_m"])
        np.testing.assert_array_equal(front.normal[..., 2], stored.channels["normal_z"])
        for name in ("range_m", "normal", "backscatter_db", "instance", "semantic", "position_m"):
            self.assertTrue(front.has(name) and other.has(name), name)
            np.testing.assert_array_equal(getattr(front, name), getattr(other, name), name)
        np.testing.assert_array_equal(front.elevation_rad, np.load(folder / "front_elevation_rad.npy"))
        np.testing.assert_array_equal(front.azimuth_rad, np.load(folder / "front_azimuth_rad.npy"))
        self.assertTrue((np.diff(front.elevation_rad) > 0).all() and (np.diff(front.azimuth_rad) > 0).all())
        self.assertEqual(front.range_m.shape, (len(front.elevation_rad), len(front.azimuth_rad)))
        met = front.instance > 0
        self.assertTrue(met.any())
        np.testing.assert_array_equal(met, np.isfinite(front.range_m))
        np.testing.assert_array_equal(met, front.semantic > 0)
        facing = (front.normal * front.position_m).sum(axis=-1)[met]
        self.assertTrue((facing <= 1e-3).all())

    def test_annotations_have_truncated_and_contrast(self):
        ping = SonarDataset(small_data.shared("seabed_and_target", "--pings", "0:1"))[0]
        for view in (ping.polar, ping.cartesian):
            named = {a.name: a for a in view.annotations}
            self.assertEqual(named["sphere"].truncated, 0)
            self.assertTrue(0 < named["seabed"].truncated < 1)
            self.assertIsNone(named["seabed"].contrast_db)
            self.assertTrue(3 < named["sphere"].contrast_db < 30)

    def test_without_polar_images_there_are_no_cartesian_float_planes(self):
        data = SonarDataset(small_data.generate("sonar_tank", self.folder / "masks", "--pings", "0:1",
                                                "--set", "output.polar=false"))
        view = data[0].cartesian
        self.assertTrue(view.has("instance") and view.has("grey"))
        self.assertFalse(view.has("level_db"))
        self.assertRaisesRegex(DatasetError, "is not there", lambda: view.level_db)

    def test_a_map_of_another_image_is_an_error(self):
        data = SonarDataset(small_data.copied(self.folder / "tank", "sonar_tank", "--pings", "0:1"))
        path = self.folder / "tank/sequences/000000/cartesian_map.npy"
        np.save(path, data[0].sequence.cartesian_map + 10**8)
        again = SonarDataset(self.folder / "tank")
        self.assertRaisesRegex(DatasetError, "cartesian_map.npy: cannot be read", lambda: again[0].cartesian.level_db)


class Lists(Folder):
    """Indexing, splits, laziness, and what is said where something is wrong."""

    def setUp(self):
        super().setUp()
        self.data = SonarDataset(small_data.copied(
            self.folder / "debris", "random_debris", "--set", "sequences=8", "--set", "trajectory.pings=2"))

    def test_items_are_pings_in_order(self):
        self.assertEqual(len(self.data), 16)
        self.assertEqual([(p.sequence.folder.name, p.number) for p in self.data],
                         [(f"{s:06}", p) for s in range(8) for p in range(2)])
        np.testing.assert_array_equal(self.data[7].polar.level_db, self.data[3, 1].polar.level_db)
        for wrong in (16, (3, 2), (8, 0)):
            with self.assertRaises(IndexError):
                self.data[wrong]

    def test_splits_are_those_of_the_manifest_and_share_no_sequence(self):
        listed = json.loads((self.folder / "debris/dataset.json").read_text())["splits"]
        found = {name: self.data.split(name) for name in ("train", "val", "test")}
        self.assertEqual({name: part.sequences for name, part in found.items()}, listed)
        self.assertEqual(sorted(sum((part.index for part in found.values()), [])), self.data.index)
        self.assertRaisesRegex(DatasetError, "train, val, test", self.data.split, "training")

    def test_nothing_is_read_before_it_is_asked_for(self):
        """With pictures and tables gone what does not need them is still there."""
        sequence = self.folder / "debris/sequences/000002"
        for gone in ("polar/000000.exr", "polar/000001_instance.png", "poses.csv", "annotations.jsonl"):
            (sequence / gone).unlink()
        ping = self.data[2, 0]
        self.assertIsInstance(ping.series, np.memmap)
        self.assertEqual(ping.polar.instance.shape, (319, 32))
        self.assertRaisesRegex(DatasetError, "000000.exr: is not there", lambda: ping.polar.level_db)
        self.assertRaisesRegex(DatasetError, "verify", lambda: ping.pose)

    def test_a_part_of_an_exr_is_read_without_the_others(self):
        path = self.folder / "debris/sequences/000000/polar/000000.exr"
        intact = self.data[0].polar.level_db
        data = path.read_bytes()
        path.write_bytes(data[: len(data) - 40])
        np.testing.assert_array_equal(self.data[0].polar.level_db, intact)
        self.assertRaisesRegex(DatasetError, "cannot be read", lambda: self.data[0].polar.clean_db)

    def test_it_travels_to_other_processes(self):
        ping = self.data[3]
        ping.polar.level_db
        again = pickle.loads(pickle.dumps(self.data))
        np.testing.assert_array_equal(again[3].polar.level_db, ping.polar.level_db)

    def test_unfinished_folders_and_other_versions_are_refused(self):
        folder = self.folder / "debris"
        self.assertRaisesRegex(DatasetError, "one sequence", SonarDataset, folder / "sequences/000000")
        self.assertRaisesRegex(DatasetError, "no data set", SonarDataset, self.folder)
        manifest = folder / "sequences/000000/sequence.json"
        manifest.write_text(manifest.read_text().replace('"ensonify_sequence": 1', '"ensonify_sequence": 2'))
        self.assertRaisesRegex(DatasetError, "is 2, .* knows version 1", lambda: self.data[0])
        manifest = folder / "dataset.json"
        text = manifest.read_text()
        manifest.write_text(text.replace('"ensonify_dataset": 1', '"ensonify_dataset": 7'))
        self.assertRaisesRegex(DatasetError, "is 7, .* knows version 1", SonarDataset, folder)
        manifest.write_text(text[:100])
        self.assertRaisesRegex(DatasetError, "no JSON", SonarDataset, folder)
        (folder / "dataset.sha256").unlink()
        self.assertRaisesRegex(DatasetError, "not finished.*same", SonarDataset, folder)

    def test_the_data_card_says_how(self):
        card = (self.folder / "debris/README.md").read_text()
        code = card.split("```python\n")[1].split("```")[0].replace('"."', "FOLDER")
        found = {"FOLDER": self.folder / "debris"}
        exec(code, found)
        last = self.data.split("train")[-1]
        np.testing.assert_array_equal(found["level_db"], last.polar.level_db)
        np.testing.assert_array_equal(found["mask"], last.polar.instance)
        np.testing.assert_array_equal(found["series"], last.series)

    def test_a_sequence_alone(self):
        alone = SequenceFolder(self.folder / "debris/sequences/000005")
        self.assertEqual(len(alone), 2)
        np.testing.assert_array_equal(alone[1].series, self.data[5, 1].series)


def png_bytes(pixels, kinds):
    """A grey PNG whose row y has filter kinds[y]; filters by the definition, byte by byte."""
    raw = pixels.astype(">u2" if pixels.dtype == np.uint16 else np.uint8).view(np.uint8).reshape(len(pixels), -1)
    step, out = pixels.dtype.itemsize, b""
    for y, kind in enumerate(kinds):
        out += bytes([kind])
        for x in range(raw.shape[1]):
            a = int(raw[y, x - step]) if x >= step else 0
            b = int(raw[y - 1, x]) if y else 0
            c = int(raw[y - 1, x - step]) if y and x >= step else 0
            pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
            paeth = a if pa <= pb and pa <= pc else b if pb <= pc else c
            out += bytes([(int(raw[y, x]) - (0, a, b, (a + b) // 2, paeth)[kind]) & 255])
    head = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8 * step, 0, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(out)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks)


class Files(Folder):
    """Files as other programs pack them."""

    def test_every_png_filter(self):
        pixels = np.random.default_rng(3).integers(0, 65536, (25, 9)).astype(np.uint16)
        pixels[::3] = 700
        for kind in (np.uint8, np.uint16):
            path = self.folder / "a.png"
            path.write_bytes(png_bytes(pixels.astype(kind), [0, 1, 2, 3, 4, 4, 3, 2, 1, 1] * 2 + [4] * 5))
            np.testing.assert_array_equal(read_png(path), pixels.astype(kind))
            self.assertEqual(read_png(path).dtype, kind)

    def test_broken_files_are_named(self):
        path = self.folder / "a.png"
        whole = png_bytes(np.full((4, 4), 9, np.uint8), [0] * 4)
        for wrong in (b"", b"GIF89a", whole[:40], whole[:-30]):
            path.write_bytes(wrong)
            self.assertRaisesRegex(DatasetError, "a.png: cannot be read", read_png, path)
            self.assertRaisesRegex(DatasetError, "a.png: cannot be read", read_exr, path)


if __name__ == "__main__":
    unittest.main()
