#!/usr/bin/python3
"""./scripts/make_tank_models.py [FOLDER]: writes the meshes of scenes/watertank.yaml to scenes/meshes.

Sizes are those that the objects have in the frames of docs/compare.md, in meters, z up. `tank_tire` is a torus with a
thick bar, `tank_hook` has the shape of a question mark, `tank_valve` is a hub with four handles, `tank_propeller` has
three blades, and `tank_bottle` and `tank_can` are ribs: in the frames, the near side, the top and the far side of
bottles and cans appear as lines. The built-in models have other proportions.
"""
import sys
from pathlib import Path

import numpy as np

from real_crops.meshes import joined, propeller, tube, write_obj

HANDLES_DEG = (35, 145, 215, 325)


def arc(radius, from_deg, to_deg, count):
    angle = np.radians(np.linspace(from_deg, to_deg, count))
    return radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], 1)


def line(start, end, count=4):
    return np.linspace(start, end, count).astype(float)


def tire():
    return tube(arc(0.108, 0, 360, 49), 0.052, 16)


def hook():
    bow = arc(0.055, 200, -60, 16) + [0, 0.05, 0]
    return tube(np.concatenate([bow, line(bow[-1] + [-0.02, -0.015, 0], [-0.015, -0.115, 0])]), 0.021, 10)


def valve():
    ways = [np.array([np.cos(angle), np.sin(angle), 0]) for angle in np.radians(HANDLES_DEG)]
    stem = tube(line([0, 0, -0.1], [0, 0, 0.03]), 0.03, 12)
    return joined([stem, *(tube(line(0.01 * way, 0.2 * way), 0.01, 8) for way in ways)])


def ribs(length_m, radius_m):
    """Lines along x at the near side, the top and the far side of a body whose wall lets sound through."""
    sides = [radius_m * np.array([0, np.cos(angle), np.sin(angle)]) for angle in np.radians((0, 90, 180))]
    return [tube(line([0, 0, 0] + side, [length_m, 0, 0] + side), 0.011, 8) for side in sides]


def bottle():
    shoulders = [tube(line([0.27, 0, 0] + rib, [0.36, 0, 0] + rib / 4), 0.011, 8)
                 for rib in 0.06 * np.array([[0, 1, 0], [0, 0, 1], [0, -1, 0]])]
    return joined([*ribs(0.27, 0.06), *shoulders, tube(line([0.36, 0, 0], [0.4, 0, 0]), 0.02, 10)])


def can():
    ends = [tube(line([x, -0.05, 0], [x, 0.05, 0]), 0.011, 8) for x in (0, 0.13)]
    return joined([*ribs(0.13, 0.055), *ends])


MODELS = {
    "tank_bottle": bottle,
    "tank_can": can,
    "tank_tire": tire,
    "tank_hook": hook,
    "tank_valve": valve,
    "tank_propeller": lambda: propeller(3, 0.7, 0.9, 0.03),
}

if __name__ == "__main__":
    default = Path(__file__).resolve().parents[1] / "scenes/meshes"
    for name, model in MODELS.items():
        vertices, triangles = model()
        write_obj((Path(sys.argv[1]) if len(sys.argv) > 1 else default) / f"{name}.obj", (vertices, triangles))
