"""Writers of the formats that a fault is planted in, and that the readers are tested with, as plain as they can be."""
import struct
import zlib

import numpy as np

PIXEL_TYPES = {"<u4": 0, "<f2": 1, "<f4": 2}


def png_bytes(image, filters=(0,)):
    """A grey PNG; row y is written with the filter filters[y % len(filters)]."""
    depth = 16 if image.dtype == np.uint16 else 8
    step = depth // 8
    rows = (
        np.ascontiguousarray(image, ">u2").view(np.uint8).reshape(len(image), -1)
        if step == 2
        else image
    )
    body = bytearray()
    previous = [0] * rows.shape[1]
    for y, row in enumerate(rows.tolist()):
        kind = filters[y % len(filters)]
        body.append(kind)
        for i, value in enumerate(row):
            left = row[i - step] if i >= step else 0
            corner = previous[i - step] if i >= step else 0
            up = previous[i]
            nearest = min((left, up, corner), key=lambda v: abs(left + up - corner - v))
            guess = (0, left, up, (left + up) // 2, nearest)[kind]
            body.append((value - guess) & 255)
        previous = row
    header = struct.pack(">IIBBBBB", image.shape[1], image.shape[0], depth, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in ((b"IHDR", header), (b"IDAT", zlib.compress(bytes(body))), (b"IEND", b""))
    )


def _exr_attribute(name, kind, body):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(body)) + body


def _exr_header(name, channels, compression, numbers, multi_part):
    """One part's header; `numbers` are further attributes of type double."""
    height, width = next(iter(channels.values())).shape
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    listed = (
        b"".join(
            channel.encode() + b"\0" + struct.pack("<iB3xii", PIXEL_TYPES[array.dtype.str], 0, 1, 1)
            for channel, array in sorted(channels.items())
        )
        + b"\0"
    )
    chunks = -(-height // (16 if compression == "zip" else 1))
    header = (
        _exr_attribute("channels", "chlist", listed)
        + _exr_attribute(
            "compression", "compression", bytes([{"none": 0, "zips": 2, "zip": 3}[compression]])
        )
        + _exr_attribute("dataWindow", "box2i", window)
        + _exr_attribute("displayWindow", "box2i", window)
        + _exr_attribute("lineOrder", "lineOrder", b"\0")
        + _exr_attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
        + _exr_attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
        + _exr_attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    )
    for key, value in numbers.items():
        header += _exr_attribute(key, "double", struct.pack("<d", value))
    if multi_part:
        header += (
            _exr_attribute("name", "string", name.encode())
            + _exr_attribute("type", "string", b"scanlineimage")
            + _exr_attribute("chunkCount", "int", struct.pack("<i", chunks))
        )
    return header + b"\0"


def _exr_zip(raw):
    data = np.frombuffer(raw, np.uint8)
    split = np.concatenate([data[0::2], data[1::2]]).astype(np.int64)
    split[1:] = (split[1:] - split[:-1] + 128) & 255
    packed = zlib.compress(split.astype(np.uint8).tobytes())
    return packed if len(packed) < len(raw) else raw


def _exr_chunks(channels, compression):
    height = next(iter(channels.values())).shape[0]
    rows = 16 if compression == "zip" else 1
    for first in range(0, height, rows):
        raw = b"".join(
            array[y].tobytes()
            for y in range(first, min(first + rows, height))
            for _, array in sorted(channels.items())
        )
        yield first, raw if compression == "none" else _exr_zip(raw)


def exr_bytes(parts):
    """Scanline EXR of [(name, {channel: array}, compression, {attribute: number})]."""
    multi_part = len(parts) > 1
    out = struct.pack("<iI", 20000630, 2 | (0x1000 if multi_part else 0))
    out += b"".join(_exr_header(*part, multi_part) for part in parts) + (
        b"\0" if multi_part else b""
    )
    chunks = [
        [
            struct.pack("<i", number) * multi_part + struct.pack("<ii", y, len(data)) + data
            for y, data in _exr_chunks(part[1], part[2])
        ]
        for number, part in enumerate(parts)
    ]
    offset = len(out) + 8 * sum(map(len, chunks))
    for part_chunks in chunks:
        for chunk in part_chunks:
            out += struct.pack("<Q", offset)
            offset += len(chunk)
    return out + b"".join(chunk for part_chunks in chunks for chunk in part_chunks)


def encode_rle(mask):
    """COCO's compressed run lengths of a boolean mask."""
    flat = mask.T.reshape(-1)
    edges = np.nonzero(np.diff(flat))[0] + 1
    runs = np.diff(np.concatenate([[0], edges, [flat.size]])).tolist()
    if flat[0]:
        runs = [0] + runs
    text = ""
    for i, run in enumerate(runs):
        value = run - runs[i - 2] if i > 2 else run
        while True:
            bits, value = value & 31, value >> 5
            done = value == (-1 if bits & 16 else 0)
            text += chr(48 + (bits | (0 if done else 32)))
            if done:
                break
    return text
