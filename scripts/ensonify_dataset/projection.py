"""The projection of a multibeam sonar, and images of motion."""
from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Optional

import numpy as np

if TYPE_CHECKING:
    from .dataset import SequenceFolder


class Projected(NamedTuple):
    """Places in a polar image, with fractions: sample 0 and beam 0 are the middles of the first pixels. The sonar
    does not measure the elevation."""

    sample: np.ndarray
    beam: np.ndarray
    elevation_rad: np.ndarray


def _place(values: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Linear between the values of the axis, and beyond its ends with the first and the last step. An axis of one
    value, as of a sonar with one beam, has no step: all places are 0."""
    if len(axis) < 2:
        return np.zeros(np.shape(values))
    low = np.clip(np.searchsorted(axis, values, side="right") - 1, 0, len(axis) - 2)
    return low + (values - axis[low]) / (axis[low + 1] - axis[low])


def _value(places: np.ndarray, axis: np.ndarray) -> np.ndarray:
    low = np.clip(np.floor(places), 0, len(axis) - 2).astype(int)
    return axis[low] + (places - low) * (axis[low + 1] - axis[low])


def project(points_m: np.ndarray, sequence: "SequenceFolder") -> Projected:
    """Points [..., 3] in the sonar's frame (x along the boresight, y to port, z up) to the polar image, along straight
    lines. For points of the world: `project((p - ping.pose.position_m) @ ping.pose.rotation, ping.sequence)`. Places
    may lie outside of the image, and nothing says whether something else hides a point."""
    x, y, z = np.moveaxis(np.asarray(points_m, float), -1, 0)
    range_m = np.sqrt(x * x + y * y + z * z)
    with np.errstate(invalid="ignore", divide="ignore"):
        elevation = np.arcsin(z / range_m)
    return Projected(_place(range_m, sequence.range_m), _place(np.arctan2(y, x), sequence.azimuth_rad), elevation)


def unproject(sample: np.ndarray, beam: np.ndarray, elevation_rad: np.ndarray,
              sequence: "SequenceFolder") -> np.ndarray:
    """float64 [..., 3], the points in the sonar's frame: the inverse of `project`."""
    range_m = _value(np.asarray(sample, float), sequence.range_m)
    azimuth = _value(np.asarray(beam, float), sequence.azimuth_rad)
    level = range_m * np.cos(elevation_rad)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), range_m * np.sin(elevation_rad)], axis=-1)


def flow_to_image(motion_samples: np.ndarray, motion_beams: np.ndarray, largest: Optional[float] = None) -> np.ndarray:
    """uint8 [..., 3]: the hue is the direction of the motion in pixels, the saturation its length against `largest`
    (by default that of the longest), white at rest; black where there is no motion (NaN)."""
    length = np.hypot(motion_samples, motion_beams)
    known = np.isfinite(length)
    if largest is None:
        largest = float(length[known].max()) if known.any() else 1.0
    hue = np.arctan2(motion_samples, motion_beams) / (2 * np.pi)
    saturation = np.clip(length / (largest if largest > 0 else 1.0), 0, 1)
    wheel = np.clip(np.abs((hue[..., None] * 6 + np.array([0.0, 4.0, 2.0])) % 6 - 3) - 1, 0, 1)
    color = 1 - saturation[..., None] * (1 - wheel)
    return np.where(known[..., None], np.round(255 * np.nan_to_num(color)), 0).astype(np.uint8)
