"""What the paper's figures let one expect, held against the program."""
from dataclasses import dataclass, replace

import numpy as np

import measure
import speckle
import tank
from bench import Row, statistical
from paper_tank import UPRIGHT, WALL_M, Tank, arrival_before, arrivals_m

# Where a number comes from that the program is held against.
SET_UP, EQUATION, MODEL = "set-up", "equation", "model"


@dataclass(frozen=True)
class Claim:
    """One line of the page: what the paper says, on what that rests, and the row that tests it."""

    figure: str
    paper: str
    source: str
    row: Row

    @property
    def verdict(self):
        if not self.row.passed:
            return "no"
        return "yes (model)" if self.source == MODEL else "yes"


def named(row, identity):
    """A row of verify_physics under this page's name."""
    return replace(row, identity=identity)


class Tanks:
    """The scenes that several figures share, each run once."""

    def __init__(self, bench, pings):
        self.bench, self.pings = bench, pings
        self.tanks = {}

    def get(self, name, settings=(), like=None, pings=None):
        key = (name, settings, pings)
        if key not in self.tanks:
            self.tanks[key] = Tank(self.bench, name, pings or self.pings, settings, like)
        return self.tanks[key]


def wall_pixels(scene):
    """Pixels on the wall so far apart, two beam widths, that their speckle is independent."""
    beams = [j for j in range(6, scene.sonar.beams, 12) if 6 < abs(scene.azimuth_deg[j]) < 40]
    place = (WALL_M / np.cos(scene.sonar.azimuths_rad[beams]) + 0.02) / scene.sonar.range_step_m
    return np.array(beams), np.round(place).astype(int)


def shadow_db(scene, power):
    """Depth of the cylinder's shadow on the wall."""
    middle = scene.window((-1, 1), (5.3, 6.0))
    beside = scene.window((-10, -6), (5.3, 6.0)) | scene.window((6, 10), (5.3, 6.0))
    return float(10 * np.log10(power[beside].mean() / power[middle].mean()))


def figure_7(tanks):
    """Amplitude of one beam against range."""
    scene = tanks.get("sonar_tank")
    cylinder, wall, _ = tank.arrivals(tanks.bench)
    clean = scene.clean()
    yield Claim("7", "a cylinder of 0.4 m diameter with its axis 4 m ahead: its echo begins at 3.8 m", SET_UP,
                named(cylinder, "Fig7.cylinder"))
    yield Claim("7", "the wall at 5.5 m: its echo begins at 5.5 m / cos θ next to the cylinder", SET_UP,
                named(wall, "Fig7.wall"))
    yield Claim("7", "behind the cylinder the wall is in shadow, except for side lobes (Eq 17)", MODEL,
                Row("Fig7.shadow", "the wall at 6 to 10 degrees over the echoes from 5.3 to 6.0 m within 1 degree",
                    shadow_db(scene, scene.expected()), shadow_db(scene, clean), 0.1))
    yield from speckle_claims(scene, clean)


def speckle_claims(scene, clean):
    """Intensities of the wall over their expected ones."""
    beams, samples = wall_pixels(scene)
    intensity = np.array([scene.power(ping)[beams, samples] for ping in scene.sequence.pings])
    intensity /= clean[beams, samples]
    contrast, error = speckle.contrast(intensity)
    mean, mean_error = measure.mean_and_error(intensity.mean(axis=1))
    yield Claim("7", "speckle: each echo is complex normal (Eq 14), so intensities have contrast 1", EQUATION,
                statistical("Fig7.contrast", "wall, standard deviation of the intensity over its mean",
                            1.0, float(contrast), error, intensity.size, ""))
    yield Claim("7", "its mean is the sum of the echoes' energies (Eq 14, 16)", EQUATION,
                statistical("Fig7.mean", "wall, mean intensity over pings against expected",
                            0.0, float(10 * np.log10(mean)), measure.DECIBELS * mean_error / mean, intensity.size))


def crossing_width_deg(azimuth_deg, power):
    """Width of a profile over beams where it is 6 dB under its peak."""
    left, right = measure.edges(azimuth_deg, power, 0.25)
    return right - left


def figure_8(tanks):
    """The fan of the tank."""
    scene = tanks.get("sonar_tank")
    step = scene.sonar.range_step_m
    clean, expected = scene.clean(), scene.expected()
    outside = np.abs(scene.azimuth_deg) > 5
    gap = (arrivals_m(clean, step) - WALL_M / np.cos(scene.sonar.azimuths_rad))[outside]
    samples = (scene.range_m > 3.7) & (scene.range_m < 4.05)
    profiles = [power[:, samples].sum(axis=1) for power in (expected, clean)]
    widths = [crossing_width_deg(scene.azimuth_deg, profile) for profile in profiles]
    lobe = (np.abs(scene.azimuth_deg) > 4) & (np.abs(scene.azimuth_deg) < 8)
    lobes = [10 * np.log10(p[lobe].mean() / p.max()) for p in profiles]
    yield Claim("8", "the wall is a straight line at x = 5.5 m over the whole fan", SET_UP,
                Row("Fig8.wall", f"worst of {outside.sum()} beams beyond 5 degrees; at 45 degrees the near side of "
                    "the beam meets the wall three samples earlier",
                    0.0, float(gap[np.argmax(np.abs(gap))]), 3.5 * step, "m"))
    yield Claim("8", "the cylinder is an arc: cos² of the incidence (Eq 14) under a beam of 1° (Eq 17)", MODEL,
                Row("Fig8.arc", "its width at -6 dB", widths[0], widths[1], 0.02, "degrees"))
    yield Claim("8", "at the cylinder's range, side lobes (Eq 17) reach the neighboring beams", MODEL,
                Row("Fig8.lobes", "mean at 4 to 8 degrees from the middle, relative to the peak",
                    float(lobes[0]), float(lobes[1]), 0.05))
    yield level_claim(scene)


def level_claim(scene):
    """The cylinder against the wall."""
    cylinder = scene.window((-2, 2), (3.7, 4.05))
    wall = scene.window((20, 24), (5.7, 6.3))
    return Claim(
        "8",
        "cylinder against wall of the same reflectivity, by Eq 8, 14 and 16",
        MODEL,
        statistical(
            "Fig8.level",
            "energy of the cylinder's middle 4 degrees over that of 4 degrees of wall",
            *scene.ratio_db(cylinder, wall),
            len(scene.sequence.pings),
        ),
    )


def figure_9(tanks):
    """One of the two dimmed by 20 dB."""
    words = {
        "tank.cylinder": "the wall dimmed from 1e-3 to 1e-5: the cylinder's echo stays",
        "tank.wall": "the wall's falls by 20 dB",
        "cylinder.cylinder": "the cylinder dimmed from 1e-3 to 1e-5: its echo falls by 20 dB",
        "cylinder.wall": "the wall's stays",
    }
    return [
        Claim("9", words[row.identity[4:]], SET_UP, named(row, f"Fig9.{row.identity[4:]}"))
        for row in tank.dimmed(tanks.bench)
    ]


def figure_10(tanks):
    """Two upright cylinders."""
    scene = tanks.get("two_cylinders")
    clean = scene.clean()
    near, far = ((3.2, 0.9), (4.4, -0.8))
    for name, (x, y) in (("near", near), ("far", far)):
        range_m, beam = np.hypot(x, y) - 0.2, scene.beam_at(np.degrees(np.arctan2(y, x)))
        before = scene.range_m < range_m + 0.5
        yield Claim("10", f"the {name} cylinder's echo begins 0.2 m before its axis", MODEL,
                    Row(f"Fig10.{name}", f"arrival on the beam of {scene.azimuth_deg[beam]:.1f} degrees",
                        float(range_m), arrival_before(clean, before, scene.sonar.range_step_m, beam),
                        scene.sonar.range_step_m, "m"))
    near_window = scene.window((13.7, 17.7), (3.05, 3.4))
    far_window = scene.window((-12.3, -8.3), (4.2, 4.55))
    wall_window = scene.window((-30, -26), (6.0, 6.5))
    pairs = (
        ("near_over_far", near_window, far_window, "the nearer cylinder is brighter (Eq 8)"),
        (
            "far_over_wall",
            far_window,
            wall_window,
            "the cylinders (1e-2) stand out against the tank (1e-4)",
        ),
    )
    for name, above, below, words in pairs:
        wanted, obtained, error = scene.ratio_db(above, below)
        row = statistical(
            f"Fig10.{name}",
            "energy of 4 degrees over that of 4 degrees",
            wanted,
            obtained,
            error,
            len(scene.sequence.pings),
        )
        yield Claim("10", words, MODEL, row)


def extents(scene, power, degrees):
    """Degrees and metres over which an object is within 20 dB of its highest pixel."""
    part = np.where(scene.window(degrees, (2.0, 5.2)), power, 0.0)
    audible = part >= part.max() / 100
    beams, samples = np.nonzero(audible.any(axis=1))[0], np.nonzero(audible.any(axis=0))[0]
    return (
        (beams[-1] - beams[0] + 1) * np.degrees(scene.sonar.spacing_rad),
        (samples[-1] - samples[0] + 1) * scene.sonar.range_step_m,
    )


def figure_11(tanks):
    """Leaning cylinders beside upright ones at the same places."""
    leaning = tanks.get("tilted_cylinders")
    upright = tanks.get("tilted_cylinders", UPRIGHT, "upright_cylinders", pings=2)
    degrees, spacing = leaning.azimuth_deg, np.degrees(leaning.sonar.spacing_rad)
    sides = {"across": (2.0, float(degrees[-1])), "away": (float(degrees[0]), -2.0)}
    for scene, stands in ((upright, "upright"), (leaning, "leaning")):
        pairs = (scene.expected(), scene.clean())
        for name, side in sides.items():
            wanted, obtained = (extents(scene, power, side) for power in pairs)
            words = {
                "upright": "an upright cylinder echoes in a short arc",
                "across": "one that leans across the line of sight smears over beams",
                "away": "one that leans along the line of sight smears over range",
            }["upright" if stands == "upright" else name]
            for i, (what, unit, tolerance) in enumerate(
                (("beams", "degrees", 2 * spacing), ("range", "m", 2 * scene.sonar.range_step_m))
            ):
                row = Row(
                    f"Fig11.{stands}.{name}.{what}",
                    f"{'leaning_' + name}{', set upright' if scene is upright else ''}: "
                    f"{'azimuths' if i == 0 else 'ranges'} within 20 dB of its peak",
                    float(wanted[i]),
                    float(obtained[i]),
                    float(tolerance),
                    unit,
                )
                yield Claim("11", words, MODEL, row)
