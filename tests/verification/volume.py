"""Reverberation of a uniform volume: its level, what the pulse and the patterns do, shadows."""
import math

import numpy as np

import beam_patterns
import measure
from bench import Row, case, diffuse, statistical
from closed_forms import Envelope, elevation_integral, integral
from levels import BEAM_RAD, ELEVATION_RAD
from pulses import Pulse

STRENGTH_DB, COUNT, SPACING_DEG = -60.0, 60, 0.5


def volume_run(bench, changes, objects=(), pings=12):
    """The sequence of a run, and the power of its pings, [pings, beams, samples]."""
    scenario = {
        "volumes": [{"name": "water", "uniform": {"strength_db": STRENGTH_DB}}],
        **changes,
    }
    scenario["sonar"] = {
        "range_max_m": 10,
        "beams": {"count": COUNT, "spacing_deg": SPACING_DEG},
        "rays": {"elevation": 40},
        **changes.get("sonar", {}),
    }
    if objects:
        scenario.update(objects=list(objects), materials={"m": {"reflectivity": 1e-15}})
    sequence = bench.run({**scenario, "trajectory": {"ping_rate_hz": 1, "pings": pings}})
    return sequence, np.abs(measure.all_series(sequence)) ** 2


def closed_form(sonar, pulse, elevation_limits=None):
    """S0^2 s_v int B_az^2 B_tx^2 dtheta int B_el^2 cos dphi (c/2) int |s|^2 dt r^-2 absorption."""
    low, high = elevation_limits or (-sonar.fan_rad / 2, sonar.fan_rad / 2)
    angle = np.linspace(-0.5, 0.5, 20001) * sonar.beams * sonar.spacing_rad
    sent = beam_patterns.transmit_pattern(angle, sonar.transmit_width_rad) ** 2
    azimuth = np.array(
        [
            integral(beam_patterns.beam_pattern(angle - beam, BEAM_RAD) ** 2 * sent, angle)
            for beam in sonar.azimuths_rad
        ]
    )
    ranges = np.maximum(np.arange(sonar.samples), 1) * sonar.range_step_m
    loss = 10 ** (-2 * 2 * sonar.absorption_db_m * ranges / 20)
    length = sonar.sound_speed_m_s / 2 * Envelope(pulse).energy / sonar.bandwidth_hz
    return (
        sonar.source_pressure_pa_m**2
        * 10 ** (STRENGTH_DB / 10)
        * elevation_integral(ELEVATION_RAD, low, high)
        * length
        * np.outer(azimuth, loss * ranges**-2)
    )


def level_row(identity, words, power, wanted, beams, samples):
    """Mean of power over its closed form, put at the level of the closed form's first pixel."""
    ratio = (power / wanted)[:, beams, samples]
    mean, error = measure.mean_and_error(ratio.mean(axis=(1, 2)))
    at = float(measure.level(wanted[beams, samples].reshape(-1)[0]))
    error_db = measure.DECIBELS * error / mean
    return statistical(identity, words,
                       at, at + float(10 * np.log10(mean)), error_db, measure.equivalent_draws(error_db), tolerance=0.2)


@case("V14")
def uniform_volume(bench):
    """Mean level over range, with absorption, other pulses, a transmit pattern and a larger fan."""
    inner = slice(10, 50)
    lossy = {"water": {"absorption": {"fixed_db_m": 0.3}}}
    wide = {"sonar": {"elevation": {"fan_deg": 36}}}
    beamed = {"sonar": {"beams": {"count": COUNT, "spacing_deg": SPACING_DEG, "transmit_width_deg": 20}}}
    for name, words, changes, pulse, near_m, far_m in (
        ("near", "uniform volume of -60 dB re 1/m: mean level, 2 to 4 m (value at 2 m)", {}, Pulse(), 2, 4),
        ("far", "the same, 7 to 9.5 m (value at 7 m)", {}, Pulse(), 7, 9.5),
        ("absorption", "with 0.3 dB/m, 7 to 9.5 m", lossy, Pulse(), 7, 9.5),
        ("flat", "flat pulse, 3 to 6 m", {"sonar": {"pulse": "flat"}}, Pulse("flat"), 3, 6),
        ("fan", "fan of 36 degrees, 3 to 6 m", wide, Pulse(), 3, 6),
        ("transmit", "transmission 20 degrees wide, 3 to 6 m", beamed, Pulse(), 3, 6),
    ):
        sequence, power = volume_run(bench, changes)
        step = sequence.sonar.range_step_m
        samples = slice(math.ceil(near_m / step), math.floor(far_m / step))
        yield level_row(f"V14.{name}", words, power, closed_form(sequence.sonar, pulse), inner, samples)


@case("volume_shadow")
def shadow(bench):
    """A body stops the rays that meet it: nothing behind a wall, half behind a half wall."""
    inner = slice(10, 50)
    wall = diffuse("wall", {"box": {"size_m": [0.1, 10, 10]}}, (3.05, 0, 0))
    half = diffuse("half", {"box": {"size_m": [0.1, 10, 10]}}, (3.05, 0, 5))
    sequence, power = volume_run(bench, {}, [wall])
    step = sequence.sonar.range_step_m
    behind, before = slice(math.ceil(5 / step), math.floor(9 / step)), slice(
        math.ceil(1.5 / step), math.floor(2.5 / step)
    )
    wanted = closed_form(sequence.sonar, Pulse())
    # 3 m have become 3.1 m on the outermost rays; 5 m is 70 samples further on.
    yield Row("volume_shadow.wall", "behind a wall at 3 m: power over that of open water",
              0.0, float((power / wanted)[:, inner, behind].mean()), 1e-6, "")
    yield level_row(
            "volume_shadow.before", "before the wall, 1.5 to 2.5 m", power, wanted, inner, before
        )
    _, power = volume_run(bench, {}, [half])
    upper_hidden = closed_form(sequence.sonar, Pulse(), (-ELEVATION_RAD / 2, 0.0))
    yield level_row(
            "volume_shadow.half",
            "behind a wall before the upper half of the fan, 5 to 9 m",
            power,
            upper_hidden,
            inner,
            behind,
        )
    sequence, _ = volume_run(bench, {"output": {"polar": True}}, pings=1)
    clean = sequence.image("polar", 0)["labels"].channels["clean_db"].T.astype(float)
    level = measure.level(closed_form(sequence.sonar, Pulse()))
    yield Row("volume_shadow.clean", "open water: clean_db less its closed form, mean of 1.5 to 9 m",
              0.0, float((clean - level)[inner, before.start : behind.stop].mean()), 0.05)
    yield Row("volume_shadow.label", "open water: share of pixels labeled as the volume",
              1.0, float(np.mean(sequence.mask("polar", 0, "instance")[1:] == 1)), 0.0, "")


@case("V28")
def patchy_volume(bench):
    """Gamma patches much larger than a resolution cell give K-distributed amplitudes of their shape."""
    shape, worlds, inner = 1.5, 48, slice(3, 43)

    def normal_power(patches, pings, count):
        """|p|^2 over the closed form, which leaves out that beams are farther apart than wide; of each world."""
        sonar = {
            "range_min_m": 8,
            "range_max_m": 30,
            "beams": {"count": 46, "spacing_deg": 2, "receive_width_deg": 0.5},
            "elevation": {"width_deg": 1, "fan_deg": 1},
            "rays": {"elevation": 1},
        }
        volume = {"strength_db": STRENGTH_DB, **patches}
        changes = {"volumes": [{"name": "water", "uniform": volume}], "sonar": sonar,
                   "trajectory": {"ping_rate_hz": 1, "pings": pings}}
        sequences = bench.run_worlds(changes, count)
        step = sequences[0].sonar.range_step_m
        inside = slice(math.ceil(10 / step), math.floor(28 / step))
        wanted = closed_form(sequences[0].sonar, Pulse())
        return [(np.abs(measure.all_series(one)) ** 2 / wanted)[:, inner, inside] for one in sequences]

    even = normal_power({}, 40, 1)[0].mean()
    patches = {"patches": {"model": "gamma", "shape": shape, "correlation_m": 2}}
    ratios = [power / even for power in normal_power(patches, 4, worlds)]
    moments = np.array([[ratio.mean(), (ratio**2).mean()] for ratio in ratios])
    found, error = measure.jackknifed(moments, measure.k_distribution_shape)
    level, level_error = measure.jackknifed(moments, lambda some: 10 * math.log10(some[:, 0].mean()))
    yield statistical(
        "V28.shape", "gamma patches of shape 1.5 in the water: shape of the K distribution by its moments",
        shape, found, error, worlds, ""
    )
    yield statistical("V28.mean", "the same: mean power over that without patches", 0.0, level, level_error, worlds)
