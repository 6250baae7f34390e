"""Levels: the sonar equation, the diffuse sphere, both normalizations."""
import math

import numpy as np

import beam_patterns
import measure
import physics
from bench import Row, case, diffuse, point_target, statistical
from closed_forms import azimuth_integral, decibels, elevation_integral, sonar_equation_db

BEAM_RAD, ELEVATION_RAD = math.radians(1.0), math.radians(20.0)
STRENGTH_DB, RANGE_M = -40.0, 5.0


def point_echo(bench, changes=None, range_m=RANGE_M):
    """One target straight ahead, at the center of the middle one of 121 narrow sectors."""
    scenario = {
        "sonar": {"beams": {"count": 121, "spacing_deg": 0.05}},
        "point_targets": [point_target("target", STRENGTH_DB, (range_m, 0, 0))],
    }
    for key, value in (changes or {}).items():
        scenario[key] = {**scenario.get(key, {}), **value} if isinstance(value, dict) else value
    return bench.run(scenario)


def peak_level(series):
    """Level of the highest point of an interpolated record."""
    return float(measure.level(measure.peak(np.abs(measure.interpolated(series)) ** 2)[1]))


@case("V1")
def point_target_level(bench):
    """Interpolated peak of a point target at a sector's center."""
    series = point_echo(bench).series(0)
    yield Row("V1", "point target at a sector center, TS -40 dB, r = 5 m: interpolated peak",
              sonar_equation_db(RANGE_M, STRENGTH_DB), peak_level(series[60]), 0.05)


@case("normalization")
def mean_square_level(bench):
    """Eq 16 lowers a point echo by N_j; 512 beams over 90 degrees."""
    spacing = math.radians(90.0) / 512
    for beam, name in ((256, "central"), (511, "outermost")):
        azimuth = (beam - 255.5) * spacing
        sequence = bench.run(
            {
                "sonar": {"beams": {"count": 512, "fov_deg": 90, "spacing_deg": None}},
                "scattering": {"normalization": "mean_square"},
                "point_targets": [
                    point_target(
                        "target",
                        STRENGTH_DB,
                        (RANGE_M * math.cos(azimuth), RANGE_M * math.sin(azimuth), 0),
                    )
                ],
            }
        )
        azimuths = physics.beam_azimuths_rad(512, spacing)
        squares = np.sum(beam_patterns.beam_pattern(azimuths - azimuths[beam], BEAM_RAD) ** 2)
        yield Row(
            f"normalization.{name}", f"Eq 16: point target on the {name} beam of 512 over 90 degrees",
            sonar_equation_db(RANGE_M, STRENGTH_DB) - decibels(squares), peak_level(sequence.series(0)[beam]), 0.05
        )


def sphere_run(bench, radius_m, normalization, pings=150):
    """Inside of a diffuse sphere; at 30 kHz its echo falls on a sample. Series of all pings."""
    sequence = bench.run(
        {
            "sonar": {
                "bandwidth_hz": 30000.0,
                "range_max_m": radius_m + 0.1,
                "beams": {"count": 180, "spacing_deg": 0.5},
                "rays": {"elevation": 40},
            },
            "scattering": {"normalization": normalization},
            "materials": {"m": {"reflectivity": 1e-3}},
            "objects": [diffuse("sphere", {"sphere": {"radius_m": radius_m, "inward_facing": True}})],
            "trajectory": {"ping_rate_hz": 1, "pings": pings},
        }
    )
    sample = round(2.0 * radius_m / 1500.0 * 30000.0)
    return sequence, np.abs(measure.all_series(sequence)[:, :, sample]) ** 2


@case("V6")
def diffuse_sphere(bench):
    """Mean level from the inside of a sphere at t = 2r/c; beams within 30 degrees are alike."""
    rows = []
    half = math.radians(45.0)
    for radius_m in (5.0, 10.0):
        sequence, power = sphere_run(bench, radius_m, "calibrated")
        inner = np.abs(sequence.sonar.azimuths_rad) < math.radians(30.0)
        expected = (
            1e10
            * 1e-3
            * azimuth_integral(BEAM_RAD, -half, half)
            * elevation_integral(ELEVATION_RAD, -ELEVATION_RAD / 2, ELEVATION_RAD / 2)
            / radius_m**2
        )
        obtained, error = measure.mean_level(power[:, inner].mean(axis=1))
        rows.append(
            statistical(
                f"V6.{radius_m:g}m", f"inside of a diffuse sphere, r = {radius_m:g} m, mu = 1e-3: mean level at 2r/c",
                float(measure.level(expected)), obtained, error, measure.equivalent_draws(error), tolerance=0.15
            )
        )
    far = np.linspace(2.0, 12.0, 50)
    bench.curve("sphere", "sphere", [5.0, 10.0], [row.obtained for row in rows])
    bench.curve("sphere", "closed form", far, None, rows[0].expected - 20 * np.log10(far / 5.0))
    return rows


@case("V7")
def eq_16(bench):
    """The mixing weights of Eq 16, read off the series; independent sectors keep their power."""
    count, spacing = 24, math.radians(0.5)
    azimuths = physics.beam_azimuths_rad(count, spacing)
    ranges = 2.0 + 0.2 * np.arange(count)
    sequence = bench.run(
        {
            "sonar": {"range_max_m": 8, "beams": {"count": count, "spacing_deg": 0.5}},
            "scattering": {"normalization": "mean_square"},
            "point_targets": [
                point_target(f"t{i}", 0.0, (r * math.cos(a), r * math.sin(a), 0))
                for i, (r, a) in enumerate(zip(ranges, azimuths))
            ],
        },
        scatterers=True,
    )
    sonar, scatterers = sequence.sonar, sequence.scatterers(0)
    delay = scatterers["delay_s"]
    one = (
        physics.source_pressure_pa_m(220.0)
        * np.exp(-2j * np.pi * np.mod(sonar.frequency_hz * delay, 1.0))
        * scatterers["gain"]
    )
    alone = physics.sector_series(
        one, np.arange(count), delay, count, sonar.spectrum, sonar.bandwidth_hz, sonar.samples
    )
    weights = np.linalg.lstsq(alone.T, sequence.series(0).astype(complex).T, rcond=None)[0].real
    sums = np.sum(weights**2, axis=0)
    worst = sums[np.argmax(np.abs(sums - 1.0))]
    yield Row("V7.sum", "Eq 16: sum of w^2 / N_j^2, the beam that is farthest off", 1.0, float(worst), 1e-6, "")
    _, power = sphere_run(bench, 5.0, "mean_square")
    sector = (
        1e10
        * 1e-3
        * math.radians(0.5)
        / 25.0
        * elevation_integral(ELEVATION_RAD, -ELEVATION_RAD / 2, ELEVATION_RAD / 2)
    )
    obtained, error = measure.mean_level(power.mean(axis=1))
    yield statistical("V7.mean_square", "Eq 16: mean square of independent sectors is kept",
                      float(measure.level(sector)), obtained, error, measure.equivalent_draws(error))
