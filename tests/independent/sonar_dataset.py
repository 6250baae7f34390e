"""Readers for the file formats of a data set, written from the formats' descriptions.

NPY, PNG (8 and 16 bit grey), OpenEXR (scanline, one or several parts, half or float or
uint, compressions NONE, ZIPS and ZIP) and COCO's compressed run lengths. NumPy and the
standard library only, so that nothing is shared with the program that wrote the files.
"""
import ast
import csv
import json
import struct
import zlib

import numpy as np


def read_json(path):
    """JSON with keys given twice refused, since a reader would silently keep one of them."""

    def no_duplicates(pairs):
        keys = [key for key, _ in pairs]
        if len(set(keys)) != len(keys):
            raise ValueError(f"{path}: a key is given twice among {keys}")
        return dict(pairs)

    with open(path, encoding="utf-8") as stream:
        return json.load(stream, object_pairs_hook=no_duplicates)


def read_csv(path):
    """Header and rows of text."""
    with open(path, encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream))
    if not rows:
        raise ValueError(f"{path}: empty")
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise ValueError(f"{path}:{number}: {len(row)} columns, the header has {len(rows[0])}")
    return rows[0], rows[1:]


def read_npy(path):
    """An NPY array, versions 1 to 3, C order; trailing or missing bytes are errors."""
    with open(path, "rb") as stream:
        data = stream.read()
    if data[:6] != b"\x93NUMPY":
        raise ValueError(f"{path}: no NPY magic")
    major = data[6]
    if major == 1:
        header_size, start = struct.unpack("<H", data[8:10])[0], 10
    elif major in (2, 3):
        header_size, start = struct.unpack("<I", data[8:12])[0], 12
    else:
        raise ValueError(f"{path}: NPY version {major}")
    header = ast.literal_eval(data[start : start + header_size].decode("utf-8"))
    if header["fortran_order"]:
        raise ValueError(f"{path}: Fortran order")
    descr = header["descr"]
    if isinstance(descr, list):
        descr = [tuple(field) for field in descr]
    dtype = np.dtype(descr)
    body = data[start + header_size :]
    expected_bytes = int(np.prod(header["shape"], dtype=np.int64)) * dtype.itemsize
    if len(body) != expected_bytes:
        raise ValueError(f"{path}: {len(body)} bytes of data, {expected_bytes} expected")
    return np.frombuffer(body, dtype).reshape(header["shape"])


def _png_chunks(path, data):
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError(f"{path}: no PNG signature")
    position, chunks = 8, []
    while position < len(data):
        size, kind = struct.unpack(">I4s", data[position : position + 8])
        body = data[position + 8 : position + 8 + size]
        check = struct.unpack(">I", data[position + 8 + size : position + 12 + size])[0]
        if zlib.crc32(kind + body) != check:
            raise ValueError(f"{path}: CRC of chunk {kind} is wrong")
        chunks.append((kind, body))
        position += 12 + size
    if not chunks or chunks[0][0] != b"IHDR" or chunks[-1][0] != b"IEND":
        raise ValueError(f"{path}: IHDR or IEND is missing")
    return chunks


def _paeth(left, up, corner):
    estimate = left + up - corner
    distances = (abs(estimate - left), abs(estimate - up), abs(estimate - corner))
    nearest = min(distances)
    return left if nearest == distances[0] else up if nearest == distances[1] else corner


def _png_unfilter_row(kind, row, previous, step):
    """Undo one row's filter; rows are uint8 arrays, `step` bytes per pixel."""
    if kind == 0:
        return row
    if kind == 2:
        return row + previous
    if kind == 1:
        columns = row.reshape(-1, step).astype(np.uint64)
        return (np.cumsum(columns, axis=0) & 255).astype(np.uint8).reshape(-1)
    if kind not in (3, 4):
        raise ValueError(f"PNG filter {kind}")
    out = [0] * len(row)
    up_row = previous.tolist()
    for i, value in enumerate(row.tolist()):
        left = out[i - step] if i >= step else 0
        corner = up_row[i - step] if i >= step else 0
        guess = (left + up_row[i]) // 2 if kind == 3 else _paeth(left, up_row[i], corner)
        out[i] = (value + guess) & 255
    return np.array(out, np.uint8)


def read_png(path):
    """A grey PNG as a uint8 or uint16 array; its text chunks are in read_png_text."""
    with open(path, "rb") as stream:
        data = stream.read()
    chunks = _png_chunks(path, data)
    width, height, depth, colour, compression, filtering, interlace = struct.unpack(
        ">IIBBBBB", chunks[0][1]
    )
    if colour != 0 or depth not in (8, 16) or compression or filtering or interlace:
        raise ValueError(
            f"{path}: not a plain 8 or 16 bit grey PNG (colour {colour}, depth {depth})"
        )
    step = depth // 8
    raw = np.frombuffer(
        zlib.decompress(b"".join(body for kind, body in chunks if kind == b"IDAT")), np.uint8
    )
    row_bytes = width * step
    if raw.size != height * (row_bytes + 1):
        raise ValueError(f"{path}: {raw.size} bytes of pixels, {height * (row_bytes + 1)} expected")
    raw = raw.reshape(height, row_bytes + 1)
    pixels = np.empty((height, row_bytes), np.uint8)
    previous = np.zeros(row_bytes, np.uint8)
    for y in range(height):
        previous = _png_unfilter_row(int(raw[y, 0]), raw[y, 1:], previous, step)
        pixels[y] = previous
    if step == 2:
        return pixels.view(">u2").astype(np.uint16)
    return pixels


def read_png_chunk_names(path):
    """Names of a PNG's chunks in order, for the check that no time stamp is written."""
    with open(path, "rb") as stream:
        return [kind.decode("latin-1") for kind, _ in _png_chunks(path, stream.read())]


class ExrPart:
    """One part of an EXR file: its header's attributes and its channels as arrays."""

    def __init__(self, attributes):
        self.attributes = attributes
        self.channels = {}
        self.x_min, self.y_min, x_max, y_max = attributes["dataWindow"]
        self.width, self.height = x_max - self.x_min + 1, y_max - self.y_min + 1

    @property
    def name(self):
        return self.attributes.get("name", "")

    @property
    def shape(self):
        return self.height, self.width

    @property
    def compression(self):
        return {0: "none", 1: "rle", 2: "zips", 3: "zip"}.get(
            self.attributes["compression"], "other"
        )


def _exr_text(data, position):
    end = data.index(b"\0", position)
    return data[position:end].decode("utf-8"), end + 1


def _exr_channel_list(body):
    """Channels of a chlist attribute in file order: (name, NumPy type)."""
    channels, position = [], 0
    while body[position] != 0:
        name, position = _exr_text(body, position)
        kind, _, x_sampling, y_sampling = struct.unpack("<iIii", body[position : position + 16])
        if (x_sampling, y_sampling) != (1, 1):
            raise ValueError(f"channel {name} is subsampled")
        channels.append((name, ("<u4", "<f2", "<f4")[kind]))
        position += 16
    return channels


def _exr_value(kind, body):
    plain = {
        "int": "<i",
        "float": "<f",
        "double": "<d",
        "box2i": "<4i",
        "box2f": "<4f",
        "v2f": "<2f",
        "v2d": "<2d",
        "v2i": "<2i",
        "v3f": "<3f",
        "v3d": "<3d",
    }
    if kind in plain:
        values = struct.unpack(plain[kind], body)
        return values[0] if len(values) == 1 else values
    if kind == "string":
        return body.decode("utf-8")
    if kind in ("compression", "lineOrder"):
        return body[0]
    if kind == "chlist":
        return _exr_channel_list(body)
    return body


def _exr_header(data, position):
    attributes = {}
    while data[position] != 0:
        name, position = _exr_text(data, position)
        kind, position = _exr_text(data, position)
        size = struct.unpack("<i", data[position : position + 4])[0]
        attributes[name] = _exr_value(kind, data[position + 4 : position + 4 + size])
        position += 4 + size
    return attributes, position + 1


def _exr_unzip(packed, raw_bytes):
    """Undo EXR's ZIP: deflate, then the byte predictor, then the two interleaved halves."""
    if len(packed) == raw_bytes:
        return packed
    deltas = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
    if deltas.size != raw_bytes:
        raise ValueError(f"EXR chunk holds {deltas.size} bytes, {raw_bytes} expected")
    deltas[1:] -= 128
    restored = (np.cumsum(deltas) & 255).astype(np.uint8)
    half = (raw_bytes + 1) // 2
    out = np.empty(raw_bytes, np.uint8)
    out[0::2] = restored[:half]
    out[1::2] = restored[half:]
    return out.tobytes()


def _exr_read_chunk(data, offset, part, part_number, multi_part):
    if multi_part:
        number = struct.unpack("<i", data[offset : offset + 4])[0]
        if number != part_number:
            raise ValueError(f"chunk of part {number} found in the table of part {part_number}")
        offset += 4
    y, size = struct.unpack("<ii", data[offset : offset + 8])
    body = data[offset + 8 : offset + 8 + size]
    first_row = y - part.y_min
    row_count = min({"none": 1, "zips": 1, "zip": 16}[part.compression], part.height - first_row)
    row_bytes = sum(part.width * np.dtype(kind).itemsize for _, kind in part.attributes["channels"])
    raw = body if part.compression == "none" else _exr_unzip(body, row_count * row_bytes)
    if len(raw) != row_count * row_bytes:
        raise ValueError(
            f"EXR chunk at row {first_row}: {len(raw)} bytes, {row_count * row_bytes} expected"
        )
    position = 0
    for row in range(first_row, first_row + row_count):
        for name, kind in part.attributes["channels"]:
            part.channels[name][row] = np.frombuffer(raw, kind, part.width, position)
            position += part.width * np.dtype(kind).itemsize
    return row_count


def read_exr(path):
    """All parts of a scanline EXR file, in file order."""
    with open(path, "rb") as stream:
        data = stream.read()
    magic, version = struct.unpack("<iI", data[:8])
    if magic != 20000630 or version & 0xFF != 2:
        raise ValueError(f"{path}: no OpenEXR 2 file")
    if version & 0xA00:
        raise ValueError(f"{path}: tiled or deep")
    multi_part = bool(version & 0x1000)
    parts, position = [], 8
    while True:
        attributes, position = _exr_header(data, position)
        parts.append(ExrPart(attributes))
        if not multi_part:
            break
        if data[position] == 0:
            position += 1
            break
    for number, part in enumerate(parts):
        if part.compression not in ("none", "zips", "zip"):
            raise ValueError(
                f"{path}: compression {part.attributes['compression']} is not read here"
            )
        for name, kind in part.attributes["channels"]:
            part.channels[name] = np.empty((part.height, part.width), kind)
        rows_per_chunk = 16 if part.compression == "zip" else 1
        chunk_count = -(-part.height // rows_per_chunk)
        offsets = struct.unpack(f"<{chunk_count}Q", data[position : position + 8 * chunk_count])
        position += 8 * chunk_count
        rows = sum(_exr_read_chunk(data, offset, part, number, multi_part) for offset in offsets)
        if rows != part.height:
            raise ValueError(f"{path}: part {part.name} has {rows} rows, {part.height} expected")
    return parts


def decode_rle(counts, height, width):
    """COCO's compressed run lengths to a boolean mask (runs go down the columns).

    Each number is written in groups of 5 bits, lowest first, as characters from '0' on; bit 5
    marks that more follow, bit 4 of the last group is the sign; from the fourth number on it
    is the difference to the number two places before.
    """
    runs, position = [], 0
    while position < len(counts):
        value, shift, more = 0, 0, True
        while more:
            bits = ord(counts[position]) - 48
            if not 0 <= bits < 64:
                raise ValueError(f"RLE holds the character {counts[position]!r}")
            value |= (bits & 31) << shift
            shift += 5
            more = bool(bits & 32)
            position += 1
            if not more and bits & 16:
                value -= 1 << shift
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
    if any(run < 0 for run in runs) or sum(runs) != height * width:
        raise ValueError(f"RLE runs add to {sum(runs)}, the image has {height * width} pixels")
    flat = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    return flat.reshape(width, height).T
