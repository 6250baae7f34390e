#!/usr/bin/env python3
"""Rebuilds the .aris log of a recording of the UXO Dataset 2024 (Dahn et al.), whose frames are stored as images.

    scripts/uxo2024_log.py recordings/100lbs/NAME NAME.aris
    ensonify import NAME.aris -o NAME

Reads aris_raw/*.pgm, which hold the samples in the order of the log, and aris_frame_meta.csv, which holds the headers of
the frames. Frames without an image are left out. Of the headers it writes what `ensonify import` reads."""
import argparse
import csv
import struct
import sys
from pathlib import Path

HEADER_BYTES = 1024
SIGNATURE = 0x05464444
# Offset and type of the members of a frame header, by their names in the table (Sound Metrics, aris-file-sdk).
MEMBERS = {
    "FrameIndex": (0, "I"), "FrameTime": (4, "Q"), "Version": (12, "I"), "sonarTimeStamp": (20, "Q"),
    "WindowStart": (52, "f"), "WindowLength": (56, "f"), "Depth": (128, "f"), "Pitch": (136, "f"), "Roll": (144, "f"),
    "Heading": (152, "f"), "CompassHeading": (160, "f"), "CompassPitch": (164, "f"), "CompassRoll": (168, "f"),
    "SampleRate": (420, "f"), "PingMode": (436, "I"), "FrequencyHiLow": (440, "I"), "SamplePeriod": (452, "I"),
    "SoundSpeed": (464, "f"), "SamplesPerBeam": (468, "I"), "SampleStartDelay": (476, "I"), "LargeLens": (480, "I"),
    "TheSystemType": (484, "I"), "SonarSerialNumber": (488, "I"), "ReorderedSamples": (516, "I"),
}


def pgm_samples(path):
    """The bytes of an 8-bit binary PGM, and its columns and rows."""
    data = path.read_bytes()
    words, at = [], 0
    while len(words) < 4:
        end = at
        while end < len(data) and not data[end:end + 1].isspace():
            end += 1
        if data[at:at + 1] == b"#":
            end = data.index(b"\n", at)
        elif end > at:
            words.append(data[at:end])
        at = end + 1
    columns, rows, most = map(int, words[1:])
    if words[0] != b"P5" or most > 255 or len(data) - at != rows * columns:
        sys.exit(f"{path}: is not a binary 8-bit PGM")
    return data[at:], columns, rows


def frame_header(row, path):
    header = bytearray(HEADER_BYTES)
    for name, (offset, kind) in MEMBERS.items():
        if name not in row:
            sys.exit(f"{path}: has no column {name}")
        struct.pack_into("<" + kind, header, offset, float(row[name]) if kind == "f" else int(float(row[name])))
    return bytes(header)


def log_bytes(folder):
    table = folder / "aris_frame_meta.csv"
    frames = []
    with open(table, newline="") as file:
        for row in csv.DictReader(file):
            image = folder / "aris_raw" / f"{int(row['FrameIndex']):04}.pgm"
            if not image.exists():
                continue
            samples, _, rows = pgm_samples(image)
            if rows != int(float(row["SamplesPerBeam"])):
                sys.exit(f"{image}: has {rows} rows, and {table} says {row['SamplesPerBeam']} samples")
            frames.append(frame_header(row, table) + samples)
    if not frames:
        sys.exit(f"{folder}: has no frames")
    header = bytearray(HEADER_BYTES)
    struct.pack_into("<II", header, 0, SIGNATURE, len(frames))
    return bytes(header) + b"".join(frames)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("recording", type=Path, help="folder with aris_raw/ and aris_frame_meta.csv")
    parser.add_argument("log", type=Path, help="the .aris file to write")
    options = parser.parse_args()
    options.log.write_bytes(log_bytes(options.recording))


if __name__ == "__main__":
    main()
