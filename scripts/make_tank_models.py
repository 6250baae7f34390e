#!/usr/bin/python3
"""./scripts/make_tank_models.py [FOLDER]: writes the meshes of scenes/watertank.yaml to scenes/meshes.

Shapes and sizes are those that the objects have in the frames for fitting of docs/real_study.md, in meters, z up. x
points away from the sonar in bodies that the scene does not turn. Bottles and cans are bars: in the frames, the near
side, the top and the far side appear as lines. The built-in models have other proportions.
"""
import sys
from pathlib import Path

import numpy as np

from real_crops.meshes import joined, tube, write_obj

HANDLES_DEG = (55, 125, 235, 305)
STRANDS = (1, 2, 2, 3)      # of the chains
HEAPS = 3


def arc(radius, from_deg, to_deg, count):
    angle = np.radians(np.linspace(from_deg, to_deg, count))
    return radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], 1)


def line(start, end, count=4):
    return np.linspace(start, end, count).astype(float)


def tire():
    return tube(arc(0.108, 0, 360, 49), 0.052, 16)


def hook():
    bow = arc(0.04, 200, -60, 16) + [0, 0.05, 0]
    return tube(np.concatenate([bow, line(bow[-1] + [-0.02, -0.015, 0], [-0.015, -0.095, 0])]), 0.031, 10)


def valve():
    """A hub with four handles."""
    ways = [np.array([np.cos(angle), np.sin(angle), 0]) for angle in np.radians(HANDLES_DEG)]
    hub = tube(line([0, 0, -0.1], [0, 0, 0.04]), 0.05, 12)
    return joined([hub, *(tube(line(0.01 * way, 0.19 * way), 0.011, 8) for way in ways)])


def bars(length_m, places_m, radii_m):
    """Along x at each (y, z): the sides of a body whose wall lets sound through."""
    return [tube(line([0, *place], [length_m, *place]), radius, 8) for place, radius in zip(places_m, radii_m)]


def bottle():
    ends = [tube(line([x, -0.035, 0.03], [x, 0.04, 0.03]), 0.004, 6) for x in (0, 0.25)]
    return joined([*bars(0.25, [(0.045, 0.03), (0.01, 0.06), (-0.045, 0.03)], (0.018, 0.004, 0.01)), *ends])


def can():
    sides = [tube(line([x, -0.07, 0.04], [x, 0.05, 0.04]), 0.005, 8) for x in (0, 0.15)]
    return joined([*bars(0.15, [(0.05, 0.03), (-0.01, 0.08), (-0.07, 0.06)], (0.022, 0.012, 0.007)), *sides])


def standing_bottle():
    return joined([tube(line([0, 0, 0], [0.2, 0, 0]), 0.05, 16), tube(line([0.2, 0, 0], [0.26, 0, 0]), 0.025, 12)])


def chain(rng, strands):
    """Heavy links that lie close, as ridges across curves."""
    links = []
    for strand in range(strands):
        yaw_rad = np.cumsum(rng.normal(0, 0.3, 24)) + rng.uniform(-0.5, 0.5)
        centers = np.cumsum(0.034 * np.stack([np.cos(yaw_rad), np.sin(yaw_rad), np.zeros(24)], 1), 0)
        centers += [*(-centers.mean(0) + rng.uniform(-0.12, 0.12, 3))[:2], 0.02 * strand]
        links += [tube(line(a + 0.1 * (b - a), a + 0.8 * (b - a), 2), radius, 8)
                  for a, b, radius in zip(centers, centers[1:], rng.uniform(0.04, 0.06, 23))]
    return joined(links)


def propeller():
    """A hub and three round blades, of which the first points to the sonar; their edges appear brightest."""
    parts = [tube(line([0, 0, -0.2], [0, 0, 0.25]), 0.24, 16)]
    for number, angle in enumerate(np.radians((180, 60, 300))):
        center = 0.62 * np.array([np.cos(angle), np.sin(angle), 0])
        edge = arc(0.38, 0, 360, 25)
        edge[:, 2] = 0.4 * edge @ [-np.sin(angle), np.cos(angle), 0]
        parts.append(tube(center + edge, 0.08, 8))
        if number != 1:
            parts.append(tube(line(center - [0, 0, 0.01], center + [0, 0, 0.01], 3), 0.3, 16))
    return joined(parts)


def debris(rng):
    """Lumps behind each other, as echoes of echoes appear."""
    places = np.stack([np.sort(rng.uniform(0, 0.6, 7)), rng.normal(0, 0.02, 7), np.zeros(7)], 1)
    return joined([tube(line(place, place + rng.normal(0, 0.03, 3), 2), rng.uniform(0.008, 0.025), 8)
                   for place in places])


def rim():
    """A bow across the whole fan, as the frames have it at the nearest ranges."""
    along = np.linspace(-1, 1, 25)
    return tube(0.35 * np.stack([1 - np.cos(along), 2 * np.sin(along), 0 * along], 1), 0.018, 8)


MODELS = {
    "bottle": bottle,
    "can": can,
    "hook": hook,
    "propeller": propeller,
    "rim": rim,
    "standing": standing_bottle,
    "tire": tire,
    "valve": valve,
    **{f"chain_{n}": lambda n=n: chain(np.random.default_rng(n), STRANDS[n]) for n in range(len(STRANDS))},
    **{f"debris_{n}": lambda n=n: debris(np.random.default_rng(10 + n)) for n in range(HEAPS)},
}

if __name__ == "__main__":
    default = Path(__file__).resolve().parents[1] / "scenes/meshes"
    for name, model in MODELS.items():
        write_obj((Path(sys.argv[1]) if len(sys.argv) > 1 else default) / f"tank_{name}.obj", model())
