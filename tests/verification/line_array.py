"""The element-level array: V12, V13, and what steering, cones and dead elements do to a beam."""
import math

import numpy as np

import measure
from bench import Row, case, point_target
from closed_forms import decibels, sonar_equation_db

ELEMENTS, STRENGTH_DB = 101, -40.0
# Puts whole metres of range on samples, 40 a metre.
BAND_HZ, SAMPLES_A_METRE = 30000.0, 40
REFERENCE = ("--backend", "reference")


def beams_of_target(bench, range_m, receiver=None, beams=None, azimuth_deg=0.0, elevation_deg=0.0):
    """Amplitudes over the beams at the sample of a target, and the beams' azimuths in degrees."""
    azimuth, elevation = math.radians(azimuth_deg), math.radians(elevation_deg)
    place = (
        range_m * math.cos(elevation) * math.cos(azimuth),
        range_m * math.cos(elevation) * math.sin(azimuth),
        range_m * math.sin(elevation),
    )
    sequence = bench.run(
        {
            "sonar": {
                "bandwidth_hz": BAND_HZ,
                "range_max_m": range_m + 1,
                "elevation": {"fan_deg": 30},
                "beams": beams or {"count": 161, "spacing_deg": 0.05},
                "receiver": {"mode": "array", **(receiver or {})},
            },
            "point_targets": [point_target("target", STRENGTH_DB, place)],
        },
        arguments=REFERENCE,
    )
    at_target = np.abs(sequence.series(0)[:, int(range_m * SAMPLES_A_METRE)])
    return at_target, np.degrees(sequence.sonar.azimuths_rad)


def line_pattern(degrees):
    """|sin(N pi d u / lambda) / (N sin(pi d u / lambda))|, d half a wavelength."""
    x = 0.5 * math.pi * np.sin(np.radians(degrees))
    safe = np.where(x == 0, 1.0, x)
    return np.where(x == 0, 1.0, np.abs(np.sin(ELEMENTS * safe) / (ELEMENTS * np.sin(safe))))


@case("V12")
def far_beam(bench):
    """The focused beam of 101 elements at half a wavelength against the discrete line."""
    cut, degrees = beams_of_target(bench, 5)
    theory = line_pattern(degrees)
    heard = theory > 10 ** (-30 / 20)
    gap = decibels((cut / cut.max()) ** 2) - decibels(np.maximum(theory, 1e-9) ** 2)
    yield Row("V12.level", "array of 101 elements, target at 5 m: level of the beam on it",
              sonar_equation_db(5, STRENGTH_DB), float(measure.level(cut.max() ** 2)), 0.05)
    yield Row("V12.curve", "the same: largest gap to the discrete line above -30 dB",
              0.0, float(np.max(np.abs(gap[heard]))), 0.3)
    yield Row("V12.lobe", "the same: first side lobe", -13.26, measure.first_side_lobe_db(cut**2), 0.1)


@case("V13")
def near_field(bench):
    """Targets in the near field, with and without focus."""
    for range_m, width, peak in ((1, 3.22, -4.58), (2, 1.08, -1.09)):
        sharp, degrees = beams_of_target(bench, range_m)
        blurred, _ = beams_of_target(bench, range_m, {"focus": "none"})
        name, words = f"V13.{range_m}m", f"array of 101 elements, target at {range_m} m"
        middle = len(degrees) // 2
        loss = float(decibels((blurred[middle] / sharp[middle]) ** 2))
        lobe = measure.first_side_lobe_db(sharp**2)
        yield Row(f"{name}.width", f"{words}, without focus: -3 dB full width",
                  width, measure.width_at(degrees, blurred**2), 0.02 * width, "deg")
        yield Row(f"{name}.peak", f"{words}, without focus: peak over that with it", peak, loss, 0.1)
        yield Row(f"{name}.focused", f"{words}, focused: -3 dB full width",
                  1.005, measure.width_at(degrees, sharp**2), 0.0201, "deg")
        yield Row(f"{name}.lobe", f"{words}, focused: first side lobe", -13.25, lobe, 0.1)


@case("array")
def beams_off_the_axis(bench):
    """Steering by phase, the width to the side, the cone, dead elements."""
    for azimuth, loss in ((30, 0.39), (45, 0.77), (65, 1.25)):
        fan = {"count": 5, "spacing_deg": azimuth / 2}
        delayed, _ = beams_of_target(bench, 10, beams=fan, azimuth_deg=azimuth)
        turned, _ = beams_of_target(bench, 10, {"steering": "phase"}, fan, azimuth)
        yield Row(f"array.phase.{azimuth}", f"steering by phase to {azimuth} deg: loss of the peak",
                  loss, float(decibels((delayed[4] / turned[4]) ** 2)), 0.03)
    ahead, aside = ({"count": 61, "spacing_deg": None, "azimuths_deg": [middle + 0.2 * k for k in range(-30, 31)]}
                    for middle in (0, 45))
    broadside, degrees = beams_of_target(bench, 5, beams=ahead)
    oblique, _ = beams_of_target(bench, 5, beams=aside, azimuth_deg=45)
    yield Row("array.width", "width of the beam at 45 deg over that at broadside",
              math.sqrt(2), measure.width_at(degrees, oblique**2) / measure.width_at(degrees, broadside**2), 0.028, "")
    cut, degrees = beams_of_target(bench, 5, beams=aside, azimuth_deg=45, elevation_deg=10)
    place, _ = measure.peak(cut)
    step = degrees[1] - degrees[0]
    yield Row(
        "array.cone",
        "target at azimuth 45, elevation 10 deg: azimuth of the peak",
        math.degrees(math.asin(math.cos(math.radians(10)) * math.sin(math.radians(45)))),
        float(degrees[0] + place * step),
        0.02,
        "deg",
    )
    sound, _ = beams_of_target(bench, 5, {"elements": 20})
    broken, _ = beams_of_target(bench, 5, {"elements": 20, "dead": [7]})
    yield Row("array.dead", "one of 20 elements dead: level of the peak",
              20 * math.log10(19 / 20), float(decibels((broken.max() / sound.max()) ** 2)), 0.01)
