"""The levels of a detector, worked out from the time series by the formulas of docs/physics/electronics.md."""
import numpy as np

import physics
import random_numbers

STREAM_DETECTOR = 18


def sub_bands(spectrum, looks):
    """Filters [looks, M] at x = -1/2 ... of bands with equal energy, which cross over a quarter of the narrower one."""
    bins = len(spectrum)
    x = np.arange(bins) / bins - 0.5
    energy = np.concatenate([[0.0], np.cumsum(np.abs(spectrum) ** 2)])
    edges = (np.arange(bins + 1) - 0.5) / bins - 0.5
    inner = np.interp(energy[-1] * np.arange(1, looks) / looks, energy, edges)
    borders = np.concatenate([[-0.5], inner, [0.5]])
    # Angles from 0 below a border to pi/2 above it; the ends of the band have no crossing.
    widths = np.diff(borders)
    angles = [np.full(bins, np.pi / 2)]
    for border, narrower in zip(inner, np.minimum(widths[1:], widths[:-1])):
        u = np.clip((x - border) / (narrower / 8.0), -1.0, 1.0)
        angles.append(np.pi / 4.0 * (1.0 + np.sin(np.pi / 2.0 * u)))
    angles.append(np.zeros(bins))
    return np.array([np.sin(low) * np.cos(high) for low, high in zip(angles[:-1], angles[1:])])


def power_of_looks(series, spectrum, looks):
    """sum_k |p_k|^2 of series [beams, samples], silent beyond the record."""
    if looks == 1:
        return np.abs(series) ** 2
    transformed = np.fft.fft(series, len(spectrum), axis=1)
    filters = np.fft.ifftshift(sub_bands(spectrum, looks), axes=1)
    return sum(np.abs(np.fft.ifft(transformed * one, axis=1)[:, : series.shape[1]]) ** 2 for one in filters)


def log_noise_db(detector, key, ping, shape):
    """Two samples share a draw."""
    beams, samples = shape
    item = (np.arange(beams, dtype=np.uint64)[:, None] << np.uint64(32)) + np.arange((samples + 1) // 2, dtype=np.uint64)
    xi = random_numbers.complex_normals(key, ping, item)
    both = np.sqrt(2.0) * np.stack([xi.real, xi.imag], axis=2).reshape(beams, -1)
    return detector.noise_db * both[:, :samples]


def mean_of_samples(values, length):
    """Means over an interval of this many samples about each, as far as there are samples."""
    total, weights = np.zeros(values.shape), np.zeros(values.shape[1])
    count = values.shape[1]
    for k in range(-int(length), int(length) + 1):
        weight = max(0.0, min(k + 0.5, length / 2.0) - max(k - 0.5, -length / 2.0))
        here = slice(max(0, -k), min(count, count - k))
        there = slice(max(0, k), min(count, count + k))
        total[:, here] += weight * values[:, there]
        weights[here] += weight
    return total / weights


def levels_db(detector, sequence, ping, series):
    """[beams, samples]; without a detector the levels of the series."""
    if detector is None:
        return physics.level_db(series)
    power = power_of_looks(series.astype(np.complex128), sequence.sonar.spectrum, detector.looks)
    if detector.floor_db is not None:
        power = power + 10.0 ** ((detector.floor_db - 120.0) / 10.0)
    key = random_numbers.stream_key(sequence.seed, STREAM_DETECTOR, sequence.number)
    power = power * 10.0 ** (log_noise_db(detector, key, ping, power.shape) / 10.0)
    if detector.law == "logarithm":
        return mean_of_samples(physics.power_level_db(power), detector.integrate)
    exponent = {"power": 1.0, "amplitude": 0.5}[detector.law]
    return physics.power_level_db(mean_of_samples(power**exponent, detector.integrate) ** (1.0 / exponent))
