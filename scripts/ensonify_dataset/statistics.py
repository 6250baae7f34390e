"""Statistics of every pixel over the pings of a sequence (`output.statistics`); see docs/physics/4_speckle.md."""
from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from .files import DatasetError, read_npy
from .manifest import listed_pings, told_of

_NAMES = ("mean_pressure", "pressure_variance", "mean_intensity", "intensity_variance", "contrast",
          "fourth_moment", "bin_covariance", "bin_coherence", "beam_covariance", "beam_coherence",
          "third_moment", "expected_intensity", "intensity_histogram")
LAGGED = ("bin_lag_products", "bin_lag_intensities", "beam_lag_products", "beam_lag_intensities")


class Source(NamedTuple):
    """Which draws of which scene."""

    scenario: str  # what the worlds of a scenario have in common
    scene: str  # ... and the realizations of one world
    seed: int
    sequence: int
    first_ping: int
    last_ping: int  # the one after the last
    speckle_seed: int = -1  # of its own; -1: the speckle follows from `seed`

    def overlaps(self, other: "Source") -> bool:
        same = (self.seed, self.speckle_seed, self.sequence) == (other.seed, other.speckle_seed, other.sequence)
        return same and self.first_ping < other.last_ping and other.first_ping < self.last_ping


class Pooling(NamedTuple):
    """What the histogram and the lags were taken over; see `statistics` in sequence.json."""

    lags: int = 0
    within_db: float = 20.0
    histogram_step: float = 0.1


class Estimate(NamedTuple):
    value: float
    error: float  # standard error


class Histogram(NamedTuple):
    """Of the intensity divided by its expectation; exp(-x) where speckle is fully developed."""

    edges: np.ndarray  # [bins + 1]
    density: np.ndarray  # [bins]
    error: np.ndarray  # [bins], standard error


class Statistics:
    """Arrays [samples, beams], read when they are asked for; NaN where there is no energy.

    mean_pressure        complex, Pa           pressure_variance   Pa^2
    mean_intensity       of I = |p|^2, Pa^2    intensity_variance  Pa^4
    contrast             std I / mean I        fourth_moment       <I^2> / <I>^2
    third_moment         <I^3> / <I>^3         expected_intensity  computed without realizations, Pa^2
    bin_covariance, bin_coherence    complex, of the next sample and this one: a row less
    beam_covariance, beam_coherence  of the next beam and this one: a column less
    intensity_histogram              [bins, beams], counts
    bin_lag_products ...             [lags + 1, beams], with `output.statistics: {lags: N}`
    """

    def __init__(self, realisations: int, arrays: Mapping[str, Any], sources: Sequence["Source"] = (),
                 pooling: Pooling = Pooling()):
        self.realisations = realisations
        self.sources = tuple(sources)
        self.pooling = pooling
        self._arrays = arrays  # an array, or the path of one

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in _NAMES + LAGGED:
            raise AttributeError(name)
        if name not in self._arrays:
            wanted = "`output.statistics: {lags: N}`" if name in LAGGED else "a newer version of ensonify"
            raise DatasetError(f"the statistics have no {name}; expected a data set of {wanted}")
        stored = self._arrays[name]
        return read_npy(stored) if isinstance(stored, Path) else stored

    def has(self, name: str) -> bool:
        return name in self._arrays

    @property
    def contrast_error(self) -> float:
        """Standard error of one pixel's contrast where speckle is fully developed."""
        return 1 / np.sqrt(self.realisations)

    def mean_contrast(self, mask: np.ndarray) -> Estimate:
        """Contrast over the pixels of `mask`: 1 for fully developed speckle of any number of realizations.

        The estimate of a single pixel is biased. Its square has the mean n / (n / C^2 + 1) where the intensity
        has a gamma distribution, which includes speckle of any number of looks, so the mean square over the
        pixels is corrected by this.
        """
        return self._of_contrast(mask, np.sqrt)

    def looks(self, mask: np.ndarray) -> Estimate:
        """Effective number of looks, 1 / C^2."""
        return self._of_contrast(mask, lambda squared: 1 / squared)

    def k_shape(self, mask: np.ndarray) -> Estimate:
        """Shape of a K distribution of one look with this contrast, C^2 = 1 + 2 / shape; infinite for speckle."""
        texture = self._of_contrast(mask, lambda squared: (squared - 1) / 2)
        if not texture.value > 0:
            return Estimate(np.inf, np.nan)
        return Estimate(1 / texture.value, texture.error / texture.value ** 2)

    def normalised_moment(self, order: int, mask: np.ndarray) -> Estimate:
        """Mean of <I^order> / <I>^order, without bias for fully developed speckle: 2 and 6 for orders 2 and 3."""
        n, pixels = self.realisations, self._effective_pixels(mask)
        if order == 2:
            mean = np.mean(self.fourth_moment[mask]) * (n + 1) / n
            return Estimate(float(mean), (n - 1) / n * _squared_contrast_error(n) / np.sqrt(pixels))
        if order == 3:
            mean = np.mean(self.third_moment[mask]) * (n + 1) * (n + 2) / n ** 2
            return Estimate(float(mean), float(np.sqrt(360 / n / pixels)))
        raise DatasetError(f"the moment of order {order} is not kept; expected 2 or 3")

    def histogram(self) -> Histogram:
        """Over the pixels that `pooling` describes. The last bin, which has no end, is left out."""
        step = self.pooling.histogram_step
        counts = _over_beam_groups(np.asarray(self.intensity_histogram).T)
        density = _ratio([(c[:-1], c.sum() * step) for c in counts])
        return Histogram(np.arange(counts.shape[1]) * step, *density)

    def coherence(self, lag: int, axis: str = "range") -> Tuple[complex, float]:
        """Complex coherence of pixels `lag` samples (or with axis="beams", beams) apart, and its standard error."""
        value, error = _ratio(self._lag_parts(lag, axis, False))
        return complex(value), float(error)

    def intensity_correlation(self, lag: int, axis: str = "range") -> Estimate:
        """Correlation coefficient of the intensities; |coherence|^2 where speckle is fully developed."""
        value, error = _ratio(self._lag_parts(lag, axis, True))
        return Estimate(float(value), float(error))

    def pooled_pixels(self) -> np.ndarray:
        """The mask [samples, beams] of the histogram and the lags."""
        expected = np.asarray(self.expected_intensity)
        return (expected > 0) & (expected >= expected.max() * 10 ** (-self.pooling.within_db / 10))

    def _effective_pixels(self, mask: np.ndarray) -> float:
        """Number of independent pixels that estimate the contrast as well as those of `mask`.

        Estimates of two pixels of coherence g are correlated by |g|^4; |g| is taken to fall with the
        square of the distance in the exponent, from what neighbours show.
        """
        mask = np.asarray(mask, bool)
        if not mask.any():
            raise DatasetError("the mask holds no pixel")
        correlated = 1.0
        for coherence, both in ((self.bin_coherence, mask[1:] & mask[:-1]),
                                (self.beam_coherence, mask[:, 1:] & mask[:, :-1])):
            near = np.mean(np.abs(coherence[both])) if both.any() else 0.0
            correlated *= 1 + 2 * sum(near ** (4 * lag * lag) for lag in range(1, 64))
        return mask.sum() / correlated

    def _of_contrast(self, mask: np.ndarray, of: Callable[[float], float]) -> Estimate:
        """A function of the squared contrast, with the error of the function's slope."""
        pixels = self._effective_pixels(mask)
        mean = float(np.mean(np.asarray(self.contrast)[np.asarray(mask, bool)] ** 2))
        squared = mean / (1 - mean / self.realisations)
        step = 1e-4 * squared
        slope = (of(squared + step) - of(squared - step)) / (2 * step)
        error = squared * _squared_contrast_error(self.realisations) / np.sqrt(pixels)
        return Estimate(float(of(squared)), float(abs(slope) * error))

    def _lag_sums(self, lag: int, axis: str, intensities: bool) -> Tuple[np.ndarray, np.ndarray]:
        """Sums over the pairs of each beam: of covariances, and of the roots of both variances."""
        if axis not in ("range", "beams"):
            raise DatasetError(f'axis is "{axis}"; expected "range" or "beams"')
        if not 0 <= lag <= self.pooling.lags:
            raise DatasetError(f"lag {lag} is not kept; expected at most {self.pooling.lags} "
                               "(`output.statistics: {lags: N}`)")
        kind = "bin" if axis == "range" else "beam"
        mean = getattr(self, f"{kind}_lag_{'intensities' if intensities else 'products'}")[lag]
        expected, mask, n = np.asarray(self.expected_intensity), self.pooled_pixels(), self.realisations
        scale = np.where(mask, expected if intensities else np.sqrt(expected), np.inf)
        values = (self.mean_intensity if intensities else self.mean_pressure) / scale
        spread = np.sqrt(self.intensity_variance if intensities else self.pressure_variance) / scale
        ahead: Any = np.s_[lag:] if axis == "range" else np.s_[:, lag:]
        behind: Any = np.s_[:len(mask) - lag] if axis == "range" else np.s_[:, :mask.shape[1] - lag]
        pairs = (mask[ahead] & mask[behind]).sum(0)
        mean = np.where(pairs > 0, mean[:len(pairs)], 0)
        covariance = (mean * pairs - (values[ahead] * values[behind].conj()).sum(0)) * n / (n - 1)
        return covariance, (spread[ahead] * spread[behind]).sum(0)

    def _lag_parts(self, lag: int, axis: str, intensities: bool) -> List[Tuple[Any, Any]]:
        covariances, spreads = self._lag_sums(lag, axis, intensities)
        return list(zip(_over_beam_groups(covariances), _over_beam_groups(spreads)))


def _over_beam_groups(values: np.ndarray) -> np.ndarray:
    """Sums of [beams ...] over groups of beams that hardly depend on one another."""
    groups = np.array_split(np.arange(len(values)), max(2, min(16, len(values) // 4)))
    return np.array([values[group].sum(0) for group in groups])


def _squared_contrast_error(n: int) -> float:
    """Relative standard error of a pixel's squared contrast over n draws of fully developed speckle."""
    return 2 * n / np.sqrt((n - 1) * (n + 2) * (n + 3)) if n > 1 else np.nan


def _ratio(parts: Sequence[Tuple[Any, Any]]) -> Tuple[Any, Any]:
    """Ratio of two sums and its standard error, by a jackknife over the parts."""
    numerators = np.array([numerator for numerator, _ in parts])
    denominators = np.array([denominator for _, denominator in parts])
    numerator, denominator, count = numerators.sum(0), denominators.sum(0), len(parts)
    weights = denominators.reshape(denominators.shape + (1,) * (numerators.ndim - denominators.ndim))
    with np.errstate(divide="ignore", invalid="ignore"):
        without = (numerator - numerators) / (denominator - weights)
        return numerator / denominator, np.sqrt((count - 1) * np.mean(np.abs(without - without.mean(0)) ** 2, 0))


def statistics_of(folder: Path, info: Dict[str, Any]) -> Statistics:
    """Of a sequence's folder and its sequence.json."""
    about = info.get("statistics")
    if about is None:
        raise DatasetError(f"{folder}: has no statistics (`output.statistics` in scenario.yaml)")
    with told_of(folder / "sequence.json"):
        # Earlier versions have no keys: what they describe must be equal.
        names = ("sonar", "water", "record", "scattering", "noise", "instances", "draws")
        described = json.dumps({name: info.get(name) for name in names}, sort_keys=True)
        scenario, scene = (str(about.get(key, described)) for key in ("scenario_sha256", "scene_sha256"))
        number, pings = listed_pings(info)
        source = Source(scenario, scene, int(info["seed"]), number, pings.start, pings.stop,
                        int(info.get("speckle_seed", -1)))
        stored = {name: folder / "statistics" / f"{name}.npy" for name in _NAMES + LAGGED}
        arrays = {name: path for name, path in stored.items() if f"statistics/{path.name}" in about["arrays"]}
        pooling = Pooling(**{name: about[name] for name in Pooling._fields if name in about})
        return Statistics(int(about["realisations"]), arrays, [source], pooling)
