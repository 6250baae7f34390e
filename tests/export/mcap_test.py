"""mcap: the records by a reader of this file, written from the format's specification, and the
messages by npm's @mcap/core and @foxglove/rosmsg2-serialization, against the data set.

MCAP_BUILD is a folder for npm's packages; without npm, or a registry, the part that needs them skips.
"""
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import unittest
import zlib

import numpy as np

import exported

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
STATISTICS, SUMMARY_OFFSET, DATA_END = 11, 14, 15


class Cursor:
    def __init__(self, data):
        self.data, self.position = data, 0

    def take(self, count):
        assert self.position + count <= len(self.data), "cut short"
        self.position += count
        return self.data[self.position - count:self.position]

    def number(self, kind):
        return struct.unpack("<" + kind, self.take(struct.calcsize("<" + kind)))[0]

    def text(self):
        return self.take(self.number("I")).decode("utf-8")

    def pairs(self, key, value):
        inner = Cursor(self.take(self.number("I")))
        found = []
        while not inner.done():
            found.append((inner.number(key), inner.number(value)))
        return found

    def done(self):
        return self.position == len(self.data)


def records(data, start, end):
    """(opcode, offset, content) of the records in data[start:end]."""
    while start < end:
        opcode, length = data[start], struct.unpack_from("<Q", data, start + 1)[0]
        assert start + 9 + length <= end, "a record goes over the end"
        yield opcode, start, data[start + 9:start + 9 + length]
        start += 9 + length


class Cdr:
    """Plain CDR, little-endian."""

    def __init__(self, data):
        assert data[:4] == b"\0\1\0\0", data[:4]
        self.data, self.position = data[4:], 0

    def numbers(self, kind, count):
        size = struct.calcsize(kind)
        if count:
            self.position = -(-self.position // size) * size
        self.position += size * count
        assert self.position <= len(self.data)
        return np.frombuffer(self.data, "<" + {"I": "u4", "i": "i4", "f": "f4", "d": "f8", "B": "u1"}[kind],
                             count, self.position - size * count)

    def number(self, kind):
        return self.numbers(kind, 1)[0]

    def array(self, kind):
        return self.numbers(kind, int(self.number("I")))

    def text(self):
        raw = self.array("B").tobytes()
        assert raw.endswith(b"\0")
        return raw[:-1].decode("utf-8")

    def header(self):
        seconds, nanoseconds = int(self.number("i")), int(self.number("I"))
        return seconds * 10**9 + nanoseconds, self.text()


def sonar_image(data):
    cdr = Cdr(data)
    image = {"header": cdr.header(), "frequency": cdr.number("f"), "sound_speed": cdr.number("f"),
             "tx": cdr.array("f"), "rx": cdr.array("f")}
    image["directions"] = cdr.numbers("d", 3 * int(cdr.number("I"))).reshape(-1, 3)
    image["ranges"] = cdr.array("f")
    image["is_bigendian"], image["dtype"] = cdr.number("B"), cdr.number("I")
    image["beam_count"] = int(cdr.number("I"))
    image["data"] = cdr.array("B")
    assert cdr.position == len(cdr.data), "bytes are left"
    return image


def pose_stamped(data):
    cdr = Cdr(data)
    header = cdr.header()
    values = cdr.numbers("d", 7).tolist()
    assert cdr.position == len(cdr.data), "bytes are left"
    return header, values


class Records(exported.Case):
    format_name = "mcap"

    def read(self, data):
        """Everything that the file says, its structure and checksums looked at on the way."""
        self.assertTrue(data.startswith(MAGIC) and data.endswith(MAGIC))
        footer_at = len(data) - len(MAGIC) - 29
        everything = list(records(data, len(MAGIC), len(data) - len(MAGIC)))
        self.assertEqual((everything[0][0], everything[-1][:2]), (HEADER, (FOOTER, footer_at)))
        summary_start, offsets_start, summary_crc = struct.unpack("<QQI", everything[-1][2])
        self.assertEqual(zlib.crc32(data[summary_start:len(data) - len(MAGIC) - 4]), summary_crc)
        data_end = next(r for r in everything if r[0] == DATA_END)
        self.assertEqual(data_end[1] + 13, summary_start)
        self.assertEqual(struct.unpack("<I", data_end[2])[0], zlib.crc32(data[:data_end[1]]))
        head = Cursor(everything[0][2])
        self.assertEqual((head.text(), head.text()), ("ros2", "ensonify"))
        section = [r for r in everything if r[1] < summary_start]
        summary = [r for r in everything if summary_start <= r[1] < offsets_start]
        for kind in (SCHEMA, CHANNEL):
            self.assertEqual([r[2] for r in section if r[0] == kind], [r[2] for r in summary if r[0] == kind])
        self.check_offsets([r[2] for r in everything if r[0] == SUMMARY_OFFSET], summary)
        messages = self.check_chunks(data, section, [r[2] for r in summary if r[0] == CHUNK_INDEX])
        self.check_statistics(next(r[2] for r in summary if r[0] == STATISTICS), messages,
                              sum(r[0] == CHUNK for r in section))
        topics = {}
        for _, _, content in (r for r in section if r[0] == CHANNEL):
            cursor = Cursor(content)
            number, schema, topic, encoding = (cursor.number("H"), cursor.number("H"), cursor.text(), cursor.text())
            self.assertEqual(encoding, "cdr")
            topics[number] = (topic, schema)
        return topics, messages

    def check_offsets(self, offsets, summary):
        found = {}
        for content in offsets:
            opcode, start, length = struct.unpack("<BQQ", content)
            found[opcode] = (start, length)
        expected = {}
        for opcode, start, content in summary:
            first, length = expected.get(opcode, (start, 0))
            self.assertEqual(first + length, start, "records of a kind stand together")
            expected[opcode] = (first, length + 9 + len(content))
        self.assertEqual(found, expected)

    def check_chunks(self, data, section, indices):
        """Messages (channel, sequence, time, bytes) in file order."""
        messages, chunks = [], []
        for opcode, offset, content in section:
            self.assertNotEqual(opcode, MESSAGE, "a message outside of chunks has no index")
            if opcode == CHUNK:
                cursor = Cursor(content)
                first, last, size, crc = (cursor.number(k) for k in "QQQI")
                self.assertEqual(cursor.text(), "")
                body = cursor.take(cursor.number("Q"))
                self.assertTrue(cursor.done())
                self.assertEqual((len(body), zlib.crc32(body)), (size, crc))
                inside = {}
                for kind, at, message in records(body, 0, len(body)):
                    self.assertEqual(kind, MESSAGE)
                    channel, sequence, time, published = struct.unpack_from("<HIQQ", message)
                    self.assertEqual(time, published)
                    self.assertTrue(first <= time <= last)
                    messages.append((channel, sequence, time, message[22:]))
                    inside.setdefault(channel, []).append((time, at))
                chunks.append([(first, last), offset, 9 + len(content), inside, {}, 0, size])
            elif opcode == MESSAGE_INDEX:
                cursor = Cursor(content)
                channel = cursor.number("H")
                self.assertEqual(cursor.pairs("Q", "Q"), chunks[-1][3].pop(channel))
                chunks[-1][4][channel] = offset
                chunks[-1][5] += 9 + len(content)
        self.assertEqual(len(indices), len(chunks))
        for content, ((first, last), offset, length, inside, where, index_length, size) in zip(indices, chunks):
            self.assertEqual(inside, {}, "messages without an index")
            cursor = Cursor(content)
            self.assertEqual([cursor.number("Q") for _ in range(4)], [first, last, offset, length])
            self.assertEqual(dict(cursor.pairs("H", "Q")), where)
            self.assertEqual(cursor.number("Q"), index_length)
            self.assertEqual(cursor.text(), "")
            self.assertEqual([cursor.number("Q"), cursor.number("Q")], [size, size])
        return messages

    def check_statistics(self, content, messages, chunks):
        cursor = Cursor(content)
        self.assertEqual([cursor.number(k) for k in "QHIIII"], [len(messages), 2, 2, 0, 0, chunks])
        times = [time for _, _, time, _ in messages]
        self.assertEqual([cursor.number("Q"), cursor.number("Q")], [min(times), max(times)])
        counts = {}
        for channel, *_ in messages:
            counts[channel] = counts.get(channel, 0) + 1
        self.assertEqual(dict(cursor.pairs("H", "Q")), counts)

    def check_message(self, sequence, ping, topic, time, data):
        self.assertEqual(time, round(float(sequence.poses[ping]["time_s"]) * 1e9))
        if topic == "/sonar/pose":
            header, values = pose_stamped(data)
            self.assertEqual(header, (time, "world"))
            x, y, z, qw, qx, qy, qz = sequence.pose(ping)
            self.assertEqual(values, [x, y, z, qx, qy, qz, qw])
            return
        image = sonar_image(data)
        self.assertEqual(image["header"], (time, "sonar_fan"))
        head, grey = sequence.head, sequence.png("png", ping, "_polar")
        azimuth = sequence.npy("azimuth_rad.npy")
        self.assertEqual((image["is_bigendian"], image["dtype"], image["beam_count"]), (0, 0, grey.shape[1]))
        np.testing.assert_array_equal(image["data"].reshape(-1, image["beam_count"]), grey)
        np.testing.assert_array_equal(image["ranges"], sequence.npy("range_m.npy").astype(np.float32))
        self.assertEqual(image["frequency"], np.float32(head["sonar"]["frequency_hz"]))
        self.assertEqual(image["sound_speed"], np.float32(head["water"]["sound_speed_m_s"]))
        widths = np.full(len(azimuth), head["sonar"]["beams"]["width_rad"], np.float32)
        np.testing.assert_array_equal(image["rx"], widths)
        heights = np.full(len(azimuth), head["sonar"]["elevation"]["width_rad"], np.float32)
        np.testing.assert_array_equal(image["tx"], heights)
        # z ahead, x up, y to starboard; beam 0 is the one to starboard.
        ahead, starboard = np.cos(azimuth), -np.sin(azimuth)
        np.testing.assert_allclose(image["directions"], np.stack([0 * ahead, starboard, ahead], 1), atol=1e-15)
        self.assertGreater(image["directions"][0, 1], 0)

    def check(self, source):
        out = exported.export("mcap", source=source)
        for sequence in exported.sequences(source):
            data = (out / f"{sequence.number:06}.mcap").read_bytes()
            topics, messages = self.read(data)
            self.assertEqual(sorted(name for name, _ in topics.values()), ["/sonar/image", "/sonar/pose"])
            self.assertEqual(len(messages), 2 * len(sequence.pings))
            for i, (channel, number, time, content) in enumerate(messages):
                self.assertEqual(number, i // 2)
                self.check_message(sequence, sequence.pings[i // 2], topics[channel][0], time, content)
        self.assertEqual(len(list(out.iterdir())), 2)
        files = [path.read_bytes() for path in out.iterdir()]
        return [sum(r[0] == CHUNK for r in records(data, 8, len(data) - 8)) for data in files]

    def test_structure_and_messages(self):
        self.check(exported.dataset())

    def test_several_chunks(self):
        big = ("--set", "sonar.beams.count=1536", "--set", "sonar.rays.elevation=1",
               "--set", "output={timeseries: none, polar: false, cartesian: false}", "--set", "trajectory.pings=5")
        counts = self.check(exported.dataset(*big))
        self.assertGreater(min(counts), 1, "there is one chunk only")

    def test_times_before_zero_are_refused(self):
        source = exported.dataset("--set", "trajectory.poses.0.time_s=-1")
        result = exported.run("export", source, "--format", "mcap", "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 2)
        self.assertIn("-1 s", result.stderr)


class ByOtherHands(unittest.TestCase):
    """The authors' own libraries read the file, index, checksums, schemas and messages."""

    @classmethod
    def setUpClass(cls):
        if not shutil.which("npm") or not shutil.which("node"):
            raise unittest.SkipTest("npm or node is not here")
        here = pathlib.Path(__file__).parent / "mcap_reader"
        cls.folder = pathlib.Path(os.environ.get("MCAP_BUILD", exported.scratch())) / "mcap_reader"
        cls.folder.mkdir(parents=True, exist_ok=True)
        for name in ("package.json", "package-lock.json", "read.js"):
            shutil.copy(here / name, cls.folder / name)
        if not (cls.folder / "node_modules/@mcap/core").is_dir():
            made = subprocess.run(["npm", "ci", "--no-audit", "--no-fund", "--fetch-retries=1",
                                   "--fetch-timeout=20000"], cwd=cls.folder, capture_output=True, text=True)
            if made.returncode != 0:
                raise unittest.SkipTest("npm ci failed, is there a registry? " + made.stderr[-300:])

    def read(self, path):
        result = subprocess.run(["node", "read.js", str(path)], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [json.loads(line) for line in result.stdout.splitlines()]
        return lines[0], lines[1:]

    def test_everything(self):
        out = exported.export("mcap")
        for sequence in exported.sequences():
            index, messages = self.read(out / f"{sequence.number:06}.mcap")
            self.assertEqual(index["header"]["profile"], "ros2")
            self.assertEqual(index["statistics"]["messageCount"], str(2 * len(sequence.pings)))
            self.assertEqual({s["name"] for s in index["schemas"]},
                             {"geometry_msgs/msg/PoseStamped", "marine_acoustic_msgs/msg/ProjectedSonarImage"})
            images = [m for m in messages if m["topic"] == "/sonar/image"]
            poses = [m for m in messages if m["topic"] == "/sonar/pose"]
            self.assertEqual(len(images) + len(poses), len(messages))
            for ping, image, pose in zip(sequence.pings, images, poses, strict=True):
                self.check_image(sequence, ping, image)
                self.check_pose(sequence, ping, pose)

    def check_image(self, sequence, ping, found):
        message, grey = found["message"], sequence.png("png", ping, "_polar")
        time = float(sequence.poses[ping]["time_s"])
        stamp = message["header"]["stamp"]
        self.assertEqual(stamp["sec"], math.floor(time))
        self.assertEqual(stamp["nanosec"], round(time % 1 * 1e9))
        self.assertEqual(int(found["logTime"]), round(time * 1e9))
        image = message["image"]
        self.assertEqual((image["is_bigendian"], image["dtype"], image["beam_count"]), (False, 0, grey.shape[1]))
        np.testing.assert_array_equal(np.array(image["data"], np.uint8).reshape(grey.shape), grey)
        np.testing.assert_array_equal(np.float32(message["ranges"]), sequence.npy("range_m.npy").astype(np.float32))
        azimuth = sequence.npy("azimuth_rad.npy")
        directions = [[d["x"], d["y"], d["z"]] for d in message["beam_directions"]]
        np.testing.assert_allclose(directions, np.stack([0 * azimuth, -np.sin(azimuth), np.cos(azimuth)], 1),
                                   atol=1e-15)
        self.assertEqual(len(message["ping_info"]["rx_beamwidths"]), len(azimuth))
        self.assertEqual(message["ping_info"]["frequency"], sequence.head["sonar"]["frequency_hz"])

    def check_pose(self, sequence, ping, found):
        pose = found["message"]["pose"]
        values = [pose["position"][k] for k in "xyz"] + [pose["orientation"][k] for k in "wxyz"]
        self.assertEqual(values, sequence.pose(ping))


if __name__ == "__main__":
    unittest.main()
