"""Label rules of the data set, worked out anew from a scatterer list.

Arrays are [beams, samples] here; the image files hold their transpose.
"""
import numpy as np


def echo_samples(delay_s, bandwidth_hz, samples):
    """Pairs (echo index, sample) with |r_echo - r_sample| <= c/2b, that is |tau b - n| <= 1."""
    position = delay_s * bandwidth_hz
    first = np.ceil(position - 1.0).astype(np.int64)
    echoes, bins = [], []
    for step in range(3):
        inside = (first + step <= position + 1.0) & (first + step >= 0) & (first + step < samples)
        echoes.append(np.nonzero(inside)[0])
        bins.append((first + step)[inside])
    return np.concatenate(echoes), np.concatenate(bins)


def expected_energy(scatterers):
    """E|a|^2 gain^2 of each echo, without phase."""
    mean = (
        scatterers["mean_re"].astype(np.float64) ** 2
        + scatterers["mean_im"].astype(np.float64) ** 2
    )
    return (mean + scatterers["variance"].astype(np.float64)) * scatterers["gain"].astype(
        np.float64
    ) ** 2


class PixelLabels:
    """Instance, share of the energy, elevation mean and spread of every pixel.

    `margin` is how far the runner-up's energy lies below the winner's, relative to the
    winner's: pixels with a tiny margin can fall either way by rounding. Labels are of direct
    echoes; `ghost` is the instance of most bounced energy where that outweighs the direct one, and
    `ghost_margin` how far that is from turning, relative to the larger of the two that compete.
    """

    def __init__(self, scatterers, bandwidth_hz, beams, samples):
        bounced = scatterers["path"] != 0
        self._label(scatterers[~bounced], bandwidth_hz, beams, samples)
        self.ghost = np.zeros((beams, samples), np.int64)
        self.ghost_margin = np.ones((beams, samples))
        if not bounced.any():
            return
        ghosts = PixelLabels.__new__(PixelLabels)
        ghosts._label(scatterers[bounced], bandwidth_hz, beams, samples)
        self.fraction = self.fraction * self.total / (self.total + ghosts.total)
        self.ghost = np.where(ghosts.total > self.total, ghosts.instance, 0)
        with np.errstate(invalid="ignore", divide="ignore"):
            either = np.abs(ghosts.total - self.total) / np.maximum(ghosts.total, self.total)
        self.ghost_margin = np.nanmin([np.ones(either.shape), either, ghosts.margin], axis=0)

    def _label(self, scatterers, bandwidth_hz, beams, samples):
        shape = (beams, samples)
        energy = expected_energy(scatterers)
        alive = scatterers[energy > 0]
        echo, sample = echo_samples(alive["delay_s"].astype(np.float64), bandwidth_hz, samples)
        energy = energy[energy > 0][echo]
        pixel = alive["beam"][echo].astype(np.int64) * samples + sample
        instance = alive["instance"][echo].astype(np.int64)
        elevation = alive["elevation_rad"][echo].astype(np.float64)
        self._find_winners(pixel, instance, energy, shape)
        self.elevation_mean, self.elevation_spread = _weighted_moments(
            pixel, elevation, energy, shape
        )

    def _find_winners(self, pixel, instance, energy, shape):
        count = shape[0] * shape[1]
        id_range = int(instance.max(initial=0)) + 1
        groups, group_of = np.unique(pixel * id_range + instance, return_inverse=True)
        sums = np.bincount(group_of, energy, len(groups))
        group_pixel, group_id = groups // id_range, groups % id_range
        order = np.lexsort((group_id, -sums, group_pixel))
        sums, group_pixel, group_id = sums[order], group_pixel[order], group_id[order]
        first = np.ones(len(order), bool)
        first[1:] = group_pixel[1:] != group_pixel[:-1]
        winner_pixel = group_pixel[first]
        second = np.zeros(len(order), bool)
        second[1:] = first[:-1] & ~first[1:]
        total = np.bincount(group_pixel, sums, count)
        best, runner_up, identity = np.zeros(count), np.zeros(count), np.zeros(count, np.int64)
        best[winner_pixel] = sums[first]
        identity[winner_pixel] = group_id[first]
        runner_up[group_pixel[second]] = sums[second]
        with np.errstate(invalid="ignore", divide="ignore"):
            self.fraction = (best / total).reshape(shape)
            self.margin = ((best - runner_up) / best).reshape(shape)
        self.instance = identity.reshape(shape)
        self.has_echo = (total > 0).reshape(shape)
        self.total = total.reshape(shape)


def _weighted_moments(pixel, value, weight, shape):
    """Energy-weighted mean and standard deviation per pixel, NaN where there is nothing."""
    count = shape[0] * shape[1]
    with np.errstate(invalid="ignore", divide="ignore"):
        total = np.bincount(pixel, weight, count)
        mean = np.bincount(pixel, weight * value, count) / total
        square = np.bincount(pixel, weight * (value - mean[pixel]) ** 2, count) / total
    return mean.reshape(shape), np.sqrt(square).reshape(shape)


def first_return_m(scatterers, sound_speed_m_s, beams):
    """Nearest direct echo of every beam's own sector, float64, NaN for none."""
    scatterers = scatterers[scatterers["path"] == 0]
    nearest = np.full(beams, np.inf)
    np.minimum.at(nearest, scatterers["beam"], scatterers["delay_s"] * sound_speed_m_s / 2.0)
    return np.where(np.isfinite(nearest), nearest, np.nan)


class CartesianMap:
    """Nearest-neighbour lookup of the fan seen from above, boresight up, port left.

    A pixel stands for its centre. It is `uncertain` where its range or azimuth lies so near a
    cell's border that rounding decides.
    """

    ROUNDING = 1e-4  # of a cell

    def __init__(self, grid, sonar):
        beams, samples, range_step_m = sonar.beams, sonar.samples, sonar.range_step_m
        forward = grid.x_top_m - (np.arange(grid.height) + 0.5) * grid.metres_per_pixel
        port = grid.y_left_m - (np.arange(grid.width) + 0.5) * grid.metres_per_pixel
        range_m = np.hypot(forward[:, None], port[None, :])
        azimuth = np.arctan2(port[None, :], forward[:, None])
        sample_position = range_m / range_step_m + 0.5
        beam_position = sonar.sector_position(azimuth)
        self.sample = np.floor(sample_position).astype(np.int64)
        self.beam = np.floor(beam_position).astype(np.int64)
        self.inside = (self.sample < samples) & (self.beam >= 0) & (self.beam < beams)
        self.uncertain = (_border_distance(sample_position) < self.ROUNDING) | (
            _border_distance(beam_position) < self.ROUNDING
        )
        self.sample = np.clip(self.sample, 0, samples - 1)
        self.beam = np.clip(self.beam, 0, beams - 1)

    def apply(self, polar, outside):
        """Cartesian image of a polar [beams, samples] array."""
        return np.where(self.inside, polar[self.beam, self.sample], outside)


class SmoothMap:
    """Mean intensity over the footprints of Cartesian pixels, as weights of polar pixels.

    Along each axis the interpolation at the middles of a footprint's parts gives a row of weights; a pixel is the
    product of its two rows with the polar image. Places are rounded to 2^-15 of a cell, which shows next to pixels
    that are 40 dB louder.
    """

    def __init__(self, grid, sonar):
        beams, samples, range_step_m = sonar.beams, sonar.samples, sonar.range_step_m
        forward = grid.x_top_m - (np.arange(grid.height) + 0.5) * grid.metres_per_pixel
        port = grid.y_left_m - (np.arange(grid.width) + 0.5) * grid.metres_per_pixel
        self.beams, self.samples = beams, samples
        self.length = grid.metres_per_pixel / range_step_m
        self.sample = _rounded(np.minimum(np.hypot(forward[:, None], port[None, :]) / range_step_m, samples - 1.0))
        beam = sonar.beam_position(np.arctan2(port[None, :], forward[:, None]))
        self.beam = _rounded(np.clip(beam, 0.0, beams - 1.0))
        self.width = np.minimum(self.length / sonar.spacing_rad / np.maximum(self.sample, 0.5), beams)

    def means(self, intensities, chosen):
        """Cartesian images of polar arrays [..., beams, samples], 0 but for the pixels that are chosen."""
        image = np.zeros((len(intensities), *chosen.shape))
        for row, column in np.argwhere(chosen):
            along = _weights(self.sample[row, column], self.length, self.samples)
            across = _weights(self.beam[row, column], self.width[row, column], self.beams)
            part = intensities[:, across[0] : across[0] + len(across[1]), along[0] : along[0] + len(along[1])]
            image[:, row, column] = across[1] @ (part @ along[1]).T
        return image


def _rounded(place):
    return np.round(place * 32768.0) / 32768.0


def _weights(middle, width, count):
    """First index and weights of the points 0 to count - 1 in the mean over a footprint."""
    parts = max(1, int(np.ceil(width - 1e-6)))
    at = _rounded(np.clip(middle + width * ((np.arange(parts) + 0.5) / parts - 0.5), 0, count - 1))
    first, last = int(np.floor(at[0])), int(np.ceil(at[-1]))
    points = np.arange(first, last + 1)
    return first, np.maximum(0.0, 1.0 - np.abs(points[:, None] - at[None, :])).mean(axis=1)


def _border_distance(position):
    return np.abs(position - np.round(position))


def stored_grey_levels(level_db, low_db, high_db):
    """8-bit grey of a dB scale, before rounding, of levels in half precision. Two of them: a level between two
    halves may be stored as either."""
    return [grey_levels(half, low_db, high_db) for half in stored_levels(level_db)]


def stored_levels(level_db):
    return [np.float16(level_db + off).astype(float) for off in (-1e-4, 1e-4)]


def grey_levels(level_db, low_db, high_db):
    return np.clip((level_db - low_db) / (high_db - low_db), 0.0, 1.0) * 255.0


def smooth_grey_levels(level_db, smooth, chosen, low_db, high_db):
    """Those of a Cartesian image, before rounding, of the lower and of the upper of two halves."""
    halves = np.array(stored_levels(level_db))
    means = smooth.means(np.where(halves > -99.0, 10.0 ** (halves / 10.0), 0.0), chosen)
    with np.errstate(divide="ignore"):
        return grey_levels(10.0 * np.log10(means), low_db, high_db)
