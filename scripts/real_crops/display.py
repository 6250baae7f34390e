"""The display of real crops, fitted by a power law with a soft limit:

    gray = 255 (1 - exp(-c (A / A_background)^exponent)).

A is the amplitude with gain, A_background the level of the crop's darkest patches, and c gives these their gray level.
With a hard limit, bright targets saturate about four times as many pixels as in real crops.
The exponent is that which gives simulated crops the median contrast of the background that real crops have; the gray
level of the background is sampled from those of the real crops. So the fit needs the backgrounds of some real crops and
nothing else of them. Where they are JPEG files, simulated crops are compressed in the same way, and twice: the frames
that real crops are cut from were compressed too, so these crops have a second grid of 8 pixels at a random place.
"""
from dataclasses import dataclass
from typing import List, Optional

import numpy as np

from ensonify_dataset import NO_ENERGY_DB, Display, Viewer
from ensonify_dataset.viewer import compressed

from .measures import background_contrasts, background_patches, median

SMALL_CROP_PERCENTILE = 35   # its background, where a crop has no room for patches
EXPONENTS = np.arange(0.3, 1.31, 0.2)
MOST_CROPS = 60         # for the fit
GRID_PX = 8             # of JPEG


@dataclass(frozen=True)
class PowerLaw:
    exponent: float
    backgrounds: List[float]    # gray levels to sample from
    jpeg_tables: Optional[dict] = None


def background_level(image):
    """Median of the means of the darkest patches."""
    patches = background_patches(image)
    return float(np.median(patches.mean((1, 2))) if len(patches) else np.percentile(image, SMALL_CROP_PERCENTILE))


def shown(level_db, law, background, corner=(0, 0)):
    """uint8 image of levels in dB with gain, whose background gets the gray level `background`. `corner` is the place of
    the crop in the grid of its frame's compression."""
    power = np.where(level_db > NO_ENERGY_DB, 10 ** (law.exponent * level_db / 20), 0)
    wanted = -np.log1p(-min(background, 254.0) / 255)     # the soft limit's inverse
    softened = -np.expm1(-power * (wanted / max(background_level(power), 1e-30)))
    frame = np.pad(20 * np.log10(np.maximum(softened, 1e-4)), [(place, GRID_PX) for place in corner], mode="edge")
    gray = Viewer(Display((-np.inf, 0.0), "amplitude"), jpeg_tables=law.jpeg_tables).image(frame)
    crop = gray[tuple(slice(place, place + size) for place, size in zip(corner, level_db.shape))]
    return compressed(np.ascontiguousarray(crop), qtables=law.jpeg_tables) if law.jpeg_tables else crop


def shown_crops(crops, kind, law, seed):
    """The 8-bit images of simulated crops, each with a background sampled for it."""
    rng = np.random.default_rng(seed)
    backgrounds, corners = rng.choice(law.backgrounds, len(crops)), rng.integers(0, GRID_PX, (len(crops), 2))
    return [shown(crop.level_db[kind], law, *place) for crop, *place in zip(crops, backgrounds, corners)]


def median_contrast(images):
    return median(np.concatenate([background_contrasts(image) for image in images] or [[]]))


def fit_power_law(real, crops, kind, seed):
    """The law of some real crops for one kind of simulated ones."""
    images = [crop.gray for crop in real]
    tables = next((crop.jpeg_tables for crop in real if crop.jpeg_tables), None)
    backgrounds = [max(background_level(image), 1.0) for image in images]
    contrast = median_contrast(images)
    order = np.random.default_rng(seed).permutation(len(crops))[:MOST_CROPS]
    some = [crops[place] for place in order]
    reached = [median_contrast(shown_crops(some, kind, PowerLaw(exponent, backgrounds, tables), seed))
               for exponent in EXPONENTS]
    if not np.isfinite(contrast) or not np.isfinite(reached).all():
        return PowerLaw(1.0, backgrounds, tables)
    # The contrast grows with the exponent; the running maximum makes this hold in spite of chance.
    exponent = float(np.interp(contrast, np.maximum.accumulate(reached), EXPONENTS))
    return PowerLaw(exponent, backgrounds, tables)
