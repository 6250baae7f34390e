"""How surfaces and water scatter: diffuse laws, coherent parts, expected moments.

The backscatter strength s_b is per unit of surface; an echo that stands for the cross-section
dA = cos(alpha) dS has E|a|^2 = s_b dA / cos(alpha).
"""
from dataclasses import dataclass

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


def echo_energy(law, cosine, cross_section_m2):
    """sigma^2 = E|a|^2 of the echo from one cell."""
    return backscatter_strength(law, cosine) * cross_section_m2 / cosine


def rician_share(coherent):
    """Share of sigma^2 that is drawn: 1 / (K + 1), all of it without a rician part."""
    if coherent is None or coherent["model"] != "rician":
        return 1.0
    return 1.0 / (coherent["k"] + 1.0)
