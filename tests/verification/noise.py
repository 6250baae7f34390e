"""Noise: its level, the chirp's gain, the signal-to-noise ratio, the converter."""
import numpy as np

import labels
import measure
import physics
from bench import Row, case, diffuse, point_target, statistical

SEABED = {
    "sonar": {
        "range_max_m": 3.2,
        "beams": {"count": 12, "spacing_deg": 1, "receive_width_deg": 2},
        "rays": {"elevation": 96, "azimuth": 2},
        "mount": {"rotation_deg": [0, 30, 0]},
    },
    "materials": {"m": {"reflectivity": 1e-3}},
    "objects": [diffuse("floor", {"plane": {}}, (0, 0, -1))],
}


def noise_level(bench, changes, pings=12):
    """Mean level over everything, of pings that hold noise alone; its error; the draws."""
    sequence = bench.run(
        {
            "trajectory": {"ping_rate_hz": 1, "pings": pings},
            "noise": {"spectrum_level_db": 30},
            **changes,
        }
    )
    power = np.abs(measure.all_series(sequence)) ** 2
    obtained, error = measure.mean_level(power.reshape(-1))
    return obtained, error, power.size


@case("V15")
def noise_alone(bench):
    """Mean level of noise, and the same for a chirp, whose compression gains b duration."""
    for name, words, pulse, gain in (
        ("band", "noise only, 30 dB re 1 uPa^2/Hz: mean level", None, 0.0),
        (
            "lfm",
            "the same with a chirp of 2 ms: lower by 10 log10(b duration)",
            {"lfm": {"duration_s": 2e-3}},
            10 * np.log10(29900 * 2e-3),
        ),
    ):
        changes = {"sonar": {"pulse": pulse}} if pulse else {}
        obtained, error, draws = noise_level(bench, changes)
        expected = 30.0 + 10 * np.log10(29900.0) - gain
        yield statistical(f"V15.{name}", words, float(expected), obtained, error, draws, tolerance=0.1)


@case("snr")
def signal_to_noise(bench):
    """noise.snr_db: noise below the mean clean power of ping 0 where there is an echo."""
    sequence = bench.run(
        {**SEABED, "noise": {"snr_db": 20}, "trajectory": {"ping_rate_hz": 1, "pings": 30}},
        scatterers=True,
    )
    sonar, power = sequence.sonar, []
    for ping in sequence.pings:
        residual = sequence.series(ping) - physics.beam_series(sequence.scatterers(ping), sonar)
        power.append(np.abs(residual) ** 2)
    scatterers = sequence.scatterers(0)
    echoes = labels.PixelLabels(scatterers, sonar.bandwidth_hz, sonar.beams, sonar.samples)
    expected = physics.snr_noise_power_pa2(
        20.0, physics.expected_power(scatterers, sonar), echoes.has_echo
    )
    power = np.array(power)
    obtained, error = measure.mean_level(power.reshape(-1))
    yield statistical("snr.level", "snr_db 20: mean level of what is not echo",
                      float(measure.level(expected)), obtained, error, power.size, tolerance=0.1)
    yield Row("snr.stated", "snr_db 20: noise power as stated",
              float(measure.level(expected)), float(measure.level(sequence.sonar.stated_noise_pa2)), 0.01)


BITS, FULL_SCALE_DB = 10, 150.0


def converted_pings(bench):
    """Parts of all samples in steps: as stored, and as worked out before the converter."""
    sequence = bench.run(
        {
            **SEABED,
            "point_targets": [point_target("strong", -20.0, (2.0, 0.0, -0.3))],
            "sonar": {
                **SEABED["sonar"],
                "receiver": {"adc": {"bits": BITS, "full_scale_db": FULL_SCALE_DB}},
            },
            "trajectory": {"ping_rate_hz": 1, "pings": 10},
        },
        scatterers=True,
    )
    step = 10 ** ((FULL_SCALE_DB - 120) / 20) / 2 ** (BITS - 1)
    stored, analogue = [], []
    for ping in sequence.pings:
        series = sequence.series(ping).astype(complex) / step
        came = physics.beam_series(sequence.scatterers(ping), sequence.sonar) / step
        stored += [series.real, series.imag]
        analogue += [came.real, came.imag]
    return np.array(stored), np.array(analogue)


@case("adc")
def converter(bench):
    """Converted samples are the nearest whole steps; the error is that of rounding; clipping."""
    stored, analogue = converted_pings(bench)
    highest = 2 ** (BITS - 1)
    whole = np.rint(stored)
    gap = np.abs(whole - np.clip(analogue, -highest, highest - 1))
    moving = (np.abs(analogue) > 2) & (np.abs(analogue) < highest - 1)
    error = (whole - analogue)[moving]
    mean, spread = measure.mean_and_error(error**2)
    steps = "steps"
    yield Row("adc.grid", f"{BITS} bits: largest distance of a sample from a whole step",
              0.0, float(np.abs(stored - whole).max()), 1e-3, steps)
    yield Row("adc.nearest", "samples that are not the nearest step within the converter's reach",
              0.0, float(np.count_nonzero(gap > 0.501)), 0, "")
    yield Row("adc.loudest", "highest: 2^(bits-1) - 1", highest - 1, stored.max(), 1e-3, steps)
    yield Row("adc.deepest", "lowest: -2^(bits-1)", -highest, stored.min(), 1e-3, steps)
    yield statistical("adc.error", "mean square error of a sample between two steps",
                      1 / 12, mean, spread, len(error), "steps^2")
