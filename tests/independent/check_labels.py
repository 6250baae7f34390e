#!/usr/bin/python3
"""Works labels and images out anew from scatterers and series, and compares them pixel by pixel.

    check_labels.py DATASET_DIR

Masks, instance_fraction, elevation, clean_db, first_return_m, level, grey pictures, and Cartesian
images against polar ones. Pixels that rounding decides (ties, borders) are counted and passed over.
"""
import sys

import numpy as np

import cartesian
import detector
import ghosts
import labels
import physics
import sonar_dataset
from checklist import run_main
from sequence import IMAGE_KINDS, DataSet

# Energies nearer than this, relative, are a tie to single precision.
TIE_MARGIN = 1e-5
# Clean power and noise power nearer than this are decided by rounding.
NOISE_MARGIN_DB = 0.01
# So many undecidable pixels may be passed over in small images.
FEW_PIXELS = 10
# Below the ping's strongest pixel by more than this, single precision may decide.
CLEAN_DEPTH_DB = 120.0
# V5, and from which tolerance of the series on clean is no longer exact to rounding.
CLEAN_TOLERANCE_DB = 0.1
SINGLE_PRECISION_TOLERANCE = 1e-6
LABEL_CHANNELS = ("clean_db", "elevation_rad", "elevation_std_rad", "instance_fraction")


class Ping:
    """One ping's images as [beams, samples] and what they should be."""

    def __init__(self, sequence, number):
        self.sequence, self.number = sequence, number
        self.sonar = sequence.sonar
        self.label = f"{sequence.name}/{number:06d}"
        self.scatterers = sequence.scatterers(number)
        self.parts = sequence.image("polar", number)
        self.masks = {what: sequence.mask("polar", number, what).T for what in sequence.mask_kinds}
        self.level_db = detector.levels_db(self.sonar.detector, sequence, number, sequence.series(number))
        self.clean_pa2 = physics.expected_power(self.scatterers, self.sonar)
        self.expected = labels.PixelLabels(
            self.scatterers, self.sonar.bandwidth_hz, self.sonar.beams, self.sonar.samples
        )
        self._apply_noise_rule()

    def _apply_noise_rule(self):
        noise = self.sonar.noise_power_pa2
        wanted = self.expected
        self.undecided = wanted.has_echo & (wanted.margin < TIE_MARGIN)
        self.audible = wanted.has_echo
        if noise is not None:
            over_db = physics.power_level_db(self.clean_pa2) - physics.power_level_db(noise)
            self.audible = self.audible & (over_db >= 0.0)
            self.undecided |= wanted.has_echo & (np.abs(over_db) < NOISE_MARGIN_DB)
        self.instance = np.where(self.audible, wanted.instance, 0)

    def channel(self, name, part="labels"):
        return self.parts[part].channels[name].T.astype(np.float64)


def half_gap(obtained, expected):
    """Difference in units of half precision's rounding at the expected value."""
    spacing = np.spacing(np.abs(expected).astype(np.float16)).astype(np.float64)
    return np.abs(obtained - expected) / spacing


def check_parts(checklist, ping):
    """The two parts, their channels, types and compressions."""
    for kind in IMAGE_KINDS:
        if not ping.sequence.has_image(kind):
            continue
        parts = list(ping.sequence.image(kind, ping.number).values())
        names = [part.name for part in parts]
        checklist.expect(
            names == ["level", "labels"], f"{ping.label} {kind} parts", names, "level, labels"
        )
        level, label = parts
        checklist.expect(
            {n: a.dtype for n, a in level.channels.items()} == {"Y": np.float16}
            and level.compression == "none",
            f"{ping.label} {kind} level part",
            (level.attributes["channels"], level.compression),
            "Y half, none",
        )
        checklist.expect(
            sorted(label.channels) == sorted(LABEL_CHANNELS)
            and all(a.dtype == np.float16 for a in label.channels.values())
            and label.compression == "zip",
            f"{ping.label} {kind} labels part",
            (sorted(label.channels), label.compression),
            "four half channels, zip",
        )


def check_headers(checklist, ping):
    """Axes in the headers of the polar image, extent of the Cartesian one in all that states it."""
    sonar, sequence = ping.sonar, ping.sequence
    wanted = {
        "first_beam_azimuth_rad": sonar.azimuths_rad[0],
        "beam_spacing_rad": sonar.spacing_rad,
        "range_step_m": sonar.range_step_m,
    }
    for part in ping.parts.values():
        for name, value in wanted.items():
            checklist.near(
                f"{ping.label} polar {part.name} header {name}", part.attributes[name], value, 1e-12
            )
    if not sequence.has("cartesian"):
        return
    grids = {"sequence.json": sequence.stated_grid}
    if sequence.has_image("cartesian"):
        parts = sequence.image("cartesian", ping.number).values()
        grids |= {part.name: sequence.grid(part) for part in parts}
    for place, grid in grids.items():
        edge = np.max(np.abs(sonar.borders_rad))
        aside = sonar.range_max_m * np.sin(min(edge, np.pi / 2))
        behind = sonar.range_max_m * min(np.cos(edge), 0.0)
        extents = {
            "top": grid.x_top_m - sonar.range_max_m,
            "bottom": behind - (grid.x_top_m - grid.height * grid.metres_per_pixel),
            "left": grid.y_left_m - aside,
            "right": grid.width * grid.metres_per_pixel - grid.y_left_m - aside,
        }
        over = {side: round(metres / grid.metres_per_pixel, 6) for side, metres in extents.items()}
        checklist.expect(
            all(-1e-3 <= value < 1.0 for value in over.values()),
            f"{ping.label} cartesian {place}, pixels beyond the fan",
            over,
            "0 to 1 on every side",
        )


def check_masks(checklist, ping):
    """Instance by the rule of most energy, semantic as its class, shadows behind their occluder."""
    wrong = (ping.masks["instance"] != ping.instance) & ~ping.undecided
    where = [
        f"beam {b} sample {n}: {ping.masks['instance'][b, n]} beside {ping.instance[b, n]}"
        for b, n in np.argwhere(wrong)[:5]
    ]
    checklist.expect(
        not wrong.any(),
        f"{ping.label} instance mask, wrong pixels",
        f"{wrong.sum()} {where}",
        f"0 of {wrong.size} ({int(np.count_nonzero(ping.instance))} labelled)",
    )
    passed_over = np.count_nonzero(ping.undecided)
    allowed = max(FEW_PIXELS, cartesian.MOST_PASSED_OVER * np.count_nonzero(ping.expected.has_echo))
    checklist.expect(
        passed_over <= allowed, f"{ping.label} undecidable pixels", passed_over, f"<= {allowed:.0f}"
    )
    known = ping.sequence.instances
    unknown = sorted(set(np.unique(ping.masks["instance"]).tolist()) - set(known) - {0})
    checklist.expect_none(unknown, f"{ping.label} instances the description does not list")
    if unknown:
        return
    table = np.zeros(max(known, default=0) + 1, np.int64)
    for identity, instance in known.items():
        table[identity] = instance.class_id
    wrong = np.count_nonzero(table[ping.masks["instance"]] != ping.masks["semantic"])
    checklist.equal(f"{ping.label} semantic mask, wrong pixels", wrong, 0)
    if "shadow" in ping.masks:
        check_shadow(checklist, ping)
    ghosts.check_mask(checklist, ping, TIE_MARGIN, NOISE_MARGIN_DB)


def check_shadow(checklist, ping):
    """Every shadow: behind an echo of its occluder in that beam, if it has one: black ones have none.

    A pixel may hear some echo and still lie in shadow: more is hidden than heard.
    """
    shadow, expected = ping.masks["shadow"].astype(np.int64), ping.expected
    labelled = np.count_nonzero((shadow > 0) & (ping.masks["instance"] > 0))
    checklist.note(f"{ping.label} pixels both in shadow and labelled {labelled}")
    offenders = []
    for identity in np.unique(shadow[shadow > 0]):
        mine = ping.scatterers[ping.scatterers["instance"] == identity]
        nearest = np.full(ping.sonar.beams, np.inf)
        np.minimum.at(nearest, mine["beam"], mine["delay_s"] * ping.sonar.bandwidth_hz)
        beams, samples = np.nonzero(shadow == identity)
        before = np.isfinite(nearest[beams]) & (samples + 1 < nearest[beams])
        if before.any():
            offenders.append(
                f"instance {identity}: {np.count_nonzero(before)} pixels before its echo"
            )
    checklist.expect_none(offenders, f"{ping.label} shadows before their occluder")
    checklist.note(
        f"{ping.label} shadow pixels {np.count_nonzero(shadow)}, "
        f"of them with an own echo {np.count_nonzero((shadow > 0) & expected.has_echo)}"
    )


def check_level(checklist, ping):
    """level Y is the series' level or the detector's, worked out to 1e-4 dB and rounded to half precision."""
    expected = ping.level_db
    obtained = ping.channel("Y", "level")
    nearer = obtained + np.clip(expected - obtained, -1e-4, 1e-4)
    gap = half_gap(nearer, expected)
    checklist.at_most(f"{ping.label} level Y, largest difference in half steps", gap.max(), 0.51)


def check_clean(checklist, ping):
    """clean_db against the scatterers' expected power, clear of the transforms' floor.

    To the rounding of half precision where the synthesis is exact; within V5's 0.1 dB where it is
    asked for a tolerance that single precision holds.
    """
    expected, obtained = physics.power_level_db(ping.clean_pa2), ping.channel("clean_db")
    strongest = expected.max()
    strong = expected > max(strongest - CLEAN_DEPTH_DB, physics.SILENCE_DB)
    exact = ping.sequence.sonar.tolerance < SINGLE_PRECISION_TOLERANCE
    gap = half_gap(obtained, expected) if exact else np.abs(obtained - expected)
    allowed, unit = (0.52, "half steps") if exact else (CLEAN_TOLERANCE_DB, "dB")
    gap = np.where(strong, np.where(np.isnan(gap), np.inf, gap), 0.0)
    where = np.unravel_index(np.argmax(gap), gap.shape)
    checklist.expect(
        gap.max() <= allowed,
        f"{ping.label} clean_db, largest difference in {unit}",
        f"{gap.max():.3f} at beam {where[0]} sample {where[1]} ({obtained[where]:.3f} dB)",
        f"<= {allowed} ({expected[where]:.3f} dB; {np.count_nonzero(strong)} pixels)",
    )
    high = np.count_nonzero(
        ~strong & ~(obtained <= np.maximum(strongest - CLEAN_DEPTH_DB + 1, physics.SILENCE_DB))
    )
    checklist.equal(f"{ping.label} clean_db too high where there is no energy", high, 0)


def check_moments(checklist, ping):
    """instance_fraction and elevation; energies are single precision, hence the slack."""
    wanted = ping.expected
    fraction = np.where(ping.audible, wanted.fraction, 0.0)
    for name, expected, judged, slack in (
        ("instance_fraction", fraction, ~ping.undecided, 1e-5),
        ("elevation_rad", wanted.elevation_mean, wanted.has_echo, 2e-6),
        ("elevation_std_rad", wanted.elevation_spread, wanted.has_echo, 2e-5),
    ):
        obtained = ping.channel(name)
        expected = np.where(judged, expected, 1.0)
        step = np.spacing(np.abs(expected).astype(np.float16)).astype(np.float64)
        excess = np.where(judged, np.abs(obtained - expected) - 0.51 * step - slack, 0.0)
        excess = np.where(np.isnan(excess), np.inf, excess)
        where = np.unravel_index(np.argmax(excess), excess.shape)
        checklist.expect(
            not (excess > 0).any(),
            f"{ping.label} {name}, wrong pixels",
            f"{np.count_nonzero(excess > 0)} (worst {obtained[where]:.6g} at beam {where[0]} "
            f"sample {where[1]})",
            f"0 of {judged.sum()} (there {expected[where]:.6g})",
        )
        if name != "instance_fraction":
            silent = obtained[~wanted.has_echo]
            heard = np.count_nonzero(~np.isnan(silent))
            checklist.equal(f"{ping.label} {name} without an echo, not NaN", heard, 0)


def check_first_return(checklist, sequence):
    """first_return_m.npy: the nearest echo of every beam's own sector."""
    stored = sonar_dataset.read_npy(sequence.path("first_return_m.npy"))
    wanted = np.array(
        [
            labels.first_return_m(
                sequence.scatterers(ping), sequence.sonar.sound_speed_m_s, sequence.sonar.beams
            )
            for ping in sequence.pings
        ]
    )
    alike = stored.shape == wanted.shape and stored.dtype == np.dtype("<f4")
    checklist.expect(
        alike,
        f"{sequence.name} first_return_m",
        f"{stored.dtype}{stored.shape}",
        f"float32{wanted.shape}",
    )
    if alike:
        same = np.isclose(stored, wanted, rtol=1e-6, atol=0, equal_nan=True)
        checklist.none_of(f"{sequence.name} first_return_m, wrong entries", np.count_nonzero(~same), same.size)


def check(checklist, root):
    for sequence in DataSet(root).sequences:
        check_first_return(checklist, sequence)
        if sequence.sonar.unsupported:
            checklist.note(f"{sequence.name}: has {', '.join(sequence.sonar.unsupported)}")
            continue
        for number in sequence.pings:
            ping = Ping(sequence, number)
            for one in (
                check_parts,
                check_headers,
                check_masks,
                check_level,
                check_clean,
                check_moments,
                cartesian.check_grey,
                cartesian.check_cartesian,
            ):
                one(checklist, ping)


if __name__ == "__main__":
    sys.exit(run_main("check_labels", check))
