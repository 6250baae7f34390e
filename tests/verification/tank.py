"""The tank of the paper: where echoes arrive, and which one a reflectivity changes."""
import math

import numpy as np

import physics
from bench import Row, case

WALL_M, NEAR_SIDE_M = 5.5, 3.8


@case("V16")
def arrivals(bench):
    """First sample of clean within 6 dB of its beam's maximum, and the cylinder's shadow."""
    sequence = bench.run_scene("sonar_tank.yaml", arguments=("--pings", "0:1"))
    sonar = sequence.sonar
    clean = physics.expected_power(sequence.scatterers(0), sonar)
    audible = clean >= clean.max(axis=1, keepdims=True) * 10**-0.6
    arrival_m = np.argmax(audible, axis=1) * sonar.range_step_m
    degrees = np.degrees(np.abs(sonar.azimuths_rad))
    yield Row("V16.cylinder", "tank: arrival on the center beam, near side of the cylinder",
              NEAR_SIDE_M, float(arrival_m[sonar.beams // 2]), sonar.range_step_m, "m")
    beside = (degrees > 5) & (degrees < 15)
    gap = (arrival_m - WALL_M / np.cos(sonar.azimuths_rad))[beside]
    yield Row("V16.wall", f"tank: arrival less 5.5 m / cos(theta), worst of {beside.sum()} beams of 5 to 15 degrees",
              0.0, float(gap[np.argmax(np.abs(gap))]), sonar.range_step_m, "m")
    ranges = np.arange(sonar.samples) * sonar.range_step_m
    window = (ranges > 5.3) & (ranges < 6.0)
    behind = clean[degrees < 1][:, window].mean()
    beam_side = clean[(degrees > 6) & (degrees < 10)][:, window].mean()
    yield Row("V16.shadow", "tank: shadow of the cylinder on the wall",
              14.2, float(10 * np.log10(beam_side / behind)), 1.0)


def energies(sequence):
    """Sum of |p|^2 over the cylinder's and the wall's window of ping 0."""
    sonar = sequence.sonar
    power = np.abs(sequence.series(0).astype(complex)) ** 2
    azimuth = sonar.azimuths_rad[:, None]
    ranges = np.arange(sonar.samples)[None, :] * sonar.range_step_m
    degrees = np.degrees(np.abs(azimuth))
    cylinder = (degrees < 2) & (ranges > 3.7) & (ranges < 4.0)
    along = ranges * np.cos(azimuth)
    wall = (degrees > 5) & (degrees < 10) & (along > 5.4) & (along < 5.9)
    return power[cylinder].sum(), power[wall].sum()


@case("V17")
def dimmed(bench):
    """Reflectivity 1e-3 to 1e-5 of one object, same seed."""
    whole, wall, target = (
        energies(bench.run_scene(f"{name}.yaml", arguments=("--pings", "0:1")))
        for name in ("sonar_tank", "tank_dim_wall", "tank_dim_target")
    )
    for name, changed, drop in (("tank", wall, (0.0, -20.0)), ("cylinder", target, (-20.0, 0.0))):
        for i, window in enumerate(("cylinder", "wall")):
            yield Row(
                f"V17.{name}.{window}", f"reflectivity of the {name} 1e-3 to 1e-5: change of the {window}'s window",
                drop[i], 10 * math.log10(changed[i] / whole[i]), 0.1
            )
