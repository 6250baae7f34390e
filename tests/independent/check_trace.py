#!/usr/bin/python3
"""Traces turning_room.yaml anew and compares poses, hits and targets with the scatterer lists.

    check_trace.py DATASET_DIR        a data set of turning_room.yaml, with its scatterers

Ray by ray: whether there is an echo, of what, at which range and incidence. Rays that graze an
edge to within rounding may fall either way and are counted.
"""
import sys

import numpy as np

import sonar_dataset
from checklist import run_main
from ray_tracer import (
    hit_box,
    hit_cylinder,
    hit_plane,
    hit_sphere,
    nearest_hits,
    rotation_from_degrees,
    rotation_from_quaternion,
    turn_between,
)
from sequence import DataSet
from surface_laws import Law
from traced_world import Body, check_hits

DIM, BRIGHT, BLACK = (Law(reflectivity=value, exponent=1.5) for value in (1e-3, 1e-2, 0.0))
# Instances 1 to 5.
WORLD = [
    Body(hit_box, ((12, 11, 7), True), (0, 0, 0), (0, 0, 12), DIM),
    Body(hit_plane, (), (0, 0, -1.5), (2, -3, 0), BRIGHT),
    Body(hit_sphere, (0.4,), (3, 0.9, 0.1), (0, 0, 0), BRIGHT),
    Body(hit_cylinder, (0.25, 1.2), (3, -1.6, -0.3), (35, 60, 20), DIM),
    Body(hit_box, ((0.1, 0.5, 0.5), False), (2.2, -0.3, 0), (0, 20, 30), BLACK),
]
# Instances 6 to 8: place and target strength.
TARGETS = [((3.5, 0.2, 0.4), -20.0), ((5.2, 1.5, 0.0), -10.0), ((0.5, 0.0, 3.0), -10.0)]
PATH = [
    (1.5, (0, 0, 0), (3, -4, 10)),
    (2.5, (0.3, 0.2, -0.1), (-3, 5, -12)),
    (4.0, (-0.3, 0.4, 0.2), (20, -10, 40)),
]
MOUNT_PLACE, MOUNT_DEG = (0.1, 0.2, 0.3), (10, 15, -20)
PING_RATE_HZ = 2.0


def expected_pose(time_s):
    """Sonar in world: position and rotation at a time of the path."""
    for (start, place, turn), (end, next_place, next_turn) in zip(PATH, PATH[1:]):
        if start <= time_s <= end:
            share = (time_s - start) / (end - start)
            position = np.array(place) + share * (np.array(next_place) - np.array(place))
            rotation = turn_between(
                rotation_from_degrees(*turn), rotation_from_degrees(*next_turn), share
            )
            return position + rotation @ MOUNT_PLACE, rotation @ rotation_from_degrees(*MOUNT_DEG)
    raise ValueError(f"no pose at {time_s} s")


def object_pose(identity):
    """Place and turn of an instance; point targets are not turned."""
    if identity <= len(WORLD):
        return WORLD[identity - 1].place_m, WORLD[identity - 1].turn_deg
    return TARGETS[identity - len(WORLD) - 1][0], (0, 0, 0)


def check_poses(checklist, sequence):
    """Times and poses of all pings, and the objects' in objects.csv."""
    wanted = int((PATH[-1][0] - PATH[0][0]) * PING_RATE_HZ) + 1
    checklist.expect(
        sequence.pings == list(range(wanted)), "pings", sequence.pings, f"0 to {wanted - 1}"
    )
    worst = [0.0, 0.0, 0.0]
    for ping in sequence.pings:
        pose = sequence.pose(ping)
        time_s = PATH[0][0] + ping / PING_RATE_HZ
        position, rotation = expected_pose(time_s)
        gaps = (
            abs(sequence.time_s(ping) - time_s),
            np.abs(pose[:3] - position).max(),
            np.abs(rotation_from_quaternion(pose[3:]) - rotation).max(),
        )
        worst = [max(pair) for pair in zip(worst, gaps)]
    checklist.expect(
        max(worst) < 1e-12, "poses, largest gaps of time, place, rotation", worst, "< 1e-12"
    )
    header, rows = sonar_dataset.read_csv(sequence.path("objects.csv"))
    gap = 0.0
    for row in rows:
        entry = dict(zip(header, map(float, row)))
        identity = int(entry["instance"])
        place, turn = object_pose(identity)
        stored = rotation_from_quaternion([entry[key] for key in ("qw", "qx", "qy", "qz")])
        gap = max(
            gap,
            np.abs(np.array([entry["x"], entry["y"], entry["z"]]) - place).max(),
            np.abs(stored - rotation_from_degrees(*turn)).max(),
        )
    checklist.expect(
        gap < 1e-12 and len(rows) == len(sequence.pings) * (len(WORLD) + len(TARGETS)),
        f"objects.csv, {len(rows)} rows, largest gap",
        f"{gap:.2e}",
        "< 1e-12",
    )


def expected_targets(sonar, position, rotation):
    """(instance, amplitude, range, direction) of the targets in the fan and in sight."""
    seen = []
    for number, (place, strength_db) in enumerate(TARGETS):
        offset = np.array(place) - position
        range_m = np.linalg.norm(offset)
        x, y, z = rotation.T @ offset
        in_fan = (
            abs(np.arctan2(y, x)) < sonar.beams * sonar.spacing_rad / 2
            and abs(np.arcsin(z / range_m)) <= sonar.fan_rad / 2
        )
        nearest = nearest_hits(
            [body.traceable for body in WORLD], position, offset[None] / range_m
        )[0][0]
        if (
            in_fan
            and nearest > range_m * (1 - 1e-6)
            and sonar.range_min_m <= range_m <= sonar.range_max_m
        ):
            seen.append((len(WORLD) + 1 + number, 10 ** (strength_db / 20), range_m, (x, y, z)))
    return seen


def check_targets(checklist, label, scatterers, sonar, position, rotation):
    """Point targets are there when in the fan and in sight, with their strength."""
    mine = scatterers[scatterers["instance"] > len(WORLD)]
    wanted = sorted(
        (identity, amplitude)
        for identity, amplitude, _, _ in expected_targets(sonar, position, rotation)
    )
    obtained = sorted((int(row["instance"]), float(row["amp_re"])) for row in mine)
    ok = (
        len(wanted) == len(obtained)
        and np.allclose(wanted, obtained, rtol=1e-6)
        and not np.any(mine["amp_im"])
        and not np.any(mine["variance"])
    )
    checklist.expect(ok, f"{label} point targets (instance, amplitude)", obtained, wanted)


def check(checklist, root):
    for sequence in DataSet(root).sequences:
        check_poses(checklist, sequence)
        for ping in sequence.pings:
            label = f"{sequence.name}/{ping:06d}"
            scatterers = sequence.scatterers(ping)
            position, rotation = expected_pose(PATH[0][0] + ping / PING_RATE_HZ)
            check_hits(checklist, label, scatterers, sequence.sonar, WORLD, position, rotation)
            check_targets(checklist, label, scatterers, sequence.sonar, position, rotation)


if __name__ == "__main__":
    sys.exit(run_main("check_trace", check))
