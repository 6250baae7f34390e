"""Levels and series made ready for a network: arrays in, arrays out."""
from __future__ import annotations

import numpy as np

NO_ENERGY_DB = -99.0


def to_db(series: np.ndarray) -> np.ndarray:
    """Level of a time series in dB re 1 uPa, float32; -99 where there is no energy."""
    with np.errstate(divide="ignore"):
        level = 20 * np.log10(np.abs(np.asarray(series)).astype(np.float64)) + 120
    return np.maximum(level, NO_ENERGY_DB).astype(np.float32)


def to_grey(level_db: np.ndarray, black_db: float, white_db: float) -> np.ndarray:
    """uint8, linear in dB from black (0) to white (255), rounded as the pictures in `png/` are."""
    scaled = (np.asarray(level_db, np.float64) - black_db) * (255.0 / (white_db - black_db))
    return np.floor(np.clip(scaled, 0, 255) + 0.5).astype(np.uint8)


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
