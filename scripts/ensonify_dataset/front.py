"""The front view of a ping: the surface that each ray meets first. Every array is read when it is asked for."""
from __future__ import annotations

from typing import TYPE_CHECKING, Dict

import numpy as np

from .files import read_exr, read_png
from .manifest import OUTPUTS, missing, read_row, told_of

if TYPE_CHECKING:
    from .dataset import Ping


# The planes by name: whether each has float channels, in one EXR file.
_PLANES = {row["name"]: np.dtype(row["type"]).kind == "f" for row in OUTPUTS["front"]}


class FrontView:
    """Maps [elevations, azimuths] (`output.front`): lowest elevation and starboard first; NaN and 0: no surface.

    What the data set does not hold is a DatasetError; `has` asks before.
    """

    def __init__(self, ping: "Ping"):
        self.ping = ping
        self._channels: Dict[str, np.ndarray] = {}

    @property
    def elevation_rad(self) -> np.ndarray:
        """float64 [elevations] of the rays, positive up."""
        return self.ping.sequence.front_elevation_rad

    @property
    def azimuth_rad(self) -> np.ndarray:
        """float64 [azimuths] of the rays, positive to port."""
        return self.ping.sequence.front_azimuth_rad

    @property
    def range_m(self) -> np.ndarray:
        """float32, slant range; with refraction c times the one-way travel time."""
        return self._stored("range_m")

    @property
    def normal(self) -> np.ndarray:
        """float32 [elevations, azimuths, 3]: unit normal of the surface, sonar frame, towards the sonar."""
        return np.stack([self._stored(f"normal_{axis}") for axis in "xyz"], axis=-1)

    @property
    def backscatter_db(self) -> np.ndarray:
        """float32: backscatter per unit of surface at the ray's incidence, dB re 1 m^2/m^2; -99: none."""
        return self._stored("backscatter_db")

    @property
    def instance(self) -> np.ndarray:
        """int32 instance ids."""
        return self._stored("instance").astype(np.int32)

    @property
    def semantic(self) -> np.ndarray:
        """int32 class ids; id k is `classes[k - 1]`."""
        return self._stored("semantic").astype(np.int32)

    @property
    def position_m(self) -> np.ndarray:
        """float64 [elevations, azimuths, 3]: the points in the sonar frame; not for refracted rays."""
        elevation, azimuth = self.elevation_rad[:, None], self.azimuth_rad[None, :]
        direction = np.stack(np.broadcast_arrays(np.cos(elevation) * np.cos(azimuth),
                                                 np.cos(elevation) * np.sin(azimuth), np.sin(elevation)), axis=-1)
        return self.range_m[..., None] * direction

    def has(self, name: str) -> bool:
        """Whether the data set holds the array of that name."""
        folder, stem = self.ping.sequence.folder, self.ping.stem
        plane = "normal_x" if name == "normal" else "range_m" if name == "position_m" else name
        if plane not in _PLANES:
            return False
        single = f"{stem}.exr" if _PLANES[plane] else f"{stem}_{plane}.png"
        return (folder / f"front_{plane}.npy").exists() or (folder / "front" / single).exists()

    def _stored(self, name: str) -> np.ndarray:
        folder, stem = self.ping.sequence.folder, self.ping.stem
        packed = folder / f"front_{name}.npy"
        if packed.exists():
            return np.array(read_row(packed, self.ping.row))
        is_float = _PLANES[name]
        single = folder / "front" / (f"{stem}.exr" if is_float else f"{stem}_{name}.png")
        if not single.exists():
            raise missing(single, f"front {name}")
        if not is_float:
            return read_png(single)
        if not self._channels:
            self._channels = read_exr(single, 0)
        with told_of(single):
            return self._channels[name]
