"""Measures of a crop, the same code for real and simulated ones. A crop is a uint8 image with the sonar at the top.

    measures_of(gray)           {name: value}, NaN where the crop is too small
    echoes_along_range(gray)    number of echoes one behind another
    estimate(values)            mean and standard error over folds
    jackknifed(...)             a statistic of all folds, and its standard error
"""
import math

import numpy as np

PATCH_PX = 16
BACKGROUND_SHARE = 0.3      # of the patches of a crop: the darkest ones
SATURATED_GRAY = 250
SMALLEST_PX = 20            # crops with a shorter side have no measures
MEASURES = ("level_behind_peak_db", "target_contrast", "saturated_share", "background_contrast",
            "peak_over_background_db", "neighbor_correlation_along_arc", "neighbor_correlation_along_range")


def median(values):
    values = np.asarray(values, np.float64)
    values = values[np.isfinite(values)]
    return float(np.median(values)) if values.size else math.nan


def smoothed(image, sigma_rows, sigma_columns):
    """Gaussian filter; the edge is continued by reflection."""
    for axis, sigma in ((0, sigma_rows), (1, sigma_columns)):
        reach = int(4 * sigma + 0.5)
        if reach == 0:
            continue
        weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
        padding = [(reach, reach) if k == axis else (0, 0) for k in range(image.ndim)]
        padded = np.pad(image, padding, mode="symmetric")
        parts = [weight * np.take(padded, range(k, k + image.shape[axis]), axis)
                 for k, weight in enumerate(weights / weights.sum())]
        image = np.sum(parts, axis=0)
    return image


def background_patches(gray):
    """[n, 16, 16]: the darkest patches of a crop, without those that are black in large part."""
    height, width = gray.shape
    step = PATCH_PX // 4
    patches = [gray[row:row + PATCH_PX, column:column + PATCH_PX].astype(np.float64)
               for row in range(0, height - PATCH_PX + 1, step) for column in range(0, width - PATCH_PX + 1, step)]
    patches.sort(key=lambda patch: patch.mean())
    chosen = patches[:max(1, int(BACKGROUND_SHARE * len(patches)))][:6] if patches else []
    chosen = [patch for patch in chosen if (patch == 0).mean() < 0.3]
    return np.array(chosen).reshape(-1, PATCH_PX, PATCH_PX)


def _trend_basis():
    y, x = np.mgrid[-1:1:PATCH_PX * 1j, -1:1:PATCH_PX * 1j].reshape(2, -1)
    basis, _ = np.linalg.qr(np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1))
    return basis


TREND_BASIS = _trend_basis()


def trends(patches):
    """The quadratic surface of least squares in each patch."""
    flat = patches.reshape(len(patches), PATCH_PX * PATCH_PX)
    return ((flat @ TREND_BASIS) @ TREND_BASIS.T).reshape(patches.shape)


def background_contrasts(gray):
    """Standard deviation over mean of each background patch, its trend divided out."""
    patches = background_patches(gray)
    # Where the surface comes near zero a quotient by it would say nothing about the speckle.
    lowest = 0.2 * patches.mean((1, 2), keepdims=True) + 1e-3
    ratio = patches / np.maximum(trends(patches), lowest)
    return ratio.std((1, 2)) / np.maximum(ratio.mean((1, 2)), 1e-6)


def neighbor_correlations(patches):
    """Median correlation of a background pixel with its neighbor along the arc and along range."""
    rest = patches - trends(patches)
    power = np.maximum((rest ** 2).mean((1, 2)), 1e-9)
    along_arc = (rest[:, :, 1:] * rest[:, :, :-1]).mean((1, 2)) / power
    along_range = (rest[:, 1:] * rest[:, :-1]).mean((1, 2)) / power
    return median(along_arc), median(along_range)


def peaks_of(profile, lowest, prominence):
    """Places of the local maxima that are at least so high and so prominent."""
    found = []
    for place in range(1, len(profile) - 1):
        value = profile[place]
        if value < lowest or value <= profile[place - 1] or value < profile[place + 1]:
            continue
        higher = np.flatnonzero(profile > value)
        left = max(higher[higher < place], default=-1) + 1
        right = min(higher[higher > place], default=len(profile))
        base = max(profile[left:place].min(), profile[place + 1:right].min(initial=value))
        if value - base >= prominence:
            found.append(place)
    return found


def echoes_along_range(gray):
    """Number of separate maxima along range in the columns around the brightest one."""
    image = gray.astype(np.float64)
    background = np.percentile(image, 30) + 1
    soft = smoothed(image, 0.7, 3)
    middle, half = soft.sum(0).argmax(), max(2, gray.shape[1] // 12)
    profile = soft[:, max(0, middle - half):middle + half + 1].mean(1)
    return len(peaks_of(profile, 1.8 * background, 0.35 * np.percentile(profile, 98)))


def level_behind_peak_db(image, background):
    """Mean gray level 4 to 16 pixels behind the brightest place, over the background."""
    soft = smoothed(image, 1.5, 1.5)
    row, column = np.unravel_index(soft.argmax(), soft.shape)
    behind = soft[row + 4:row + 16, max(0, column - 2):column + 3]
    return float(20 * np.log10((behind.mean() + 1) / background)) if row + 6 < len(image) else math.nan


def measures_of(gray):
    """All measures of a crop, and `two_echoes`: 1 with two or more echoes along range, else 0."""
    patches = background_patches(gray) if min(gray.shape) >= SMALLEST_PX else np.empty((0, PATCH_PX, PATCH_PX))
    if not len(patches):
        return dict.fromkeys((*MEASURES, "two_echoes"), math.nan)
    image = gray.astype(np.float64)
    background = float(np.median(patches.mean((1, 2)))) + 1
    bright = image[smoothed(image, 1, 1) > 2.5 * background]
    along_arc, along_range = neighbor_correlations(patches)
    return {"level_behind_peak_db": level_behind_peak_db(image, background),
            "target_contrast": float(bright.std() / bright.mean()) if bright.size > 30 else math.nan,
            "saturated_share": float((gray >= SATURATED_GRAY).mean()),
            "background_contrast": median(background_contrasts(gray)),
            "peak_over_background_db": float(20 * np.log10((np.percentile(image, 99) + 1) / background)),
            "neighbor_correlation_along_arc": along_arc, "neighbor_correlation_along_range": along_range,
            "two_echoes": float(echoes_along_range(gray) >= 2)}


def estimate(values):
    """{value, standard_error, folds}: the mean over folds and its standard error."""
    values = np.asarray([value for value in values if math.isfinite(value)], np.float64)
    if not values.size:
        return {"value": None, "standard_error": None, "folds": 0}
    error = float(values.std(ddof=1) / math.sqrt(values.size)) if values.size > 1 else None
    return {"value": float(values.mean()), "standard_error": error, "folds": int(values.size)}


def jackknifed(statistic, folds):
    """{value, standard_error, folds} of statistic(list of folds); the error is that of the jackknife over folds."""
    folds = list(folds)
    left = np.array([statistic([fold for fold in folds if fold != out]) for out in folds])
    error = math.sqrt((len(folds) - 1) / len(folds) * ((left - left.mean()) ** 2).sum())
    return {"value": float(statistic(folds)), "standard_error": error, "folds": len(folds)}
