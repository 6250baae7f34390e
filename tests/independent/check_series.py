#!/usr/bin/python3
"""Works every ping's time series out anew from its scatterer list and compares.

    check_series.py DATASET_DIR

p_j(t) = S0 sum_i B(theta_beam(i) - theta_j)/N_j a_i gain_i exp(-i 2 pi f_c tau_i) s(t - tau_i)

With noise the difference must be that noise: complex normal, of the stated power, alike in
every beam, and the very draws that the documented keyed generator gives. Data sets with adc,
volumes or motion within the ping cannot be worked out from their scatterers and count as skipped.
"""
import math
import sys

import numpy as np

import physics
import random_numbers
import sonar_dataset
from checklist import SKIPPED, run_main
from sequence import DataSet

SERIES_TOLERANCE = 1e-4
# A tenth of the record is judged where it holds this share of the record's norm.
WEAK_TENTH = 1e-6
STANDARD_ERRORS = 4.5


def check_record(checklist, sequence, series, ping):
    """Shape, type and ranges of one stored series."""
    sonar = sequence.sonar
    ok = checklist.expect(series.shape == (sonar.beams, sonar.samples), f"{sequence.name}/{ping} shape",
                          series.shape, (sonar.beams, sonar.samples))
    return ok & checklist.expect(series.dtype == np.dtype("<c8"), f"{sequence.name}/{ping} type",
                                 series.dtype, "complex64")


def check_values(checklist, label, series, expected):
    """Relative L2 over the record and over each tenth of it that is strong enough to judge."""
    error = physics.relative_l2(series, expected)
    checklist.expect(error <= SERIES_TOLERANCE, f"{label} series, relative L2", f"{error:.3e}",
                     f"<= {SERIES_TOLERANCE:.0e} (|p| {np.linalg.norm(series):.6g} beside "
                     f"{np.linalg.norm(expected):.6g} Pa)")
    if error > SERIES_TOLERANCE:
        explain_difference(checklist, series, expected)
        return
    size = np.linalg.norm(expected)
    worst = 0.0
    for part, wanted in zip(np.array_split(series, 10, axis=1), np.array_split(expected, 10, axis=1)):
        if np.linalg.norm(wanted) > WEAK_TENTH * size:
            worst = max(worst, physics.relative_l2(part, wanted))
    checklist.expect(worst <= 10 * SERIES_TOLERANCE, f"{label} series, worst tenth", f"{worst:.3e}",
                     f"<= {10 * SERIES_TOLERANCE:.0e}")


def explain_difference(checklist, series, expected):
    """Name the best complex factor and the worst beam, to tell a scale fault from others."""
    factor = np.vdot(expected, series) / max(np.vdot(expected, expected).real, 1e-300)
    rest = physics.relative_l2(series, factor * expected) if factor else math.inf
    conjugate = physics.relative_l2(series, np.conj(expected))
    mirrored = physics.relative_l2(series, expected[::-1])
    beam_error = np.linalg.norm(series - expected, axis=1)
    checklist.note(f"best factor {factor:.6g}, leaves {rest:.3e}; against the conjugate {conjugate:.3e}; "
                   f"with beams mirrored {mirrored:.3e}; worst beam {int(np.argmax(beam_error))}")


def check_noise(checklist, label, difference, power_pa2):
    """The residual has the stated power overall and in each tenth, and no preferred phase."""
    count = difference.size
    mean = np.mean(np.abs(difference.astype(np.complex128)) ** 2)
    allowed = STANDARD_ERRORS / math.sqrt(count) * power_pa2
    checklist.near(f"{label} noise power", mean, power_pa2, allowed, " Pa2")
    for axis, what in ((1, "samples"), (0, "beams")):
        parts = np.array_split(difference, min(10, difference.shape[axis]), axis=axis)
        off = [np.mean(np.abs(part) ** 2) / power_pa2 - 1.0 for part in parts]
        worst = max(abs(value) * math.sqrt(part.size) for value, part in zip(off, parts))
        checklist.expect(worst <= STANDARD_ERRORS, f"{label} noise, worst tenth of the {what}",
                         f"{worst:.2f} standard errors", f"<= {STANDARD_ERRORS}")
    scale = math.sqrt(power_pa2)
    along_samples = difference[:, 1:] * np.conj(difference[:, :-1])
    along_beams = difference[1:] * np.conj(difference[:-1])
    for value, what in ((np.mean(difference), "mean"), (np.mean(difference ** 2) / scale, "E[n n]"),
                        (np.mean(along_samples) / scale, "correlation of samples"),
                        (np.mean(along_beams) / scale if len(along_beams) else 0, "correlation of beams")):
        deviations = abs(value) * math.sqrt(count / (2.0 * power_pa2))
        checklist.expect(deviations <= STANDARD_ERRORS, f"{label} noise, {what}",
                         f"{deviations:.2f} standard errors", f"<= {STANDARD_ERRORS}")
    fourth = np.mean(np.abs(difference) ** 4) / mean ** 2
    checklist.near(f"{label} noise, E|n|^4 / (E|n|^2)^2 of a complex normal", fourth, 2.0,
                   STANDARD_ERRORS * math.sqrt(20.0 / count))


def check_axes(checklist, sequence):
    """azimuth_rad.npy and range_m.npy against the sonar's numbers."""
    sonar = sequence.sonar
    azimuths = sonar_dataset.read_npy(sequence.path("azimuth_rad.npy"))
    ranges = sonar_dataset.read_npy(sequence.path("range_m.npy"))
    for array, wanted, what in ((azimuths, sonar.azimuths_rad, "azimuth_rad"),
                                (ranges, np.arange(sonar.samples) * sonar.range_step_m, "range_m")):
        alike = array.shape == wanted.shape and array.dtype == np.dtype("<f8")
        gap = np.max(np.abs(array - wanted)) if alike else math.inf
        checklist.expect(gap < 1e-9, f"{sequence.name} {what}.npy {array.dtype}{array.shape}, largest difference",
                         f"{gap:.2e}", "< 1e-9")


def check(checklist, root):
    compared = 0
    for sequence in DataSet(root).sequences:
        sonar = sequence.sonar
        check_axes(checklist, sequence)
        if sonar.unsupported:
            checklist.note(f"{sequence.name}: not worked out, it has {', '.join(sonar.unsupported)}")
            continue
        for ping in sequence.pings:
            series = sequence.series(ping)
            if not check_record(checklist, sequence, series, ping):
                continue
            expected = physics.beam_series(sequence.scatterers(ping), sonar)
            label = f"{sequence.name}/{ping:06d}"
            if sonar.noise_power_pa2 is not None:
                check_noise(checklist, label, series - expected, sonar.noise_power_pa2)
                expected = expected + random_numbers.sample_noise(sequence.seed, sequence.number, ping, sonar.beams,
                                                                  sonar.samples, sonar.noise_power_pa2)
            check_values(checklist, label, series, expected)
            compared += 1
    if not compared and not checklist.failures:
        print("check_series: skipped, no ping can be worked out")
        return SKIPPED
    return None


if __name__ == "__main__":
    sys.exit(run_main("check_series", check))
