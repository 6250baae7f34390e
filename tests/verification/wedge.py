"""Diffraction at the near edge of a rigid or soft box, against Keller's coefficient of a wedge of 90 degrees."""
import math

from bench import Row, case
from coherent import RANGE_M, body_series, strength_db

SIDE_M, HEIGHT_M = 0.3, 0.03
EXTERIOR_RAD = 1.5 * math.pi


def keller(angle_deg, sign):
    """f of a wedge back toward the source, angle_deg from one face; sign +1 rigid, -1 soft."""
    n = EXTERIOR_RAD / math.pi
    back = math.cos(math.pi / n) - math.cos(2 * math.radians(angle_deg) / n)
    return math.sin(math.pi / n) / n * (1 / (math.cos(math.pi / n) - 1) + sign / back)


def kirchhoff(angle_deg):
    """The same by the surface integral over both faces, rigid."""
    angles = (math.radians(angle_deg), EXTERIOR_RAD - math.radians(angle_deg))
    return -sum(math.tan(a) / 2 for a in angles if a < math.pi)


def edge_db(coefficient):
    """TS of an edge of HEIGHT_M, so short that all of it is as far away."""
    return 20 * math.log10(abs(coefficient) * HEIGHT_M / (2 * math.pi))


def corner(bench, angle_deg, **coherent):
    """TS of the near upright edge of a box one of whose faces is turned angle_deg from the ray."""
    turn_deg = angle_deg - 90
    turn = math.radians(turn_deg)
    place = (RANGE_M + SIDE_M / 2 * (math.cos(turn) + math.sin(turn)),
             SIDE_M / 2 * (math.sin(turn) - math.cos(turn)), 0)
    series = body_series(bench, {"box": {"size_m": [SIDE_M, SIDE_M, HEIGHT_M]}}, place, RANGE_M, (8.0, 1.0),
                         (300, 40), coherent, (0, 0, turn_deg))
    near = int(round(RANGE_M / (1500.0 / (2 * 29.9e3))))
    return strength_db(series[: near + 4], RANGE_M)


@case("V26")
def edges(bench):
    for angle in (135, 115):
        yield Row(f"V26.rigid.{angle}", f"near edge of a rigid box, {angle} deg from one face: f l/(2 pi)",
                  edge_db(keller(angle, 1)), corner(bench, angle, edges=True), 0.3)
    yield Row("V26.soft", "the same, soft, 135 deg",
              edge_db(keller(135, -1)), corner(bench, 135, edges=True, reflection=-1), 0.3)
    yield Row("V26.without", "rigid, 135 deg, without edges: Kirchhoff's integral alone",
              edge_db(kirchhoff(135)), corner(bench, 135), 0.3)
