"""The display of real crops, fitted by a power law with a soft limit:

    gray = 255 (1 - exp(-c A^exponent)).

A is the amplitude with gain, and c gives a crop its mean gray level, which differs less between real crops than that of
their backgrounds. With a hard limit, bright targets saturate about four times as many pixels as in real crops.
The exponent is that which gives simulated crops the median contrast of the background that real crops have; the mean
gray level is sampled from those of the real crops. So the fit needs the backgrounds and means of some real crops and
nothing else of them. Where they are JPEG files, simulated crops are compressed in the same way, and twice: the frames
that real crops are cut from were compressed too, so these crops have a second grid of 8 pixels at a random place.
"""
from dataclasses import dataclass
from typing import List, Optional

import numpy as np

from ensonify_dataset import NO_ENERGY_DB, Display, Viewer
from ensonify_dataset.viewer import compressed

from .measures import background_contrasts, median

EXPONENTS = np.arange(0.3, 1.31, 0.2)
MOST_CROPS = 60         # for the fit
GRID_PX = 8             # of JPEG


@dataclass(frozen=True)
class PowerLaw:
    exponent: float
    means: List[float]          # gray levels to sample from
    jpeg_tables: Optional[dict] = None


def softened(power, mean):
    """1 - exp(-c power) with the c that gives it this mean, by bisection of log c."""
    low, high = np.log(1e-4 / power.max()), np.log(1e4 / power.max())
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if -np.expm1(-np.exp(middle) * power).mean() < mean else (low, middle)
    return -np.expm1(-np.exp(low) * power)


def shown(level_db, law, mean, corner=(0, 0)):
    """uint8 image of levels in dB with gain, with the mean gray level `mean`. `corner` is the place of the crop in the
    grid of its frame's compression."""
    power = np.where(level_db > NO_ENERGY_DB, 10 ** (law.exponent * level_db / 20), 0)
    softened_db = 20 * np.log10(np.maximum(softened(power, mean / 255), 1e-4))
    frame = np.pad(softened_db, [(place, GRID_PX) for place in corner], mode="edge")
    gray = Viewer(Display((-np.inf, 0.0), "amplitude"), jpeg_tables=law.jpeg_tables).image(frame)
    crop = gray[tuple(slice(place, place + size) for place, size in zip(corner, level_db.shape))]
    return compressed(np.ascontiguousarray(crop), qtables=law.jpeg_tables) if law.jpeg_tables else crop


def shown_crops(crops, kind, law, seed):
    """The 8-bit images of simulated crops, each with a mean gray level sampled for it."""
    rng = np.random.default_rng(seed)
    means, corners = rng.choice(law.means, len(crops)), rng.integers(0, GRID_PX, (len(crops), 2))
    return [shown(crop.level_db[kind], law, *place) for crop, *place in zip(crops, means, corners)]


def median_contrast(images):
    return median(np.concatenate([background_contrasts(image) for image in images] or [[]]))


def fit_power_law(real, crops, kind, seed):
    """The law of some real crops for one kind of simulated ones."""
    images = [crop.gray for crop in real]
    tables = next((crop.jpeg_tables for crop in real if crop.jpeg_tables), None)
    means = [max(image.mean(), 1.0) for image in images]
    contrast = median_contrast(images)
    order = np.random.default_rng(seed).permutation(len(crops))[:MOST_CROPS]
    some = [crops[place] for place in order]
    reached = [median_contrast(shown_crops(some, kind, PowerLaw(exponent, means, tables), seed))
               for exponent in EXPONENTS]
    if not np.isfinite(contrast) or not np.isfinite(reached).all():
        return PowerLaw(1.0, means, tables)
    # The contrast grows with the exponent; the running maximum makes this hold in spite of chance.
    exponent = float(np.interp(contrast, np.maximum.accumulate(reached), EXPONENTS))
    return PowerLaw(exponent, means, tables)
