"""How surfaces and water scatter: diffuse laws, coherent parts, expected moments.

The backscatter strength s_b is per unit of surface; an echo that stands for the cross-section
dA = cos(alpha) dS has E|a|^2 = s_b dA / cos(alpha).
"""
from dataclasses import dataclass
from functools import lru_cache

import numpy as np


@dataclass(frozen=True)
class Law:
    """A diffuse law; rows are (grazing_deg, strength_db)."""

    model: str = "lambert"
    reflectivity: float = 0.0
    exponent: float = 1.0
    rows: tuple = ()


def backscatter_strength(law, cosine):
    """s_b at incidence cos(alpha); a table holds its first and last rows beyond them."""
    cosine = np.asarray(cosine, float)
    if law.model == "lambert":
        return law.reflectivity * cosine ** (law.exponent + 1.0)
    if law.model == "lommel_seeliger":
        return law.reflectivity * cosine
    if law.model != "table":
        raise ValueError(f"law {law.model!r}")
    rows = np.array(law.rows, float)
    grazing_deg = 90.0 - np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
    return 10.0 ** (np.interp(grazing_deg, rows[:, 0], rows[:, 1]) / 10.0)


def echo_energy(law, cosine, cross_section_m2, coherent=None, wavelength_m=None):
    """sigma^2 = E|a|^2 of the echo from one cell; `coherent` adds what its roughness scatters."""
    strength = backscatter_strength(law, cosine)
    if coherent is not None and coherent.get("roughness_correlation_m"):
        strength = strength + rough_strength(coherent, wavelength_m, cosine)
    return strength * cross_section_m2 / cosine


def bessel_j0(x):
    """Its mean over directions: J0(x) = <cos(x sin a)>."""
    angles = (np.arange(128) + 0.5) * np.pi / 256
    return np.cos(np.asarray(x)[..., None] * np.sin(angles)).mean(-1)


def rough_strength(coherent, wavelength_m, cosine):
    """What a rough reflector scatters back: Kirchhoff's integral over the correlation of its heights.

    (R k / (2 pi cos a))^2 int [e^(-g (1 - rho)) - e^(-g)] J0(2 k d sin a) 2 pi d dd, rho = e^(-(d/L)^2),
    on a grid of angles, interpolated in dB. Digits end at 1e-12 of the value at normal incidence.
    """
    keys = ("reflection", "roughness_rms_m", "roughness_correlation_m")
    alpha, level = _rough_levels(2 * np.pi / wavelength_m, *(coherent[key] for key in keys))
    return np.exp(np.interp(np.arccos(np.clip(cosine, 0.0, 1.0)), alpha, level))


@lru_cache(maxsize=8)
def _rough_levels(k, reflection, rms_m, reach):
    """The grid of angles and the logarithm of the strength there."""
    alpha = np.linspace(0, np.pi / 2 * 0.999, 1441)
    g = (2 * k * rms_m * np.cos(alpha)) ** 2
    nodes, weights = np.polynomial.legendre.leggauss(300)
    end = reach * np.sqrt(np.log(max(g[0], 1.0)) + 30)
    d, step = end * (nodes + 1) / 2, end * weights / 2
    rho = np.exp(-((d / reach) ** 2))
    kernel = np.exp(-g[:, None]) * np.expm1(g[:, None] * rho) * 2 * np.pi * d * step
    sums = np.array([
        np.sum(row * bessel_j0(2 * k * np.sin(a) * d)) for row, a in zip(kernel, alpha)
    ])
    strength = (reflection * k / (2 * np.pi * np.cos(alpha))) ** 2 * sums
    return alpha, np.log(np.maximum(strength, 1e-12 * strength[0]))


def rician_share(coherent):
    """Share of sigma^2 that is drawn: 1 / (K + 1), all of it without a rician part."""
    if coherent is None or coherent["model"] != "rician":
        return 1.0
    return 1.0 / (coherent["k"] + 1.0)
