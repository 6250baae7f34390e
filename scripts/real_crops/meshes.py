"""Meshes of propellers and hoses, written as OBJ files. All lengths are in meters before the scenario scales them.

    write_meshes(folder)        writes every mesh and returns {class: [file name, ...]}
    propeller(...), hose(...)   vertices [n, 3] and triangles [m, 3]
"""
import numpy as np

# (blades, pitch over diameter, widest chord over radius) of propellers of radius 1.
BIG_PROPELLERS = ((3, 0.7, 0.8), (4, 0.8, 0.65), (3, 1.0, 0.9), (4, 0.9, 0.6))
SMALL_PROPELLERS = ((2, 0.7, 0.7), (3, 0.8, 0.65), (2, 1.0, 0.55), (3, 0.9, 0.6))
HUB_RADIUS = 0.2
HOSES = 16
MESH_SEED = 7


def joined(parts):
    """One mesh of several."""
    vertices, triangles, first = [], [], 0
    for part_vertices, part_triangles in parts:
        vertices.append(part_vertices)
        triangles.append(part_triangles + first)
        first += len(part_vertices)
    return np.concatenate(vertices), np.concatenate(triangles)


def grid_triangles(rows, columns, first=0, turned=False):
    """Triangles of a grid of vertices, two for each cell."""
    corner = first + (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.stack([corner, corner + 1, corner + columns + 1], 1)
    upper = np.stack([corner, corner + columns + 1, corner + columns], 1)
    triangles = np.concatenate([lower, upper])
    return triangles[:, ::-1] if turned else triangles


def tube(centers_m, radius_m, sides):
    """A closed tube along a curve, with flat ends; its frame does not twist."""
    tangents = np.gradient(centers_m, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    across = np.cross(tangents[0], [0.3, 0.5, 0.8])
    angles = 2 * np.pi * np.arange(sides) / sides
    rings = []
    for center, tangent in zip(centers_m, tangents):
        across = across - tangent * (across @ tangent)
        across /= np.linalg.norm(across)
        other = np.cross(tangent, across)
        rings.append(center + radius_m * (np.cos(angles)[:, None] * across + np.sin(angles)[:, None] * other))
    vertices = np.concatenate(rings + [centers_m[[0, -1]]])
    triangles, count = [], len(centers_m)
    side, following = np.arange(sides), (np.arange(sides) + 1) % sides
    for ring in range(count - 1):
        a, b = ring * sides + side, ring * sides + following
        triangles += [np.stack([a, b, b + sides], 1), np.stack([a, b + sides, a + sides], 1)]
    first_center, last_ring = count * sides, (count - 1) * sides
    triangles.append(np.stack([np.full(sides, first_center), following, side], 1))
    triangles.append(np.stack([np.full(sides, first_center + 1), last_ring + side, last_ring + following], 1))
    return vertices, np.concatenate(triangles)


def blade(turn_rad, pitch, chord, thickness, rows=10, columns=9):
    """A blade of two faces, twisted so that its pitch is the same at all radii."""
    inner = 0.8 * HUB_RADIUS
    share = np.arange(rows)[:, None] / (rows - 1)
    across = np.arange(columns)[None, :] / (columns - 1) - 0.5
    radius = inner + (1 - inner) * share
    width = chord * np.sqrt(np.maximum(np.sin(np.pi * (0.12 + 0.86 * share)), 0.02))
    twist = np.arctan(2 * pitch / (2 * np.pi * radius))
    along = across * width
    angle = turn_rad + along * np.cos(twist) / radius
    faces = []
    for sign in (1, -1):
        height = along * np.sin(twist) + sign * thickness * (1 - (2 * across) ** 2)
        faces.append(np.stack([radius * np.cos(angle), radius * np.sin(angle), height], -1).reshape(-1, 3))
    triangles = [grid_triangles(rows, columns), grid_triangles(rows, columns, rows * columns, turned=True)]
    return np.concatenate(faces), np.concatenate(triangles)


def propeller(blades, pitch, chord, thickness):
    """A propeller of radius 1 around the z axis, with a cylindrical hub."""
    axis = np.zeros((6, 3))
    axis[:, 2] = np.linspace(-0.16, 0.16, 6)
    parts = [tube(axis, HUB_RADIUS, 16)]
    parts += [blade(2 * np.pi * k / blades, pitch, chord, thickness) for k in range(blades)]
    return joined(parts)


def hose(rng, points=60):
    """A bent hose of 0.6 to 1.9 m around its middle: its heading is a random walk with a constant drift."""
    length_m, radius_m = rng.uniform(0.6, 1.9), rng.uniform(0.015, 0.035)
    yaw_rad = np.cumsum(rng.normal(0, 0.06, points) + rng.normal(0, 0.035))
    pitch_rad = np.cumsum(rng.normal(0, 0.02, points)) + rng.normal(-0.1, 0.2)
    steps = np.stack([np.cos(yaw_rad) * np.cos(pitch_rad), np.sin(yaw_rad) * np.cos(pitch_rad), np.sin(pitch_rad)], 1)
    centers_m = np.cumsum(steps, 0) * length_m / points
    return tube(centers_m - centers_m[points // 2], radius_m, 10)


def write_obj(path, mesh):
    vertices, triangles = mesh
    lines = ["v %.5f %.5f %.5f" % tuple(vertex) for vertex in vertices]
    lines += ["f %d %d %d" % tuple(triangle + 1) for triangle in triangles]
    write_if_new(path, "\n".join(lines) + "\n")


def write_if_new(path, text):
    """A file that another study in the same folder may be reading stays untouched."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def write_meshes(folder):
    """Writes all meshes into a folder; returns the names of the files for each class."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(MESH_SEED)
    meshes = {"big_propeller": [propeller(*numbers, thickness=0.02) for numbers in BIG_PROPELLERS],
              "small_propeller": [propeller(*numbers, thickness=0.03) for numbers in SMALL_PROPELLERS],
              "soft_pipeline": [hose(rng) for _ in range(HOSES)]}
    names = {}
    for kind, built in meshes.items():
        names[kind] = [f"{kind}_{number}.obj" for number in range(len(built))]
        for name, mesh in zip(names[kind], built):
            write_obj(folder / name, mesh)
    return names
