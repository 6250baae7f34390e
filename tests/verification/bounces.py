"""Paths over several surfaces (`bounces`): corners, a plate over a plane, a closed room of Lambert walls."""
import math

import numpy as np

from bench import Row, case, diffuse
from coherent import strength_db

WAVELENGTH_M = 1500.0 / 9e5
RANGE_M = 5.0
FAN_DEG = 0.5


def widest_pattern(sin_elevation):
    """Two-way amplitude of the widest vertical pattern, 180 degrees; each direction of a path has its root."""
    return np.sinc(0.884 * np.asarray(sin_elevation) / math.pi)


def obj(triangles):
    """A mesh of single triangles."""
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for corners in triangles for x, y, z in corners]
    faces = [f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}" for i in range(len(triangles))]
    return "\n".join(lines + faces) + "\n"


def dihedral(side_m, height_m):
    """Two plates at right angles, their upright edge at the origin, open towards -x."""
    d, h = side_m / math.sqrt(2), height_m / 2
    triangles = []
    for y in (d, -d):
        low, high, out_low, out_high = (0, 0, -h), (0, 0, h), (-d, y, -h), (-d, y, h)
        triangles += [(low, out_low, out_high), (low, out_high, high)]
    return triangles


def trihedral(leg_m, square):
    """Three faces at right angles, apex at the origin, axis along -x."""
    turns = [2 * math.pi * i / 3 for i in range(3)]
    leg = [
        leg_m * np.array([-1 / math.sqrt(3), math.sqrt(2 / 3) * math.cos(t), math.sqrt(2 / 3) * math.sin(t)])
        for t in turns
    ]
    triangles = []
    for i in range(3):
        a, b = leg[i], leg[(i + 1) % 3]
        triangles.append((np.zeros(3), a, b))
        if square:
            triangles.append((a, a + b, b))
    return triangles


def corner_db(bench, triangles, bounces, reflection=1.0):
    """TS at the apex, from the interpolated peak of the beam ahead; single bounces are far off their specular angle."""
    sequence = bench.run(
        {
            "sonar": {
                "range_max_m": RANGE_M + 1,
                "beams": {"count": 3, "spacing_deg": FAN_DEG},
                "elevation": {"fan_deg": FAN_DEG},
                "rays": {"azimuth": 24, "elevation": 24},
            },
            "bounces": bounces,
            "materials": {
                "m": {"reflectivity": 1e-12, "coherent": {"model": "kirchhoff", "reflection": reflection}}
            },
            "objects": [diffuse("corner", {"mesh": {"file": "corner.obj"}}, (RANGE_M, 0, 0))],
        },
        files={"corner.obj": obj(triangles)},
    )
    return strength_db(sequence.series(0)[1], RANGE_M)


@case("V21")
def corners(bench):
    """Cross-sections of corner reflectors on axis, a^2 much less than lambda R."""
    a = 0.03
    a4 = a**4 / WAVELENGTH_M**2
    yield Row("V21.dihedral", "dihedral of 3 cm plates, on axis: 2 a^2 b^2 / lambda^2",
              10 * math.log10(2 * a4), corner_db(bench, dihedral(a, a), 1), 0.3)
    yield Row("V21.triangular", "triangular trihedral, legs of 3 cm: a^4 / (3 lambda^2)",
              10 * math.log10(a4 / 3), corner_db(bench, trihedral(a, False), 2), 0.3)
    yield Row("V21.square", "square trihedral, legs of 3 cm: 3 a^4 / lambda^2",
              10 * math.log10(3 * a4), corner_db(bench, trihedral(a, True), 2), 0.3)
    weak = corner_db(bench, trihedral(a, True), 2, 0.5) - corner_db(bench, trihedral(a, True), 2)
    yield Row("V21.reflection", "the last one with reflection 0.5: change", 60 * math.log10(0.5), weak, 0.05)


@case("V22")
def plate_over_plane(bench):
    """A Lambert plate over a smooth plane: direct, two equal paths one way by it, and both ways by it."""
    height, ahead, reflection, mu = 1.0, 4.0, 0.8, 1e-2
    side = 0.1
    sequence = bench.run(
        {
            "sonar": {
                "range_max_m": 6,
                "beams": {"count": 41, "spacing_deg": 0.25},
                "elevation": {"width_deg": 180, "fan_deg": 80},
                "rays": {"azimuth": 7, "elevation": 2600},
            },
            "bounces": 2,
            "materials": {
                "m": {"reflectivity": mu},
                "mirror": {"reflectivity": 1e-12, "coherent": {"model": "kirchhoff", "reflection": reflection}},
            },
            "objects": [
                diffuse("floor", {"plane": {}}, (0, 0, -height), material="mirror"),
                diffuse("plate", {"box": {"size_m": [0.001, side, side]}}, (ahead + 0.0005, 0, 0)),
            ],
        },
        scatterers=True,
    )
    echoes = sequence.scatterers(0)
    energy = echoes["variance"] * echoes["gain"].astype(float) ** 2
    kinds = {path["id"]: path["out"] for path in sequence.info["paths"]}
    of_plate = echoes["instance"] == 2
    # Area, cosine and distance hardly change over the plate.
    direct, image = ahead, math.hypot(ahead, 2 * height)
    cosine = ahead / image

    down = widest_pattern(2 * height / image)

    def sound(out, back, cos_out, cos_back, bounces):
        spread = mu * cos_out * cos_back * side**2 / (out * back) ** 2
        return spread * reflection ** (2 * bounces) * down**bounces

    wanted = {
        "direct": sound(direct, direct, 1, 1, 0),
        # Out by the plane and back by it, two equal paths that add in phase in their one beam.
        "one way by the plane": 4 * sound(image, direct, cosine, 1, 1),
        "both ways by the plane": sound(image, image, cosine, cosine, 2),
    }
    name = {("specular", "diffuse"): "one way by the plane", ("diffuse", "specular"): "one way by the plane",
            ("specular", "diffuse", "specular"): "both ways by the plane"}
    for which, expected in wanted.items():
        # 1e-12 of the floor's own scattering adds paths over the plate that end in no name above.
        mine = [p for p, out in {0: (), **kinds}.items()
                if name.get(tuple(out), "direct" if p == 0 else "") == which]
        got = energy[np.isin(echoes["path"], mine) & of_plate].sum()
        yield Row(f"V22.{which.split()[0]}", f"Lambert plate over a smooth plane, {which}: energy",
                  10 * math.log10(expected), 10 * math.log10(got), 0.15)


@case("V23")
def closed_sphere(bench):
    """A closed Lambert sphere heard from its middle: each order has the albedo times the one before."""
    albedo, radius, fan_deg = 0.6, 2.0, 170.0
    sequence = bench.run(
        {
            "sonar": {
                "range_max_m": 20,
                "beams": {"count": 90, "spacing_deg": 2},
                "elevation": {"width_deg": 180, "fan_deg": fan_deg},
                "rays": {"azimuth": 1, "elevation": 120},
            },
            "bounces": 3,
            "materials": {"m": {"reflectivity": albedo / math.pi}},
            "objects": [diffuse("room", {"sphere": {"radius_m": radius, "inward_facing": True}})],
        },
        scatterers=True,
    )
    echoes = sequence.scatterers(0)
    energy = echoes["variance"] * echoes["gain"].astype(float) ** 2
    surfaces = {path["id"]: len(path["out"]) for path in sequence.info["paths"]}
    order = np.array([surfaces.get(int(p), 1) for p in echoes["path"]])
    # The sine of the elevation is uniform over a sphere, and half the azimuths are in the fan; a longer path
    # needs both its ends there, which are independent.
    sines = np.linspace(-1, 1, 20001)
    inside = np.abs(sines) <= math.sin(math.radians(fan_deg / 2))
    share = 0.5 * np.mean(widest_pattern(sines) * inside)
    whole = 4 * albedo / radius**2
    first = whole * 0.5 * np.mean(widest_pattern(sines) ** 2 * inside)
    yield Row("V23.1", "closed Lambert sphere, albedo 0.6, first order: 4 pi mu / R^2 of the fan's share",
              10 * math.log10(first), 10 * math.log10(energy[order == 1].sum()), 0.05)
    for k in (2, 3, 4):
        # One pair in 90 arrives in one beam, with twice the energy.
        expected = whole * share**2 * albedo ** (k - 1) * (1 + 1 / 90)
        yield Row(f"V23.{k}", f"the same, order {k}: albedo^{k - 1}, both ends in the fan",
                  10 * math.log10(expected), 10 * math.log10(energy[order == k].sum()), 0.15)
