"""What happens to an image after the recorder: the gain and law of a display, lost beams, JPEG compression, and the pixels
of a fan-shaped display image.

All else that an instrument does to an image belongs to the keys of the scenario.
"""
from __future__ import annotations

import dataclasses
import io
from dataclasses import dataclass
from typing import Dict, Optional, Sequence, Tuple

import numpy as np

from .files import DatasetError
from .transforms import Display

GAIN, LOST, QUALITY = range(3)  # streams of random numbers, so that a change of one part leaves the others alone


@dataclass(frozen=True)
class Viewer:
    """Makes 8-bit images of levels [samples, beams], in this order: a gain in dB, uniform from `gain_db` and the same
    for the whole image; the law of `display`; beams that are black, each one with the probability `lost_beams`; and
    compression as JPEG, with a whole quality, uniform from `jpeg_quality`, or with the tables `jpeg_tables` of a file
    (Pillow's `image.quantization`). Compression needs Pillow.
    """

    display: Display = Display()
    gain_db: Tuple[float, float] = (0.0, 0.0)
    lost_beams: float = 0.0
    jpeg_quality: Optional[Tuple[int, int]] = None
    jpeg_tables: Optional[Dict[int, Sequence[int]]] = None

    def __post_init__(self) -> None:
        if self.gain_db[0] > self.gain_db[1]:
            raise ValueError(f"gain_db: {self.gain_db}; expected the smaller gain first")
        if not 0 <= self.lost_beams <= 1:
            raise ValueError(f"lost_beams: {self.lost_beams}; expected a probability from 0 to 1")
        if self.jpeg_quality is not None and not 1 <= self.jpeg_quality[0] <= self.jpeg_quality[1] <= 95:
            raise ValueError(f"jpeg_quality: {self.jpeg_quality}; expected two numbers from 1 to 95, the smaller first")
        if self.jpeg_quality is not None and self.jpeg_tables is not None:
            raise ValueError("jpeg_quality and jpeg_tables are both given; expected one of them")

    def image(self, level_db: np.ndarray, key: Sequence[int] = (), step_m: float = 1.0, absorption_db_m: float = 0.0,
              first_m: float = 0.0) -> np.ndarray:
        """uint8 of polar levels; the same for the same `key`, such as (seed, sequence, ping). The other arguments are
        those of `Display.grey`."""
        gain_db = self.display.gain_db + self._random(GAIN, key).uniform(*self.gain_db)
        display = dataclasses.replace(self.display, gain_db=gain_db)
        gray = display.grey(level_db, step_m, absorption_db_m, first_m)
        if self.lost_beams:
            gray[:, self._random(LOST, key).random(gray.shape[1]) < self.lost_beams] = 0
        if self.jpeg_tables is not None:
            return compressed(gray, qtables=self.jpeg_tables)
        if self.jpeg_quality is not None:
            low, high = self.jpeg_quality
            return compressed(gray, quality=int(self._random(QUALITY, key).integers(low, high + 1)))
        return gray

    @staticmethod
    def _random(stream: int, key: Sequence[int]) -> np.random.Generator:
        return np.random.default_rng([*key, stream])


def redrawn(image: np.ndarray, range_m: np.ndarray, azimuth_rad: np.ndarray, rows_m: np.ndarray,
            columns_rad: np.ndarray) -> np.ndarray:
    """An image [samples, beams], such as levels or a mask, as it comes back from a fan-shaped display image that was made
    polar again: [rows, columns].

    The display image has square pixels that are as long as a row, one of them at the sonar, and each pixel shows the
    nearest sample and beam. Each row and column has the value of the nearest pixel. So some samples and beams appear
    twice, and others not at all. `range_m` and `rows_m` have equal steps, and `azimuth_rad` increases; places outside
    have the value of the first or last sample or beam.
    """
    pixel_m = rows_m[1] - rows_m[0]
    row_m, column_rad = rows_m[:, None], columns_rad[None, :]
    ahead_m = np.rint(row_m * np.cos(column_rad) / pixel_m) * pixel_m
    across_m = np.rint(row_m * np.sin(column_rad) / pixel_m) * pixel_m
    places = (np.hypot(ahead_m, across_m) - range_m[0]) / (range_m[1] - range_m[0])
    sample = np.clip(np.rint(places).astype(int), 0, len(range_m) - 1)
    beam = np.searchsorted((azimuth_rad[1:] + azimuth_rad[:-1]) / 2, np.arctan2(across_m, ahead_m))
    return image[sample, beam]


def compressed(gray: np.ndarray, **options: object) -> np.ndarray:
    """The image as it is read back from a JPEG file in color, as displays are stored; `options` of Pillow's encoder."""
    try:
        from PIL import Image  # type: ignore[import]
    except ImportError as error:
        raise DatasetError("compressing as JPEG needs Pillow (python3-pil)") from error
    buffer = io.BytesIO()
    Image.fromarray(gray).convert("RGB").save(buffer, "JPEG", **options)
    with Image.open(buffer) as image:
        return np.array(image.convert("L"))
