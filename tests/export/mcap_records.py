"""Readers of MCAP files and of the ROS messages in them, written from the formats' specifications."""
import struct
import zlib

import numpy as np

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = 11, 12, 13, 14, 15


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

    def texts(self):
        inner = Cursor(self.take(self.number("I")))
        found = {}
        while not inner.done():
            key = inner.text()
            found[key] = inner.text()
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
    """Plain CDR, little-endian, read by the definitions that the file itself carries."""

    KINDS = {"bool": "u1", "uint8": "u1", "int8": "i1", "uint16": "<u2", "int16": "<i2", "uint32": "<u4",
             "int32": "<i4", "float32": "<f4", "float64": "<f8"}

    def __init__(self, data, definition):
        assert data[:4] == b"\0\1\0\0", data[:4]
        self.data, self.position = data[4:], 0
        parts = definition.split("=" * 80 + "\n")
        self.types = {"": fields_of(parts[0])}
        for part in parts[1:]:
            head, _, text = part.partition("\n")
            assert head.startswith("MSG: "), head
            self.types[head[5:]] = fields_of(text)

    def numbers(self, kind, count):
        kind = np.dtype(self.KINDS[kind])
        if count:
            self.position = -(-self.position // kind.itemsize) * kind.itemsize
        self.position += kind.itemsize * count
        assert self.position <= len(self.data), "cut short"
        return np.frombuffer(self.data, kind, count, self.position - kind.itemsize * count)

    def value(self, kind):
        if kind == "string":
            raw = self.numbers("uint8", int(self.numbers("uint32", 1)[0])).tobytes()
            assert raw.endswith(b"\0")
            return raw[:-1].decode("utf-8")
        if kind in self.KINDS:
            return self.numbers(kind, 1)[0].item()
        return {name: self.field(part, array) for part, array, name in self.types[kind]}

    def field(self, kind, array):
        if array is None:
            return self.value(kind)
        count = int(array) if array else int(self.numbers("uint32", 1)[0])
        return self.numbers(kind, count) if kind in self.KINDS else [self.value(kind) for _ in range(count)]


def fields_of(text):
    """(type, None or the length of an array or "", name) of each line that is no constant."""
    fields = []
    for line in text.splitlines():
        kind, name = line.split(" ")
        if "=" in name:
            continue
        kind, _, array = kind.partition("[")
        fields.append((kind, array[:-1] if array else None, name))
    return fields


def message_of(data, definition):
    cdr = Cdr(data, definition)
    message = cdr.value("")
    assert cdr.position == len(cdr.data), "bytes are left"
    return message


def stamp_of(header):
    return header["stamp"]["sec"] * 10**9 + header["stamp"]["nanosec"], header["frame_id"]


def pose_values(pose, position="position", rotation="orientation"):
    return [pose[position][k] for k in "xyz"] + [pose[rotation][k] for k in "wxyz"]


class Reader:
    """Reads a file for a test case, which it asks about structure and checksums on the way."""

    def __init__(self, case):
        self.case = case

    def read(self, data):
        """Everything that the file says, its structure and checksums looked at on the way."""
        self.case.assertTrue(data.startswith(MAGIC) and data.endswith(MAGIC))
        footer_at = len(data) - len(MAGIC) - 29
        everything = list(records(data, len(MAGIC), len(data) - len(MAGIC)))
        self.case.assertEqual((everything[0][0], everything[-1][:2]), (HEADER, (FOOTER, footer_at)))
        summary_start, offsets_start, summary_crc = struct.unpack("<QQI", everything[-1][2])
        self.case.assertEqual(zlib.crc32(data[summary_start:len(data) - len(MAGIC) - 4]), summary_crc)
        data_end = next(r for r in everything if r[0] == DATA_END)
        self.case.assertEqual(data_end[1] + 13, summary_start)
        self.case.assertEqual(struct.unpack("<I", data_end[2])[0], zlib.crc32(data[:data_end[1]]))
        head = Cursor(everything[0][2])
        self.case.assertEqual((head.text(), head.text()), ("ros2", "ensonify"))
        section = [r for r in everything if r[1] < summary_start]
        summary = [r for r in everything if summary_start <= r[1] < offsets_start]
        for kind in (SCHEMA, CHANNEL):
            self.case.assertEqual([r[2] for r in section if r[0] == kind], [r[2] for r in summary if r[0] == kind])
        self.check_offsets([r[2] for r in everything if r[0] == SUMMARY_OFFSET], summary)
        messages = self.check_chunks(data, section, [r[2] for r in summary if r[0] == CHUNK_INDEX])
        self.check_statistics(next(r[2] for r in summary if r[0] == STATISTICS), messages,
                              [sum(r[0] == kind for r in section) for kind in (SCHEMA, CHANNEL)],
                              [sum(r[0] == kind for r in section) for kind in (METADATA, CHUNK)])
        self.read_schemas([r[2] for r in section if r[0] == SCHEMA])
        self.read_channels([r[2] for r in section if r[0] == CHANNEL])
        self.read_metadata(section, [r[2] for r in summary if r[0] == METADATA_INDEX])
        return [(*self.topics[channel], number, time, message_of(content, self.schemas[self.topics[channel][1]]))
                for channel, number, time, content in messages]

    def read_schemas(self, contents):
        """{type: definition}."""
        self.schemas, self.types = {}, {}
        for content in contents:
            cursor = Cursor(content)
            number, name, encoding = cursor.number("H"), cursor.text(), cursor.text()
            self.case.assertEqual(encoding, "ros2msg")
            self.case.assertNotIn(name, self.schemas, "a type has one schema")
            self.types[number], self.schemas[name] = name, cursor.text()

    def read_channels(self, contents):
        """{number: (topic, type)}, and the metadata of each topic."""
        self.topics, self.qualities = {}, {}
        for content in contents:
            cursor = Cursor(content)
            number, schema, topic, encoding = (cursor.number("H"), cursor.number("H"), cursor.text(), cursor.text())
            self.case.assertEqual(encoding, "cdr")
            self.topics[number] = (topic, self.types[schema])
            self.qualities[topic] = cursor.texts()

    def read_metadata(self, section, indices):
        self.metadata = []
        for (_, offset, content), index in zip((r for r in section if r[0] == METADATA), indices, strict=True):
            cursor = Cursor(content)
            name = cursor.text()
            self.metadata.append((name, cursor.texts()))
            cursor = Cursor(index)
            self.case.assertEqual((cursor.number("Q"), cursor.number("Q"), cursor.text()),
                                  (offset, 9 + len(content), name))

    def check_offsets(self, offsets, summary):
        found = {}
        for content in offsets:
            opcode, start, length = struct.unpack("<BQQ", content)
            found[opcode] = (start, length)
        expected = {}
        for opcode, start, content in summary:
            first, length = expected.get(opcode, (start, 0))
            self.case.assertEqual(first + length, start, "records of a kind stand together")
            expected[opcode] = (first, length + 9 + len(content))
        self.case.assertEqual(found, expected)

    def check_chunks(self, data, section, indices):
        """Messages (channel, sequence, time, bytes) in file order."""
        messages, chunks = [], []
        for opcode, offset, content in section:
            self.case.assertNotEqual(opcode, MESSAGE, "a message outside of chunks has no index")
            if opcode == CHUNK:
                cursor = Cursor(content)
                first, last, size, crc = (cursor.number(k) for k in "QQQI")
                self.case.assertEqual(cursor.text(), "")
                body = cursor.take(cursor.number("Q"))
                self.case.assertTrue(cursor.done())
                self.case.assertEqual((len(body), zlib.crc32(body)), (size, crc))
                inside = {}
                for kind, at, message in records(body, 0, len(body)):
                    self.case.assertEqual(kind, MESSAGE)
                    channel, sequence, time, published = struct.unpack_from("<HIQQ", message)
                    self.case.assertEqual(time, published)
                    self.case.assertTrue(first <= time <= last)
                    messages.append((channel, sequence, time, message[22:]))
                    inside.setdefault(channel, []).append((time, at))
                chunks.append([(first, last), offset, 9 + len(content), inside, {}, 0, size])
            elif opcode == MESSAGE_INDEX:
                cursor = Cursor(content)
                channel = cursor.number("H")
                self.case.assertEqual(cursor.pairs("Q", "Q"), chunks[-1][3].pop(channel))
                chunks[-1][4][channel] = offset
                chunks[-1][5] += 9 + len(content)
        self.case.assertEqual(len(indices), len(chunks))
        for content, ((first, last), offset, length, inside, where, index_length, size) in zip(indices, chunks):
            self.case.assertEqual(inside, {}, "messages without an index")
            cursor = Cursor(content)
            self.case.assertEqual([cursor.number("Q") for _ in range(4)], [first, last, offset, length])
            self.case.assertEqual(dict(cursor.pairs("H", "Q")), where)
            self.case.assertEqual(cursor.number("Q"), index_length)
            self.case.assertEqual(cursor.text(), "")
            self.case.assertEqual([cursor.number("Q"), cursor.number("Q")], [size, size])
        return messages

    def check_statistics(self, content, messages, described, others):
        cursor = Cursor(content)
        self.case.assertEqual([cursor.number(k) for k in "QHIIII"], [len(messages), *described, 0, *others])
        self.chunks = others[1]
        times = [time for _, _, time, _ in messages]
        self.case.assertEqual([cursor.number("Q"), cursor.number("Q")], [min(times), max(times)])
        counts = {}
        for channel, *_ in messages:
            counts[channel] = counts.get(channel, 0) + 1
        self.case.assertEqual(dict(cursor.pairs("H", "Q")), counts)
