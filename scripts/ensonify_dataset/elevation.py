"""The echo power of a ping over elevation, and the expected image that beams and pulse make of it."""
from __future__ import annotations

from typing import TYPE_CHECKING, Optional, Tuple

import numpy as np

from .files import DatasetError

if TYPE_CHECKING:
    from .dataset import SequenceFolder

_FINE = 16  # points of the grid of delays in a sample
_POINTS = 8  # ... between which a delay is shared out
_BEAMS = 32  # transformed at once


class ElevationEchoes:
    """A list of echoes (`output.elevation`), one row for each range bin, beam cell, step of elevation, surface and
    path, before the pulse and the beams spread them. An echo that lies between two samples has its exact delay in
    `offset`; rows whose delays differ by a 128th of a sample or more are apart, so that a bin may have several rows.
    """

    def __init__(self, sequence: "SequenceFolder", rows: np.ndarray):
        self.sequence, self.rows = sequence, rows

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, which: np.ndarray) -> "ElevationEchoes":
        """Some of the rows: `echoes[echoes.path == 0]` are the direct ones, without multipath."""
        return ElevationEchoes(self.sequence, self.rows[which])

    @property
    def step_rad(self) -> float:
        return float(self.sequence.info["elevation"]["step_rad"])

    @property
    def sample(self) -> np.ndarray:
        """int32, the nearest sample; echoes that begin outside of the record have samples outside of the image."""
        return self.rows["sample"]

    @property
    def beam(self) -> np.ndarray:
        """uint16, the cell between the middles of adjacent beams in which the echo arrives."""
        return self.rows["beam"]

    @property
    def step(self) -> np.ndarray:
        """int16: elevations from `step` to `step + 1` times `step_rad`."""
        return self.rows["step"]

    @property
    def elevation_rad(self) -> np.ndarray:
        """float64, the middle of the step."""
        return (self.rows["step"] + 0.5) * self.step_rad

    @property
    def offset(self) -> np.ndarray:
        """float32 from `sample` to the delay, in samples."""
        return self.rows["offset"]

    @property
    def diffuse_pa2(self) -> np.ndarray:
        """float32, the expected power of echoes with random amplitudes, at the peak of the pulse; powers add."""
        return self.rows["diffuse_pa2"]

    @property
    def coherent_pa(self) -> np.ndarray:
        """complex64, the sum of the pressures of echoes with fixed amplitudes, such as glints and point targets, at
        the peak of the pulse and with the phase of the carrier. Pressures of different rows add before they are
        squared: the pieces of a glint cancel except around the specular point."""
        return self.rows["coherent_pa"]

    @property
    def instance(self) -> np.ndarray:
        """uint16 instance ids."""
        return self.rows["instance"]

    @property
    def path(self) -> np.ndarray:
        """uint16, 0: direct; others are `paths` of sequence.json."""
        return self.rows["path"]

    def dense(self, steps: Optional[range] = None) -> Tuple[np.ndarray, np.ndarray]:
        """float32 [samples, beams, steps] and float64 [steps], the middles of the steps in radians, lowest first. The
        powers of both kinds in Pa^2: the sum of `diffuse_pa2`, and the square of the sum of `coherent_pa`. `steps` are
        those of the fan by default; echoes outside of them or of the record are left out."""
        if steps is None:
            half_rad = self.sequence.info["sonar"]["elevation"]["fan_rad"] / 2
            last = int(np.ceil(half_rad / self.step_rad - 1e-6))
            steps = range(-last, last)
        shape = len(self.sequence.range_m), len(self.sequence.azimuth_rad), len(steps)
        place = self.sample, self.beam.astype(int), self.step.astype(int) - steps.start
        inside = np.all([(at >= 0) & (at < size) for at, size in zip(place, shape)], axis=0)
        cell = tuple(at[inside] for at in place)
        power = np.zeros(shape, np.float32)
        np.add.at(power, cell, self.diffuse_pa2[inside])
        pressure = np.zeros(shape, np.complex64)
        np.add.at(pressure, cell, self.coherent_pa[inside])
        return power + np.abs(pressure) ** 2, (np.arange(steps.start, steps.stop) + 0.5) * self.step_rad

    def expected_power(self) -> np.ndarray:
        """float64 [samples, beams], Pa^2: what the pulse and the beams make of the sum of `diffuse_pa2` over elevation.
        For all rows, a scene without fixed amplitudes, and volumes in the list, the level of this is `clean_db`."""
        spread = self.sequence.power_spread
        if spread is None:
            raise DatasetError("the beams of an array of elements (sonar.receiver.mode array) depend on the range and "
                               "the elevation of each echo; there is no table for them")
        beam_power, pulse_power = spread
        beams, samples, period = len(beam_power), len(self.sequence.range_m), len(pulse_power)
        cells = np.empty((beams, samples))
        for first in range(0, beams, _BEAMS):
            last = min(first + _BEAMS, beams)
            cells[first:last] = self._cells(first, last, pulse_power)[:, :samples]
        return np.maximum(beam_power.astype(float) @ cells, 0).T

    def _cells(self, first: int, last: int, pulse_power: np.ndarray) -> np.ndarray:
        """[cells, period] of the beam cells from `first` to `last`: sums of A_k e^(i 2 pi k n / M)."""
        period = len(pulse_power)
        mine = (self.beam >= first) & (self.beam < last)
        grid = np.zeros((last - first) * period * _FINE)
        delay = _FINE * (self.sample[mine] + self.offset[mine].astype(float))
        base = np.floor(delay).astype(int)
        row = (self.beam[mine].astype(int) - first) * period * _FINE
        for point, weight in enumerate(_shares(delay - base)):
            column = (base + point - (_POINTS // 2 - 1)) % (period * _FINE)
            grid += np.bincount(row + column, weight * self.diffuse_pa2[mine], len(grid))
        coefficients = np.fft.rfft(grid.reshape(last - first, -1), axis=1)[:, :period] * pulse_power
        coefficients[:, 1:] *= 2
        return np.fft.ifft(coefficients, axis=1).real * period


def _shares(place: np.ndarray) -> np.ndarray:
    """[points, n]: Lagrange's weights of points -3 .. 4 for places from 0 to 1. Those of a sum of powers give its
    spectrum as Lagrange's interpolation of a phasor does."""
    points = np.arange(_POINTS) - (_POINTS // 2 - 1)
    weights = np.ones((_POINTS, len(place)))
    for i, at in enumerate(points):
        for other in points:
            if other != at:
                weights[i] *= (place - other) / (at - other)
    return weights
