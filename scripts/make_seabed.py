#!/usr/bin/env python3
"""Writes scenes/meshes/seabed.obj: 16 m x 12 m of sand with ripples and gentle hills.

    ./scripts/make_seabed.py [FILE]

The same bytes every time: no random numbers, heights rounded to a tenth of a millimeter.
"""
import math
import pathlib
import sys

LENGTH_M, WIDTH_M, STEP_M = 16.0, 12.0, 0.16


def height_m(x: float, y: float) -> float:
    """Hills of 5-9 m and ripples of 0.8 m wavelength with slightly curved crests."""
    hills = 0.10 * math.sin(2 * math.pi * x / 9.0 + 0.7) * math.cos(2 * math.pi * y / 7.0)
    hills += 0.05 * math.cos(2 * math.pi * (x + y) / 5.0)
    ripples = 0.03 * math.sin(2 * math.pi * (x + 0.3 * math.sin(y)) / 0.8)
    return hills + ripples


def write_obj(path: pathlib.Path) -> None:
    columns = round(LENGTH_M / STEP_M) + 1
    rows = round(WIDTH_M / STEP_M) + 1
    lines = ["# seabed of scripts/make_seabed.py; metres, z up"]
    for j in range(rows):
        for i in range(columns):
            x, y = i * STEP_M - LENGTH_M / 2, j * STEP_M - WIDTH_M / 2
            lines.append(f"v {x:.2f} {y:.2f} {height_m(x, y):.4f}")
    for j in range(rows - 1):
        for i in range(columns - 1):
            a = j * columns + i + 1
            b = a + columns
            lines.append(f"f {a} {a + 1} {b + 1}")
            lines.append(f"f {a} {b + 1} {b}")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent / "scenes/meshes/seabed.obj"
    write_obj(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default)
