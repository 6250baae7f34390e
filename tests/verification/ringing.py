"""Elastic spheres and cylinders: the transfer function of the time series against series summed here."""
import math
from functools import lru_cache

import numpy as np

import measure
from bench import Row, case, diffuse, point_target

SPEED_M_S, DENSITY_KG_M3 = 1500.0, 1025.0
RANGE_M, STRENGTH_DB = 3.0, -40.0
CARBIDE = (14900.0, 6853.0, 4171.0)
ALUMINUM = (2700.0, 6420.0, 3040.0)


@lru_cache(maxsize=16)
def bessel(orders, x):
    """j_n and y_n with their derivatives, n = 0 .. orders - 1, each as (value, derivative)."""
    high = orders + int(x) + 40
    j = [0.0] * (high + 2)
    j[high] = 1e-280
    for n in range(high, 0, -1):
        j[n - 1] = (2 * n + 1) / x * j[n] - j[n + 1]
        if abs(j[n - 1]) > 1e200:
            j = [value * 1e-200 for value in j]
    j0, j1 = math.sin(x) / x, math.sin(x) / x**2 - math.cos(x) / x
    scale = j0 / j[0] if abs(j0) > abs(j1) else j1 / j[1]
    j = [value * scale for value in j]
    y = [-math.cos(x) / x, -math.cos(x) / x**2 - math.sin(x) / x]
    for n in range(1, orders):
        y.append((2 * n + 1) / x * y[n] - y[n - 1])
    return tuple([(f[n], n / x * f[n] - f[n + 1]) for n in range(orders)] for f in (j, y))


def solid_mode(n, orders, x, material):
    """MacLennan 1981, equations 6 to 9: i sin(eta) e^(i eta) of one order, and ka = x."""
    density, fast, slow = material
    x1, x2 = x * SPEED_M_S / fast, x * SPEED_M_S / slow
    (j, dj), (y, dy) = (f[n] for f in bessel(orders, x))
    (j1, dj1), (j2, dj2) = (bessel(orders, z)[0][n] for z in (x1, x2))
    ddj1 = (n * (n + 1) / x1**2 - 1) * j1 - 2 / x1 * dj1
    ddj2 = (n * (n + 1) / x2**2 - 1) * j2 - 2 / x2 * dj2
    alpha = 2 * density / DENSITY_KG_M3 * (slow / SPEED_M_S) ** 2
    beta = density / DENSITY_KG_M3 * (fast / SPEED_M_S) ** 2 - alpha
    a2 = (n * n + n - 2) * j2 + x2**2 * ddj2
    a1 = 2 * n * (n + 1) * (x1 * dj1 - j1)
    b2 = a2 * x1**2 * (beta * j1 - alpha * ddj1) - a1 * alpha * (j2 - x2 * dj2)
    b1 = x * (a2 * x1 * dj1 - a1 * j2)
    eta = math.atan2(-(b2 * dj - b1 * j), b2 * dy - b1 * y)
    return 1j * math.sin(eta) * complex(math.cos(eta), math.sin(eta))


def wall_columns(n, r, k, waves, stiffness, is_shear):
    """u_r, s_rr and s_rt of the waves j and y with wavenumber k at radius r (Goodman and Stern)."""
    lame, rigidity = stiffness
    columns = []
    for f, df in waves:
        df *= k
        ddf = (n * (n + 1) / r**2 - k**2) * f - 2 / r * df
        if is_shear:
            radial = n * (n + 1) * f / r
            pull = 2 * rigidity * n * (n + 1) * (df / r - f / r**2)
            shear = rigidity * (ddf + (n * (n + 1) - 2) * f / r**2)
        else:
            radial = df
            pull = -lame * k**2 * f + 2 * rigidity * ddf
            shear = 2 * rigidity * (df / r - f / r**2)
        columns.append((radial, pull, shear))
    return columns


def shell_mode(n, orders, f_hz, radius_m, wall_m, material):
    """c_n of a shell full of the water around it: six equations for six waves."""
    density, fast, slow = material
    w = 2 * math.pi * f_hz
    rigidity = density * slow**2
    stiffness = (density * fast**2 - 2 * rigidity, rigidity)
    k, outer, inner = w / SPEED_M_S, radius_m, radius_m - wall_m
    (j, dj), (y, dy) = (f[n] for f in bessel(orders, k * outer))
    inside, dinside = bessel(orders, k * inner)[0][n]
    compliance = DENSITY_KG_M3 * w**2
    # Unknown: c_n, the pressure amplitude inside, j and y of both kinds of waves in the wall.
    rows = np.zeros((6, 6), complex)
    h, dh = complex(j, -y), complex(dj, -dy)
    rows[0, 0], rows[1, 0] = -k * dh / compliance, h
    rows[3, 1], rows[4, 1] = -k * dinside / compliance, inside
    for is_shear, speed in ((False, fast), (True, slow)):
        for side, r in ((0, outer), (3, inner)):
            waves = [f[n] for f in bessel(orders, w / speed * r)]
            columns = wall_columns(n, r, w / speed, waves, stiffness, is_shear)
            for i, column in enumerate(columns):
                rows[side : side + 3, 2 + 2 * is_shear + i] = column
    right = np.array([k * dj / compliance, -j, 0, 0, 0, 0], complex)
    if n == 0:
        keep = [0, 1, 3, 4], [0, 1, 2, 3]
        rows, right = rows[np.ix_(*keep)], right[keep[0]]
    heights = np.abs(rows).max(axis=1)
    rows, right = rows / heights[:, None], right / heights
    widths = np.abs(rows).max(axis=0)
    return np.linalg.solve(rows / widths, right)[0] / widths[0]


def backscatter_m(f_hz, radius_m, mode):
    """(i/k) sum (-1)^n (2n + 1) c_n."""
    k = 2 * math.pi * f_hz / SPEED_M_S
    orders = int(k * radius_m + 4 * (k * radius_m) ** (1 / 3) + 8)
    return 1j / k * sum((-1) ** n * (2 * n + 1) * mode(n, orders) for n in range(orders))


def cylinder_functions(orders, x):
    """J_n and Y_n with their derivatives; J by downward recurrence, Y_0 by Neumann's series."""
    high = orders + int(x) + 40
    high += high % 2
    j = [0.0] * (high + 2)
    j[high] = 1e-280
    for n in range(high, 0, -1):
        j[n - 1] = 2 * n / x * j[n] - j[n + 1]
        if abs(j[n - 1]) > 1e200:
            j = [value * 1e-200 for value in j]
    whole = j[0] + 2 * sum(j[2::2])
    j = [value / whole for value in j]
    pairs = sum((-1) ** k * j[2 * k] / k for k in range(1, high // 2))
    y = [2 / math.pi * ((math.log(x / 2) + np.euler_gamma) * j[0] - 2 * pairs)]
    y.append((j[1] * y[0] - 2 / (math.pi * x)) / j[0])
    for n in range(1, orders):
        y.append(2 * n / x * y[n] - y[n - 1])
    return tuple([(f[n], n / x * f[n] - f[n + 1]) for n in range(orders)] for f in (j, y))


def cylinder_echo(f_hz, radius_m, material):
    """(i/pi) sum (-1)^n e_n c_n of a solid cylinder, with the phases of Faran 1951."""
    density, fast, slow = material
    w = 2 * math.pi * f_hz
    x, x1, x2 = (w / speed * radius_m for speed in (SPEED_M_S, fast, slow))
    orders = int(x + 4 * x ** (1 / 3) + 4)
    (water_j, water_y), first, second = (cylinder_functions(orders, z) for z in (x, x1, x2))
    total = 0
    for n in range(orders):
        a1 = -x1 * first[0][n][1] / first[0][n][0]
        a2 = -x2 * second[0][n][1] / second[0][n][0]
        shear = a2 + n**2 - x2**2 / 2
        above = a1 / (a1 + 1) - (n**2 / shear if n else 0)
        below = (a1 + n**2 - x2**2 / 2) / (a1 + 1) - (n**2 * (a2 + 1) / shear if n else 0)
        phi = DENSITY_KG_M3 / density * x2**2 / 2 * above / below
        of_j = x * water_j[n][1] - phi * water_j[n][0]
        of_y = x * water_y[n][1] - phi * water_y[n][0]
        total += (-1) ** n * (2 if n else 1) * -of_j / complex(of_j, -of_y)
    return 1j / math.pi * total


def at_target(entry):
    base = point_target("target", 0.0, (RANGE_M, 0, 0))
    del base["target_strength_db"]
    return {"point_targets": [{**base, **entry}]}


def echoes(bench, body, carrier_hz, band_hz):
    """The time series of a body, and that of a target of -40 dB at its center."""
    series = []
    for changes in (body, at_target({"target_strength_db": STRENGTH_DB})):
        sequence = bench.run(
            {
                "sonar": {"frequency_hz": carrier_hz, "bandwidth_hz": band_hz},
                "synthesis": {"tolerance": 1e-6},
                **changes,
            }
        )
        series.append(sequence.series(0)[20].astype(complex))
    return series


def rows_of_body(bench, name, text, body, response, carrier_hz, band_hz):
    """Band, carrier and peak of one body."""
    rung, plain = echoes(bench, body, carrier_hz, band_hz)
    offset = np.fft.fftfreq(len(rung), 1 / band_hz)
    inner = np.abs(offset) < 0.4 * band_hz
    expected = np.zeros(len(rung), complex)
    expected[inner] = [response(carrier_hz + f) for f in offset[inner]]
    spectra = np.fft.fft(rung), np.fft.fft(plain)
    found = spectra[0] / spectra[1] * 10 ** (STRENGTH_DB / 20)
    error = np.sum(np.abs(found - expected)[inner] ** 2) / np.sum(np.abs(expected[inner]) ** 2)
    shown = np.argsort(offset[inner])
    bench.curve(
        "spheres", name, (carrier_hz + offset[inner][shown]) / 1e3,
        20 * np.log10(np.abs(found[inner][shown])), 20 * np.log10(np.abs(expected[inner][shown])),
    )
    # The peak of the echo within 80 % of the band.
    lines = [np.fft.ifft(np.where(inner, s, 0)) for s in (spectra[1] * expected * 100, spectra[0])]
    peaks = [float(measure.level(np.max(np.abs(measure.interpolated(line)) ** 2))) for line in lines]
    mean = [10 * math.log10(np.mean(np.abs(f[inner]) ** 2)) for f in (expected, found)]
    yield Row(f"sphere.{name}.band", f"{text}: energy of the difference over 80 % of the band",
              0.0, float(error), 1.5e-3, "of the energy")
    yield Row(f"sphere.{name}.strength", f"{text}: mean target strength over it", mean[0], mean[1], 0.05)
    yield Row(f"sphere.{name}.peak", f"{text}: highest point of the echo", peaks[0], peaks[1], 0.2)


@case("sphere")
def spheres(bench):
    """A calibration sphere after MacLennan, a shell after Goodman and Stern, and a rod after Faran."""
    solid, radius_m, wall_m = 0.01905, 0.03, 0.002
    density, fast, slow = ALUMINUM
    shell = {
        "radius_m": radius_m, "density_kg_m3": density, "speed_m_s": fast, "shear_speed_m_s": slow,
        "wall_m": wall_m, "filling": "water",
    }

    # So short that all of it is as far away.
    rod_radius_m, rod_length_m = 0.015, 0.02
    rod = {
        "materials": {"m": {"reflectivity": 0}},
        "objects": [{
            **diffuse("rod", {"cylinder": {"radius_m": rod_radius_m, "height_m": rod_length_m}}, (RANGE_M, 0, 0)),
            "elastic": {"material": "aluminum"},
        }],
    }

    def of_solid(f_hz):
        x = 2 * math.pi * f_hz / SPEED_M_S * solid
        return backscatter_m(f_hz, solid, lambda n, orders: solid_mode(n, orders, x, CARBIDE))

    def of_shell(f_hz):
        return backscatter_m(
            f_hz, radius_m, lambda n, orders: shell_mode(n, orders, f_hz, radius_m, wall_m, ALUMINUM)
        )

    carbide = at_target({"sphere": {"radius_m": solid, "material": "tungsten_carbide"}})
    yield from rows_of_body(
        bench, "carbide", "tungsten carbide, 38.1 mm, 200 kHz, b = 60 kHz", carbide, of_solid, 200e3, 60e3
    )
    yield from rows_of_body(
        bench, "shell", "aluminum shell full of water, 60 mm, wall 2 mm, 120 kHz, b = 40 kHz",
        at_target({"sphere": shell}), of_shell, 120e3, 40e3,
    )
    yield from rows_of_body(
        bench, "rod", "aluminum rod, 30 mm thick, 20 mm long, 200 kHz, b = 60 kHz", rod,
        lambda f_hz: rod_length_m * cylinder_echo(f_hz, rod_radius_m, ALUMINUM), 200e3, 60e3,
    )
