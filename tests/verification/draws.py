"""The random amplitudes themselves, as exported: what the speckle of V4 is made of."""
import math

import numpy as np

from bench import Row, case, statistical
from noise import SEABED
from speckle import KS_CRITICAL, exponential_distance

PINGS = 40


def exported_draws(bench):
    """xi = (a - mean) / standard deviation of every scatterer of every ping."""
    sequence = bench.run(
        {
            **SEABED,
            "sonar": {**SEABED["sonar"], "rays": {"elevation": 300, "azimuth": 4}},
            "trajectory": {"ping_rate_hz": 1, "pings": PINGS},
        },
        scatterers=True,
    )
    draws = []
    for ping in sequence.pings:
        echo = sequence.scatterers(ping)
        deviation = np.sqrt(echo["variance"].astype(float))
        real = echo["amp_re"].astype(float) - echo["mean_re"].astype(float)
        imaginary = echo["amp_im"].astype(float) - echo["mean_im"].astype(float)
        draws.append((real + 1j * imaginary) / deviation)
    return np.concatenate(draws)


def moment(identity, experiment, values, expected):
    """Row of a mean of independent numbers, three standard errors wide."""
    error = float(values.std(ddof=1) / math.sqrt(values.size))
    return statistical(identity, experiment, expected, float(values.mean()), error, values.size, "")


@case("draws")
def amplitudes(bench):
    """Circular complex normal: the intensity of many echoes no longer tells."""
    xi = exported_draws(bench)
    intensity = np.abs(xi) ** 2
    yield Row("draws.ks", "|xi|^2 of exported scatterers: distance to the exponential (Kolmogorov-Smirnov)",
              0.0, exponential_distance(intensity), KS_CRITICAL / math.sqrt(xi.size), "", draws=xi.size)
    yield moment("draws.power", "mean of |xi|^2", intensity, 1.0)
    yield moment("draws.real", "mean of Re xi^2: parts of one size", (xi**2).real, 0.0)
    yield moment("draws.imaginary", "mean of Im xi^2: parts independent", (xi**2).imag, 0.0)
    yield moment("draws.mean", "mean of Re xi", xi.real, 0.0)
    yield moment("draws.neighbours", "Re xi xi'* of neighbours", (xi[1:] * xi[:-1].conj()).real, 0.0)
