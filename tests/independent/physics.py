"""The sonar model's formulas, worked out anew in double precision.

Everything follows the written physics: complex baseband series in Pa rms, engineering sign
(a delay tau multiplies the spectrum by exp(-i 2 pi f tau)), records of N stored samples at
1/bandwidth, transforms padded to M bins so that the record does not wrap.
"""
import math

import numpy as np

from beam_patterns import Shading, beam_pattern, transmit_pattern

# Level that stands for "no energy" in the images, dB re 1 uPa.
SILENCE_DB = -99.0


def source_pressure_pa_m(source_level_db):
    """S0: rms pressure at 1 m from a source level in dB re 1 uPa m."""
    return 10.0 ** ((source_level_db - 120.0) / 20.0)


def level_db(pressure_pa):
    """Level of a pressure, dB re 1 uPa; silence for zero."""
    return power_level_db(np.abs(np.asarray(pressure_pa).astype(np.complex128)) ** 2)


def power_level_db(power_pa2):
    """Level of a power in Pa^2, dB re 1 uPa; silence for zero and below."""
    with np.errstate(divide="ignore"):
        return np.maximum(10.0 * np.log10(np.maximum(power_pa2, 0.0)) + 120.0, SILENCE_DB)


def stored_samples(bandwidth_hz, range_max_m, sound_speed_m_s):
    """N = ceil(b 2R/c); products that are whole numbers but for rounding stay whole."""
    exact = bandwidth_hz * 2.0 * range_max_m / sound_speed_m_s
    return round(exact) if abs(exact - round(exact)) < 1e-9 * exact else math.ceil(exact)


def beam_azimuths_rad(count, spacing_rad):
    """Beam (and sector) centres, beam 0 to starboard."""
    return (np.arange(count) - (count - 1) / 2.0) * spacing_rad


def beam_borders_rad(azimuths_rad):
    """Borders of the sectors: halfway between beams, the outer sectors symmetric about theirs."""
    inner = (azimuths_rad[1:] + azimuths_rad[:-1]) / 2.0
    low, high = 2.0 * azimuths_rad[0] - inner[0], 2.0 * azimuths_rad[-1] - inner[-1]
    return np.concatenate([[low], inner, [high]])


def mixing_weights(azimuths_rad, width_rad, normalization, shading=Shading(), middles_rad=None):
    """W[j, i] = B(theta_i - theta_j) / N_j, theta_i the middle of sector i; one width or one of each beam."""
    middles_rad = azimuths_rad if middles_rad is None else middles_rad
    offsets = middles_rad[None, :] - azimuths_rad[:, None]
    if np.ndim(width_rad) == 0:
        weights = beam_pattern(offsets, width_rad, shading)
    else:
        weights = np.stack([beam_pattern(*each, shading) for each in zip(offsets, width_rad)])
    if normalization == "mean_square":
        return weights / np.sqrt(np.sum(weights**2, axis=1, keepdims=True))
    if normalization != "calibrated":
        raise ValueError(f"normalization {normalization!r}")
    return weights


def propagation_gain(range_m, azimuth_rad, elevation_rad, sonar):
    """Spreading and absorption over both ways, elevation pattern (once), transmit pattern."""
    loss = 10.0 ** (-sonar.absorption_db_m * 2.0 * range_m / 20.0)
    sent = transmit_pattern(azimuth_rad, sonar.transmit_width_rad)
    up = beam_pattern(elevation_rad, sonar.elevation_width_rad, sonar.elevation_shading)
    return loss * sent * up / range_m**2


def trigonometric_sums(coefficients, cycles, bins):
    """F[k] = sum_i c_i exp(-i 2 pi k x_i), k = 0 .. bins-1, by splitting k = 32 q + r."""
    width = 32
    rows = -(-bins // width)
    coarse = np.exp(-2j * np.pi * np.outer(cycles, width * np.arange(rows)))
    fine = np.exp(-2j * np.pi * np.outer(cycles, np.arange(width)))
    return ((coefficients[:, None] * coarse).T @ fine).reshape(-1)[:bins]


def sector_series(coefficients, sector, delay_s, sectors, spectrum, bandwidth_hz, samples):
    """q_i(t_n) = sum over the sector's echoes of coefficient * s(t_n - tau).

    `spectrum` is the pulse at (m - M/2) b/M; an exact trigonometric sum, no interpolation.
    """
    bins = len(spectrum)
    out = np.zeros((sectors, samples), np.complex128)
    for index in np.unique(sector):
        mine = sector == index
        cycles = delay_s[mine] * bandwidth_hz / bins
        # Bin m stands for k = m - M/2: take that half turn per sample into the coefficients.
        shifted = coefficients[mine] * np.exp(2j * np.pi * cycles * (bins // 2))
        sums = spectrum * trigonometric_sums(shifted, cycles, bins)
        out[index] = bins * np.fft.ifft(np.fft.ifftshift(sums))[:samples]
    return out


def sector_intensity(weights, sector, delay_s, sectors, spectrum, bandwidth_hz, samples):
    """v_i(t_n) = sum over the sector's echoes of weight * |s(t_n - tau)|^2, weight real.

    |s|^2 is itself a trigonometric sum whose coefficients are the spectrum's autocorrelation.
    """
    bins = len(spectrum)
    correlation = np.correlate(spectrum, spectrum, "full")[bins - 1 :]
    out = np.zeros((sectors, samples))
    for index in np.unique(sector):
        mine = sector == index
        cycles = delay_s[mine] * bandwidth_hz / bins
        sums = correlation * trigonometric_sums(weights[mine].astype(np.complex128), cycles, bins)
        # At whole samples negative and positive frequencies are conjugate: twice the real part.
        sums[0] *= 0.5
        out[index] = 2.0 * bins * np.fft.ifft(sums).real[:samples]
    return out


def beam_series(scatterers, sonar):
    """p_j(t) of the beam model from a scatterer list, complex128 [beams, samples], Pa."""
    delay = scatterers["delay_s"].astype(np.float64)
    amplitude = scatterers["amp_re"].astype(np.float64) + 1j * scatterers["amp_im"].astype(
        np.float64
    )
    return _mixed_series(amplitude, scatterers, delay, sonar)


def _mixed_series(amplitude, scatterers, delay, sonar):
    gain = scatterers["gain"].astype(np.float64)
    # Whole turns of the carrier are removed before the exponential to keep its phase exact.
    turns = np.mod(sonar.frequency_hz * delay, 1.0)
    coefficients = sonar.source_pressure_pa_m * amplitude * gain * np.exp(-2j * np.pi * turns)
    sectors = sector_series(
        coefficients,
        scatterers["beam"],
        delay,
        sonar.beams,
        sonar.spectrum,
        sonar.bandwidth_hz,
        sonar.samples,
    )
    return sonar.weights @ sectors


def expected_power(scatterers, sonar):
    """clean_j(t): coherent mean squared plus the incoherent sum of variances, Pa^2."""
    delay = scatterers["delay_s"].astype(np.float64)
    mean = scatterers["mean_re"].astype(np.float64) + 1j * scatterers["mean_im"].astype(np.float64)
    power = np.abs(_mixed_series(mean, scatterers, delay, sonar)) ** 2 if np.any(mean) else 0.0
    strength = (
        scatterers["variance"].astype(np.float64) * scatterers["gain"].astype(np.float64) ** 2
    )
    sectors = sector_intensity(
        strength,
        scatterers["beam"],
        delay,
        sonar.beams,
        sonar.spectrum,
        sonar.bandwidth_hz,
        sonar.samples,
    )
    return power + sonar.source_pressure_pa_m**2 * (sonar.weights**2 @ sectors)


def noise_power_pa2(spectrum_level_db, bandwidth_hz, pulse_gain=1.0):
    """Mean square of the noise: NL over the band, divided by a chirp's processing gain."""
    return bandwidth_hz * 10.0 ** ((spectrum_level_db - 120.0) / 10.0) / pulse_gain


def snr_noise_power_pa2(snr_db, clean_pa2, has_echo):
    """Noise that lies snr_db under the mean clean power of the pixels with an echo of their own."""
    return float(np.mean(clean_pa2[has_echo])) / 10.0 ** (snr_db / 10.0)


def converted(series, bits, full_scale_db):
    """What an analogue-to-digital converter makes of re and im: whole steps, clipped."""
    step = 10.0 ** ((full_scale_db - 120.0) / 20.0) / 2.0 ** (bits - 1)
    highest = 2.0 ** (bits - 1)

    def one(part):
        return np.clip(np.rint(part / step), -highest, highest - 1.0) * step

    return one(series.real) + 1j * one(series.imag)


def relative_l2(obtained, expected):
    """||obtained - expected|| / ||expected||; infinite where only the expected is zero."""
    difference = np.linalg.norm(obtained - expected)
    size = np.linalg.norm(expected)
    return difference / size if size > 0 else (0.0 if difference == 0 else math.inf)
