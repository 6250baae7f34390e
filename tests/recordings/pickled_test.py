"""`ensonify import` of sets of neusis, HoloOcean and SonarSplat, with pickles of NumPy and by hand."""
import json
import os
import pickle
import struct
import unittest

import numpy as np

from cases import RANDOM, Case, SonarDataset, ensonify

CONFIG = {"agents": [{"sensors": [
    {"sensor_type": "PoseSensor", "Hz": 3},
    {"sensor_type": "ImagingSonar", "Hz": 4, "configuration": {
        "Azimuth": 60, "Elevation": 14, "RangeMin": 0.5, "RangeMax": 3.5, "RangeBins": 30, "AzimuthBins": 24}}]}]}


def pose(yaw, pitch=0.0, roll=0.0, at=(0, 0, 0)):
    """x ahead, y port, z up to the world: first roll, then pitch (nose down), then yaw."""
    def turn(axis, angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.roll(np.roll([[c, -s, 0], [s, c, 0], [0, 0, 1]], axis + 1, 0), axis + 1, 1)
    matrix = np.eye(4)
    matrix[:3, :3] = turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)
    matrix[:3, 3] = at
    return matrix


class Neusis(Case):
    def write(self, states, config=CONFIG, protocol=4, name="set"):
        folder = self.folder / name
        (folder / "Data").mkdir(parents=True, exist_ok=True)
        (folder / "Config.json").write_text(json.dumps(config))
        for i, state in enumerate(states):
            raw = state if isinstance(state, bytes) else pickle.dumps(state, protocol)
            (folder / "Data" / f"{i}.pkl").write_bytes(raw)
        return folder

    def read(self, folder, *options, out="data"):
        self.said = ensonify("import", folder, "-o", self.folder / out, "--height-px", 200, *options)
        ensonify("verify", self.folder / out)
        return SonarDataset(self.folder / out)

    def images(self, count=3, kind=np.float32):
        return [RANDOM.random((30, 24)).astype(kind) for _ in range(count)]

    def test_counts_axes_times_and_levels_by_every_protocol(self):
        for protocol in (2, 3, 4, 5):
            images = self.images()
            states = [{"ImagingSonar": image, "PoseSensor": pose(0.1).astype(np.float32), "t": 0.5} for image in images]
            data = self.read(self.write(states, protocol=protocol, name=f"set{protocol}"), out=f"data{protocol}",
                             *["--frequency-hz", "9e5"])
            self.assertEqual(len(data), 3)
            for i, (image, ping) in enumerate(zip(images, data)):
                counts = np.round(65535 * image.astype(np.float64))
                np.testing.assert_array_equal(ping.recorded, counts, f"protocol {protocol}")
                self.assertEqual(ping.time_s, 0.25 * i)
                level = 20 * np.log10(np.maximum(counts, 1) / 65535)
                offset = data.sequence(0).info["recorder"]["db"][1]
                np.testing.assert_allclose(ping.polar.level_db[counts > 0], (level + offset)[counts > 0], atol=0.05)
            sequence = data.sequence(0)
            np.testing.assert_allclose(sequence.range_m, 0.5 + 0.1 * (np.arange(30) + 0.5), atol=1e-6)
            np.testing.assert_allclose(np.degrees(sequence.azimuth_rad), -30 + 2.5 * (np.arange(24) + 0.5), atol=1e-9)
            self.assertEqual(sequence.info["sonar"]["frequency_hz"], 9e5)
            self.assertEqual(sequence.info["recording"]["format"], "neusis")
            self.assertNotIn("warning", self.said)

    def test_poses_are_those_of_the_set(self):
        poses = [pose(0.3, 0.2, -0.1, (1, 2, -3)), pose(np.pi, at=(0, 0, 1)), pose(0, np.pi), pose(0, 0, np.pi - 1e-4)]
        states = [{"ImagingSonar": image, "PoseSensor": matrix} for image, matrix in zip(self.images(4), poses)]
        states[1]["PoseSensor"] = np.asfortranarray(poses[1])
        states[2]["PoseSensor"] = poses[2].astype(">f8")
        for ping, matrix in zip(self.read(self.write(states)), poses):
            np.testing.assert_allclose(ping.pose.rotation, matrix[:3, :3], atol=1e-6)
            np.testing.assert_allclose(ping.pose.position_m, matrix[:3, 3], atol=1e-9)

    def test_poses_of_some_files_only_are_refused(self):
        """They would stand beside identities that nobody gave."""
        for first, words in ((0, "1.pkl: has no PoseSensor"), (1, "1.pkl: has a PoseSensor")):
            states = [{"ImagingSonar": image} for image in self.images(2)]
            states[first]["PoseSensor"] = pose(0.1)
            folder = self.write(states, name=f"mixed{first}")
            self.assertIn(words, ensonify("import", folder, "-o", self.folder / "none", status=2))

    def test_a_folder_that_cannot_be_listed_is_an_error_of_reading(self):
        folder = self.write([])
        (folder / "Data").rmdir()
        (folder / "Data").write_text("a file")
        self.assertIn("Data: cannot be read", ensonify("import", folder, "-o", self.folder / "none", status=4))

    def test_what_is_assumed_and_clipped_is_said(self):
        config = json.loads(json.dumps(CONFIG))
        del config["agents"][0]["sensors"][1]["Hz"]
        images = self.images(11, np.float64)
        images[2][0, :3] = (-0.25, 1.5, np.nan)
        data = self.read(self.write([{"ImagingSonar": image} for image in images], config))
        self.assertEqual(list(data[2].recorded[0, :3]), [0, 65535, 0])
        self.assertIn("1000 kHz is assumed", self.said)
        self.assertIn("one ping per second", self.said)
        self.assertIn("3 pixels outside of 0 to 1", self.said)
        # 10.pkl follows 9.pkl.
        np.testing.assert_array_equal(data[10].recorded, np.round(65535 * images[10]))
        np.testing.assert_array_equal(data[10].time_s, 10)

    def test_scenes_of_sonarsplat_are_read(self):
        """Its loader takes the last sensor of any type, no RangeMin, and the first pixels of larger images."""
        config = {"agents": [{"sensors": [
            {"sensor_type": "PoseSensor"},
            {"configuration": {"Azimuth": 60, "Elevation": 14, "RangeMax": 3, "RangeBins": 30, "AzimuthBins": 24}}]}]}
        images = [RANDOM.random((32, 25)) for _ in range(2)]
        folder = self.write([], config)
        for number, image in zip((900, 1100), images):
            state = {"ImagingSonar": image, "PoseSensor": pose(0.1)}
            (folder / "Data" / f"{number:08d}.pkl").write_bytes(pickle.dumps(state))
        (folder / "sonar_images" / "labels").mkdir(parents=True)
        (folder / "bounds.txt").write_text("0 0 0 1 1 1\n")
        data = self.read(folder)
        for image, ping in zip(images, data):
            np.testing.assert_array_equal(ping.recorded, np.round(65535 * image[:30, :24]))
        np.testing.assert_allclose(data.sequence(0).range_m, 0.1 * (np.arange(30) + 0.5), atol=1e-6)
        self.assertIn("2 images larger than Config.json says", self.said)
        # The first sample is at half a step, which an .oculus log would lose.
        said = ensonify("export", data.folder, "--format", "oculus", "-o", self.folder / "log", status=2)
        self.assertIn("those of an Oculus begin at 0", said)

    def refused(self, state, words, config=CONFIG):
        folder = self.write([state], config, name="refused")
        said = ensonify("import", folder, "-o", self.folder / "none", status=2)
        self.assertIn(words, said)
        self.assertFalse((self.folder / "none").exists())

    def test_a_pickle_runs_nothing(self):
        class Evil:
            def __reduce__(self):
                return os.system, (f"touch {TARGET}",)
        TARGET = self.folder / "touched"
        for protocol in (2, 4):
            self.refused(pickle.dumps({"ImagingSonar": Evil()}, protocol), "system, which is not one of NumPy's")
        self.refused(b"\x80\x02cos\nsystem\n(X\x02\0\0\0idtR.", "byte 2: refers to os.system")
        self.refused(b"\x80\x02cnumpy\nndarray\n)R.", "byte 18: calls numpy.ndarray")
        self.assertFalse(TARGET.exists())

    def test_damage_is_refused_with_its_place(self):
        good = {"ImagingSonar": self.images(1)[0], "PoseSensor": pose(0)}
        whole = pickle.dumps(good, 4)
        self.refused(whole[:200], "ends here")
        self.refused(b"\x80\x04]\x94.", "byte 2: opcode 0x5d; expected only those of dictionaries")
        self.refused(pickle.dumps(good, 0), "byte 0: not a pickle of protocol 2 to 5")
        self.refused(b"\x80\x06}.", "protocol 6")
        self.refused(b"\x80\x02K\x01.", "ends without a dictionary")
        self.refused(b"\x80\x02}s.", "takes a value that is not there")
        self.refused(b"\x80\x02h\x05.", "recalls a value that is not there")
        self.refused(b"\x80\x02B" + struct.pack("<I", 2**32 - 1) + b"abc.", "byte 2: ends here")
        self.refused(b"\x80\x02}" + b"K\x01" * 70000 + b".", "more than 65536 values")
        self.refused(b"\x80\x02" + b"(" * 70000 + b".", "more marks")
        larger = whole.replace(b"M\x04\x10", b"M\x04\x20") if b"M\x04\x10" in whole else whole.replace(b"K\x1eK\x18", b"K\x1fK\x18")
        self.refused(larger, "which its shape and type do not need")
        objects = pickle.dumps({"ImagingSonar": np.array([[None, 1]], dtype=object)}, 4)
        self.refused(objects, "an array of type O8")

    def test_sets_that_do_not_fit_are_refused(self):
        image = self.images(1)[0]
        self.refused({"PoseSensor": pose(0)}, "has no array ImagingSonar")
        self.refused({"ImagingSonar": image[:-1]}, "29 ranges and 24 azimuths; Config.json has 30 and 24")
        self.refused({"ImagingSonar": (255 * image).astype(np.uint8)}, "expected floats")
        self.refused({"ImagingSonar": image[0]}, "expected floats [ranges, azimuths]")
        for bad in (pose(0) * 2, np.diag([1.0, 1, -1, 1]), np.full((4, 4), np.nan)):
            self.refused({"ImagingSonar": image, "PoseSensor": bad}, "PoseSensor: is not a rotation")
        self.refused({"ImagingSonar": image, "PoseSensor": np.eye(3)}, "matrix of 4 x 4")
        for change, words in (({"RangeMax": 0.2}, "RangeMin, RangeMax"), ({"Azimuth": 500}, "configuration.Azimuth")):
            config = json.loads(json.dumps(CONFIG))
            config["agents"][0]["sensors"][1]["configuration"].update(change)
            self.refused({"ImagingSonar": image}, words, config)
        self.refused({"ImagingSonar": image}, "expected one of type ImagingSonar", {"agents": [1, {"sensors": 3}]})
        empty = self.write([], name="empty")
        self.assertIn("has no .pkl files", ensonify("import", empty, "-o", self.folder / "x", status=2))
        self.assertIn("options of MCAP", ensonify("import", empty, "-o", self.folder / "x", "--topic", "/a", status=2))
        self.assertIn("sets of neusis only", ensonify("import", self.folder, "-o", self.folder / "x",
                                                      "--frequency-hz", "1e6", status=2))


if __name__ == "__main__":
    unittest.main()
