"""Statistics of every pixel over the pings of a sequence (`output.statistics`); see docs/physics/4_speckle.md."""
from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Dict, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from .files import DatasetError, read_npy
from .manifest import listed_pings, told_of

_NAMES = ("mean_pressure", "pressure_variance", "mean_intensity", "intensity_variance", "contrast",
          "fourth_moment", "bin_covariance", "bin_coherence", "beam_covariance", "beam_coherence")


class Source(NamedTuple):
    """Which draws of which scene."""

    scene: str  # what the sequence's sonar, water, noise and instances are
    seed: int
    sequence: int
    first_ping: int
    last_ping: int  # the one after the last

    def overlaps(self, other: "Source") -> bool:
        same = (self.seed, self.sequence) == (other.seed, other.sequence)
        return same and self.first_ping < other.last_ping and other.first_ping < self.last_ping


class Statistics:
    """Arrays [samples, beams], read when they are asked for; NaN where there is no energy.

    mean_pressure        complex, Pa           pressure_variance   Pa^2
    mean_intensity       of I = |p|^2, Pa^2    intensity_variance  Pa^4
    contrast             std I / mean I        fourth_moment       <I^2> / <I>^2
    bin_covariance, bin_coherence    complex, of the next sample and this one: a row less
    beam_covariance, beam_coherence  of the next beam and this one: a column less
    """

    def __init__(self, realisations: int, arrays: Mapping[str, Any], sources: Sequence["Source"] = ()):
        self.realisations = realisations
        self.sources = tuple(sources)
        self._arrays = arrays  # an array, or the path of one

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in _NAMES:
            raise AttributeError(name)
        stored = self._arrays[name]
        return read_npy(stored) if isinstance(stored, Path) else stored

    @property
    def contrast_error(self) -> float:
        """Standard error of one pixel's contrast where speckle is fully developed."""
        return 1 / np.sqrt(self.realisations)

    def mean_contrast(self, mask: np.ndarray) -> Tuple[float, float]:
        """Mean of the contrast over the pixels of `mask`, and its standard error.

        Estimates of two pixels of coherence g are correlated by |g|^4; |g| is taken to fall with the
        square of the distance in the exponent, from what neighbours show.
        """
        mask = np.asarray(mask, bool)
        if not mask.any():
            raise DatasetError("the mask of mean_contrast holds no pixel")
        correlated = 1.0
        for coherence, both in ((self.bin_coherence, mask[1:] & mask[:-1]),
                                (self.beam_coherence, mask[:, 1:] & mask[:, :-1])):
            near = np.mean(np.abs(coherence[both])) if both.any() else 0.0
            correlated *= 1 + 2 * sum(near ** (4 * lag * lag) for lag in range(1, 64))
        contrast = np.asarray(self.contrast)[mask]
        return float(contrast.mean()), float(np.sqrt(correlated / (contrast.size * self.realisations)))


def statistics_of(folder: Path, info: Dict[str, Any]) -> Statistics:
    """Of a sequence's folder and its sequence.json."""
    about = info.get("statistics")
    if about is None:
        raise DatasetError(f"{folder}: has no statistics (`output.statistics` in scenario.yaml)")
    scene = {name: info.get(name) for name in ("sonar", "water", "record", "scattering", "noise", "instances")}
    with told_of(folder / "sequence.json"):
        number, pings = listed_pings(info)
        source = Source(json.dumps(scene, sort_keys=True), int(info["seed"]), number, pings.start, pings.stop)
        return Statistics(int(about["realisations"]),
                          {name: folder / "statistics" / f"{name}.npy" for name in _NAMES}, [source])


def merge(parts: Sequence[Statistics]) -> Statistics:
    """Of all realisations together: of sequences or ranges of pings that are draws of one scene.

    DatasetError where the scenes differ, or where draws would count twice.
    """
    if not parts:
        raise DatasetError("there are no statistics to merge")
    sources = [source for part in parts for source in part.sources]
    _check(sources)
    count, sums = parts[0].realisations, _sums(parts[0])
    for part in parts[1:]:
        _add(count, sums, part.realisations, _sums(part))
        count += part.realisations
    return _of_sums(count, sums, sources)


def _check(sources: Sequence[Source]) -> None:
    ordered = sorted(sources, key=lambda s: (s.seed, s.sequence, s.first_ping))
    for one, other in zip(ordered, ordered[1:]):
        if one.scene != other.scene:
            raise DatasetError("statistics of different scenes are no statistics of one: their sonar, water, "
                               "scattering, noise or instances differ")
        if one.overlaps(other):
            raise DatasetError(f"pings {other.first_ping} to {min(one.last_ping, other.last_ping) - 1} of seed "
                               f"{one.seed} would count twice")


def _sums(part: Statistics) -> Dict[str, np.ndarray]:
    degrees = part.realisations - 1
    if degrees < 1:
        raise DatasetError("statistics of a single ping cannot be merged: they have no variance")
    sums = {name: np.array(getattr(part, name)) * (1 if name.startswith("mean") else degrees)
            for name in _NAMES if not name.endswith(("contrast", "moment", "coherence"))}
    return sums


def _add(count: int, sums: Dict[str, np.ndarray], more: int, others: Dict[str, np.ndarray]) -> None:
    """Chan, Golub and LeVeque's merge."""
    share, weight = more / (count + more), count * more / (count + more)
    step = others["mean_pressure"] - sums["mean_pressure"]
    step_intensity = others["mean_intensity"] - sums["mean_intensity"]
    sums["pressure_variance"] += others["pressure_variance"] + weight * np.abs(step) ** 2
    sums["intensity_variance"] += others["intensity_variance"] + weight * step_intensity ** 2
    sums["bin_covariance"] += others["bin_covariance"] + weight * step[1:] * step[:-1].conj()
    sums["beam_covariance"] += others["beam_covariance"] + weight * step[:, 1:] * step[:, :-1].conj()
    sums["mean_pressure"] += share * step
    sums["mean_intensity"] += share * step_intensity


def _of_sums(count: int, sums: Dict[str, np.ndarray], sources: Sequence[Source]) -> Statistics:
    arrays: Dict[str, np.ndarray] = {name: values / (1 if name.startswith("mean") else count - 1)
              for name, values in sums.items()}
    spread = np.sqrt(arrays["pressure_variance"])
    with np.errstate(divide="ignore", invalid="ignore"):
        intensity = np.where(arrays["mean_intensity"] > 0, arrays["mean_intensity"], np.nan)
        arrays["contrast"] = np.sqrt(arrays["intensity_variance"]) / intensity
        arrays["fourth_moment"] = 1 + sums["intensity_variance"] / count / intensity ** 2
        arrays["bin_coherence"] = arrays["bin_covariance"] / (spread[1:] * spread[:-1])
        arrays["beam_coherence"] = arrays["beam_covariance"] / (spread[:, 1:] * spread[:, :-1])
    return Statistics(count, arrays, sources)
