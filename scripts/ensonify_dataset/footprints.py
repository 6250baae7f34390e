"""Where the pixels of Cartesian images lie in the polar image, and the mean intensity that each of them shows.

The footprint of a pixel with edge e at range r is e / (r spacing) beams wide and e / step samples long. It is divided
into equal parts, in both directions as many as its width rounded up. The mean is that of the intensities at the
centers of the parts, interpolated bilinearly, as a row of weights along beams and one along samples. Single precision,
in the order of the program, makes the images equal.
"""
from __future__ import annotations

import math
from typing import Any, Dict, Iterator, Sequence, Tuple

import numpy as np

_ONE = 1 << 15  # of a fraction
_LEAST, _MOST = float(np.finfo(np.float32).tiny), 1e37


def bounded(powers: Sequence[float]) -> np.ndarray:
    """float32 that are neither 0 nor infinite."""
    return np.clip(np.asarray(powers, np.float64), _LEAST, _MOST).astype(np.float32)


def power(db: float) -> float:
    """10^(db / 10), infinite where that is too large."""
    return math.pow(10.0, db / 10) if db < 3000 else math.inf


class Footprints:
    """The footprints of a sequence; `info` is its sequence.json and `pixels` its cartesian_map."""

    def __init__(self, info: Dict[str, Any], pixels: np.ndarray):
        grid, beams = info["cartesian"], info["sonar"]["beams"]
        record = info["record"]
        recorded = "recording" in info
        bandwidth_hz = 1 / record["sample_interval_s"] if recorded else info["sonar"]["bandwidth_hz"]
        per_m = 2.0 * bandwidth_hz / info["water"]["sound_speed_m_s"]
        self.first_sample = record.get("first_range_m", 0.0) * per_m
        self.shape = pixels.shape
        self.beams, self.samples = int(beams["count"]), int(info["record"]["samples"])
        if pixels.shape != (grid["height_px"], grid["width_px"]):
            raise ValueError(f"cartesian: {grid['height_px']} x {grid['width_px']} pixels; expected those of "
                             "cartesian_map.npy")
        self._length = grid["metres_per_pixel"] * per_m
        # Forward and back, or to both sides; the work on untrusted files has an end.
        longest = 2.02 * (self.samples + 1.0 + self.first_sample)
        azimuths = np.array(beams["azimuth_rad"]) if beams.get("azimuth_rad") else None
        half_fan = min(self.beams * beams["spacing_rad"] / 2 if azimuths is None else _half_fan(azimuths), math.pi / 2)
        if not (beams["spacing_rad"] > 0 and self._length > 0 and grid["height_px"] * self._length <= longest
                and (grid["width_px"] - 2) * self._length <= longest * math.sin(half_fan)):
            raise ValueError("cartesian: is larger than the fan")
        self.row, self.column = np.nonzero(pixels >= 0)
        x = grid["x_top_m"] - (self.row + 0.5) * grid["metres_per_pixel"]
        y = grid["y_left_m"] - (self.column + 0.5) * grid["metres_per_pixel"]
        azimuth = np.arctan2(y, x)
        self._beam = self._place(azimuth / beams["spacing_rad"] + (self.beams - 1) / 2.0 if azimuths is None
                                 else _among(azimuths, azimuth), self.beams)
        self._sample = self._place(np.sqrt(x * x + y * y) * per_m - self.first_sample, self.samples)
        self.sample = self._sample / _ONE  # of the middle of each
        self._width = np.minimum(self._length / beams["spacing_rad"] / np.maximum(self.first_sample + self.sample, 0.5),
                                 self.beams)

    def mean_intensity(self, level_db: np.ndarray, no_energy_db: float) -> np.ndarray:
        """float32, of each pixel in the fan; levels are [samples, beams]."""
        if np.shape(level_db) != (self.samples, self.beams):
            raise ValueError(f"levels are {np.shape(level_db)}; expected {(self.samples, self.beams)}")
        levels, which = np.unique(np.asarray(level_db, np.float32), return_inverse=True)
        powers = bounded([power(float(level)) for level in levels])
        intensity = np.where(levels > no_energy_db, powers / np.float32(_ONE), np.float32(0))
        intensity = intensity[which].reshape(self.samples, self.beams)
        m, n = int(_parts(np.array(self._length))), _parts(self._width)
        offsets = np.floor(self._length * _middles(m) * _ONE + 0.5).astype(np.int64)
        mean = np.zeros(self.sample.size, np.float32)
        for count in np.unique(n):
            for chosen in _some(np.flatnonzero(n == count)):
                samples = np.clip(self._sample[chosen, None] + offsets, 0, (self.samples - 1) * _ONE)
                beams = self._place((self._beam[chosen] / _ONE)[:, None] + self._width[chosen, None] * _middles(count),
                                    self.beams)
                first, along = _weights(samples)
                column, across = _weights(beams)
                terms = np.zeros((chosen.size, -(-along.shape[1] // 4) * 4), np.float32)
                rows = np.minimum(first[:, None] + np.arange(along.shape[1]), self.samples - 1)
                for k in range(across.shape[1]):
                    weight = (across[:, k] / (count * _ONE)).astype(np.float32)
                    at = np.minimum(column + k, self.beams - 1)
                    terms[:, :along.shape[1]] += weight[:, None] * intensity[rows, at[:, None]]
                terms[:, :along.shape[1]] *= along.astype(np.float32)
                fourth = np.zeros((chosen.size, 4), np.float32)
                for k in range(0, terms.shape[1], 4):
                    fourth += terms[:, k:k + 4]
                mean[chosen] = (fourth[:, 0] + fourth[:, 1]) + (fourth[:, 2] + fourth[:, 3])
        return mean * np.float32(1 / m)

    def _place(self, position: np.ndarray, count: int) -> np.ndarray:
        """In units of 2^-15."""
        return np.floor(np.clip(position, 0.0, count - 1.0) * _ONE + 0.5).astype(np.int64)


def _middles(parts: int) -> np.ndarray:
    """Of equal parts of a length of 1, from its middle."""
    return (np.arange(parts) + 0.5) / parts - 0.5


def _some(items: np.ndarray) -> Iterator[np.ndarray]:
    """Parts whose weights need little memory."""
    for start in range(0, items.size, 1 << 16):
        yield items[start:start + (1 << 16)]


def _weights(places: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """The first point, and the sums of weights, in units of 2^-15, of it and the next ones; places rise in each row."""
    point, fraction = places // _ONE, places % _ONE
    first, row = point[:, 0], np.arange(len(places))
    sums = np.zeros((len(places), int((point[:, -1] - first).max()) + 2), np.int64)
    for k in range(places.shape[1]):
        sums[row, point[:, k] - first] += _ONE - fraction[:, k]
        sums[row, point[:, k] - first + 1] += fraction[:, k]
    return first, sums


def _half_fan(azimuths: np.ndarray) -> float:
    """The larger angle from the boresight to an edge of the fan."""
    low, high = azimuths[0] - (azimuths[1] - azimuths[0]) / 2, azimuths[-1] + (azimuths[-1] - azimuths[-2]) / 2
    return max(abs(low), abs(high))


def _among(azimuths: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Place among the beams, linear between their azimuths."""
    beam = np.searchsorted(azimuths[1:-1], azimuth, side="right")
    return beam + (azimuth - azimuths[beam]) / (azimuths[beam + 1] - azimuths[beam])


def _parts(width: np.ndarray) -> np.ndarray:
    return np.maximum(1, np.ceil(width - 1e-6).astype(np.int64))
