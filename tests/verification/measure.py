"""Reading numbers off series: interpolation, peaks, widths, side lobes, means with errors."""
import math

import numpy as np

# 10 log10 of a mean intensity has this standard error, times that of the mean relative to it.
DECIBELS = 10.0 / math.log(10.0)


def interpolated(series, fine=32):
    """Series on a grid fine times denser, by a zero-padded DFT along the last axis."""
    series = np.asarray(series, complex)
    count = series.shape[-1]
    spectrum = np.fft.fft(series)
    padded = np.zeros(series.shape[:-1] + (count * fine,), complex)
    positive = (count + 1) // 2
    padded[..., :positive] = spectrum[..., :positive]
    padded[..., positive - count :] = spectrum[..., positive:]
    return np.fft.ifft(padded) * fine


def level(power_pa2):
    """dB re 1 uPa of a power in Pa^2."""
    return 10.0 * np.log10(power_pa2) + 120.0


def peak(y):
    """Place (in points) and height of the highest point, by the parabola through three points."""
    top = int(np.argmax(y))
    if top in (0, len(y) - 1):
        return float(top), float(y[top])
    return vertex(y, top)


def vertex(y, i):
    """Place and height of the parabola through points i - 1, i, i + 1."""
    left, middle, right = float(y[i - 1]), float(y[i]), float(y[i + 1])
    curvature = left - 2.0 * middle + right
    if curvature == 0.0:
        return float(i), middle
    shift = 0.5 * (left - right) / curvature
    return i + shift, middle - 0.25 * (left - right) * shift


def crossing(x, y, i, target):
    """Where the cubic through points i - 1 ... i + 2 meets target between points i and i + 1."""
    here = slice(max(i - 1, 0), i + 3)
    origin = x[i]
    cubic = np.polyfit(x[here] - origin, y[here] - target, 3)
    roots = np.roots(cubic)
    real = roots[np.abs(roots.imag) < 1e-9 * (abs(x[i + 1] - x[i]))].real
    inside = real[(real >= -1e-12) & (real <= (x[i + 1] - x[i]) * (1 + 1e-9))]
    return origin + float(inside[0])


def edges(x, power, share=0.5):
    """Where power falls to this share of its peak (half power) to the left and right of it."""
    top = int(np.argmax(power))
    target = share * peak(power)[1]
    right = top + int(np.argmax(power[top:] < target)) - 1
    left = top - int(np.argmax(power[top::-1] < target))
    return crossing(x, power, left, target), crossing(x, power, right, target)


def width_at(x, power, share=0.5):
    """Full width at this share of the peak (half power)."""
    left, right = edges(x, power, share)
    return right - left


def lobes(power):
    """Indices of local maxima, the ends left out."""
    return np.nonzero((power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:]))[0] + 1


def first_side_lobe_db(power):
    """Height of the nearest lobe to the right of the highest one, relative to it."""
    top, highest = int(np.argmax(power)), peak(power)[1]
    beside = [i for i in lobes(power) if i > top]
    return 10.0 * math.log10(vertex(power, beside[0])[1] / highest)


def highest_side_lobe_db(power):
    """Height of the highest lobe beyond the half-power edges, relative to the peak."""
    left, right = edges(np.arange(len(power), dtype=float), power)
    heights = [vertex(power, i)[1] for i in lobes(power) if not left <= i <= right]
    return 10.0 * math.log10(max(heights) / peak(power)[1])


def all_series(sequence):
    """Series of all pings, complex128 [pings, beams, samples]."""
    return np.stack([sequence.series(ping) for ping in sequence.pings]).astype(np.complex128)


def mean_and_error(values):
    """Mean of independent values (one a ping) and its standard error."""
    values = np.asarray(values, float)
    return float(values.mean()), float(values.std(ddof=1) / math.sqrt(len(values)))


def jackknifed(values, fitted):
    """The fit over all values and its standard error, by leaving out one after the other."""
    count = len(values)
    left_out = np.array([fitted(np.delete(values, k, axis=0)) for k in range(count)])
    spread = np.sum((left_out - left_out.mean()) ** 2)
    return fitted(values), math.sqrt((count - 1) / count * spread)


def k_distribution_shape(moments):
    """Shape of the K distribution from first and second moments of intensities, one pair a row."""
    return 1 / (moments[:, 1].mean() / moments[:, 0].mean() ** 2 / 2 - 1)


def mean_level(power_of_pings):
    """Level of the mean power and its standard error in dB, from one value a ping."""
    mean, error = mean_and_error(power_of_pings)
    return float(level(mean)), DECIBELS * error / mean


def equivalent_draws(level_error_db):
    """How many independent intensities would give this standard error of a mean level."""
    return int(round((DECIBELS / level_error_db) ** 2))
