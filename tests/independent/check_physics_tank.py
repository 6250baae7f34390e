#!/usr/bin/python3
"""What a data set of the sonar tank scene must show: the cylinder's arc, every ray, masks.

    check_physics_tank.py DATASET_DIR

The scene: the sonar at the origin looking along x, walls at 5.5 m, an upright cylinder of
0.4 m across whose axis stands 4 m ahead. Every ray is traced anew where scatterers are exported. Arrivals
and the depth of the shadow, V16, are in tests/verification/tank.py.
"""
import sys

import numpy as np

from checklist import run_main
from ray_tracer import hit_box, hit_cylinder
from sequence import DataSet
from sonar_dataset import read_npy
from traced_world import Body, check_hits

WALL_M, AXIS_M, RADIUS_M = 5.5, 4.0, 0.2


def tank_bodies(sequence):
    """Tank and cylinder, with the laws that the data set states."""
    law = {entry.class_name: entry.law for entry in sequence.instances.values()}
    return [
        Body(
            hit_box, ((2 * WALL_M, 2 * WALL_M, 4.0), True), (0, 0, 0), (0, 0, 0), law["structure"]
        ),
        Body(hit_cylinder, (RADIUS_M, 2.0), (AXIS_M, 0, 0), (0, 0, 0), law["cylinder"]),
    ]


def cylinder_range_m(azimuth_rad):
    """Range of the cylinder's near side in the horizontal plane, NaN where a ray passes it."""
    inside = RADIUS_M**2 - (AXIS_M * np.sin(azimuth_rad)) ** 2
    root = np.sqrt(np.where(inside >= 0, inside, np.nan))
    return AXIS_M * np.cos(azimuth_rad) - root


def check_arc(checklist, label, first_return_m, sonar):
    """The cylinder's arc: first returns follow its near side across all beams that meet it.

    A sector is as wide as the beams' spacing, so its nearest point is that of its innermost ray.
    """
    inner = np.maximum(np.abs(sonar.azimuths_rad) - sonar.spacing_rad / 2.0, 0.0)
    nearest, centre = cylinder_range_m(inner), cylinder_range_m(sonar.azimuths_rad)
    beams = np.nonzero(np.isfinite(centre))[0]
    early = np.count_nonzero(first_return_m[beams] < nearest[beams] - 1e-3)
    farthest = np.where(
        np.abs(sonar.azimuths_rad) < np.arcsin(RADIUS_M / AXIS_M) - sonar.spacing_rad,
        cylinder_range_m(np.abs(sonar.azimuths_rad) + sonar.spacing_rad / 2.0),
        np.inf,
    )
    late = np.count_nonzero(first_return_m[beams] > farthest[beams] + 2e-3)
    middle = len(sonar.azimuths_rad) // 2
    checklist.expect(
        len(beams) > 0 and early == 0 and late == 0,
        f"{label} cylinder's arc on {len(beams)} beams, first returns off it",
        f"{early} early, {late} late (centre {first_return_m[middle]:.4f} m)",
        "0 (centre 3.80 m)",
    )


def check_masks(checklist, label, sequence, instance_mask, sonar):
    """Cylinder pixels only where a ray can meet its near side; the wall on the beams beside it."""
    cylinders = [i for i, entry in sequence.instances.items() if entry.class_name == "cylinder"]
    checklist.equal(f"{label} objects of class cylinder", len(cylinders), 1)
    is_cylinder = np.isin(instance_mask, cylinders)
    edges = np.abs(sonar.azimuths_rad)[:, None] + sonar.spacing_rad / 2.0 * np.array([-1.0, 1.0])
    nearest = cylinder_range_m(np.maximum(edges[:, 0], 0.0))
    limb = np.arcsin(RADIUS_M / AXIS_M)
    farthest = cylinder_range_m(np.minimum(edges[:, 1], limb * (1 - 1e-12))) / np.cos(
        sonar.fan_rad / 2.0
    )
    ranges = np.arange(sonar.samples) * sonar.range_step_m
    possible = (ranges >= nearest[:, None] - sonar.range_step_m) & (
        ranges <= farthest[:, None] + sonar.range_step_m
    )
    stray = np.count_nonzero(is_cylinder & ~possible)
    checklist.expect(
        stray == 0 and is_cylinder.any(),
        f"{label} cylinder pixels where no ray meets its near side",
        f"{stray} of {np.count_nonzero(is_cylinder)}",
        "0 of some",
    )
    meeting = np.nonzero(np.abs(sonar.azimuths_rad) < limb - sonar.spacing_rad)[0]
    front = np.round(cylinder_range_m(sonar.azimuths_rad[meeting]) / sonar.range_step_m).astype(int)
    bare = np.count_nonzero(~is_cylinder[meeting, front])
    checklist.none_of(f"{label} beams whose near-side pixel is not the cylinder", bare, len(meeting))
    beside = np.nonzero(
        (np.abs(sonar.azimuths_rad) > limb + sonar.spacing_rad)
        & (np.abs(sonar.azimuths_rad) < np.radians(40.0))
    )[0]
    wall = np.round(WALL_M / np.cos(sonar.azimuths_rad[beside]) / sonar.range_step_m).astype(int)
    wall_ids = set(sequence.instances) - set(cylinders)
    other = np.count_nonzero(~np.isin(instance_mask[beside, wall], list(wall_ids)))
    checklist.none_of(f"{label} beams beside it whose wall pixel is not the wall", other, len(beside))


def check(checklist, root):
    for sequence in DataSet(root).sequences:
        sonar = sequence.sonar
        returns = read_npy(sequence.path("first_return_m.npy"))
        for row, ping in enumerate(sequence.pings):
            label = f"{sequence.name}/{ping:06d}"
            check_arc(checklist, label, returns[row].astype(np.float64), sonar)
            if sequence.has("scatterers"):
                check_hits(
                    checklist,
                    label,
                    sequence.scatterers(ping),
                    sonar,
                    tank_bodies(sequence),
                    np.zeros(3),
                    np.eye(3),
                )
            check_masks(
                checklist, label, sequence, sequence.mask("polar", ping, "instance").T, sonar
            )


if __name__ == "__main__":
    sys.exit(run_main("check_physics_tank", check))
