#!/usr/bin/python3
"""Works every ping's time series out anew from its scatterer list and compares.

    check_series.py DATASET_DIR

p_j(t) = S0 sum_i B(theta_beam(i) - theta_j)/N_j a_i gain_i exp(-i 2 pi f_c tau_i) s(t - tau_i)

With noise the difference must be that noise: the very draws of the stated power that the documented
keyed generator gives. With a converter every sample must be the nearest of its steps. Data sets with
volumes cannot be worked out from their scatterers and count as skipped.
"""
import math
import sys

import numpy as np

import labels
import physics
import random_numbers
import sonar_dataset
from checklist import SKIPPED, run_main
from sequence import DataSet

SERIES_TOLERANCE = 1e-4
# Of the loudest sample: what single precision may move before the converter.
ROUNDING = 1e-6
# A tenth of the record is judged where it holds this share of the record's norm.
WEAK_TENTH = 1e-6


def check_record(checklist, sequence, series, ping):
    """Shape, type and ranges of one stored series."""
    sonar = sequence.sonar
    ok = checklist.equal(
        f"{sequence.name}/{ping} shape", series.shape, (sonar.beams, sonar.samples)
    )
    return ok & checklist.expect(
        series.dtype == np.dtype("<c8"), f"{sequence.name}/{ping} type", series.dtype, "complex64"
    )


def check_values(checklist, label, series, expected):
    """Relative L2 over the record and over each tenth of it that is strong enough to judge."""
    error = physics.relative_l2(series, expected)
    checklist.at_most(
        f"{label} series, relative L2",
        error,
        SERIES_TOLERANCE,
        note=f"(|p| {np.linalg.norm(series):.6g} beside {np.linalg.norm(expected):.6g} Pa)",
    )
    if error > SERIES_TOLERANCE:
        explain_difference(checklist, series, expected)
        return
    size = np.linalg.norm(expected)
    worst = 0.0
    for part, wanted in zip(
        np.array_split(series, 10, axis=1), np.array_split(expected, 10, axis=1)
    ):
        if np.linalg.norm(wanted) > WEAK_TENTH * size:
            worst = max(worst, physics.relative_l2(part, wanted))
    checklist.at_most(f"{label} series, worst tenth", worst, 10 * SERIES_TOLERANCE)


def explain_difference(checklist, series, expected):
    """Name the best complex factor and the worst beam, to tell a scale fault from others."""
    factor = np.vdot(expected, series) / max(np.vdot(expected, expected).real, 1e-300)
    rest = physics.relative_l2(series, factor * expected) if factor else math.inf
    conjugate = physics.relative_l2(series, np.conj(expected))
    mirrored = physics.relative_l2(series, expected[::-1])
    beam_error = np.linalg.norm(series - expected, axis=1)
    checklist.note(
        f"best factor {factor:.6g}, leaves {rest:.3e}; against the conjugate {conjugate:.3e}; "
        f"with beams mirrored {mirrored:.3e}; worst beam {int(np.argmax(beam_error))}"
    )


def check_axes(checklist, sequence):
    """azimuth_rad.npy and range_m.npy against the sonar's numbers."""
    sonar = sequence.sonar
    azimuths = sonar_dataset.read_npy(sequence.path("azimuth_rad.npy"))
    ranges = sonar_dataset.read_npy(sequence.path("range_m.npy"))
    for array, wanted, what in (
        (azimuths, sonar.azimuths_rad, "azimuth_rad"),
        (ranges, np.arange(sonar.samples) * sonar.range_step_m, "range_m"),
    ):
        alike = array.shape == wanted.shape and array.dtype == np.dtype("<f8")
        gap = np.max(np.abs(array - wanted)) if alike else math.inf
        checklist.at_most(f"{sequence.name} {what}.npy {array.dtype}{array.shape}, largest difference", gap, 1e-9)


def check_converted(checklist, label, series, expected, adc, tolerance):
    """Whole steps of the converter, each the nearest to what came in, clipped at its ends."""
    wanted = physics.converted(expected, adc.bits, adc.full_scale_db)
    step = 10.0 ** ((adc.full_scale_db - 120.0) / 20.0) / 2.0 ** (adc.bits - 1)
    checklist.near(f"{label} converter's step", adc.step_pa, step, 1e-9 * step, " Pa")
    parts = np.stack([series.real, series.imag]).astype(np.float64) / step
    off_grid = np.max(np.abs(parts - np.rint(parts)))
    checklist.at_most(f"{label} samples off the converter's steps, largest", off_grid, 1e-3, unit=" steps")
    # A sample that lies between two steps to within the series' own error may go either way.
    gap = np.abs(parts - np.stack([wanted.real, wanted.imag]) / step)
    unsure = max(ROUNDING, 10 * tolerance) * np.abs(expected).max() / step
    away = np.abs(np.stack([expected.real, expected.imag]) / step % 1.0 - 0.5)
    wrong = np.count_nonzero((gap > 0.5) & ((away > unsure) | (gap > 1.5)))
    checklist.none_of(f"{label} samples at another step", wrong, parts.size)


def check_snr(checklist, sequence):
    """The noise that a signal-to-noise ratio stands for, from the clean power of ping 0."""
    sonar = sequence.sonar
    if sonar.snr_db is None or 0 not in sequence.pings:
        return
    scatterers = sequence.scatterers(0)
    echoes = labels.PixelLabels(scatterers, sonar.bandwidth_hz, sonar.beams, sonar.samples)
    wanted = physics.snr_noise_power_pa2(
        sonar.snr_db, physics.expected_power(scatterers, sonar), echoes.has_echo
    )
    checklist.near(
        f"{sequence.name} noise power of {sonar.snr_db:g} dB",
        sonar.stated_noise_pa2,
        wanted,
        1e-4 * wanted,
        " Pa2",
    )


def check_ping(checklist, sequence, ping, series):
    """One ping's series against its scatterers, noise and converter."""
    sonar, label = sequence.sonar, f"{sequence.name}/{ping:06d}"
    expected = physics.beam_series(sequence.scatterers(ping), sonar)
    power = sonar.noise_power_pa2
    if power is not None:
        expected = expected + random_numbers.sample_noise(
            sequence.seed, sequence.number, ping, sonar.beams, sonar.samples, power
        )
    if sonar.adc is not None:
        check_converted(checklist, label, series, expected, sonar.adc, sonar.tolerance)
    else:
        check_values(checklist, label, series, expected)


def check(checklist, root):
    compared = 0
    for sequence in DataSet(root).sequences:
        sonar = sequence.sonar
        check_axes(checklist, sequence)
        if sonar.unsupported:
            checklist.note(
                f"{sequence.name}: not worked out, it has {', '.join(sonar.unsupported)}"
            )
            continue
        check_snr(checklist, sequence)
        for ping in sequence.pings:
            series = sequence.series(ping)
            if check_record(checklist, sequence, series, ping):
                check_ping(checklist, sequence, ping, series)
                compared += 1
    if not compared and not checklist.failures:
        print("check_series: skipped, no ping can be worked out")
        return SKIPPED
    return None


if __name__ == "__main__":
    sys.exit(run_main("check_series", check))
