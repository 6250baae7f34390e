"""Kirchhoff echoes of rigid bodies: plate, sphere, cylinder, and how the cells' size matters.

Each body lies within one sector, whose centre the weights are taken at; the fan is narrowed so
that the rays stand as close as the case asks for.
"""
import math

import numpy as np

import measure
from bench import Row, case, diffuse
from levels import peak_level

WAVELENGTH_M = 1500.0 / 9e5
SIDE_M, PLATE_RANGE_M = 0.05, 10.0
RADIUS_M, RANGE_M = 0.2, 5.0
ROD_RADIUS_M, ROD_LENGTH_M = 0.1, 0.05


def body_series(
    bench, shape, place_m, range_m, fan_deg, rays, coherent=None, rotation_deg=(0, 0, 0), files=None
):
    """Series of the sector straight ahead; fan and rays are (azimuth, elevation)."""
    part = {"model": "kirchhoff", "reflection": 1, "roughness_rms_m": 0, **(coherent or {})}
    sequence = bench.run(
        {
            "sonar": {
                "range_max_m": range_m + 1,
                "beams": {"count": 3, "spacing_deg": fan_deg[0]},
                "elevation": {"fan_deg": fan_deg[1]},
                "rays": {"azimuth": rays[0], "elevation": rays[1]},
            },
            "materials": {"m": {"reflectivity": 1e-9, "coherent": part}},
            "objects": [diffuse("body", shape, place_m, rotation_deg)],
        },
        files=files,
    )
    return sequence.series(0)[1]


def strength_db(series, range_m):
    """TS from the interpolated peak."""
    return peak_level(series) - (220.0 - 40.0 * math.log10(range_m))


def plate_series(bench, rays=(176, 176), coherent=None, tilt_deg=0.0):
    """A square plate that faces the sonar; it turns about the middle of its face."""
    turn = math.radians(tilt_deg)
    place = (PLATE_RANGE_M + 0.01 * math.cos(turn), 0.01 * math.sin(turn), 0)
    shape = {"box": {"size_m": [0.02, SIDE_M, SIDE_M]}}
    fan = (0.4, 0.4)
    return body_series(bench, shape, place, PLATE_RANGE_M, fan, rays, coherent, (0, 0, tilt_deg))


def plate(bench, *arguments, **settings):
    return strength_db(plate_series(bench, *arguments, **settings), PLATE_RANGE_M)


def sphere_series(bench, rays=(172, 172), radius_m=RADIUS_M):
    """A sphere whose nearest point lies RANGE_M away; the fan is 5 degrees, 0.44 m there."""
    shape, place = {"sphere": {"radius_m": radius_m}}, (RANGE_M + radius_m, 0, 0)
    return body_series(bench, shape, place, RANGE_M, (5.0, 5.0), rays)


def sphere(bench, *arguments, **settings):
    return strength_db(sphere_series(bench, *arguments, **settings), RANGE_M)


def rod(bench, rays=(90, 64)):
    """An upright cylinder, so short that it lies in one Fresnel zone."""
    shape = {"cylinder": {"radius_m": ROD_RADIUS_M, "height_m": ROD_LENGTH_M}}
    place = (RANGE_M + ROD_RADIUS_M, 0, 0)
    return strength_db(body_series(bench, shape, place, RANGE_M, (2.6, 0.7), rays), RANGE_M)


def phase_deg(series):
    """Phase at the interpolated peak; at 5 and 10 m the way there and back is whole wavelengths."""
    fine = measure.interpolated(series)
    return float(np.degrees(np.angle(fine[np.argmax(np.abs(fine))])))


PLATE_DB = 20 * math.log10(SIDE_M**2 / WAVELENGTH_M)
ROD_DB = 10 * math.log10(ROD_RADIUS_M * ROD_LENGTH_M**2 / (2 * WAVELENGTH_M)) + 10 * math.log10(
    RANGE_M / (RANGE_M + ROD_RADIUS_M)
)


def sphere_db(radius_m):
    return 20 * math.log10(radius_m / 2) + 20 * math.log10(RANGE_M / (RANGE_M + radius_m))


@case("V18")
def square_plate(bench):
    """A/lambda, and what tilt, roughness and reflection take from it."""
    yield Row("V18.facing", "rigid square plate of 0.05 m, r = 10 m, facing, 126 cells across",
              PLATE_DB, plate(bench), 0.3)
    for tilt in (0.4, 1.3):
        across = 2 * SIDE_M * math.sin(math.radians(tilt)) / WAVELENGTH_M
        wanted = PLATE_DB + 20 * math.log10(abs(np.sinc(across)) * math.cos(math.radians(tilt)))
        yield Row(f"V18.tilt.{tilt:g}", f"the same, turned by {tilt:g} deg: sinc(2 a sin(turn) / lambda)",
                  wanted, plate(bench, tilt_deg=tilt), 0.3)
    # k rho^2 / r, averaged over the plate: its edges lie farther away than its middle.
    lag = math.degrees(2 * math.pi / WAVELENGTH_M * (SIDE_M**2 / 6) / PLATE_RANGE_M)
    yield Row("V18.phase", "phase of the facing plate: +i, less the lag of its edges",
              90.0 - lag, phase_deg(plate_series(bench)), 2.0, "deg")
    smooth = plate(bench)
    rough = 1e-4
    wanted = -2 * (2 * math.pi / WAVELENGTH_M) ** 2 * rough**2 * 20 / math.log(10)
    yield Row("V18.rough", "roughness of 0.1 mm rms: change",
              wanted, plate(bench, coherent={"roughness_rms_m": rough}) - smooth, 0.05)
    yield Row("V18.reflection", "reflection 0.5: change",
              20 * math.log10(0.5), plate(bench, coherent={"reflection": 0.5}) - smooth, 0.05)


@case("V19")
def rigid_sphere(bench):
    """a/2, by the curvature of sphere and wave front."""
    for radius in (0.2, 0.08):
        yield Row(f"V19.{radius:g}m", f"rigid sphere of {radius:g} m, r = 5 m, cells of 2.5 mm",
                  sphere_db(radius), sphere(bench, radius_m=radius), 0.5)
    yield Row("V19.phase", "phase of the rigid sphere of 0.2 m", 0.0, phase_deg(sphere_series(bench)), 5.0, "deg")
    yield Row("V19.coarse", "rigid sphere of 0.2 m, cells of 11 mm",
              sphere_db(RADIUS_M), sphere(bench, (40, 40)), 0.5)


@case("V20")
def rigid_cylinder(bench):
    """Broadside, short against the Fresnel zone."""
    yield Row("V20", "rigid cylinder of 0.1 m, length 0.05 m, r = 5 m, broadside, 52 cells along it",
              ROD_DB, rod(bench), 0.5)


SEGMENTS = 24


def prism():
    """The rod as triangles between SEGMENTS corners, without lids."""
    corners = [(math.cos(2 * math.pi * i / SEGMENTS), math.sin(2 * math.pi * i / SEGMENTS)) for i in range(SEGMENTS)]
    text = "".join(f"v {ROD_RADIUS_M * x:.9f} {ROD_RADIUS_M * y:.9f} {end * ROD_LENGTH_M / 2}\n"
                   for end in (-1, 1) for x, y in corners)
    for i in range(SEGMENTS):
        low, next_low = i + 1, (i + 1) % SEGMENTS + 1
        text += f"f {low} {next_low} {low + SEGMENTS}\nf {next_low} {next_low + SEGMENTS} {low + SEGMENTS}\n"
    return text


def mesh_rod(bench, yaw_deg, normals):
    """The rod from a file of triangles."""
    shape = {"mesh": {"file": "rod.obj", "normals": normals}}
    place = (RANGE_M + ROD_RADIUS_M, 0, 0)
    series = body_series(bench, shape, place, RANGE_M, (2.6, 0.7), (90, 64), None, (0, 0, yaw_deg), {"rod.obj": prism()})
    return strength_db(series, RANGE_M)


@case("V20.mesh")
def coarse_cylinder(bench):
    """24 facets with smooth normals echo as the cylinder that they stand for, from every side."""
    side_deg = 360 / SEGMENTS
    for yaw in (0.0, side_deg / 6, side_deg / 2):
        yield Row(f"V20.mesh.{yaw:g}", f"V20 as a mesh of {SEGMENTS} segments, normals: smooth, turned by {yaw:g} deg",
                  ROD_DB, mesh_rod(bench, yaw, "smooth"), 0.5)
    if bench.figures:
        yaws = np.linspace(0, side_deg, 31)
        for normals in ("face", "smooth"):
            levels = [mesh_rod(bench, yaw, normals) for yaw in yaws]
            bench.curve("facets", f"normals: {normals}", yaws, levels, [ROD_DB] * len(yaws))


@case("cells")
def cell_size(bench):
    """Twice the rays in either direction, and coarser cells for the figure."""
    for name, make, rays in (
        ("plate", plate, (176, 176)),
        ("sphere", sphere, (172, 172)),
        ("cylinder", rod, (90, 64)),
    ):
        before = make(bench, rays)
        for direction, more in (
            ("azimuth", (2 * rays[0], rays[1])),
            ("elevation", (rays[0], 2 * rays[1])),
        ):
            yield Row(f"cells.{name}.{direction}", f"{name}: twice the rays in {direction}, TS against half as many",
                      before, make(bench, more), 0.2)
    for name, make, wanted, fan_deg, range_m in () if not bench.figures else (
        ("sphere", sphere, sphere_db(RADIUS_M), 5.0, RANGE_M),
        ("plate", plate, PLATE_DB, 0.4, PLATE_RANGE_M),
    ):
        counts = (20, 28, 40, 60, 86, 172, 344)
        sizes = [1e3 * range_m * math.radians(fan_deg) / count for count in counts]
        levels = [make(bench, (count, count)) - wanted for count in counts]
        bench.curve("kirchhoff", name, sizes, levels)
