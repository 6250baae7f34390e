"""Writes logs of real sonars from their published layouts, without any code of the program.

.aris: Sound Metrics, aris-file-sdk, type-definitions/C; .oculus: the drivers oculus_driver and liboculus; MCAP:
https://mcap.dev/spec and the messages of marine_msgs.
"""
from __future__ import annotations

import struct
import zlib
from typing import List, Optional, Sequence

import numpy as np

ARIS_SIGNATURE = 0x05464444

# Offset and type of members of a frame header.
FRAME = {
    "FrameIndex": (0, "I"), "FrameTime": (4, "Q"), "Version": (12, "I"), "sonarTimeStamp": (20, "Q"),
    "Depth": (128, "f"), "Pitch": (136, "f"), "Roll": (144, "f"), "Heading": (152, "f"),
    "CompassHeading": (160, "f"), "CompassPitch": (164, "f"), "CompassRoll": (168, "f"),
    "PingMode": (436, "I"), "FrequencyHiLow": (440, "I"), "SamplePeriod": (452, "I"), "SoundSpeed": (464, "f"),
    "SamplesPerBeam": (468, "I"), "SampleStartDelay": (476, "I"), "LargeLens": (480, "I"),
    "TheSystemType": (484, "I"), "SonarSerialNumber": (488, "I"), "ReorderedSamples": (516, "I"),
}


def aris_frame(counts: np.ndarray, **members: float) -> bytes:
    """`counts`: uint8 [samples, beams], beam 0 on the right."""
    header = bytearray(1024)
    values = {"Version": ARIS_SIGNATURE, "SamplesPerBeam": len(counts), "SamplePeriod": 10, "SoundSpeed": 1480.5,
              "SampleStartDelay": 2700, "PingMode": 9, "FrequencyHiLow": 1, "TheSystemType": 1,
              "SonarSerialNumber": 24, "ReorderedSamples": 1}
    values.update(members)
    for name, value in values.items():
        offset, kind = FRAME[name]
        struct.pack_into("<" + kind, header, offset, value)
    return bytes(header) + np.ascontiguousarray(counts, np.uint8).tobytes()


def aris(frames: Sequence[bytes]) -> bytes:
    header = bytearray(1024)
    struct.pack_into("<II", header, 0, ARIS_SIGNATURE, len(frames))
    return bytes(header) + b"".join(frames)


def oculus_message(counts: np.ndarray, bearings: Sequence[int], gains: Optional[Sequence[int]] = None, version: int = 2,
                   mode: int = 1, gamma: int = 255, step_m: float = 0.01, speed: float = 1500.0,
                   frequency: float = 750e3, attitude: Sequence[float] = (0, 0, 0), start: float = 0) -> bytes:
    """`counts`: uint8, uint16 or uint32 [ranges, beams], in the order of `bearings`, hundredths of a degree."""
    size = {1: 0, 2: 1, 4: 3}[counts.dtype.itemsize]
    little = counts.astype(counts.dtype.newbyteorder("<"))
    rows = [(struct.pack("<I", gains[i]) if gains is not None else b"") + row.tobytes() for i, row in enumerate(little)]
    image = b"".join(rows)
    fire = struct.pack("<BBBBB4d", mode, 0, 0, gamma, 0x19, 10.0, 50.0, 0.0, 0.0)
    if version == 2:
        fire += struct.pack("<I8I", 0, *[0] * 8)
    head = struct.pack("<II3d", 7, 0, frequency, 12.0, 1.1)
    if version == 2:
        head += struct.pack("<3d", *attitude)
    head += struct.pack("<d", speed)
    head += struct.pack("<d", start) if version == 2 else struct.pack("<I", int(start * 1e9) % 2**32)
    head += struct.pack("<BdHH", size, step_m, len(counts), counts.shape[1])
    if version == 2:
        head += struct.pack("<4I", 0, 0, 0, 0)
    offset = 16 + len(fire) + len(head) + 12 + 2 * len(bearings)
    head += struct.pack("<III", offset, len(image), offset + len(image))
    body = fire + head + struct.pack(f"<{len(bearings)}h", *bearings) + image
    return struct.pack("<HHHHHIH", 0x4F53, 41, 0, 0x23, version, len(body), 0) + body


def oculus_item(payload: bytes, time_s: float, kind: int = 10, compressed: bool = False) -> bytes:
    stored = struct.pack(">I", len(payload)) + zlib.compress(payload) if compressed else payload
    return struct.pack("<IIHH4xdH2xII4x", 0xAABBCCDD, 40, kind, 0, time_s, int(compressed), len(payload),
                       len(stored)) + stored


def oculus(items: List[bytes], encryption: int = 0) -> bytes:
    return struct.pack("<II16sHH4xqd", 0x11223344, 48, b"Oculus", 1, encryption, 0, 1.6e9) + b"".join(items)


class Cdr:
    """Plain CDR: numbers are aligned to their size, counted behind the header."""

    def __init__(self) -> None:
        self.bytes = b""

    def put(self, kind: str, *values: float) -> None:
        size = struct.calcsize("<" + kind)
        for value in values:
            self.bytes += bytes(-len(self.bytes) % size) + struct.pack("<" + kind, value)

    def text(self, text: str) -> None:
        self.put("I", len(text) + 1)
        self.bytes += text.encode() + b"\0"


def projected_image(counts: np.ndarray, bearings: Sequence[float], ranges: Sequence[float], time_us: int,
                    big_endian: bool = False) -> bytes:
    """marine_acoustic_msgs/msg/ProjectedSonarImage; bearings in rad, to starboard."""
    cdr = Cdr()
    cdr.put("i", time_us // 1_000_000)
    cdr.put("I", time_us % 1_000_000 * 1000)
    cdr.text("sonar")
    cdr.put("f", 1.2e6, 1490.0)
    for _ in range(2):
        cdr.put("I", len(bearings))
        cdr.put("f", *[0.01] * len(bearings))
    cdr.put("I", len(bearings))
    for bearing in bearings:
        cdr.put("d", 0, np.sin(bearing), np.cos(bearing))
    cdr.put("I", len(ranges))
    cdr.put("f", *ranges)
    cdr.put("B", int(big_endian))
    cdr.put("I", {1: 0, 2: 2, 4: 8}[counts.dtype.itemsize], counts.shape[1], counts.nbytes)
    return b"\0\1\0\0" + cdr.bytes + counts.astype(counts.dtype.newbyteorder(">" if big_endian else "<")).tobytes()


def sonar_info(quantity: int, kind: int, scale: float, offset: float) -> bytes:
    """marine_interfaces/msg/SonarInfo: quantity 2 amplitude, 3 power; kind 1 linear, 2 dB; values scale x + offset."""
    cdr = Cdr()
    cdr.put("i", 0)
    cdr.put("I", 0)
    for text in ("sonar", "model", "of the factory"):
        cdr.text(text)
    cdr.put("i", 0)
    cdr.put("I", 0, 1)
    cdr.put("f", 1e-4)
    cdr.put("I", 0, 1)
    cdr.put("B", 1, quantity, kind, 1)
    cdr.put("f", scale, offset)
    cdr.put("B", 1)
    cdr.put("f", 0, 200)
    cdr.put("B", 1)
    cdr.put("I", 0, 0)
    cdr.put("B", 0)
    cdr.put("f", 0)
    cdr.put("I", 0, 0)
    return b"\0\1\0\0" + cdr.bytes


def raw_image(counts: np.ndarray, angles: Sequence[float], rate_hz: float, first: int, time_us: int,
              big_endian: bool = False, samples: Optional[int] = None, sound_speed: float = 1490.0) -> bytes:
    """marine_acoustic_msgs/msg/RawSonarImage; angles in rad, to starboard; `first`: number of the first sample."""
    cdr = Cdr()
    cdr.put("i", time_us // 1_000_000)
    cdr.put("I", time_us % 1_000_000 * 1000)
    cdr.text("sonar")
    cdr.put("f", 1.2e6, sound_speed)
    cdr.put("I", 0, 0)  # widths of beams
    cdr.put("f", rate_hz)
    cdr.put("I", len(counts) if samples is None else samples, first)
    cdr.put("I", 0, 1)  # delays, then one transmit angle
    cdr.put("f", 0.1)
    cdr.put("I", len(angles))
    cdr.put("f", *angles)
    cdr.put("B", int(big_endian))
    cdr.put("I", {1: 0, 2: 2}[counts.dtype.itemsize], counts.shape[1], counts.nbytes)
    return b"\0\1\0\0" + cdr.bytes + counts.astype(counts.dtype.newbyteorder(">" if big_endian else "<")).tobytes()


def zstd_stored(content: bytes) -> bytes:
    """A frame of Zstandard (RFC 8878) whose blocks are raw, or one repeated byte."""
    blocks = [content[i:i + 100_000] for i in range(0, len(content), 100_000)]
    packed = b""
    for i, block in enumerate(blocks):
        repeated = len(set(block)) == 1
        head = int(i + 1 == len(blocks)) | (2 if repeated else 0) | len(block) << 3
        packed += struct.pack("<I", head)[:3] + (block[:1] if repeated else block)
    return struct.pack("<IBI", 0xFD2FB528, 0xA0, len(content)) + packed  # one segment, size of four bytes


def mcap(messages: Sequence[bytes], chunked: bool = True, compression: str = "", kind: str = "ProjectedSonarImage",
         size: Optional[int] = None, infos: Sequence[Optional[bytes]] = ()) -> bytes:
    """`size`: of the chunk without compression, where it is not the right one; `infos`: SonarInfo before messages."""
    def text(value: str) -> bytes:
        return struct.pack("<I", len(value)) + value.encode()

    def record(opcode: int, content: bytes) -> bytes:
        return struct.pack("<BQ", opcode, len(content)) + content

    def schema(number: int, name: str) -> bytes:
        return record(3, struct.pack("<H", number) + text(name) + text("ros2msg") + text(""))

    records = schema(1, f"marine_acoustic_msgs/msg/{kind}") + schema(2, "std_msgs/msg/String")
    records += record(4, struct.pack("<HH", 8, 2) + text("/words") + text("cdr") + struct.pack("<I", 0))
    records += record(4, struct.pack("<HH", 7, 1) + text("/sonar") + text("cdr") + struct.pack("<I", 0))
    records += schema(3, "marine_interfaces/msg/SonarInfo")
    records += record(4, struct.pack("<HH", 9, 3) + text("/sonar/info") + text("cdr") + struct.pack("<I", 0))
    for i, message in enumerate(messages):
        if i < len(infos) and infos[i] is not None:
            records += record(5, struct.pack("<HIQQ", 9, i, i, i) + infos[i])
        records += record(5, struct.pack("<HIQQ", 8, i, i, i) + b"words")
        records += record(5, struct.pack("<HIQQ", 7, i, i, i) + message)
    if chunked or compression:
        head = struct.pack("<QQQI", 0, 0, len(records) if size is None else size, 0) + text(compression)
        packed = zstd_stored(records) if compression == "zstd" else records
        records = record(6, head + struct.pack("<Q", len(packed)) + packed)
    return b"\x89MCAP0\r\n" + record(1, text("ros2") + text("test")) + records + record(15, struct.pack("<I", 0))
