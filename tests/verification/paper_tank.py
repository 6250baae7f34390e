"""The paper's tanks a second time: traced by the rays of tests/independent, summed by its formulas.

What the program makes of scenes/*.yaml is held against this, which knows the scenes from the
lists below and shares no code with the program.
"""
import numpy as np

import measure
import physics
from ray_tracer import hit_box, hit_cylinder, nearest_hits, rotation_from_degrees

ROOM_M = (11.0, 11.0, 4.0)
WALL_M = 5.5
# Reflectivity of the tank, then (radius, reflectivity, position, rotation in degrees) of cylinders.
SCENES = {
    "sonar_tank": (1e-3, [(0.2, 1e-3, (4.0, 0.0, 0.0), (0, 0, 0))]),
    "two_cylinders": (
        1e-4,
        [
            (0.2, 1e-2, (3.2, 0.9, 0.0), (0, 0, 0)),
            (0.2, 1e-2, (4.4, -0.8, 0.0), (0, 0, 0)),
        ],
    ),
    "tilted_cylinders": (
        1e-4,
        [
            (0.15, 1e-2, (3.5, 1.2, 0.0), (45, 0, 0)),
            (0.15, 1e-2, (3.5, -1.2, 0.0), (0, 45, 0)),
        ],
    ),
    "upright_cylinders": (
        1e-4,
        [
            (0.15, 1e-2, (3.5, 1.2, 0.0), (0, 0, 0)),
            (0.15, 1e-2, (3.5, -1.2, 0.0), (0, 0, 0)),
        ],
    ),
}
HEIGHT_M, EXPONENT = 2.0, 2
# Upright in place of the scene's own rotations.
UPRIGHT = ("objects.1.pose.rotation_deg=[0,0,0]", "objects.2.pose.rotation_deg=[0,0,0]")
SERIES_ONLY = ("output.polar=false", "output.cartesian=false", "output.png=false")


def setting(*assignments):
    """Arguments of the program that set keys of the scenario."""
    return tuple(word for assignment in assignments for word in ("--set", assignment))


def world(name):
    """Objects for nearest_hits and their reflectivities."""
    room, cylinders = SCENES[name]
    objects = [(hit_box, (ROOM_M, True), np.eye(3), np.zeros(3))]
    for radius, _, place, rotation in cylinders:
        turned = rotation_from_degrees(*rotation)
        objects.append((hit_cylinder, (radius, HEIGHT_M), turned, np.array(place)))
    return objects, np.array([room, *(reflectivity for _, reflectivity, _, _ in cylinders)])


def traced(name, sonar, exponent=EXPONENT):
    """Echoes of one ray a cell of the fan (Eq 1 to 8), as physics.expected_power reads them."""
    objects, reflectivity = world(name)
    edges = np.linspace(-sonar.fan_rad / 2, sonar.fan_rad / 2, sonar.rays_elevation + 1)
    azimuth, elevation = np.meshgrid(
        sonar.azimuths_rad, 0.5 * (edges[1:] + edges[:-1]), indexing="ij"
    )
    directions = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=-1,
    ).reshape(-1, 3)
    distance, cosine, index = nearest_hits(objects, np.zeros(3), directions)
    solid = np.tile(sonar.spacing_rad * np.diff(np.sin(edges)), sonar.beams)
    heard = (distance >= sonar.range_min_m) & (distance <= sonar.range_max_m)
    fields = ("delay_s", "beam", "mean_re", "mean_im", "variance", "gain")
    echoes = np.zeros(
        heard.sum(), [(field, "i4" if field == "beam" else "f8") for field in fields]
    )
    far = distance[heard]
    echoes["delay_s"] = 2 * far / sonar.sound_speed_m_s
    echoes["beam"] = np.repeat(np.arange(sonar.beams), sonar.rays_elevation)[heard]
    echoes["variance"] = (
        reflectivity[index[heard]] * cosine[heard] ** exponent * far**2 * solid[heard]
    )
    echoes["gain"] = physics.propagation_gain(
        far, azimuth.reshape(-1)[heard], elevation.reshape(-1)[heard], sonar
    )
    return echoes


class Tank:
    """One scene as the program makes it and as it is worked out here."""

    def __init__(self, bench, name, pings, settings=(), like=None):
        """`settings` change the scene; `like` names the world of SCENES that it then is."""
        scene = f"{name}.yaml"
        self.name = like or name
        self.sequence = bench.run_scene(
            scene,
            scatterers=False,
            arguments=setting(*SERIES_ONLY, f"trajectory.pings={pings}", *settings),
        )
        self.first = bench.run_scene(
            scene, arguments=(*setting(*SERIES_ONLY, *settings), "--pings", "0:1")
        )
        self.sonar = self.sequence.sonar
        self.range_m = np.arange(self.sonar.samples) * self.sonar.range_step_m
        self.azimuth_deg = np.degrees(self.sonar.azimuths_rad)

    def expected(self, exponent=EXPONENT):
        """Mean power from the second tracer, Pa^2 [beams, samples]."""
        return physics.expected_power(traced(self.name, self.sonar, exponent), self.sonar)

    def clean(self):
        """Mean power from the scatterers that the program exported."""
        return physics.expected_power(self.first.scatterers(0), self.sonar)

    def power(self, ping):
        return np.abs(self.sequence.series(ping).astype(complex)) ** 2

    def mean_power(self):
        """Mean of |p|^2 over the pings."""
        return sum(self.power(ping) for ping in self.sequence.pings) / len(self.sequence.pings)

    def window(self, degrees, ranges_m):
        """Beams and samples between these azimuths and ranges."""
        beams = (self.azimuth_deg > degrees[0]) & (self.azimuth_deg < degrees[1])
        samples = (self.range_m > ranges_m[0]) & (self.range_m < ranges_m[1])
        return beams[:, None] & samples[None, :]

    def beam_at(self, degrees):
        return int(np.argmin(np.abs(self.azimuth_deg - degrees)))

    def ratio_db(self, above, below):
        """Energy of one window over another's, dB: expected; mean over pings and its error."""
        fine = self.expected()
        wanted = 10 * np.log10(fine[above].sum() / fine[below].sum())
        upper, lower = [], []
        for ping in self.sequence.pings:
            power = self.power(ping)
            upper.append(power[above].sum())
            lower.append(power[below].sum())
        (high, high_error), (low, low_error) = map(measure.mean_and_error, (upper, lower))
        error = measure.DECIBELS * np.hypot(high_error / high, low_error / low)
        return float(wanted), float(10 * np.log10(high / low)), float(error)


def arrivals_m(power, range_step_m):
    """First sample of each beam within 6 dB of its highest."""
    audible = power >= power.max(axis=1, keepdims=True) * 10**-0.6
    return np.argmax(audible, axis=1) * range_step_m


def arrival_before(power, samples, range_step_m, beam):
    """The same of one beam, over some of its samples."""
    line = np.where(samples, power[beam], 0.0)
    return float(np.argmax(line >= line.max() * 10**-0.6) * range_step_m)
