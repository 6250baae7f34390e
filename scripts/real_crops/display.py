"""The display of real crops, fitted by a power law: gray = background (A / A_background)^exponent, cut off at 255.

A is the amplitude with gain, A_background the 20th percentile of the crop, which targets and their tails rarely reach.
The exponent is that which gives simulated crops the median contrast of the background that real crops have; the gray
level of the background is sampled from those of the real crops. So the fit needs the backgrounds of some real crops and
nothing else of them.
"""
from dataclasses import dataclass
from typing import List

import numpy as np

from .measures import background_contrasts, median

BACKGROUND_PERCENTILE = 20
EXPONENTS = np.arange(0.3, 1.31, 0.05)
MOST_CROPS = 160        # for the fit


@dataclass(frozen=True)
class PowerLaw:
    exponent: float
    backgrounds: List[float]    # gray levels to sample from
    contrast: float             # of the real crops of the fit


def background_gray(gray):
    return max(float(np.percentile(gray, BACKGROUND_PERCENTILE)), 1.0)


def shown(level_db, exponent, background):
    """uint8 image of levels in dB with gain."""
    amplitude = 10 ** (exponent * level_db / 20)
    inside = amplitude[level_db > -250]
    reference = np.percentile(inside, BACKGROUND_PERCENTILE) if inside.size else 1.0
    return np.clip(np.round(amplitude / reference * background), 0, 255).astype(np.uint8)


def shown_crops(crops, kind, law, seed):
    """The 8-bit images of simulated crops, each with a background sampled for it."""
    backgrounds = np.random.default_rng(seed).choice(law.backgrounds, len(crops))
    return [shown(crop.level_db[kind], law.exponent, background) for crop, background in zip(crops, backgrounds)]


def median_contrast(images):
    return median(np.concatenate([background_contrasts(image) for image in images] or [[]]))


def fit_power_law(real_images, crops, kind, seed):
    """The law of some real images for one kind of simulated crops; classes have equal numbers only by chance."""
    backgrounds = [background_gray(image) for image in real_images]
    contrast = median_contrast(real_images)
    order = np.random.default_rng(seed).permutation(len(crops))[:MOST_CROPS]
    some = [crops[place] for place in order]
    reached = [median_contrast(shown_crops(some, kind, PowerLaw(exponent, backgrounds, contrast), seed))
               for exponent in EXPONENTS]
    if not np.isfinite(contrast) or not np.isfinite(reached).all():
        return PowerLaw(1.0, backgrounds, contrast)
    # The contrast grows with the exponent; the running maximum makes this hold in spite of chance.
    exponent = float(np.interp(contrast, np.maximum.accumulate(reached), EXPONENTS))
    return PowerLaw(exponent, backgrounds, contrast)
