#!/usr/bin/env python3
"""Writes scenes/meshes/wreck.obj: the hull of a 14 m fishing boat with deckhouse, funnel and a hole; and the same in
scenes/rigs/meshes/wreck.ply, with colors of its vertices for a camera: rust and paint under algae.

    ./scripts/make_wreck.py [FOLDER]

Meters, z up, bow to +x, origin amidships on the keel. The half breadth follows a parabola along the
length and a power law over the depth, as the first sketch of any hull does. The same bytes every
time: no random numbers, coordinates rounded to a millimeter.
"""
import math
import pathlib
import sys

LENGTH_M, BREADTH_M, DEPTH_M = 14.0, 4.4, 2.6
STATIONS, WATERLINES = 57, 15
HOLE = (-2.0, 0.5, 0.5, 1.7)  # x from, to; z from, to; on the starboard side


def half_breadth_m(x: float, z: float) -> float:
    fullness = max(0.0, 1.0 - abs(2 * x / LENGTH_M) ** 2.4)
    return BREADTH_M / 2 * fullness * (z / DEPTH_M) ** (0.35 + 0.5 * abs(2 * x / LENGTH_M))


def sheer_m(x: float) -> float:
    """The deck rises toward bow and stern."""
    return DEPTH_M + 0.5 * (2 * x / LENGTH_M) ** 2 + 0.2 * max(0.0, 2 * x / LENGTH_M) ** 3


class Mesh:
    def __init__(self):
        self.vertices, self.faces = [], []

    def vertex(self, x, y, z):
        self.vertices.append((x, y, z))
        return len(self.vertices)

    def quad(self, a, b, c, d):
        self.faces += [(a, b, c), (a, c, d)]

    def box(self, low, high):
        corner = [self.vertex(*(high[k] if i >> k & 1 else low[k] for k in range(3))) for i in range(8)]
        for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)):
            self.quad(corner[a], corner[b], corner[c], corner[d])

    def cylinder(self, x, y, z_low, z_high, radius, sides=16):
        ring = []
        for z in (z_low, z_high):
            ring.append([self.vertex(x + radius * math.cos(2 * math.pi * k / sides),
                                     y + radius * math.sin(2 * math.pi * k / sides), z) for k in range(sides)])
        top = self.vertex(x, y, z_high)
        for k in range(sides):
            n = (k + 1) % sides
            self.quad(ring[0][k], ring[0][n], ring[1][n], ring[1][k])
            self.faces.append((ring[1][k], ring[1][n], top))


def hull(mesh: Mesh) -> None:
    xs = [LENGTH_M * (i / (STATIONS - 1) - 0.5) for i in range(STATIONS)]
    sides = {}
    for side in (-1, 1):
        sides[side] = [[mesh.vertex(x, side * half_breadth_m(x, DEPTH_M * w / (WATERLINES - 1)),
                                    sheer_m(x) * w / (WATERLINES - 1)) for w in range(WATERLINES)] for x in xs]
    for side, grid in sides.items():
        for i in range(STATIONS - 1):
            for w in range(WATERLINES - 1):
                x, z = (xs[i] + xs[i + 1]) / 2, DEPTH_M * (w + 0.5) / (WATERLINES - 1)
                if side == -1 and HOLE[0] < x < HOLE[1] and HOLE[2] < z < HOLE[3]:
                    continue
                corners = (grid[i][w], grid[i + 1][w], grid[i + 1][w + 1], grid[i][w + 1])
                mesh.quad(*(corners if side == -1 else corners[::-1]))
    for i in range(STATIONS - 1):
        mesh.quad(sides[-1][i][-1], sides[-1][i + 1][-1], sides[1][i + 1][-1], sides[1][i][-1])


def wreck() -> Mesh:
    mesh = Mesh()
    hull(mesh)
    mesh.box((-5.0, -1.2, DEPTH_M), (-1.8, 1.2, DEPTH_M + 2.0))
    mesh.cylinder(-4.2, 0.0, DEPTH_M + 2.0, DEPTH_M + 3.0, 0.35)
    mesh.cylinder(2.5, 0.0, DEPTH_M, DEPTH_M + 3.6, 0.12)
    mesh.vertices = [tuple(round(x, 3) for x in place) for place in mesh.vertices]
    # At bow and keel a side's corners coincide: such a face has no area.
    mesh.faces = [face for face in mesh.faces if len({mesh.vertices[corner - 1] for corner in face}) == 3]
    return mesh


def color(x: float, y: float, z: float) -> bytes:
    """sRGB, 8 bits: red below the waterline, rust above and a pale deckhouse, with algae where light falls."""
    paint = (0.35, 0.09, 0.06) if z < 1.1 else (0.40, 0.20, 0.11) if z < DEPTH_M + 0.8 else (0.55, 0.52, 0.45)
    patches = math.sin(1.9 * x + 0.7 * z) * math.sin(2.3 * y + 1.1 * x) + math.sin(4.7 * x) * math.sin(3.9 * z + y)
    algae = min(1.0, max(0.0, 0.2 * z + 0.5 * patches))
    linear = [(1 - algae) * p + algae * a for p, a in zip(paint, (0.10, 0.17, 0.05))]
    return bytes(round(255 * (1.055 * c ** (1 / 2.4) - 0.055)) for c in linear)


def obj(mesh: Mesh) -> bytes:
    lines = ["# wreck of scripts/make_wreck.py; metres, z up"]
    lines += [f"v {x:.3f} {y:.3f} {z:.3f}" for x, y, z in mesh.vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in mesh.faces]
    return ("\n".join(lines) + "\n").encode()


def ply(mesh: Mesh) -> bytes:
    lines = ["ply", "format ascii 1.0", "comment wreck of scripts/make_wreck.py; metres, z up"]
    lines += [f"element vertex {len(mesh.vertices)}", *(f"property float {axis}" for axis in "xyz")]
    lines += [f"property uchar {channel}" for channel in ("red", "green", "blue")]
    lines += [f"element face {len(mesh.faces)}", "property list uchar ushort vertex_indices", "end_header"]
    lines += ["{:g} {:g} {:g} {} {} {}".format(*place, *color(*place)) for place in mesh.vertices]
    lines += [f"3 {a - 1} {b - 1} {c - 1}" for a, b, c in mesh.faces]
    return ("\n".join(lines) + "\n").encode()


if __name__ == "__main__":
    scenes = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent / "scenes"
    for name, made in (("meshes/wreck.obj", obj), ("rigs/meshes/wreck.ply", ply)):
        (scenes / name).parent.mkdir(parents=True, exist_ok=True)
        (scenes / name).write_bytes(made(wreck()))
