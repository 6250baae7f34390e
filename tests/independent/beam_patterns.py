"""Receive, elevation and transmit patterns, shaded and not.

A shaded line aperture of A wavelengths has the pattern F(u), u = A sin(theta); A is such that
F is at half power at half the stated width, where sin(theta) is taken for theta: the array grows
as it is shaded. Chebyshev is van der Maas' limit of many elements.
"""
from dataclasses import dataclass

import numpy as np

# sinc(0.884 sin(theta) / width) is 3 dB down at +- width / 2, nearly.
SINC_WIDTH_FACTOR = 0.884
# sinc(0.442946) is half power.
TRANSMIT_WIDTH_FACTOR = 0.442946


@dataclass(frozen=True)
class Shading:
    """Aperture shading; side lobes in dB (negative) for taylor and chebyshev."""

    kind: str = "uniform"
    side_lobe_db: float = -35.0
    nbar: int = 5


def line_pattern(shading, u):
    """F(u) of a continuous line aperture one unit long, F(0) = 1."""
    u = np.asarray(u, float)
    if shading.kind == "uniform":
        return np.sinc(u)
    if shading.kind == "hann":
        return np.sinc(u) + 0.5 * (np.sinc(u - 1.0) + np.sinc(u + 1.0))
    strength = np.arccosh(10.0 ** (-shading.side_lobe_db / 20.0)) / np.pi
    if shading.kind == "chebyshev":
        root = np.sqrt((strength**2 - u**2).astype(complex))
        return (np.cosh(np.pi * root) / np.cosh(np.pi * strength)).real
    if shading.kind != "taylor":
        raise ValueError(f"shading {shading.kind!r}")
    return _taylor(u, strength, shading.nbar)


def _taylor(u, strength, nbar):
    """Taylor's aperture by its Fourier series: sums of shifted sinc, no division by zero."""
    order = np.arange(1, nbar)
    stretch = nbar**2 / (strength**2 + (nbar - 0.5) ** 2)
    zeros = stretch * (strength**2 + (order - 0.5) ** 2)
    out = np.sinc(u)
    for m in order:
        others = order[order != m]
        factor = (
            (-1.0) ** (m + 1)
            * np.prod(1.0 - m**2 / zeros)
            / (2.0 * np.prod(1.0 - m**2 / others.astype(float) ** 2))
        )
        out = out + factor * (np.sinc(u - m) + np.sinc(u + m))
    return out


def half_power_u(shading):
    """u at which F falls to half power, by bisection on the main lobe."""
    low, high = 0.0, 0.1
    while line_pattern(shading, high) > np.sqrt(0.5):
        high += 0.1
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if line_pattern(shading, middle) > np.sqrt(0.5) else (low, middle)
        )
    return 0.5 * (low + high)


def aperture_wavelengths(shading, width_rad):
    """Length of the aperture whose -3 dB width is width_rad."""
    if shading.kind == "uniform":
        return SINC_WIDTH_FACTOR / width_rad
    return 2.0 * half_power_u(shading) / width_rad


def beam_pattern(offset_rad, width_rad, shading=Shading()):
    """Signed one-way pattern at an angle off the beam."""
    return line_pattern(shading, aperture_wavelengths(shading, width_rad) * np.sin(offset_rad))


def transmit_pattern(azimuth_rad, width_rad):
    """Amplitude of the sent sound, half power at +- width / 2; 1 where no width is given."""
    if width_rad is None:
        return np.ones_like(azimuth_rad)
    return np.sinc(TRANSMIT_WIDTH_FACTOR * np.sin(azimuth_rad) / np.sin(width_rad / 2.0))
