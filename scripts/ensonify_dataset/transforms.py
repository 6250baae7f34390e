"""Levels and series made ready for a network: arrays in, arrays out."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np

from .footprints import Footprints, bounded, power

NO_ENERGY_DB = -99.0


def to_db(series: np.ndarray) -> np.ndarray:
    """Level of a time series in dB re 1 uPa, float32; -99 where there is no energy."""
    with np.errstate(divide="ignore"):
        level = 20 * np.log10(np.abs(np.asarray(series)).astype(np.float64)) + 120
    return np.maximum(level, NO_ENERGY_DB).astype(np.float32)


def to_grey(level_db: np.ndarray, black_db: float, white_db: float) -> np.ndarray:
    """uint8, linear in dB from black (0) to white (255), rounded as the images in `png/` are."""
    return Display((black_db, white_db)).grey(level_db)


def _middles(first: int, end: int, size: int) -> np.ndarray:
    """Of blocks from `first` to end - 1; the last one may be smaller. Of two, the first."""
    start = np.arange(first, end, size)
    return start + (np.minimum(size, end - start) - 1) // 2


class Part(NamedTuple):
    """The polar pixels that a display shows: samples first to end - 1, in blocks of `samples` x `beams`."""

    first: int
    end: int
    samples: int
    beams: int

    def middle_samples(self) -> np.ndarray:
        """Of each row of the image."""
        return _middles(self.first, self.end, self.samples)

    def held(self, level_db: np.ndarray, shown: np.ndarray) -> np.ndarray:
        """The levels [samples, beams], but those in the window are those of their block, which are `shown`."""
        level = np.array(level_db)
        rows = np.arange(self.end - self.first) // self.samples
        level[self.first:self.end] = shown[rows[:, None], np.arange(level.shape[1]) // self.beams]
        return level

    def mapped(self, pixels: np.ndarray, beams: int) -> np.ndarray:
        """A Cartesian map cut to the window; its values are pixels of the image, or -1."""
        sample, beam = np.divmod(pixels, beams)
        inside = (pixels >= 0) & (sample >= self.first) & (sample < self.end)
        columns = -(-beams // self.beams)
        cut = np.where(inside, (sample - self.first) // self.samples * columns + beam // self.beams, -1)
        return cut[self.rectangle(pixels, beams)]

    def rectangle(self, pixels: np.ndarray, beams: int) -> Tuple[slice, slice]:
        """The smallest one with all pixels of the window."""
        sample = pixels // beams
        inside = (pixels >= 0) & (sample >= self.first) & (sample < self.end)
        rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
        if not rows.size:
            raise ValueError("range_m: holds no pixel of the Cartesian image")
        return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)


@dataclass(frozen=True)
class Display:
    """How levels become 8-bit images; `data.display()` is that of a data set, and of its renders.

    A pixel shows s = level + spreading log10(r / 1 m) + 2 alpha r (with `absorption`) + gain_db as
    255 (s - black) / (white - black) (scale "db") or 255 10^(gamma (s - white) / 20) ("amplitude").
    `automatic_gain` puts the 99.5th percentile of each ping on white. A pixel of a Cartesian image shows the mean
    intensity over its footprint in the polar image (`resampling` "bilinear") or the nearest polar pixel ("nearest").

    `range_m` shows only these slant ranges. `samples` and `beams` decimate: a pixel of the polar image shows the middle
    pixel ("pick") or the loudest one ("max") of a block of so many. Cartesian images show the blocks.
    """

    limits_db: Tuple[float, float] = (60.0, 120.0)  # black and white
    scale: str = "db"
    gamma: float = 1.0
    gain_db: float = 0.0
    spreading: float = 0.0
    absorption: bool = False
    automatic_gain: bool = False
    color_map: str = ""
    flip: str = "none"
    resampling: str = "bilinear"
    range_m: Optional[Tuple[float, float]] = None
    samples: int = 1
    beams: int = 1
    decimation: str = "pick"

    @classmethod
    def of(cls, told: Dict[str, Any]) -> "Display":
        """Of `png` in a manifest, or of `display` in a render's."""
        tvg = told.get("tvg", {})
        absorption = bool(tvg.get("absorption", tvg.get("absorption_db_m", 0) != 0))
        black, white = (float(limit) for limit in told["db"])
        window, blocks = told.get("range_m"), told.get("decimation", {})
        return cls((black, white), str(told["scale"]), float(told.get("gamma", 1)),
                   float(told.get("gain_db", 0)), float(tvg.get("spreading", 0)), absorption,
                   bool(told.get("automatic_gain", False)), str(told.get("color_map", "")),
                   str(told.get("flip", "none")), str(told.get("resampling", "bilinear")),
                   None if window is None else (float(window[0]), float(window[1])),
                   int(blocks.get("samples", 1)), int(blocks.get("beams", 1)), str(blocks.get("shows", "pick")))

    def grey(self, level_db: np.ndarray, step_m: float = 1.0, absorption_db_m: float = 0.0,
             first_m: float = 0.0) -> np.ndarray:
        """uint8 of polar levels [samples, beams], not flipped; samples stand `step_m` apart, the first at `first_m`.
        With `range_m`, `samples` or `beams` it has fewer rows and columns.

        The values of the program: sums and comparisons are the same in double precision, and
        logarithms are those of the C library.
        """
        heard, shown = self._part_with_tvg(level_db, step_m, absorption_db_m, first_m)
        grey = np.searchsorted(self._steps_db(), shown + self._further_gain_db(heard, shown), side="right")
        return np.where(heard, grey, 0).astype(np.uint8)

    def cartesian_grey(self, level_db: np.ndarray, footprints: Footprints, step_m: float = 1.0,
                       absorption_db_m: float = 0.0, first_m: float = 0.0) -> np.ndarray:
        """uint8 [rows, columns] of polar levels, with `resampling` "bilinear", not flipped; black outside the fan.

        The image is that of all ranges; `part` cuts it.
        """
        heard, shown = self._part_with_tvg(level_db, step_m, absorption_db_m, first_m)
        offset_db = self._further_gain_db(heard, shown)
        part = self.part(np.shape(level_db), step_m, first_m)
        if part is not None:
            level_db = part.held(level_db, self._blocks(part, level_db))
        intensity = footprints.mean_intensity(level_db, NO_ENERGY_DB)
        if self.spreading or self.absorption:
            last_db = float(self._tvg_db(len(level_db), step_m, absorption_db_m, first_m)[-1])
            alpha = absorption_db_m if self.absorption else 0.0
            range_m = np.maximum(footprints.first_sample + footprints.sample, 1) * step_m
            tvg_db = self.spreading * np.log10(range_m) + 2 * alpha * range_m
            intensity = intensity * (10 ** ((tvg_db - last_db) / 10)).astype(np.float32)
            offset_db += last_db
        steps = bounded([power(step - offset_db) for step in self._steps_db()])
        image = np.zeros(footprints.shape, np.uint8)
        image[footprints.row, footprints.column] = np.searchsorted(steps, intensity, side="right")
        return image

    def part(self, shape: Tuple[int, ...], step_m: float = 1.0, first_m: float = 0.0) -> Optional[Part]:
        """What it shows of polar levels of this shape; None: all."""
        if self.range_m is None and self.samples == 1 and self.beams == 1:
            return None
        first, end = 0, shape[0]
        if self.range_m is not None:
            low, high = self.range_m
            inside = [n for n in range(end) if low <= first_m + n * step_m <= high]
            if not inside:
                raise ValueError(f"range_m: holds no sample; expected a part of {first_m:.2f} to "
                                 f"{first_m + (end - 1) * step_m:.2f}")
            first, end = inside[0], inside[-1] + 1
        if not (1 <= self.samples <= end - first and 1 <= self.beams <= shape[1]):
            raise ValueError(f"samples, beams: {self.samples} x {self.beams}; expected at most {end - first} x {shape[1]}")
        if self.decimation not in ("pick", "max"):
            raise ValueError(f"decimation: {self.decimation}; expected pick or max")
        return Part(first, end, self.samples, self.beams)

    def _blocks(self, part: Part, level_db: np.ndarray) -> np.ndarray:
        """The level that each block shows."""
        level = np.asarray(level_db)
        beams = level.shape[1]
        if self.decimation == "pick":
            return level[part.middle_samples()[:, None], _middles(0, beams, part.beams)]
        whole = level[part.first:part.end]
        more = (-len(whole) % part.samples, -beams % part.beams)
        whole = np.pad(whole, ((0, more[0]), (0, more[1])), constant_values=-np.inf)
        return whole.reshape(len(whole) // part.samples, part.samples, -1, part.beams).max(axis=(1, 3))

    def _part_with_tvg(self, level_db: np.ndarray, step_m: float, absorption_db_m: float,
                       first_m: float) -> Tuple[np.ndarray, np.ndarray]:
        """Which pixels of the polar image have energy, and their levels with time-varied gain."""
        part = self.part(np.shape(level_db), step_m, first_m)
        level = np.asarray(level_db if part is None else self._blocks(part, level_db), np.float64)
        shown = level
        if self.spreading or self.absorption:
            tvg_db = self._tvg_db(len(level_db), step_m, absorption_db_m, first_m)
            shown = level + (tvg_db if part is None else tvg_db[part.middle_samples()])[:, None]
        return level > NO_ENERGY_DB, shown

    def _further_gain_db(self, heard: np.ndarray, shown: np.ndarray) -> float:
        if not self.automatic_gain or not heard.any():
            return self.gain_db
        values = shown[heard]
        rank = int(0.995 * (values.size - 1))
        return self.gain_db + (self.limits_db[1] - float(np.partition(values, rank)[rank]))

    def flipped(self, image: np.ndarray) -> np.ndarray:
        rows = slice(None, None, -1 if self.flip in ("vertical", "both") else 1)
        columns = slice(None, None, -1 if self.flip in ("horizontal", "both") else 1)
        return np.ascontiguousarray(image[rows, columns])

    def _tvg_db(self, samples: int, step_m: float, absorption_db_m: float, first_m: float) -> np.ndarray:
        alpha = absorption_db_m if self.absorption else 0.0
        ranges = [max(first_m + n * step_m, step_m) for n in range(samples)]
        return np.array([self.spreading * math.log10(r) + 2 * alpha * r for r in ranges])

    def _steps_db(self) -> np.ndarray:
        """Where each gray level but 0 begins."""
        black, white = self.limits_db
        if self.scale == "db":
            return np.array([(k - 0.5) * (white - black) / 255 + black for k in range(1, 256)])
        return np.array([20 * math.log10((k - 0.5) / 255) / self.gamma + white for k in range(1, 256)])


def to_amplitude(level_db: np.ndarray) -> np.ndarray:
    """Rms pressure in Pa, float32; 0 where there is no energy."""
    level = np.asarray(level_db, np.float64)
    return np.where(level > NO_ENERGY_DB, 10 ** ((level - 120) / 20), 0).astype(np.float32)


def normalise(level_db: np.ndarray) -> np.ndarray:
    """Mean 0 and standard deviation 1 over the pixels of this picture that have energy, float32.

    Those without, as outside the fan, take the least value of the others; a picture without any
    energy is 0 everywhere.
    """
    level = np.asarray(level_db, np.float64)
    filled = level > NO_ENERGY_DB
    if not filled.any():
        return np.zeros(level.shape, np.float32)
    scaled = (level - level[filled].mean()) / max(level[filled].std(), 1e-6)
    return np.where(filled, scaled, scaled[filled].min()).astype(np.float32)
