"""Pulses: width, side lobes, peak and arrival of every shape and window, and the record."""
import math

import numpy as np

import measure
import pulses
from bench import Row, case, point_target
from closed_forms import BAND_HZ, CARRIER_HZ, SOUND_SPEED_M_S, Envelope, decibels, sonar_equation_db
from levels import RANGE_M, STRENGTH_DB, point_echo
from pulses import Pulse

RANGE_STEP_M = SOUND_SPEED_M_S / (2.0 * BAND_HZ)
FINE = 32
GROUP_DELAY_S = 2e-4


def table_rows():
    """A lopsided spectrum with a group delay: (frequency_hz, amplitude, phase_deg)."""
    x = np.linspace(-0.5, 0.5, 65)
    frequency = CARRIER_HZ + x * BAND_HZ
    return [
        (f, math.exp(-((2.0 * (v - 0.1)) ** 2)), -360.0 * f * GROUP_DELAY_S)
        for f, v in zip(frequency.tolist(), x.tolist())
    ]


def table_file():
    lines = ["frequency_hz,amplitude,phase_deg"]
    return "\n".join(lines + [",".join(map(repr, row)) for row in table_rows()]) + "\n"


def table_pulse():
    return Pulse(shape="table", rows=tuple((f, a, math.radians(p)) for f, a, p in table_rows()))


# Name, scenario's value of sonar.pulse, the same here, and the window.
PULSES = [
    ("gaussian", "gaussian", Pulse("gaussian")),
    ("flat", "flat", Pulse("flat")),
    ("lfm", {"lfm": {"duration_s": 1e-3}}, Pulse("lfm", 1e-3)),
    ("lfm_taper", {"lfm": {"duration_s": 1e-3, "taper": 0.4}}, Pulse("lfm", 1e-3, 0.4)),
    ("cw", {"cw": {"duration_s": 1e-4}}, Pulse("cw", 1e-4)),
    ("cw_long", {"cw": {"duration_s": 5e-4}}, Pulse("cw", 5e-4)),
    ("table", {"table": {"file": "pulse.csv"}}, table_pulse()),
    ("hann", "flat", Pulse("flat", window="hann")),
    ("hamming", "flat", Pulse("flat", window="hamming")),
    ("blackman", "flat", Pulse("flat", window="blackman")),
    ("gaussian_hann", "gaussian", Pulse("gaussian", window="hann")),
]


def echo_of(bench, given, pulse):
    """Sequence of one target with this pulse; the default one is shared with V1."""
    sonar = {"beams": {"count": 121, "spacing_deg": 0.05}}
    if given != "gaussian" or pulse.window != "none":
        sonar.update(pulse=given, window=pulse.window)
    files = {"pulse.csv": table_file()} if pulse.shape == "table" else None
    if files is None:
        return point_echo(bench, {"sonar": sonar})

    return bench.run(
        {"sonar": sonar, "point_targets": [point_target("target", STRENGTH_DB, (RANGE_M, 0, 0))]},
        files=files,
    )


def range_cut(series):
    """Ranges and power of the middle beam's interpolated record."""
    power = np.abs(measure.interpolated(series[60], FINE)) ** 2
    return np.arange(len(power)) * RANGE_STEP_M / FINE, power


@case("V3")
def range_cut_of_the_gaussian(bench):
    """-3 dB width in range and energy of the default pulse."""
    series = point_echo(bench).series(0)
    ranges, power = range_cut(series)
    energy = np.sum(np.abs(series[60].astype(complex)) ** 2) / measure.peak(power)[1]
    yield Row("V3.width", "range cut through V1: -3 dB full width",
              0.0330, measure.width_at(ranges, power), 0.00033, "m")
    yield Row("V3.energy", "range cut through V1: b int |s|^2 dt for unit peak", 1.370, float(energy), 0.0137, "")


def pulse_rows(bench, name, given, pulse):
    """Width, highest side lobe, peak level and arrival of one shape."""
    ranges, power = range_cut(echo_of(bench, given, pulse).series(0))
    theory = Envelope(pulse)
    near = np.abs(theory.samples) < 60
    samples, shape = theory.samples[near], theory.power[near]
    height = measure.peak(power)[1]
    # A long burst peaks near both its ends: the middle between the edges is its place.
    middle = RANGE_M + np.mean(measure.edges(samples, shape)) * RANGE_STEP_M
    offset = ranges / RANGE_STEP_M - RANGE_M / RANGE_STEP_M
    shown = np.abs(offset) < 14
    bench.curve(
        "pulses",
        name,
        offset[shown],
        decibels(power[shown] / height),
        decibels(np.maximum(theory.power_at(offset[shown] / BAND_HZ), 1e-12)),
    )
    width = measure.width_at(samples, shape) * RANGE_STEP_M
    yield Row(f"pulse.{name}.width", f"{name}: -3 dB full width in range",
              width, measure.width_at(ranges, power), 0.01 * width, "m")
    yield Row(f"pulse.{name}.lobe", f"{name}: highest side lobe in range",
              measure.highest_side_lobe_db(shape), measure.highest_side_lobe_db(power), 0.1)
    yield Row(f"pulse.{name}.peak", f"{name}: interpolated peak of V1's target",
              sonar_equation_db(RANGE_M, STRENGTH_DB), float(measure.level(height)), 0.05)
    yield Row(f"pulse.{name}.place", f"{name}: range of the middle between its edges",
              float(middle), float(np.mean(measure.edges(ranges, power))), 0.01 * RANGE_STEP_M, "m")


@case("pulse")
def every_pulse(bench):
    """All shapes and windows against their spectra, summed here."""
    return [row for name, given, pulse in PULSES for row in pulse_rows(bench, name, given, pulse)]


@case("record")
def record(bench):
    """Padding: an echo in the last sample does not come back; long pulses get longer records."""
    for name, given in (("gaussian", None), ("flat", "flat")):
        last_m = 239 * RANGE_STEP_M
        sonar = {"beams": {"count": 121, "spacing_deg": 0.05}, "range_max_m": last_m + 1e-6}
        sonar.update({"pulse": given} if given else {})
        power = np.abs(point_echo(bench, {"sonar": sonar}, last_m).series(0)[60]) ** 2
        yield Row(f"record.{name}", f"{name}: echo in the last sample, highest amplitude in the first tenth",
                  0.0, float(np.sqrt(power[:24].max() / power.max())), 10**-4.5, "of the peak")
    for name, given, pulse in PULSES:
        if name in ("cw_long", "table"):
            sequence = echo_of(bench, given, pulse)
            extent = pulses.extent_s(pulse, BAND_HZ, CARRIER_HZ)
            yield Row(
                f"record.{name}.extent", f"{name}: T_p as stated",
                extent * 1e3, sequence.stated_pulse_extent_s * 1e3, 1e3 / BAND_HZ if name == "table" else 1e-9, "ms"
            )
            length = pulses.transform_length(
                sequence.sonar.samples, BAND_HZ, sequence.stated_pulse_extent_s
            )
            yield Row(f"record.{name}.transform", f"{name}: length of the transform",
                      length, sequence.stated_record[1], 0, "")
