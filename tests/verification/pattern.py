"""Patterns: receive in azimuth with every shading, elevation, transmit."""
import math

import numpy as np

import beam_patterns
import measure
from beam_patterns import Shading
from bench import Row, case, point_target
from closed_forms import decibels, sonar_equation_db
from levels import BEAM_RAD, ELEVATION_RAD, RANGE_M, STRENGTH_DB, peak_level, point_echo

SHADINGS = [
    ("hann", "hann", Shading("hann")),
    ("taylor", "taylor", Shading("taylor", -35.0, 5)),
    ("taylor_25_4", {"taylor": {"side_lobe_db": -25, "nbar": 4}}, Shading("taylor", -25.0, 4)),
    ("chebyshev", "chebyshev", Shading("chebyshev", -35.0)),
    ("chebyshev_50", {"chebyshev": {"side_lobe_db": -50}}, Shading("chebyshev", -50.0)),
]


def azimuth_cut(series):
    """Signed pattern over the beams at the middle beam's interpolated peak."""
    fine = measure.interpolated(series)
    middle = series.shape[0] // 2
    at_peak = fine[:, int(np.argmax(np.abs(fine[middle])))]
    return (at_peak / at_peak[middle]).real


def degrees_of(sequence):
    return np.degrees(sequence.sonar.azimuths_rad)


@case("V2")
def azimuth_pattern(bench):
    """Width and first side lobe of the unshaded receiver, and that its lobes alternate in sign."""
    sequence = point_echo(bench)
    cut, degrees = azimuth_cut(sequence.series(0)), degrees_of(sequence)
    theory = beam_patterns.beam_pattern(np.radians(degrees), BEAM_RAD)
    bench.curve(
        "azimuth",
        "uniform",
        degrees,
        decibels(np.maximum(cut**2, 1e-12)),
        decibels(np.maximum(theory**2, 1e-12)),
    )
    yield Row("V2.width", "azimuth cut through V1: -3 dB full width",
              1.002, measure.width_at(degrees, cut**2), 0.00501, "deg")
    yield Row("V2.lobe", "azimuth cut through V1: first side lobe", -13.26, measure.first_side_lobe_db(cut**2), 0.1)
    yield Row("V2.sign", "azimuth cut through V1: first side lobe as a signed amplitude",
              -(10 ** (-13.26 / 20)), float(cut.min()), 0.0025, "of the peak")
    yield Row("V2.curve", "azimuth cut through V1: largest gap to sinc(0.884 sin(theta)/width)",
              0.0, float(np.max(np.abs(cut - theory))), 1e-4, "of the peak")


@case("shading")
def shadings(bench):
    """Every shading keeps the -3 dB width and has its own first side lobe."""
    for name, given, shading in SHADINGS:
        sequence = point_echo(
            bench, {"sonar": {"beams": {"count": 121, "spacing_deg": 0.05, "shading": given}}}
        )
        cut, degrees = azimuth_cut(sequence.series(0)), degrees_of(sequence)
        theory = beam_patterns.beam_pattern(np.radians(degrees), BEAM_RAD, shading)
        bench.curve(
            "azimuth",
            name,
            degrees,
            decibels(np.maximum(cut**2, 1e-12)),
            decibels(np.maximum(theory**2, 1e-12)),
        )
        dense = np.linspace(0.0, 5.0, 50001)
        lobe = measure.first_side_lobe_db(beam_patterns.line_pattern(shading, dense) ** 2)
        yield Row(f"shading.{name}.width", f"{name}: -3 dB full width in azimuth",
                  1.0, measure.width_at(degrees, cut**2), 0.005, "deg")
        yield Row(f"shading.{name}.lobe", f"{name}: first side lobe in azimuth",
                  lobe, measure.first_side_lobe_db(cut**2), 0.1)
        yield Row(f"shading.{name}.curve", f"{name}: largest gap to its pattern",
                  0.0, float(np.max(np.abs(cut - theory))), 1e-3, "of the peak")


@case("elevation")
def elevation_pattern(bench):
    """The two-way elevation pattern, applied once, in the level of targets above and below."""
    plain, hann, taylor = Shading(), Shading("hann"), Shading("taylor", -25.0, 5)
    yield from targets_at(bench, "", plain, [-9.0, -6.0, -3.0, 0.0, 5.0, 10.0, 20.0, 28.0])
    yield from targets_at(bench, "hann.", hann, [-20.0, -10.0, 0.0, 15.0, 22.0])
    yield from targets_at(bench, "taylor.", taylor, [-10.0, 0.0, 17.0, 21.0])


def targets_at(bench, name, shading, angles):
    """Targets at these elevations, and what the pattern leaves of each."""
    ranges = [3.0 + 0.3 * i for i in range(len(angles))]
    targets = [
        point_target(
            f"t{i}", STRENGTH_DB, (r * math.cos(math.radians(a)), 0, r * math.sin(math.radians(a)))
        )
        for i, (a, r) in enumerate(zip(angles, ranges))
    ]
    words = shading.kind
    if shading.kind == "taylor":
        words = {"taylor": {"side_lobe_db": shading.side_lobe_db, "nbar": shading.nbar}}
    elevation = {"fan_deg": 60, "shading": words}
    series = bench.run({"sonar": {"elevation": elevation}, "point_targets": targets}).series(0)
    power = np.abs(measure.interpolated(series[20])) ** 2
    for angle, range_m in zip(angles, ranges):
        wanted = beam_patterns.beam_pattern(math.radians(angle), ELEVATION_RAD, shading)
        around = range_m * 2 / 1500 * 29900 * 32
        here = power[int(around) - 32 : int(around) + 32]
        yield Row(
            f"elevation.{name}{angle:g}",
            f"{name and shading.kind + ': '}target at elevation {angle:g} deg",
            sonar_equation_db(range_m, STRENGTH_DB) + float(decibels(wanted**2)),
            float(measure.level(measure.peak(here)[1])),
            0.1,
        )


@case("transmit")
def transmit_pattern(bench):
    """Transmission of a given width: targets at the centres of sectors over the fan."""
    spacing = 0.5
    for width in (60.0, 20.0):
        targets, places = [], []
        for i, beam in enumerate((0, 30, 60, 80, 90, 96, 110, 140, 180)):
            azimuth, range_m = math.radians((beam - 90) * spacing), 2.0 + 0.35 * i
            places.append((beam, azimuth, range_m))
            targets.append(
                point_target(
                    f"t{i}",
                    STRENGTH_DB,
                    (range_m * math.cos(azimuth), range_m * math.sin(azimuth), 0),
                )
            )
        series = bench.run(
            {
                "sonar": {
                    "beams": {"count": 181, "spacing_deg": spacing, "transmit_width_deg": width}
                },
                "point_targets": targets,
            }
        ).series(0)
        for beam, azimuth, range_m in places:
            sent = beam_patterns.transmit_pattern(azimuth, math.radians(width))
            if sent**2 < 1e-3:
                continue
            yield Row(
                f"transmit.{width:g}.{math.degrees(azimuth):g}",
                f"transmission {width:g} deg wide: target at azimuth {math.degrees(azimuth):g} deg",
                sonar_equation_db(range_m, STRENGTH_DB) + float(decibels(sent**2)),
                own_peak(series[beam], range_m),
                0.1,
            )
    series = point_echo(bench).series(0)
    yield Row("transmit.none", "no width given: the same level over the fan",
              sonar_equation_db(RANGE_M, STRENGTH_DB), peak_level(series[60]), 0.05)


def own_peak(series, range_m):
    """Level of the interpolated peak within a sample of a range."""
    power = np.abs(measure.interpolated(series)) ** 2
    around = int(range_m * 2 / 1500 * 29900 * 32)
    return float(measure.level(measure.peak(power[around - 32 : around + 32])[1]))
