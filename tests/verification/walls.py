"""Walls that let sound through: a shell of water, and of air, against the transfer matrix of its plate."""
import math

import numpy as np

from bench import Row, case, diffuse

CARRIER_HZ, BANDWIDTH_HZ, SPEED_M_S = 900e3, 150e3, 1500.0
MIDDLE_M, RADIUS_M = 3.0, 0.1
WATER_PA_S_M = 1025 * SPEED_M_S
# Steel so thin that its response hardly depends on the angle over the middle of the shell.
FOIL = {"thickness_m": 2e-4, "density_kg_m3": 7850, "speed_m_s": 5900, "shear_speed_m_s": 3230, "loss": 0.02}


def plate(wall, air=False):
    """Reflected and transmitted pressure at normal incidence over the band, by the matrix of one layer."""
    f = CARRIER_HZ + BANDWIDTH_HZ * (np.arange(400) + 0.5 - 200) / 400
    speed = wall["speed_m_s"] * np.sqrt(1 + 1j * wall["loss"])
    phase = 2 * np.pi * f / speed * wall["thickness_m"]
    z = wall["density_kg_m3"] * speed
    behind_p, behind_v = (0, 1) if air else (1, 1 / WATER_PA_S_M)
    p = np.cos(phase) * behind_p + 1j * z * np.sin(phase) * behind_v
    v = 1j / z * np.sin(phase) * behind_p + np.cos(phase) * behind_v
    whole = p + WATER_PA_S_M * v
    return (p - WATER_PA_S_M * v) / whole, 2 * behind_p / whole


def axial(pieces_m, radii_m):
    """Pressure back at the source after mirrors on one axis, radii positive if concave."""
    pressure, front = 1 / pieces_m[0], pieces_m[0]
    for piece, radius in zip(pieces_m[1:], radii_m):
        front = 1 / (1 / front - 2 / radius)
        pressure *= abs(front / (front + piece))
        front += piece
    return pressure


def shell_series(bench, wall, bounces=0):
    sequence = bench.run(
        {
            "sonar": {
                "bandwidth_hz": BANDWIDTH_HZ,
                "pulse": "flat",
                "range_max_m": 4,
                "beams": {"count": 41, "spacing_deg": 0.25, "receive_width_deg": 30},
                "elevation": {"width_deg": 180, "fan_deg": 5},
                "rays": {"azimuth": 6, "elevation": 96},
            },
            "bounces": bounces,
            "materials": {"m": {"reflectivity": 1e-12, "coherent": {"model": "kirchhoff"}, **wall}},
            "objects": [diffuse("shell", {"sphere": {"radius_m": RADIUS_M}}, (MIDDLE_M, 0, 0))],
        }
    )
    return np.asarray(sequence.series(0)[20], complex)


def ranges_m(series):
    return np.arange(len(series)) * SPEED_M_S / (2 * BANDWIDTH_HZ)


def energy(series, range_m, reach_m=0.05):
    return float(np.sum(np.abs(series[np.abs(ranges_m(series) - range_m) < reach_m]) ** 2))


def db(ratio):
    return 10 * math.log10(max(ratio, 1e-30))


@case("V25")
def shell(bench):
    """The front, the far wall and the next round trip, by the energy of the band around each."""
    near, far, again = MIDDLE_M - RADIUS_M, MIDDLE_M + RADIUS_M, MIDDLE_M + 3 * RADIUS_M
    reflected, transmitted = plate(FOIL)
    whole = energy(shell_series(bench, {}), near)
    unit = axial([near, near], [-RADIUS_M]) ** 2
    # With bounces, rays that turn at 45 degrees come back beside the far wall, and louder.
    water, trained = (shell_series(bench, {"wall": FOIL}, bounces) for bounces in (0, 2))
    air = shell_series(bench, {"wall": {**FOIL, "filling": "air"}})

    def mean(response):
        return np.mean(np.abs(response) ** 2)

    for name, what, series, range_m, wanted in (
        ("front", "shell of 0.2 mm steel, radius 0.1 m, r = 3 m, its front over that of a rigid sphere: |R|^2",
         water, near, mean(reflected)),
        ("far", "its far wall: |T^2 R|^2 and the mirror's spreading", water, far,
         mean(transmitted**2 * reflected) * axial([far, far], [RADIUS_M]) ** 2 / unit),
        ("again", "the next round trip: |T^2 R^3|^2 and the spreading of three mirrors", trained, again,
         mean(transmitted**2 * reflected**3)
         * axial([far, 2 * RADIUS_M, 2 * RADIUS_M, far], [RADIUS_M] * 3) ** 2 / unit),
        ("air", "the front with air inside", air, near, mean(plate(FOIL, air=True)[0])),
    ):
        got = energy(series, range_m) / whole
        yield Row(f"V25.{name}", what, db(wanted), db(got), 0.5)
    around = np.abs(ranges_m(water) - far) < 0.03
    peak = ranges_m(water)[np.argmax(np.where(around, np.abs(water), 0))]
    yield Row("V25.arrival", "range at which the far wall arrives", far, peak, 0.005, "m")
    silent = energy(air, far) / energy(water, far)
    yield Row("V25.silent", "behind the front with air inside, over the far wall with water: at most -40 dB",
              -70.0, db(silent), 30.0)
