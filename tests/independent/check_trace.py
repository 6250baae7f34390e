#!/usr/bin/python3
"""Traces turning_room.yaml anew and compares poses, hits and targets with the scatterer lists.

    check_trace.py DATASET_DIR        a data set of turning_room.yaml, with its scatterers

Ray by ray: whether there is an echo, of what, at which range and incidence. Rays that graze an
edge to within rounding may fall either way and are counted.
"""
import sys

import numpy as np

import physics
import sonar_dataset
from checklist import run_main
from ray_tracer import (hit_box, hit_cylinder, hit_plane, hit_sphere, nearest_hits, rotation_from_degrees,
                        rotation_from_quaternion, turn_between)
from sequence import DataSet

# Instances 1 to 5: shape, parameters, rotation (roll, pitch, yaw in degrees), place, reflectivity.
WORLD = [(hit_box, ((12, 11, 7), True), (0, 0, 12), (0, 0, 0), 1e-3),
         (hit_plane, (), (2, -3, 0), (0, 0, -1.5), 1e-2),
         (hit_sphere, (0.4,), (0, 0, 0), (3, 0.9, 0.1), 1e-2),
         (hit_cylinder, (0.25, 1.2), (35, 60, 20), (3, -1.6, -0.3), 1e-3),
         (hit_box, ((0.1, 0.5, 0.5), False), (0, 20, 30), (2.2, -0.3, 0), 0.0)]
# Instances 6 to 8: place and target strength.
TARGETS = [((3.5, 0.2, 0.4), -20.0), ((5.2, 1.5, 0.0), -10.0), ((0.5, 0.0, 3.0), -10.0)]
PATH = [(1.5, (0, 0, 0), (3, -4, 10)), (2.5, (0.3, 0.2, -0.1), (-3, 5, -12)), (4.0, (-0.3, 0.4, 0.2), (20, -10, 40))]
MOUNT_PLACE, MOUNT_DEG = (0.1, 0.2, 0.3), (10, 15, -20)
PING_RATE_HZ = 2.0
LAMBERT_EXPONENT = 1.5
# Share of the rays that may fall on another object by rounding at an edge.
MOST_AT_EDGES = 2e-4


def expected_pose(time_s):
    """Sonar in world: position and rotation at a time of the path."""
    for (start, place, turn), (end, next_place, next_turn) in zip(PATH, PATH[1:]):
        if start <= time_s <= end:
            share = (time_s - start) / (end - start)
            position = np.array(place) + share * (np.array(next_place) - np.array(place))
            rotation = turn_between(rotation_from_degrees(*turn), rotation_from_degrees(*next_turn), share)
            return position + rotation @ MOUNT_PLACE, rotation @ rotation_from_degrees(*MOUNT_DEG)
    raise ValueError(f"no pose at {time_s} s")


def check_poses(checklist, sequence):
    """Times and poses of all pings, and the objects' in objects.csv."""
    wanted = int((PATH[-1][0] - PATH[0][0]) * PING_RATE_HZ) + 1
    checklist.expect(sequence.pings == list(range(wanted)), "pings", sequence.pings, f"0 to {wanted - 1}")
    worst = [0.0, 0.0, 0.0]
    for ping in sequence.pings:
        pose = sequence.pose(ping)
        time_s = PATH[0][0] + ping / PING_RATE_HZ
        position, rotation = expected_pose(time_s)
        gaps = (abs(sequence.time_s(ping) - time_s), np.abs(pose[:3] - position).max(),
                np.abs(rotation_from_quaternion(pose[3:]) - rotation).max())
        worst = [max(pair) for pair in zip(worst, gaps)]
    checklist.expect(max(worst) < 1e-12, "poses, largest gaps of time, place, rotation", worst, "< 1e-12")
    header, rows = sonar_dataset.read_csv(sequence.path("objects.csv"))
    gap = 0.0
    for row in rows:
        entry = dict(zip(header, map(float, row)))
        identity = int(entry["instance"])
        place = WORLD[identity - 1][3] if identity <= len(WORLD) else TARGETS[identity - len(WORLD) - 1][0]
        turn = WORLD[identity - 1][2] if identity <= len(WORLD) else (0, 0, 0)
        stored = rotation_from_quaternion([entry[key] for key in ("qw", "qx", "qy", "qz")])
        gap = max(gap, np.abs(np.array([entry["x"], entry["y"], entry["z"]]) - place).max(),
                  np.abs(stored - rotation_from_degrees(*turn)).max())
    checklist.expect(gap < 1e-12 and len(rows) == len(sequence.pings) * (len(WORLD) + len(TARGETS)),
                     f"objects.csv, {len(rows)} rows, largest gap", f"{gap:.2e}", "< 1e-12")


def ray_directions(sonar):
    """Azimuth, elevation and unit vectors of all rays in the sonar's frame, by ray number."""
    columns = sonar.beams * sonar.rays_azimuth
    azimuth = ((np.arange(columns) + 0.5) / columns - 0.5) * sonar.beams * sonar.spacing_rad
    elevation = ((np.arange(sonar.rays_elevation) + 0.5) / sonar.rays_elevation - 0.5) * sonar.fan_rad
    azimuth, elevation = (a.reshape(-1) for a in np.meshgrid(azimuth, elevation, indexing="ij"))
    return azimuth, elevation, np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                                         np.sin(elevation)], axis=1)


def ray_numbers(scatterers, sonar):
    """Which ray each echo belongs to, from its direction."""
    column = np.floor((scatterers["azimuth_rad"] / sonar.spacing_rad + sonar.beams / 2.0) * sonar.rays_azimuth)
    row = np.floor((scatterers["elevation_rad"] / sonar.fan_rad + 0.5) * sonar.rays_elevation)
    return (column * sonar.rays_elevation + row).astype(int)


def check_hits(checklist, label, scatterers, sonar, position, rotation):
    """Every ray's echo: its object, range, incidence and variance."""
    objects = [(hit, parameters, rotation_from_degrees(*turn), np.array(place, float))
               for hit, parameters, turn, place, _ in WORLD]
    _, elevation, directions = ray_directions(sonar)
    range_m, cosine, index = nearest_hits(objects, position, directions @ rotation.T)
    reflectivity = np.array([entry[4] for entry in WORLD])[index]
    echoing = (range_m >= sonar.range_min_m) & (range_m <= sonar.range_max_m) & (reflectivity > 0)
    hits = scatterers[scatterers["instance"] <= len(WORLD)]
    rays = ray_numbers(hits, sonar)
    checklist.expect(len(np.unique(rays)) == len(rays), f"{label} rays with two echoes",
                     len(rays) - len(np.unique(rays)), 0)
    stored = np.zeros(len(directions), int)
    stored[rays] = hits["instance"]
    wanted = np.where(echoing, index + 1, 0)
    other = np.count_nonzero(stored != wanted)
    checklist.expect(other <= MOST_AT_EDGES * len(wanted), f"{label} rays that meet another object", other,
                     f"<= {MOST_AT_EDGES * len(wanted):.0f} of {len(wanted)} ({np.bincount(wanted).tolist()} by id)")
    same = stored[rays] == wanted[rays]
    hits, rays = hits[same], rays[same]
    gap = np.abs(hits["delay_s"] * sonar.sound_speed_m_s / 2 - range_m[rays]).max()
    checklist.expect(gap < 1e-9, f"{label} ranges, largest gap", f"{gap:.2e} m", "< 1e-9 m")
    gap = np.abs(hits["cos_incidence"] - cosine[rays]).max()
    checklist.expect(gap < 1e-5, f"{label} incidence, largest gap", f"{gap:.2e}", "< 1e-5")
    step = sonar.fan_rad / sonar.rays_elevation
    solid_angle = sonar.spacing_rad / sonar.rays_azimuth * 2 * np.cos(elevation[rays]) * np.sin(step / 2)
    variance = reflectivity[rays] * cosine[rays] ** LAMBERT_EXPONENT * range_m[rays] ** 2 * solid_angle
    error = physics.relative_l2(hits["variance"].astype(float), variance)
    checklist.expect(error < 1e-5, f"{label} variances, relative L2", f"{error:.2e}", "< 1e-5")
    return objects


def check_targets(checklist, label, scatterers, sonar, objects, position, rotation):
    """Point targets are there when in the fan and in sight, with their strength."""
    for number, (place, strength_db) in enumerate(TARGETS):
        identity = len(WORLD) + 1 + number
        offset = np.array(place) - position
        range_m = np.linalg.norm(offset)
        x, y, z = rotation.T @ offset
        in_fan = abs(np.arctan2(y, x)) < sonar.beams * sonar.spacing_rad / 2 and \
            abs(np.arcsin(z / range_m)) <= sonar.fan_rad / 2
        hidden = nearest_hits(objects, position, offset[None] / range_m)[0][0] < range_m * (1 - 1e-6)
        wanted = int(in_fan and not hidden and sonar.range_min_m <= range_m <= sonar.range_max_m)
        mine = scatterers[scatterers["instance"] == identity]
        checklist.expect(len(mine) == wanted, f"{label} target {number + 1} (in fan {in_fan}, hidden {hidden})",
                         len(mine), wanted)
        if len(mine) == 1 and wanted:
            gap = abs(mine["amp_re"][0] - 10 ** (strength_db / 20)) + abs(mine["amp_im"][0]) + mine["variance"][0]
            checklist.expect(gap < 1e-6, f"{label} target {number + 1} amplitude", mine["amp_re"][0],
                             f"{10 ** (strength_db / 20):.7g}")


def check(checklist, root):
    for sequence in DataSet(root).sequences:
        check_poses(checklist, sequence)
        for ping in sequence.pings:
            label = f"{sequence.name}/{ping:06d}"
            scatterers = sequence.scatterers(ping)
            position, rotation = expected_pose(PATH[0][0] + ping / PING_RATE_HZ)
            objects = check_hits(checklist, label, scatterers, sequence.sonar, position, rotation)
            check_targets(checklist, label, scatterers, sequence.sonar, objects, position, rotation)


if __name__ == "__main__":
    sys.exit(run_main("check_trace", check))
