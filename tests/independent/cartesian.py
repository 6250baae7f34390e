"""Grey pictures, and the Cartesian images that are polar ones seen from above."""
import numpy as np

import labels
import physics
from sequence import IMAGE_KINDS

# Largest share of the pixels that may be passed over as undecidable.
MOST_PASSED_OVER = 0.01
# Of a Cartesian grey picture about so many pixels are worked out, one by one.
SMOOTH_PIXELS = 30000


def check_grey(checklist, ping):
    """The grey picture is the stored half-precision level between the limits, rounded to a grey step; a Cartesian one
    that of the mean intensity over each pixel's footprint."""
    if not ping.sequence.has("png"):
        return
    low, high = ping.sequence.png_limits_db
    for kind in IMAGE_KINDS:
        if not ping.sequence.has(kind):
            continue
        grey = ping.sequence.grey(kind, ping.number)
        both = labels.stored_grey_levels(ping.level_db, low, high)
        outside = np.zeros(grey.shape, bool)
        if kind == "polar":
            both, unsure = [wanted.T for wanted in both], np.zeros(grey.shape, bool)
        else:
            fan = labels.CartesianMap(grid_of(ping), ping.sonar)
            unsure, outside = fan.uncertain, ~fan.inside
            if ping.sequence.png_resampling == "bilinear":
                level = ping.level_db
                chosen = fan.inside & every(1 + grey.size // SMOOTH_PIXELS, grey.shape)
                smooth = labels.SmoothMap(grid_of(ping), ping.sonar)
                both = labels.smooth_grey_levels(level, smooth, chosen, low, high)
                unsure = unsure | (fan.inside & ~chosen)
            else:
                both = [fan.apply(wanted, 0.0) for wanted in both]
        # Pixels are stored as either half; a mean of them lies between those of all.
        gap = np.maximum(np.min(both, axis=0) - grey, grey - np.max(both, axis=0))
        gap = np.where(unsure | outside, 0.0, gap)
        checklist.at_most(
            f"{ping.label} {kind} grey, largest difference in grey steps",
            gap.max(),
            0.501,
            note=f"(limits {low} to {high} dB)",
        )
        lit = np.count_nonzero(grey[outside & ~unsure])
        checklist.equal(f"{ping.label} {kind} grey, lit pixels outside the fan", lit, 0)


def every(step, shape):
    """True at each step-th pixel."""
    return np.arange(np.prod(shape)).reshape(shape) % step == 0


def grid_of(ping):
    """Grid of one Cartesian image, with the scale from its own header where it has one."""
    sequence = ping.sequence
    if sequence.has_image("cartesian"):
        return sequence.grid(sequence.image("cartesian", ping.number)["level"])
    return sequence.stated_grid


def cartesian_channels(ping):
    """Name, stored image, polar one and what is outside, of each channel where there are level images."""
    if not ping.sequence.has_image("cartesian"):
        return []
    parts = ping.sequence.image("cartesian", ping.number)
    blank = {"Y": physics.SILENCE_DB, "clean_db": physics.SILENCE_DB, "instance_fraction": 0.0}
    return [
        (name, parts[part.name].channels[name], polar.T, blank.get(name, np.nan))
        for part in ping.parts.values()
        for name, polar in part.channels.items()
    ]


def check_cartesian(checklist, ping):
    """The map's pixels are the nearest ones, and every Cartesian image is its polar one through it."""
    if not ping.sequence.has("cartesian"):
        return
    fan = labels.CartesianMap(grid_of(ping), ping.sonar)
    polar_pixel = np.arange(ping.sonar.samples)[None, :] * ping.sonar.beams
    polar_pixel = polar_pixel + np.arange(ping.sonar.beams)[:, None]
    images = cartesian_channels(ping)
    images.append(("map", ping.sequence.cartesian_map(), polar_pixel, -1))
    images += [
        (what, ping.sequence.mask("cartesian", ping.number, what), ping.masks[what], 0)
        for what in ping.sequence.mask_kinds
    ]
    checklist.expect(
        np.mean(fan.uncertain & fan.inside) <= MOST_PASSED_OVER,
        f"{ping.label} cartesian, share of pixels on a border",
        f"{np.mean(fan.uncertain):.2e}",
        f"<= {MOST_PASSED_OVER}",
    )
    for name, obtained, polar, outside in images:
        wanted = fan.apply(polar, outside)
        same = (obtained == wanted) | (np.isnan(wanted) & np.isnan(obtained)) | fan.uncertain
        bad = ~same
        at = np.argwhere(bad)[:2]
        where = [f"row {y} column {x}: {obtained[y, x]} beside {wanted[y, x]}" for y, x in at]
        checklist.expect(
            not bad.any(),
            f"{ping.label} cartesian {name}, wrong pixels",
            f"{bad.sum()} {where}",
            f"0 of {bad.size}",
        )
