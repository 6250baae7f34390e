#!/usr/bin/python3
"""Holds scatterer lists against geometry, propagation, draws and order.

    check_scatterers.py DATASET_DIR

Delay, direction and gain follow from the world position and the sonar's pose; the beam is the
sector that holds the azimuth; the list is sorted by beam and delay; amplitudes are the
documented keyed draws about their means. The footprint is checked through the variance:
variance beside s_b(alpha) r^2 dOmega / cos(alpha) of the instance's law, less its rician part.
"""
import math
import sys

import numpy as np

import physics
import random_numbers
from beam_patterns import beam_pattern
from checklist import run_main
from ray_tracer import rotation_from_quaternion
from sequence import DataSet
from surface_laws import echo_energy, rician_share

FIELDS = (
    ("delay_s", "<f8"),
    ("beam", "<i4"),
    ("azimuth_rad", "<f4"),
    ("elevation_rad", "<f4"),
    ("amp_re", "<f4"),
    ("amp_im", "<f4"),
    ("mean_re", "<f4"),
    ("mean_im", "<f4"),
    ("variance", "<f4"),
    ("gain", "<f4"),
    ("cos_incidence", "<f4"),
    ("doppler", "<f4"),
    ("instance", "<u4"),
    ("path", "<u2"),
    ("x", "<f8"),
    ("y", "<f8"),
    ("z", "<f8"),
)
DIRECT_PATH = 0
STANDARD_ERRORS = 4.5


def check_table(checklist, label, scatterers):
    """Fields, order, and numbers that are finite."""
    fields = tuple((name, scatterers.dtype[name].str) for name in scatterers.dtype.names)
    checklist.equal(f"{label} fields", fields, FIELDS)
    order = np.lexsort((scatterers["delay_s"], scatterers["beam"]))
    keys = np.stack([scatterers["beam"].astype(float), scatterers["delay_s"]])
    checklist.equal(f"{label} sorted by beam and delay", np.array_equal(keys[:, order], keys), True)
    bad = sum(
        int(np.count_nonzero(~np.isfinite(scatterers[name]))) for name in scatterers.dtype.names
    )
    checklist.equal(f"{label} numbers that are not finite", bad, 0)


def check_geometry(checklist, label, scatterers, pose, sonar):
    """Delay, azimuth, elevation, beam and gain from the world positions of direct echoes."""
    direct = scatterers[scatterers["path"] == DIRECT_PATH]
    world = np.stack([direct[axis] for axis in "xyz"], axis=1)
    local = (world - pose[:3]) @ rotation_from_quaternion(pose[3:])
    range_m = np.linalg.norm(local, axis=1)
    azimuth = np.arctan2(local[:, 1], local[:, 0])
    elevation = np.arcsin(np.clip(local[:, 2] / range_m, -1, 1))
    gap = np.max(np.abs(direct["delay_s"] * sonar.sound_speed_m_s / 2.0 - range_m), initial=0)
    checklist.at_most(f"{label} delay against position, largest gap", gap, 1e-6, unit=" m")
    for name, wanted in (("azimuth_rad", azimuth), ("elevation_rad", elevation)):
        gap = np.max(np.abs(direct[name] - wanted), initial=0)
        checklist.at_most(f"{label} {name} against position, largest gap", gap, 1e-6)
    sector = sonar.sector_position(azimuth)
    outside = np.count_nonzero(
        (sector < direct["beam"] - 1e-4) | (sector > direct["beam"] + 1 + 1e-4)
    )
    checklist.none_of(f"{label} echoes outside their beam's sector", outside, len(direct))
    high = np.count_nonzero(np.abs(elevation) > sonar.fan_rad / 2 + 1e-6)
    checklist.equal(f"{label} echoes outside the elevation fan", high, 0)
    inside = (range_m >= sonar.range_min_m - 1e-9) & (range_m <= sonar.range_max_m + 1e-9)
    checklist.expect(
        bool(inside.all()), f"{label} echoes outside the range limits", np.count_nonzero(~inside), 0
    )
    gain = physics.propagation_gain(range_m, azimuth, elevation, sonar)
    relative = np.max(np.abs(direct["gain"] / gain - 1.0), initial=0)
    checklist.at_most(
        f"{label} gain, largest relative gap", relative, 3e-6, note=f"(absorption {sonar.absorption_db_m:.6g} dB/m)"
    )


def check_draws(checklist, label, scatterers):
    """Moments of xi = (a - mean) / sqrt(variance): a unit complex normal."""
    drawn = scatterers[scatterers["variance"] > 0]
    still = scatterers[scatterers["variance"] == 0]
    fixed = np.count_nonzero(
        (still["amp_re"] != still["mean_re"]) | (still["amp_im"] != still["mean_im"])
    )
    checklist.equal(f"{label} echoes without variance that are not their mean", fixed, 0)
    if len(drawn) < 100:
        return
    xi = (
        drawn["amp_re"]
        - drawn["mean_re"]
        + 1j * (drawn["amp_im"] - drawn["mean_im"]).astype(np.float64)
    )
    xi = xi / np.sqrt(drawn["variance"].astype(np.float64))
    count = len(xi)
    checklist.near(
        f"{label} E|xi|^2", np.mean(np.abs(xi) ** 2), 1.0, STANDARD_ERRORS / math.sqrt(count)
    )
    checklist.near(
        f"{label} E|xi|^4", np.mean(np.abs(xi) ** 4), 2.0, STANDARD_ERRORS * math.sqrt(20.0 / count)
    )
    checklist.near(f"{label} |E xi|", abs(np.mean(xi)), 0.0, STANDARD_ERRORS / math.sqrt(count))
    checklist.near(
        f"{label} |E xi xi|", abs(np.mean(xi**2)), 0.0, STANDARD_ERRORS * math.sqrt(2.0 / count)
    )


def check_keyed_draws(checklist, label, scatterers, sequence, ping):
    """xi worked out from seed, sequence, ping and ray number by the documented generator."""
    sonar = sequence.sonar
    drawn = scatterers[(scatterers["variance"] > 0) & (scatterers["path"] == DIRECT_PATH)]
    column = (
        sonar.sector_position(drawn["azimuth_rad"].astype(np.float64)) - drawn["beam"]
    )
    column = np.clip(np.floor(column * sonar.rays_azimuth), 0, sonar.rays_azimuth - 1).astype(
        np.uint64
    )
    row = (drawn["elevation_rad"].astype(np.float64) / sonar.fan_rad + 0.5) * sonar.rays_elevation
    ray = (drawn["beam"].astype(np.uint64) * np.uint64(sonar.rays_azimuth) + column) * np.uint64(
        sonar.rays_elevation
    ) + np.floor(row).astype(np.uint64)
    key = random_numbers.stream_key(sequence.seed, random_numbers.STREAM_SPECKLE, sequence.number)
    xi = random_numbers.complex_normals(key, 0 if sequence.speckle == "per_ray" else ping, ray)
    wanted = xi * np.sqrt(drawn["variance"].astype(np.float64))
    obtained = (drawn["amp_re"] - drawn["mean_re"]) + 1j * (drawn["amp_im"] - drawn["mean_im"])
    error = physics.relative_l2(obtained, wanted)
    checklist.at_most(f"{label} keyed draws, relative L2 of a - mean", error, 1e-5)


def nearest_to_one(ratios):
    """Of several ratios of each echo the one that is nearest to 1."""
    ratios = np.array(ratios)
    return np.take_along_axis(ratios, np.argmin(np.abs(np.log(ratios)), axis=0)[None], axis=0)[0]


def check_footprint(checklist, label, scatterers, sequence):
    """variance is what the law gives for the ray's cell; a coloured mesh only dims it.

    Of an object whose parts have laws of their own: what one of them gives.
    """
    sonar = sequence.sonar
    drawn = scatterers[(scatterers["variance"] > 0) & (scatterers["path"] == DIRECT_PATH)]
    step = sonar.fan_rad / sonar.rays_elevation
    cell = np.floor((drawn["elevation_rad"].astype(np.float64) + sonar.fan_rad / 2) / step)
    low = cell * step - sonar.fan_rad / 2
    solid_angle = sonar.sector_width_rad(drawn["beam"]) / sonar.rays_azimuth * (np.sin(low + step) - np.sin(low))
    range_m = drawn["delay_s"] * sonar.sound_speed_m_s / 2.0
    for identity in np.unique(drawn["instance"]):
        instance, mine = sequence.instances[identity], drawn["instance"] == identity
        ratio = nearest_to_one(
            [
                drawn["variance"][mine]
                / echo_energy(
                    law,
                    drawn["cos_incidence"][mine].astype(np.float64),
                    (range_m**2 * solid_angle)[mine],
                    coherent,
                    sonar.sound_speed_m_s / sonar.frequency_hz,
                )
                / rician_share(coherent)
                for law, coherent in instance.surfaces
            ]
        )
        what = f"{label} {instance.name}, variance beside its law's"
        if instance.vertex_reflectivity:
            checklist.at_most(f"{what}, largest", ratio.max(), 1 + 1e-4)
            continue
        checklist.at_most(f"{what}, spread", ratio.max() / ratio.min() - 1, 1e-4)
        checklist.near(what, np.median(ratio), 1.0, 1e-5)


def seen_over(mirrors, point, planes):
    """A point's image over horizontal mirrors, named in the order from the sonar on."""
    image = point.copy()
    for name in reversed(mirrors):
        image[:, 2] = 2 * planes[name]["z_m"] - image[:, 2]
    return image


def check_bounced(checklist, label, scatterers, sequence, ping):
    """Delay, direction and level of echoes over surface and bottom, by images of their place."""
    sonar, pose = sequence.sonar, sequence.pose(ping)
    planes = {key: sequence.info["multipath"][key] for key in ("surface", "bottom")}
    known = [p for p in sequence.info["paths"] if set(p["out"] + p["back"]) <= set(planes)]
    for path in known:
        mine = scatterers[scatterers["path"] == path["id"]]
        world = np.stack([mine[axis] for axis in "xyz"], axis=1)
        out, back = (
            (seen_over(leg, world, planes) - pose[:3]) @ rotation_from_quaternion(pose[3:])
            for leg in (path["out"], path["back"][::-1])
        )
        r_out, r_back = np.linalg.norm(out, axis=1), np.linalg.norm(back, axis=1)
        gaps = {
            "delay": np.abs(mine["delay_s"] * sonar.sound_speed_m_s - r_out - r_back),
            "azimuth": np.abs(mine["azimuth_rad"] - np.arctan2(back[:, 1], back[:, 0])),
            "elevation": np.abs(mine["elevation_rad"] - np.arcsin(back[:, 2] / r_back)),
        }
        for what, gap in gaps.items():
            checklist.at_most(
                f"{label} path {path['id']}, {len(mine)} echoes, {what}, largest gap", np.max(gap, initial=0), 1e-6
            )
        turned = sum(planes[name]["reflection"] < 0 for name in path["out"] + path["back"]) % 2
        heard = beam_pattern(
            mine["elevation_rad"].astype(np.float64),
            sonar.elevation_width_rad,
            sonar.elevation_shading,
        )
        wrong = np.count_nonzero((mine["gain"] < 0) != (bool(turned) ^ (heard < 0)))
        checklist.equal(f"{label} path {path['id']}, gains of wrong sign", wrong, 0)


def check_rician(checklist, label, scatterers, sequence):
    """mean^2 / variance is the K of a surface, or of one of its parts; the mean is real."""
    for identity, instance in sequence.instances.items():
        k = [1 / rician_share(coherent) - 1 for _, coherent in instance.surfaces]
        if not any(k):
            continue
        mine = scatterers[(scatterers["instance"] == identity) & (scatterers["variance"] > 0)]
        ratio = mine["mean_re"].astype(np.float64) ** 2 / mine["variance"]
        gap = np.max(np.min(np.abs(np.subtract.outer(k, ratio)), axis=0), initial=0)
        gap += np.max(np.abs(mine["mean_im"]), initial=0)
        checklist.expect(
            gap < 1e-5 * max(*k, 1.0) and np.all(mine["mean_re"] >= 0),
            f"{label} {instance.name}, mean^2 / variance, largest gap",
            f"{gap:.2e}",
            f"< 1e-5 (K {', '.join(f'{x:g}' for x in k)})",
        )


def check(checklist, root):
    for sequence in DataSet(root).sequences:
        for ping in sequence.pings:
            label = f"{sequence.name}/{ping:06d}"
            scatterers = sequence.scatterers(ping)
            check_table(checklist, label, scatterers)
            check_geometry(checklist, label, scatterers, sequence.pose(ping), sequence.sonar)
            check_draws(checklist, label, scatterers)
            # Those fixed on surfaces are of no ray, and the files do not say of which leaf; nor into
            # how many a cell of the fan is cut by need.
            if sequence.speckle != "surface" and not sequence.rays_by_need:
                check_keyed_draws(checklist, label, scatterers, sequence, ping)
                check_footprint(checklist, label, scatterers, sequence)
            check_rician(checklist, label, scatterers, sequence)
            if sequence.info.get("multipath"):
                check_bounced(checklist, label, scatterers, sequence, ping)


if __name__ == "__main__":
    sys.exit(run_main("check_scatterers", check))
