"""Scatterers fixed on surfaces: what a shift of the sonar leaves of the coherence (V10, V11)."""
import math

import numpy as np

from bench import Row, case, diffuse

RADIUS_M, BEAM_RAD = 12.0, math.radians(1.0)
WAVELENGTH_M = 1500.0 / 900e3
APERTURE_M = 0.884 * WAVELENGTH_M / BEAM_RAD
SHIFTS_M = (0.0, 0.0106, 0.0211, 0.0317, 0.0422)
# Looks that share no place within 10 degrees: all around, at three heights. With 20 beams each these are 1,080 draws,
# and a coherence of rho has a standard error of (1 - rho^2) / sqrt(2 * 1080), 0.016 at most of these.
LOOKS_DEG = [(yaw, pitch) for pitch in (-8, 0, 8) for yaw in range(0, 360, 20)]


def poses():
    """Every look from either end of every shift, a ping each; the shift goes along the array."""
    out = []
    for yaw, pitch in LOOKS_DEG:
        port = (-math.sin(math.radians(yaw)), math.cos(math.radians(yaw)))
        for shift in SHIFTS_M:
            for side in (-0.5, 0.5):
                place = [side * shift * port[0], side * shift * port[1], 0.0]
                out.append(
                    {"time_s": len(out), "position_m": place, "rotation_deg": [0, pitch, yaw]}
                )
    return out


def run(bench):
    """Pixels at 2r/c of beams 1 degree apart within 10: [looks, shifts, sides, beams]."""
    sequence = bench.run(
        {
            "sonar": {
                "bandwidth_hz": 30000.0,
                "range_max_m": RADIUS_M + 0.5,
                "beams": {"count": 112, "spacing_deg": 0.25},
                "elevation": {"fan_deg": 1},
                "rays": {"elevation": 1},
            },
            "scattering": {"speckle": "surface"},
            "materials": {"m": {"reflectivity": 1e-3}},
            "objects": [diffuse("sphere", {"sphere": {"radius_m": RADIUS_M, "inward_facing": True}})],
            "trajectory": {
                "ping_rate_hz": 1,
                "pings": len(LOOKS_DEG) * len(SHIFTS_M) * 2,
                "poses": poses(),
            },
        }
    )
    beams = np.arange(16, 96, 4)
    sample = round(2.0 * RADIUS_M / 1500.0 * 30000.0)
    pixels = np.array([sequence.series(ping)[beams, sample] for ping in sequence.pings], complex)
    pixels = pixels.reshape(len(LOOKS_DEG), len(SHIFTS_M), 2, beams.size)
    return pixels, np.asarray(sequence.sonar.azimuths_rad)[beams]


def correlation(first, second):
    """Magnitude of the normalised complex correlation."""
    product = np.vdot(second, first)
    return abs(product) / math.sqrt((abs(first) ** 2).sum() * (abs(second) ** 2).sum())


@case("V10")
def shifted_sideways(bench):
    """The overlap of the aperture with itself, shifted by twice the shift of the sonar."""
    pixels, azimuth_rad = run(bench)
    for i, shift_m in enumerate(SHIFTS_M[1:], 1):
        turn = 4 * math.pi / WAVELENGTH_M * shift_m * np.sin(azimuth_rad)
        first, second = pixels[:, i, 0], pixels[:, i, 1] * np.exp(-1j * turn)
        yield Row(
            f"V10.{1000 * shift_m:.1f}mm",
            f"speckle on a surface, sonar shifted sideways by {1000 * shift_m:.1f} mm: coherence",
            max(0.0, 1.0 - 2.0 * shift_m / APERTURE_M),
            correlation(first, second),
            0.05,
            "",
            draws=first.size,
        )


@case("V11")
def at_rest(bench):
    """Another ping from the same pose."""
    pixels, _ = run(bench)
    yield Row("V11", "the same, another ping from the same pose",
              1.0, correlation(pixels[:, 0, 0], pixels[:, 0, 1]), 1e-6, "", draws=pixels[:, 0, 0].size)
