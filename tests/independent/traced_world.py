"""A world of analytic shapes traced anew, and its comparison with a scatterer list."""
from dataclasses import dataclass
from typing import Callable

import numpy as np

import physics
from ray_tracer import nearest_hits, rotation_from_degrees
from surface_laws import Law, echo_energy

# Share of the rays that may fall on another object by rounding at an edge.
MOST_AT_EDGES = 2e-4


@dataclass(frozen=True)
class Body:
    """One object: hit function and its parameters, pose in the world, diffuse law."""

    hit: Callable
    parameters: tuple
    place_m: tuple
    turn_deg: tuple
    law: Law

    @property
    def traceable(self):
        return (
            self.hit,
            self.parameters,
            rotation_from_degrees(*self.turn_deg),
            np.array(self.place_m, float),
        )


@dataclass
class Echoes:
    """What every ray should bring back, by ray number."""

    range_m: np.ndarray
    cosine: np.ndarray
    instance: np.ndarray
    variance: np.ndarray


def ray_directions(sonar):
    """Elevation and unit vectors of all rays in the sonar's frame, by ray number."""
    columns = sonar.beams * sonar.rays_azimuth
    azimuth = ((np.arange(columns) + 0.5) / columns - 0.5) * sonar.beams * sonar.spacing_rad
    elevation = (
        (np.arange(sonar.rays_elevation) + 0.5) / sonar.rays_elevation - 0.5
    ) * sonar.fan_rad
    azimuth, elevation = (a.reshape(-1) for a in np.meshgrid(azimuth, elevation, indexing="ij"))
    return elevation, np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=1,
    )


def ray_numbers(scatterers, sonar):
    """Which ray each echo belongs to, from its direction."""
    column = np.floor(
        (scatterers["azimuth_rad"] / sonar.spacing_rad + sonar.beams / 2.0) * sonar.rays_azimuth
    )
    row = np.floor((scatterers["elevation_rad"] / sonar.fan_rad + 0.5) * sonar.rays_elevation)
    return (column * sonar.rays_elevation + row).astype(int)


def expected_echoes(bodies, sonar, position, rotation):
    """Trace all rays; instance 0 where nothing echoes within the range limits."""
    elevation, directions = ray_directions(sonar)
    range_m, cosine, index = nearest_hits(
        [body.traceable for body in bodies], position, directions @ rotation.T
    )
    black = np.array([body.law.model != "table" and body.law.reflectivity == 0 for body in bodies])
    echoing = (range_m >= sonar.range_min_m) & (range_m <= sonar.range_max_m) & (index >= 0)
    echoing &= ~black[index]
    step = sonar.fan_rad / sonar.rays_elevation
    solid_angle = (
        sonar.spacing_rad / sonar.rays_azimuth * 2.0 * np.cos(elevation) * np.sin(step / 2.0)
    )
    variance = np.zeros(len(range_m))
    for number, body in enumerate(bodies):
        mine = echoing & (index == number)
        variance[mine] = echo_energy(body.law, cosine[mine], (range_m**2 * solid_angle)[mine])
    return Echoes(range_m, cosine, np.where(echoing, index + 1, 0), variance)


def check_hits(checklist, label, scatterers, sonar, bodies, position, rotation):
    """Every ray's echo: its object, range, incidence and variance."""
    wanted = expected_echoes(bodies, sonar, position, rotation)
    hits = scatterers[scatterers["instance"] <= len(bodies)]
    rays = ray_numbers(hits, sonar)
    checklist.equal(f"{label} rays with two echoes", len(rays) - len(np.unique(rays)), 0)
    stored = np.zeros(len(wanted.instance), int)
    stored[rays] = hits["instance"]
    other, count = np.count_nonzero(stored != wanted.instance), len(stored)
    checklist.expect(
        other <= MOST_AT_EDGES * count,
        f"{label} rays that meet another object",
        other,
        f"<= {MOST_AT_EDGES * count:.0f} of {count} "
        f"({np.bincount(wanted.instance).tolist()} by id)",
    )
    same = stored[rays] == wanted.instance[rays]
    hits, rays = hits[same], rays[same]
    gap = np.max(
        np.abs(hits["delay_s"] * sonar.sound_speed_m_s / 2 - wanted.range_m[rays]), initial=0
    )
    checklist.at_most(f"{label} ranges, largest gap", gap, 1e-9, unit=" m")
    gap = np.max(np.abs(hits["cos_incidence"] - wanted.cosine[rays]), initial=0)
    checklist.at_most(f"{label} incidence, largest gap", gap, 1e-5)
    error = physics.relative_l2(hits["variance"].astype(float), wanted.variance[rays])
    checklist.at_most(f"{label} variances, relative L2", error, 1e-5)
