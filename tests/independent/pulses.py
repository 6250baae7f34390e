"""Pulse shapes: spectra over the band, their envelope, and how far they reach.

x = (f - f_c) / b throughout. A spectrum is scaled so that the envelope of a unit echo,
s(t) = sum_m S_m exp(i 2 pi (f_m - f_c) t), peaks at 1 over the grid t = k / (32 b).
"""
import math
from dataclasses import dataclass

import numpy as np

# Part of the band over which the edges are tapered, at each side.
EDGE = 0.1
# Points of the peak's grid for one sample.
PEAK_GRID = 32


@dataclass(frozen=True)
class Pulse:
    """What decides the spectrum; rows are (frequency_hz, amplitude, phase_rad)."""

    shape: str = "gaussian"
    duration_s: float = 0.0
    taper: float = EDGE
    rows: tuple = ()
    window: str = "none"

    def processing_gain(self, bandwidth_hz):
        """What compression gains over the noise: b duration for the chirp, else 1."""
        return bandwidth_hz * self.duration_s if self.shape == "lfm" else 1.0


def taper(offset, edge=EDGE):
    """Raised cosine over the outer part of the band; offset = |x|."""
    ramp = 0.5 * (1.0 + np.cos(np.pi * (offset - (0.5 - edge)) / edge))
    return np.where(offset <= 0.5 - edge, 1.0, np.where(offset <= 0.5, ramp, 0.0))


def window(kind, x):
    """Receiver's window over the band, 1 at f_c."""
    turn = 2.0 * np.pi * x
    if kind == "hann":
        return 0.5 + 0.5 * np.cos(turn)
    if kind == "hamming":
        return 0.54 + 0.46 * np.cos(turn)
    if kind == "blackman":
        return 0.42 + 0.5 * np.cos(turn) + 0.08 * np.cos(2.0 * turn)
    if kind != "none":
        raise ValueError(f"window {kind!r}")
    return np.ones_like(x)


def table_spectrum(rows, frequency_hz):
    """Amplitude and phase straight between the rows, nothing outside them."""
    rows = np.array(rows, float)
    amplitude = np.interp(frequency_hz, rows[:, 0], rows[:, 1], left=0.0, right=0.0)
    phase = np.unwrap(rows[:, 2])
    return amplitude * np.exp(1j * np.interp(frequency_hz, rows[:, 0], phase))


def raw_spectrum(pulse, x, bandwidth_hz, frequency_hz):
    """Spectrum at offsets x before scaling."""
    edge = pulse.taper if pulse.shape == "lfm" else EDGE
    shape = taper(np.abs(x), edge) * window(pulse.window, x)
    if pulse.shape == "gaussian":
        return shape * np.exp(-((np.pi * x) ** 2))
    if pulse.shape == "cw":
        return shape * np.sinc(x * bandwidth_hz * pulse.duration_s)
    if pulse.shape == "table":
        return shape * table_spectrum(pulse.rows, frequency_hz + x * bandwidth_hz)
    if pulse.shape not in ("flat", "lfm"):
        raise ValueError(f"pulse {pulse.shape!r} has no closed form here")
    return shape


def envelope(spectrum, fine):
    """s at t = k / (fine b) over one period, k = 0 ... fine M - 1; late k are before the delay."""
    bins = len(spectrum)
    padded = np.zeros(bins * fine, complex)
    padded[np.arange(bins) - bins // 2] = spectrum
    return np.fft.ifft(padded) * bins * fine


def spectrum(pulse, bins, bandwidth_hz, frequency_hz=0.0):
    """Spectrum at f_c + (m - M/2) b/M, scaled to unit peak."""
    raw = raw_spectrum(pulse, np.arange(bins) / bins - 0.5, bandwidth_hz, frequency_hz)
    return raw / np.abs(envelope(raw, PEAK_GRID)).max()


def extent_s(pulse, bandwidth_hz, frequency_hz, depth_db=-90.0):
    """T_p: the burst of cw; the span of a table's s above -90 dB, with t = 0 in it; else 0."""
    if pulse.shape == "cw":
        return pulse.duration_s
    if pulse.shape != "table":
        return 0.0
    bins = 65536
    level = np.abs(envelope(spectrum(pulse, bins, bandwidth_hz, frequency_hz), 8))
    heard = np.nonzero(level > 10.0 ** (depth_db / 20.0))[0]
    offset = np.where(heard < 4 * bins, heard, heard - 8 * bins)
    return (max(offset.max(), 0) - min(offset.min(), 0)) / (8.0 * bandwidth_hz)


def smallest_even_smooth(least):
    """The smallest even integer >= least whose only prime factors are 2, 3 and 5."""
    candidate = least + least % 2
    while True:
        rest = candidate
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return candidate
        candidate += 2


def transform_length(samples, bandwidth_hz, pulse_extent_s=0.0, padding=64):
    """M of the padded record."""
    return smallest_even_smooth(samples + padding + math.ceil(bandwidth_hz * pulse_extent_s))
