"""The water: absorption and sound speed, measured on the echo of a point target."""
import math

import numpy as np

import measure
from bench import Row, case, point_target

RANGE_M, STRENGTH_DB, BAND_HZ = 50.0, 0.0, 30000.0
FRANCOIS_GARRISON = ((100, 0.0336), (400, 0.0961), (900, 0.2995), (1200, 0.4954), (2100, 1.4186))


def echo(bench, water, frequency_hz=9e5):
    """Level and range in samples of a target's interpolated peak."""
    sequence = bench.run(
        {
            "sonar": {
                "frequency_hz": frequency_hz,
                "bandwidth_hz": BAND_HZ,
                "range_max_m": 56,
                "beams": {"count": 3},
            },
            "water": {**water, "absorption": {"fixed_db_m": None, **water["absorption"]}},
            "point_targets": [point_target("target", STRENGTH_DB, (RANGE_M, 0, 0))],
        }
    )
    power = np.abs(measure.interpolated(sequence.series(0)[1])) ** 2
    place, height = measure.peak(power)
    return float(measure.level(height)), place / 32.0


def absorption(bench, model):
    """dB/m from the level: SL - 40 log r - 2 alpha r + TS."""
    lossless = 220.0 - 40.0 * math.log10(RANGE_M) + STRENGTH_DB
    level, _ = echo(bench, {"absorption": model[0]}, model[1])
    return (lossless - level) / (2.0 * RANGE_M)


def conditions(model, temperature_c=10, salinity_psu=35, ph=8, depth_m=0):
    return {
        "model": model,
        "temperature_c": temperature_c,
        "salinity_psu": salinity_psu,
        "ph": ph,
        "depth_m": depth_m,
    }


def ainslie_mccolm(frequency_khz, temperature_c, salinity_psu, ph, depth_m):
    """dB/m by Ainslie and McColm, JASA 103 (1998) 1671: boric acid, magnesium sulphate, water."""
    f, t, s, z = frequency_khz, temperature_c, salinity_psu, depth_m / 1000.0
    boron = 0.78 * math.sqrt(s / 35.0) * math.exp(t / 26.0)
    magnesium = 42.0 * math.exp(t / 17.0)
    acid = 0.106 * boron * f**2 / (f**2 + boron**2) * math.exp((ph - 8.0) / 0.56)
    sulphate = (
        0.52
        * (1 + t / 43.0)
        * (s / 35.0)
        * magnesium
        * f**2
        / (f**2 + magnesium**2)
        * math.exp(-z / 6.0)
    )
    return (acid + sulphate + 0.00049 * f**2 * math.exp(-(t / 27.0 + z / 17.0))) / 1000.0


def leroy(t, s, z):
    """m/s by Leroy, Robinson and Goldsmith, JASA 124 (2008) 2774, at 45 degrees of latitude."""
    return (
        1402.5
        + 5.0 * t
        - 5.44e-2 * t**2
        + 2.1e-4 * t**3
        + 1.33 * s
        - 1.23e-2 * s * t
        + 8.7e-5 * s * t**2
        + 1.56e-2 * z
        + 2.55e-7 * z**2
        - 7.3e-12 * z**3
        - 9.5e-13 * t * z**3
        + 3e-7 * t**2 * z
        + 1.43e-5 * s * z
    )


def mackenzie(t, s, z):
    """m/s by Mackenzie, JASA 70 (1981) 807: another fit to other data, sea water alone."""
    return (
        1448.96
        + 4.591 * t
        - 5.304e-2 * t**2
        + 2.374e-4 * t**3
        + 1.34 * (s - 35)
        + 1.63e-2 * z
        + 1.675e-7 * z**2
        - 1.025e-2 * t * (s - 35)
        - 7.139e-13 * t * z**3
    )


@case("V9")
def francois_garrison(bench):
    """Absorption at five frequencies, from the level of an echo 50 m away."""
    return [
        Row(f"V9.{khz}", f"Francois-Garrison at {khz} kHz, 10 deg C, 35 psu, pH 8, 0 m",
            wanted, absorption(bench, (conditions("francois_garrison"), khz * 1e3)), 0.01 * wanted, "dB/m")
        for khz, wanted in FRANCOIS_GARRISON
    ]


def francois_garrison_formula(frequency_khz, temperature_c, salinity_psu, ph, depth_m):
    """dB/m by Francois and Garrison, JASA 72 (1982) 1879: boric acid, magnesium sulphate, water."""
    f, t, s, d = frequency_khz, temperature_c, salinity_psu, depth_m
    kelvin, speed = 273.0 + t, 1412.0 + 3.21 * t + 1.19 * s + 0.0167 * d
    boron = 2.8 * math.sqrt(s / 35.0) * 10.0 ** (4.0 - 1245.0 / kelvin)
    acid = 8.86 / speed * 10.0 ** (0.78 * ph - 5.0) * boron / (f**2 + boron**2)
    magnesium = 8.17 * 10.0 ** (8.0 - 1990.0 / kelvin) / (1.0 + 0.0018 * (s - 35.0))
    pressure = 1.0 - 1.37e-4 * d + 6.2e-9 * d**2
    sulphate = (
        21.44 * s / speed * (1.0 + 0.025 * t) * pressure * magnesium / (f**2 + magnesium**2)
    )
    if t <= 20.0:
        water = 4.937e-4 - 2.59e-5 * t + 9.11e-7 * t**2 - 1.50e-8 * t**3
    else:
        water = 3.964e-4 - 1.146e-5 * t + 1.45e-7 * t**2 - 6.5e-10 * t**3
    water *= 1.0 - 3.83e-5 * d + 4.9e-10 * d**2
    return (acid + sulphate + water) * f**2 / 1000.0


# kHz, and deg C, psu, pH, m: each term of the formulas leads in one of them.
STATES = (
    (1, (10, 35, 8, 0)),
    (1, (4, 34, 7.7, 2000)),
    (20, (25, 38, 8.2, 10)),
    (60, (2, 30, 8, 3000)),
    (900, (28, 0.5, 7, 0)),
    (900, (15, 35, 8, 3500)),
)


@case("formulas")
def absorption_formulas(bench):
    """Both formulas over all that they depend on, beside what the program states."""
    for khz, state in STATES:
        for name, formula in (
            ("francois_garrison", francois_garrison_formula),
            ("ainslie_mccolm", ainslie_mccolm),
        ):
            sequence = bench.run(
                {
                    "sonar": {
                        "frequency_hz": khz * 1e3,
                        "bandwidth_hz": 500.0,
                        "range_max_m": 10,
                        "beams": {"count": 3},
                    },
                    "water": {"absorption": {"fixed_db_m": None, **conditions(name, *state)}},
                    "point_targets": [point_target("target", STRENGTH_DB, (5, 0, 0))],
                }
            )
            wanted = formula(khz, *state)
            words = "{} deg C, {} psu, pH {}, {} m".format(*state)
            yield Row(f"formulas.{name}.{khz}.{state[3]}", f"{name} at {khz} kHz, {words}: over the formula",
                      1.0, sequence.sonar.absorption_db_m / wanted, 1e-4, "")


@case("absorption")
def other_absorption(bench):
    """Ainslie and McColm's formula, its agreement with the other one, and a fixed number."""
    for khz, state in ((100, (10, 35, 8, 0)), (400, (4, 30, 7.7, 1000)), (900, (18, 38, 8.2, 50))):
        wanted = ainslie_mccolm(khz, *state)
        got = absorption(bench, (conditions("ainslie_mccolm", *state), khz * 1e3))
        words = "{} deg C, {} psu, pH {}, {} m".format(*state)
        yield Row(f"absorption.am.{khz}", f"Ainslie-McColm at {khz} kHz, {words}", wanted, got, 0.01 * wanted, "dB/m")
        other = absorption(bench, (conditions("francois_garrison", *state), khz * 1e3))
        yield Row(f"absorption.both.{khz}", "Francois-Garrison there over Ainslie-McColm", 1.0, other / got, 0.1, "")
    yield Row("absorption.fixed", "absorption given as 0.25 dB/m",
              0.25, absorption(bench, ({"fixed_db_m": 0.25}, 9e5)), 0.0025, "dB/m")


@case("sound_speed")
def sound_speed(bench):
    """Speed from the arrival of an echo 50 m away; Leroy's formula and its neighbour's."""
    for t, s, z in ((10, 35, 0), (4, 34, 3000), (20, 0, 2)):
        water = {
            "sound_speed_m_s": {"from": {"temperature_c": t, "salinity_psu": s, "depth_m": z}},
            "absorption": {"fixed_db_m": 0},
        }
        samples = echo(bench, water)[1]
        got = 2.0 * RANGE_M * BAND_HZ / samples
        where = f"{t} deg C, {s} psu, {z} m"
        yield Row(f"sound_speed.{t}", f"Leroy 2008 at {where}", leroy(t, s, z), got, 0.05, "m/s")
        if s > 0:
            yield Row(f"sound_speed.{t}.mackenzie", f"Mackenzie 1981 at {where}", mackenzie(t, s, z), got, 1.0, "m/s")
