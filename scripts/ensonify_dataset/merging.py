"""Statistics joined: realizations of one scene, and worlds of one scenario; see docs/physics/4_speckle.md."""
from __future__ import annotations

from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Sequence, Tuple

import numpy as np

from .files import DatasetError
from .statistics import LAGGED, Estimate, Pooling, Source, Statistics

_SUMS = ("mean_pressure", "pressure_variance", "mean_intensity", "intensity_variance", "bin_covariance",
         "beam_covariance")


def merge(parts: Sequence[Statistics]) -> Statistics:
    """Join sequences or ranges of pings: all realizations of one scene together, or `Worlds` of a scenario.

    Parts whose scenes are the same are joined first. DatasetError where the scenarios differ, or where draws
    would count twice.
    """
    if not parts:
        raise DatasetError("there are no statistics to merge")
    flat = [scene for part in parts for scene in getattr(part, "scenes", [part])]
    _check([source for part in flat for source in part.sources])
    scenes: Dict[str, List[Statistics]] = {}
    for part in flat:
        scenes.setdefault(part.sources[0].scene if part.sources else "", []).append(part)
    joined = [_of_one_scene(same) for same in scenes.values()]
    if len(joined) == 1:
        return joined[0]
    return Worlds(joined)


class Variances(NamedTuple):
    """Variances of the intensity, divided by the square of its mean, over the pixels of a mask."""

    within: Estimate  # of the realizations of a world: speckle
    between: Estimate  # of the worlds' mean intensities: texture, places


class _Relative(NamedTuple):
    """Over the pixels of a mask, relative to powers of the mean over worlds."""

    variance: float
    within: float
    third: float


class Worlds(Statistics):
    """Statistics of several worlds, each of which counts once, with the members of Statistics.

    Means are means over worlds. Variances are those of a realization of a random world:
    intensity_variance = within_variance + between_variance. Errors are those over worlds, by a jackknife, which
    also removes the bias that decreases with the number of worlds.
    """

    within_variance: np.ndarray  # mean of the worlds' variances; NaN for worlds of one realization
    between_variance: np.ndarray  # variance of the worlds' expected intensities, without bias

    def __init__(self, scenes: Sequence[Statistics]):
        self.scenes = list(scenes)
        arrays = _over_worlds(self.scenes)
        self.within_variance = arrays.pop("within_variance")
        self.between_variance = arrays["intensity_variance"] - self.within_variance
        sources = [source for scene in scenes for source in scene.sources]
        super().__init__(sum(scene.realisations for scene in scenes), arrays, sources, scenes[0].pooling)

    @property
    def worlds(self) -> int:
        return len(self.scenes)

    @property
    def contrast_error(self) -> float:
        raise DatasetError("the contrast of one pixel over worlds has no error in closed form; expected "
                           "mean_contrast(mask)")

    def variances(self, mask: np.ndarray) -> Variances:
        return Variances(self._jackknife(mask, lambda r: r.within),
                         self._jackknife(mask, lambda r: r.variance - r.within))

    def normalised_moment(self, order: int, mask: np.ndarray) -> Estimate:
        """The moment of a realization of a random world: <I^order> / <I>^order over worlds."""
        if order == 2:
            return self._jackknife(mask, lambda r: 1 + r.variance)
        if order == 3:
            return self._jackknife(mask, lambda r: r.third)
        raise DatasetError(f"the moment of order {order} is not kept; expected 2 or 3")

    def histogram(self):
        raise DatasetError("the intensity is divided by the expectation of its own world; expected the histogram of "
                           "one of `scenes`")

    def _of_contrast(self, mask: np.ndarray, of: Callable[[float], float]) -> Estimate:
        return self._jackknife(mask, lambda r: of(r.variance))

    def _lag_parts(self, lag: int, axis: str, intensities: bool) -> List[Tuple[Any, Any]]:
        sums = [scene._lag_sums(lag, axis, intensities) for scene in self.scenes]
        return [(covariances.sum(), spreads.sum()) for covariances, spreads in sums]

    def _jackknife(self, mask: np.ndarray, of: Callable[[_Relative], float]) -> Estimate:
        mask = np.asarray(mask, bool)
        if not mask.any():
            raise DatasetError("the mask holds no pixel")
        count = len(self.scenes)
        sums: Any = sum(self._terms(mask))
        whole = of(_relative(count, sums))
        if count < 3:  # one world alone has no variance between worlds
            return Estimate(float(whole), np.nan)
        without = np.array([of(_relative(count - 1, sums - terms)) for terms in self._terms(mask)])
        value = count * whole - (count - 1) * without.mean()
        return Estimate(float(value), float(np.sqrt((count - 1) / count * np.sum((without - without.mean()) ** 2))))

    def _terms(self, mask: np.ndarray) -> Iterator[np.ndarray]:
        """For each world M, M^2, <I^2>, <I^3> and the variance, [5, pixels]: worlds are read one after another."""
        for scene in self.scenes:
            mean = np.asarray(scene.mean_intensity)[mask]
            third = scene.third_moment[mask] if scene.has("third_moment") else np.nan
            with np.errstate(invalid="ignore"):
                terms = [mean, mean ** 2, scene.fourth_moment[mask] * mean ** 2, third * mean ** 3]
            yield np.array([*(np.where(mean > 0, t, 0) for t in terms), scene.intensity_variance[mask]])


def _relative(worlds: int, sums: np.ndarray) -> _Relative:
    mean, squared, power, cubes, within = sums / worlds
    between = (squared - mean ** 2) * worlds / (worlds - 1) if worlds > 1 else np.nan * mean
    variance = power - mean ** 2 + between / worlds  # E I^2 less an unbiased (E I)^2
    return _Relative(np.mean(variance / mean ** 2), np.mean(within / mean ** 2), np.mean(cubes / mean ** 3))


def _over_worlds(scenes: Sequence[Statistics]) -> Dict[str, Any]:
    """The law of total variance for every pixel and every pair of neighbors."""
    count = len(scenes)
    inside: Dict[str, Any] = dict.fromkeys(_SUMS, 0)
    means: Dict[str, Any] = {}
    within: Any = 0
    power: Any = 0
    cubes: Any = 0
    expected: Any = 0
    for number, scene in enumerate(scenes):
        share = 1 - 1 / scene.realisations  # the rest of a variance is in the scatter of the estimated means
        here = {name: np.array(getattr(scene, name)) for name in _SUMS}
        within = within + here["intensity_variance"] / count
        for name, values in here.items():
            if name.startswith("mean"):
                continue
            inside[name] = inside[name] + (values * share / count if share > 0 else 0)
            here[name] = np.zeros_like(values)
        mean = here["mean_intensity"]
        power = power + np.nan_to_num(scene.fourth_moment * mean ** 2) / count
        third = scene.third_moment if scene.has("third_moment") else np.nan * mean
        cubes = cubes + np.where(mean > 0, third * mean ** 3, 0) / count
        expected = expected + (scene.expected_intensity / count if scene.has("expected_intensity") else np.nan)
        if number == 0:
            means = here
        else:
            _add(number, means, 1, here)
    arrays: Dict[str, Any] = {name: means[name] if name.startswith("mean") else inside[name] + means[name] / (count - 1)
              for name in _SUMS}
    _add_ratios(arrays)
    mean = np.where(arrays["mean_intensity"] > 0, arrays["mean_intensity"], np.nan)
    arrays.update(fourth_moment=power / mean ** 2, third_moment=cubes / mean ** 3, expected_intensity=expected,
                  within_variance=within)
    return arrays


def _check(sources: Sequence[Source]) -> None:
    ordered = sorted(sources, key=lambda s: (s.seed, s.speckle_seed, s.sequence, s.first_ping))
    for one, other in zip(ordered, ordered[1:]):
        if one.scenario != other.scenario:
            raise DatasetError("statistics of different scenes are no statistics of one, and of no worlds of one "
                               "scenario: keys other than the seed, the sequences and the pings differ")
        if one.overlaps(other):
            raise DatasetError(f"pings {other.first_ping} to {min(one.last_ping, other.last_ping) - 1} of seed "
                               f"{one.seed} would count twice")


def _of_one_scene(parts: Sequence[Statistics]) -> Statistics:
    if len(parts) == 1:
        return parts[0]
    count, sums = parts[0].realisations, _sums(parts[0])
    pooled = _weighted(parts)
    for part in parts[1:]:
        _add(count, sums, part.realisations, _sums(part))
        count += part.realisations
    sources = [source for part in parts for source in part.sources]
    return _of_sums(count, sums, pooled, sources, parts[0].pooling)


def _weighted(parts: Sequence[Statistics]) -> Dict[str, Any]:
    """What is added or averaged over realizations. Arrays that a part lacks are left out."""
    total = sum(part.realisations for part in parts)
    same = all(part.pooling == parts[0].pooling for part in parts)
    arrays = {}
    for name in ("expected_intensity",) + (("intensity_histogram",) + LAGGED if same else ()):
        if all(part.has(name) for part in parts):
            shares = [1 if name == "intensity_histogram" else part.realisations / total for part in parts]
            arrays[name] = sum(np.asarray(getattr(part, name)) * share for part, share in zip(parts, shares))
    return arrays


def _sums(part: Statistics) -> Dict[str, Any]:
    degrees = part.realisations - 1
    if degrees < 1:
        raise DatasetError("statistics of a single ping cannot be joined with others of its scene: they have no "
                           "variance")
    sums = {name: np.array(getattr(part, name)) * (1 if name.startswith("mean") else degrees) for name in _SUMS}
    if part.has("third_moment"):
        with np.errstate(invalid="ignore"):
            mean, n = sums["mean_intensity"], part.realisations
            cubes = n * mean ** 3 * (part.third_moment - 1) - 3 * mean * sums["intensity_variance"]
            sums["third_moment"] = np.where(mean > 0, cubes, 0)  # sum of (I - mean)^3
    return sums


def _add(count: int, sums: Dict[str, Any], more: int, others: Dict[str, Any]) -> None:
    """Chan, Golub and LeVeque's merge."""
    share, weight = more / (count + more), count * more / (count + more)
    step = others["mean_pressure"] - sums["mean_pressure"]
    step_intensity = others["mean_intensity"] - sums["mean_intensity"]
    if "third_moment" in sums and "third_moment" in others:
        sums["third_moment"] += others["third_moment"] + weight * (1 - 2 * share) * step_intensity ** 3 + (
            3 * step_intensity * ((1 - share) * others["intensity_variance"] - share * sums["intensity_variance"]))
    else:
        sums.pop("third_moment", None)
    sums["pressure_variance"] += others["pressure_variance"] + weight * np.abs(step) ** 2
    sums["intensity_variance"] += others["intensity_variance"] + weight * step_intensity ** 2
    sums["bin_covariance"] += others["bin_covariance"] + weight * step[1:] * step[:-1].conj()
    sums["beam_covariance"] += others["beam_covariance"] + weight * step[:, 1:] * step[:, :-1].conj()
    sums["mean_pressure"] += share * step
    sums["mean_intensity"] += share * step_intensity


def _of_sums(count: int, sums: Dict[str, Any], pooled: Dict[str, Any], sources: Sequence[Source],
             pooling: Pooling) -> Statistics:
    arrays: Dict[str, Any] = {name: sums[name] / (1 if name.startswith("mean") else count - 1) for name in _SUMS}
    arrays.update(pooled)
    _add_ratios(arrays)
    with np.errstate(divide="ignore", invalid="ignore"):
        intensity = np.where(arrays["mean_intensity"] > 0, arrays["mean_intensity"], np.nan)
        squares = sums["intensity_variance"] / count / intensity ** 2
        arrays["fourth_moment"] = 1 + squares
        if "third_moment" in sums:
            arrays["third_moment"] = 1 + 3 * squares + sums["third_moment"] / count / intensity ** 3
    return Statistics(count, arrays, sources, pooling)


def _add_ratios(arrays: Dict[str, Any]) -> None:
    """The contrast and the coherences that follow from means, variances and covariances."""
    spread = np.sqrt(arrays["pressure_variance"])
    with np.errstate(divide="ignore", invalid="ignore"):
        intensity = np.where(arrays["mean_intensity"] > 0, arrays["mean_intensity"], np.nan)
        arrays["contrast"] = np.sqrt(arrays["intensity_variance"]) / intensity
        arrays["bin_coherence"] = arrays["bin_covariance"] / (spread[1:] * spread[:-1])
        arrays["beam_coherence"] = arrays["beam_covariance"] / (spread[:, 1:] * spread[:, :-1])
