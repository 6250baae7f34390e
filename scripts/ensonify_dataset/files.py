"""Readers of the files of a data set: grey PNG, scanline EXR of several parts, COCO run lengths.

A data set may come from anywhere: whatever a file claims is held against its size before memory is
taken, and every fault in it is a DatasetError.
"""
from __future__ import annotations

import io
import mmap
import struct
import tokenize
import zlib
from pathlib import Path
from typing import Any, Dict, List, Tuple, Union

import numpy as np

# What reading damaged bytes raises, NumPy's parser of headers included.
FAULTS = (OSError, ValueError, IndexError, KeyError, TypeError, AttributeError, OverflowError, SyntaxError,
          MemoryError, RecursionError, struct.error, zlib.error, tokenize.TokenError)
# Deflate packs 258 bytes into two bits at best.
_DEFLATE_AT_MOST = 1032
_MAX_PIXELS = 1 << 28


class DatasetError(Exception):
    """What is wrong with a data set, where, and what to do about it."""


def unreadable(path: Union[str, Path], fault: Exception) -> DatasetError:
    """The error for a file that is missing or is not what its name says."""
    why = getattr(fault, "strerror", None) or str(fault)
    return DatasetError(f"{path}: cannot be read: {why}; `ensonify verify` on the data set's folder "
                        "lists the files that are missing or damaged")


def read_bytes(path: Union[str, Path]) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as fault:
        raise unreadable(path, fault) from fault


def read_npy(path: Union[str, Path]) -> np.ndarray:
    """An array, memory-mapped."""
    try:
        with open(path, "rb") as file:
            head = file.read(12)
        # NumPy takes memory for as long a header as is claimed, up to 4 GB.
        if head[6:7] != b"\1" and struct.unpack_from("<I", head, 8)[0] > 0xFFFF:
            raise ValueError("a header of more than 65,535 bytes")
        return np.lib.format.open_memmap(path, mode="r")
    except FAULTS as fault:
        raise unreadable(path, fault) from fault


def read_png(path: Union[str, Path]) -> np.ndarray:
    """A plain grey PNG, uint8 or uint16, or the gray levels of one with a palette, uint8, [rows, columns]; of one in red,
    green and blue, uint8 [rows, columns, 3]."""
    data = read_bytes(path)
    try:
        return _decode_png(data)
    except FAULTS as fault:
        raise unreadable(path, fault) from fault


def read_jpeg(path: Union[str, Path]) -> np.ndarray:
    """A grey JPEG of a render, uint8 [rows, columns]; needs Pillow."""
    try:
        from PIL import Image  # type: ignore[import]
    except ImportError as error:
        raise DatasetError(f"{path}: reading JPEG files needs Pillow (python3-pil); `ensonify render` without "
                           "--jpeg-quality writes PNG files, and `displayed` needs no files") from error
    data = read_bytes(path)
    try:
        with Image.open(io.BytesIO(data), formats=["JPEG"]) as image:
            return np.array(image.convert("L"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as fault:
        raise unreadable(path, fault) from fault


def _inflated(packed: bytes, size: int) -> bytes:
    """What deflates to `packed`, which has to be of that size: no more than a byte beyond it is made."""
    if size > _DEFLATE_AT_MOST * len(packed):
        raise ValueError(f"claims {size} bytes of {len(packed)} packed ones")
    raw = zlib.decompressobj().decompress(packed, size + 1)
    if len(raw) != size:
        raise ValueError(f"not the {size} bytes that its header claims")
    return raw


def _decode_png(data: bytes) -> np.ndarray:
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("no PNG file")
    width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    # Of a render in colors the indices into its palette are the gray levels.
    if (colour, depth) not in ((0, 8), (0, 16), (3, 8), (2, 8)) or interlaced:
        raise ValueError("not a PNG of 8 or 16 bits of gray, or of 8-bit colors")
    position, packed = 8, []
    while position < len(data):
        size, kind = struct.unpack_from(">I4s", data, position)
        if kind == b"IDAT":
            packed.append(data[position + 8 : position + 8 + size])
        position += 12 + size
    step = 3 if colour == 2 else depth // 8
    raw = np.frombuffer(_inflated(b"".join(packed), height * (1 + width * step)), np.uint8)
    raw = raw.reshape(height, 1 + width * step)
    pixels = np.array(raw[:, 1:])
    # ensonify filters no rows; another program that packed the files anew may have.
    for y in np.flatnonzero(raw[:, 0]):
        above = pixels[y - 1] if y else np.zeros(width * step, np.uint8)
        pixels[y] = _unfiltered(int(raw[y, 0]), raw[y, 1:].tobytes(), above.tobytes(), step)
    if step == 3:
        return pixels.reshape(height, width, 3)
    return pixels if step == 1 else pixels.view(">u2").astype(np.uint16)


def _unfiltered(kind: int, row: bytes, above: bytes, step: int) -> np.ndarray:
    if kind > 4:
        raise ValueError(f"PNG filter {kind}")
    out = bytearray(row)
    for i in range(len(out)):
        left, corner = (out[i - step], above[i - step]) if i >= step else (0, 0)
        up = above[i]
        if kind == 4:
            ahead = left + up - corner
            guess = min((left, up, corner), key=lambda neighbour: abs(ahead - neighbour))
        else:
            guess = (0, left, up, (left + up) // 2)[kind]
        out[i] = (out[i] + guess) & 255
    return np.frombuffer(bytes(out), np.uint8)


def read_exr(path: Union[str, Path], part: int = 0) -> Dict[str, np.ndarray]:
    """The channels of one part of a scanline EXR, uncompressed, ZIPS or ZIP; each [rows, columns].

    The other parts are not read.
    """
    try:
        with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return _decode_exr(data, part)
    except FAULTS as fault:
        raise unreadable(path, fault) from fault


def _exr_header(data: Any, position: int) -> Tuple[Dict[str, bytes], int]:
    """Attributes as bytes, and where the next header begins."""
    attributes = {}
    while data[position] != 0:
        name_end = data.find(b"\0", position)
        kind_end = data.find(b"\0", name_end + 1)
        if not position < name_end < kind_end:
            raise ValueError("a header without end")
        (size,) = struct.unpack_from("<I", data, kind_end + 1)
        start = kind_end + 5
        attributes[data[position:name_end].decode()] = data[start : start + size]
        position = start + size
    return attributes, position + 1


def _exr_channels(body: bytes) -> List[Tuple[str, np.dtype]]:
    channels, position = [], 0
    while body[position] != 0:
        end = body.index(b"\0", position)
        (kind,) = struct.unpack_from("<I", body, end + 1)
        channels.append((body[position:end].decode(), np.dtype(("<u4", "<f2", "<f4")[kind])))
        position = end + 17
    return channels


def _exr_unzipped(packed: bytes, size: int) -> bytes:
    """Deflated differences of neighbouring bytes, those of even places before those of odd ones."""
    if len(packed) == size:
        return packed
    steps = np.frombuffer(_inflated(packed, size), np.uint8).copy()
    steps[1:] -= 128
    planes = np.add.accumulate(steps, dtype=np.uint8)
    out = np.empty(size, np.uint8)
    out[0::2], out[1::2] = planes[: (size + 1) // 2], planes[(size + 1) // 2 :]
    return out.tobytes()


def _decode_exr(data: Any, part: int) -> Dict[str, np.ndarray]:
    magic, version = struct.unpack_from("<iI", data)
    if magic != 20000630 or version & 0xA00:
        raise ValueError("no scanline EXR file")
    several = bool(version & 0x1000)
    headers: List[Dict[str, Any]] = []
    position = 8
    while not headers or (several and data[position] != 0):
        header, position = _exr_header(data, position)
        headers.append(header)
    position += several
    for header in headers[: part + 1]:
        left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
        height, width = bottom - top + 1, right - left + 1
        chunk_rows = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
        table = position
        position += 8 * -(-height // chunk_rows)
    channels = _exr_channels(headers[part]["channels"])
    row_bytes = width * sum(kind.itemsize for _, kind in channels)
    if min(height, width) < 1 or height * row_bytes > _DEFLATE_AT_MOST * len(data):
        raise ValueError(f"claims {width} x {height} pixels in {len(data)} bytes")
    out = {name: np.empty((height, width), kind) for name, kind in channels}
    for i, offset in enumerate(struct.unpack_from(f"<{(position - table) // 8}Q", data, table)):
        first, rows = i * chunk_rows, min(chunk_rows, height - i * chunk_rows)
        start = offset + (12 if several else 8)
        owner, y, size = struct.unpack_from("<iiI", data, start - 12)
        if y != top + first or (several and owner != part):
            raise ValueError(f"rows {y - top} stand in the place of rows {first}")
        raw = _exr_unzipped(data[start : start + size], rows * row_bytes)
        lines = np.frombuffer(raw, np.uint8).reshape(rows, row_bytes)
        place = 0
        for name, kind in channels:
            end = place + width * kind.itemsize
            out[name][first : first + rows] = np.ascontiguousarray(lines[:, place:end]).view(kind)
            place = end
    return out


def decode_rle(counts: str, height: int, width: int) -> np.ndarray:
    """A boolean mask [height, width] from COCO's compressed run lengths; ValueError if they are none of that size."""
    runs: List[int] = []
    value = shift = 0
    for letter in counts:
        bits = ord(letter) - 48
        value |= (bits & 31) << shift
        shift += 5
        if shift > 60:
            raise ValueError("run lengths without end")
        if bits & 32:
            continue
        if bits & 16:
            value -= 1 << shift
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
        value = shift = 0
    if not 0 <= height * width <= _MAX_PIXELS or sum(runs) != height * width or min(runs, default=0) < 0:
        raise ValueError(f"run lengths of no mask of {width} x {height} pixels")
    flat = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    return flat.reshape(width, height).T
