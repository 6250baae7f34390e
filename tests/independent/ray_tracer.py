"""Rays against boxes, spheres, cylinders and planes in closed form, in double precision.

Each shape takes origins-in-shape-frame rays and gives the nearest distance > 0 (inf for none)
and the unit normal there; poses are 3 x 3 rotations and translations to the world.
"""
import numpy as np

# Distances nearer than this are the sonar's own place.
NEAREST_M = 1e-9


def rotation_from_degrees(roll, pitch, yaw):
    """Intrinsic z-y'-x'': turn by yaw, then pitch about the new y, then roll about the newest x."""
    r, p, y = np.radians([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, np.cos(r), -np.sin(r)], [0, np.sin(r), np.cos(r)]])
    about_y = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
    about_z = np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def rotation_from_quaternion(wxyz):
    """Rotation matrix of a quaternion w, x, y, z of any length."""
    w, x, y, z = np.asarray(wxyz) / np.linalg.norm(wxyz)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turn_between(first, second, share):
    """Rotation that lies `share` of the way from one to another, about their one common axis."""
    change = first.T @ second
    angle = np.arccos(np.clip((np.trace(change) - 1) / 2, -1, 1))
    if angle < 1e-12:
        return first
    cross = (change - change.T) / (2 * np.sin(angle))
    turned = share * angle
    return first @ (np.eye(3) + np.sin(turned) * cross + (1 - np.cos(turned)) * cross @ cross)


def _quadratic(a, b, c):
    """Roots of a t^2 + 2 b t + c = 0 in rising order, NaN where there are none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - a * c)
        return (-b - root) / a, (-b + root) / a


def _first_positive(candidates):
    """Smallest of the distances that lies before the ray's origin, and its index."""
    stack = np.stack(candidates)
    stack = np.where(stack > NEAREST_M, stack, np.inf)
    return stack.min(axis=0), stack.argmin(axis=0)


def hit_sphere(origin, direction, radius_m):
    near, far = _quadratic(1.0, direction @ origin, origin @ origin - radius_m**2)
    distance, _ = _first_positive([near, far])
    with np.errstate(invalid="ignore"):
        return distance, (origin + distance[:, None] * direction) / radius_m


def hit_plane(origin, direction):
    with np.errstate(divide="ignore"):
        distance = -origin[2] / direction[:, 2]
    return np.where(distance > NEAREST_M, distance, np.inf), np.tile(
        [0.0, 0.0, 1.0], (len(direction), 1)
    )


def hit_box(origin, direction, size_m, inside):
    """Slabs; a room (inside) shows its far faces only, a block its first face met."""
    half = np.asarray(size_m) / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = (-half - origin) / direction, (half - origin) / direction
    enter_each, leave_each = np.minimum(low, high), np.maximum(low, high)
    enter, leave = enter_each.max(axis=1), leave_each.min(axis=1)
    met = (enter <= leave) & (leave > NEAREST_M)
    far = np.full(len(direction), inside) | (enter <= NEAREST_M)
    distance = np.where(met, np.where(far, leave, enter), np.inf)
    axis = np.where(far, leave_each.argmin(axis=1), enter_each.argmax(axis=1))
    return distance, np.eye(3)[axis]


def hit_cylinder(origin, direction, radius_m, height_m):
    """Side and both end discs."""
    a = (direction[:, :2] ** 2).sum(axis=1)
    near, far = _quadratic(
        a, direction[:, :2] @ origin[:2], origin[:2] @ origin[:2] - radius_m**2
    )
    sides = [
        np.where(np.abs(origin[2] + t * direction[:, 2]) <= height_m / 2, t, np.inf)
        for t in (near, far)
    ]
    discs = []
    for z in (-height_m / 2, height_m / 2):
        with np.errstate(divide="ignore"):
            t = (z - origin[2]) / direction[:, 2]
        beside = origin[:2] + t[:, None] * direction[:, :2]
        discs.append(np.where((beside**2).sum(axis=1) <= radius_m**2, t, np.inf))
    distance, which = _first_positive(sides + discs)
    with np.errstate(invalid="ignore"):
        normal = (origin + distance[:, None] * direction) / radius_m
    normal[:, 2] = 0.0
    normal[which >= 2] = [0.0, 0.0, 1.0]
    return distance, normal


def nearest_hits(objects, position, directions):
    """Distance, |cos| of incidence and object number (from 0) of rays into a world.

    `objects` are (hit function, its parameters, rotation, position).
    """
    best = np.full(len(directions), np.inf)
    cosine, index = np.zeros(len(directions)), np.full(len(directions), -1)
    for number, (hit, parameters, rotation, place) in enumerate(objects):
        local = directions @ rotation
        distance, normal = hit((position - place) @ rotation, local, *parameters)
        nearer = distance < best
        best[nearer], index[nearer] = distance[nearer], number
        cosine[nearer] = np.abs((local[nearer] * normal[nearer]).sum(axis=1))
    return best, cosine, index
