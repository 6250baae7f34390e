"""The camera of a sequence, and its image at a ping. Every array is read when it is asked for."""
from __future__ import annotations

from typing import TYPE_CHECKING, Dict, NamedTuple, Optional, Tuple

import numpy as np

from .files import DatasetError, read_exr, read_png
from .manifest import OUTPUTS, missing, read_row, told_of
from .projection import project, unproject

if TYPE_CHECKING:
    from .dataset import Ping, Pose, SequenceFolder

# The planes by name, and what each appends to a ping's stem.
_FILES = {row["name"]: f"{row['file']}.exr" if np.dtype(row["type"]).kind == "f" else f"_{row['name']}.png"
          for row in OUTPUTS["camera"]}


class Camera:
    """Pixels and points: a pinhole with the distortion of OpenCV. Pixel (0, 0) is the center of the first one; the
    frame is x to the right of the image, y down, z along the axis of view."""

    def __init__(self, sequence: "SequenceFolder"):
        if "camera" not in sequence.info:
            raise DatasetError(f"{sequence.folder}: the data set has no camera; expected the section camera in its scenario")
        with told_of(sequence.folder / "sequence.json"):
            info = sequence.info["camera"]
            self.width_px, self.height_px = int(info["width_px"]), int(info["height_px"])
            self.matrix = np.array([[info["focal_x_px"], 0, info["center_x_px"]],
                                    [0, info["focal_y_px"], info["center_y_px"]], [0, 0, 1]], float)
            self.distortion = np.array([info["distortion"][key] for key in ("k1", "k2", "p1", "p2", "k3")], float)
            self._place = (np.array(info["in_sonar"]["position_m"]), np.array(info["in_sonar"]["quaternion_wxyz"]))

    @property
    def in_sonar(self) -> "Pose":
        """The camera's frame in that of the sonar."""
        from .dataset import Pose
        return Pose(*self._place)

    def distort(self, points: np.ndarray) -> np.ndarray:
        """[..., 2], points x / z, y / z to those of a distorted image."""
        x, y = np.moveaxis(np.asarray(points, float), -1, 0)
        k1, k2, p1, p2, k3 = self.distortion
        r2 = x * x + y * y
        s = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.stack([s * x + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                         s * y + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y], axis=-1)

    def undistort(self, points: np.ndarray) -> np.ndarray:
        """The inverse of `distort` in the image, to 1e-12."""
        target = np.asarray(points, float)
        found = np.zeros_like(target)
        if not self.distortion.any():
            return target.copy()
        for share in np.arange(1, 9) / 8:
            for _ in range(12):
                step = 1e-7
                rest = share * target - self.distort(found)
                by_x = (self.distort(found + [step, 0]) - self.distort(found - [step, 0])) / (2 * step)
                by_y = (self.distort(found + [0, step]) - self.distort(found - [0, step])) / (2 * step)
                area = by_x[..., 0] * by_y[..., 1] - by_y[..., 0] * by_x[..., 1]
                found += np.stack([by_y[..., 1] * rest[..., 0] - by_y[..., 0] * rest[..., 1],
                                   by_x[..., 0] * rest[..., 1] - by_x[..., 1] * rest[..., 0]], axis=-1) / area[..., None]
                if np.abs(rest).max(initial=0) < 1e-13:
                    break
        return found

    def project(self, points_m: np.ndarray) -> np.ndarray:
        """float64 [..., 2], column and row of points [..., 3] in the camera's frame; NaN behind the camera. Places may
        lie outside of the image, and nothing says whether something else hides a point."""
        points = np.asarray(points_m, float)
        with np.errstate(invalid="ignore", divide="ignore"):
            plane = np.where(points[..., 2:] > 0, points[..., :2] / points[..., 2:], np.nan)
            return self.distort(plane) * [self.matrix[0, 0], self.matrix[1, 1]] + self.matrix[:2, 2]

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """float64 [..., 3] with z = 1: a depth times the ray of a pixel [..., 2] (column, row) is its point."""
        plane = (np.asarray(pixels, float) - self.matrix[:2, 2]) / [self.matrix[0, 0], self.matrix[1, 1]]
        return np.concatenate([self.undistort(plane), np.ones(plane.shape[:-1] + (1,))], axis=-1)


class SonarPlace(NamedTuple):
    """Where points are in the polar image, with fractions (see `projection.project`)."""

    range_m: np.ndarray
    sample: np.ndarray
    beam: np.ndarray
    elevation_rad: np.ndarray


class CameraImage:
    """Maps [rows, columns] of what each pixel shows (`camera`), the top row first; NaN and 0: no surface.

    What the data set does not hold is a DatasetError; `has` asks before.
    """

    def __init__(self, ping: "Ping"):
        self.ping = ping
        self._channels: Dict[str, Dict[str, np.ndarray]] = {}

    @property
    def camera(self) -> Camera:
        return self.ping.sequence.camera

    @property
    def pose(self) -> "Pose":
        """The camera's frame in the world."""
        return self.ping.pose @ self.camera.in_sonar

    @property
    def depth_m(self) -> np.ndarray:
        """float32: z of the point in the camera's frame."""
        return self._stored("depth_m")

    @property
    def normal(self) -> np.ndarray:
        """float32 [rows, columns, 3]: unit normal of the surface, camera frame, toward the camera."""
        return np.stack([self._stored(f"normal_{axis}") for axis in "xyz"], axis=-1)

    @property
    def instance(self) -> np.ndarray:
        """int32 instance ids."""
        return self._stored("instance").astype(np.int32)

    @property
    def semantic(self) -> np.ndarray:
        """int32 class ids; id k is `classes[k - 1]`."""
        return self._stored("semantic").astype(np.int32)

    @property
    def color(self) -> np.ndarray:
        """uint8 [rows, columns, 3]: red, green and blue, sRGB."""
        return self._stored("color")

    @property
    def flow_px(self) -> np.ndarray:
        """float32 [rows, columns, 2]: motion of each pixel's point to the next ping, to the right and down; NaN: none."""
        return np.stack([self._stored("flow_x_px"), self._stored("flow_y_px")], axis=-1)

    @property
    def position_m(self) -> np.ndarray:
        """float64 [rows, columns, 3]: the points in the camera's frame."""
        camera = self.camera
        columns, rows = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
        return self.depth_m[..., None] * camera.rays(np.stack([columns, rows], axis=-1))

    def _in_sonar(self, ping: "Optional[Ping]") -> "Tuple[np.ndarray, np.ndarray, SequenceFolder]":
        """Rotation and position of the camera's frame in that of the sonar, and the sonar's sequence."""
        if ping is not None:
            sonar, own = ping.pose, self.pose
            return sonar.rotation.T @ own.rotation, (own.position_m - sonar.position_m) @ sonar.rotation, ping.sequence
        if "sonar" not in self.ping.sequence.info:
            raise DatasetError(f"{self.ping.sequence.folder}: a camera of a rig; expected a ping of one of its sonars")
        return self.camera.in_sonar.rotation, self.camera.in_sonar.position_m, self.ping.sequence

    def to_sonar(self, ping: "Optional[Ping]" = None) -> SonarPlace:
        """The place of each pixel's point in the polar image of its ping, or of a ping of a sonar on the same rig as if
        nothing else moved meanwhile, [rows, columns]."""
        rotation, position_m, sequence = self._in_sonar(ping)
        points = self.position_m @ rotation.T + position_m
        sample, beam, elevation = project(points, sequence)
        return SonarPlace(np.linalg.norm(points, axis=-1), sample, beam, elevation)

    def from_sonar(self, sample: np.ndarray, beam: np.ndarray, elevation_rad: np.ndarray,
                   ping: "Optional[Ping]" = None) -> Tuple[np.ndarray, np.ndarray]:
        """Of places in the polar image, of `ping` as in `to_sonar`, with their elevation (`ping.polar.elevation_rad`,
        ...): float64 [..., 2], column and row in this image, and whether the pixel there shows the point, and nothing
        in front of it, to 5 % of its depth."""
        rotation, position_m, sequence = self._in_sonar(ping)
        points = (unproject(sample, beam, elevation_rad, sequence) - position_m) @ rotation
        pixels = self.camera.project(points)
        camera = self.camera
        with np.errstate(invalid="ignore"):
            column, row = np.moveaxis(np.nan_to_num(np.rint(pixels), nan=-1, posinf=-1, neginf=-1), -1, 0)
            inside = (column >= 0) & (row >= 0) & (column < camera.width_px) & (row < camera.height_px)
            depth = self.depth_m[np.where(inside, row, 0).astype(int), np.where(inside, column, 0).astype(int)]
            return pixels, inside & (np.abs(depth - points[..., 2]) <= 0.05 * points[..., 2])

    def has(self, name: str) -> bool:
        """Whether the data set holds the array of that name."""
        plane = {"normal": "normal_x", "position_m": "depth_m", "flow_px": "flow_x_px"}.get(name, name)
        return plane in _FILES and any(path.exists() for path in self._paths(plane))

    def _paths(self, plane: str) -> Tuple:
        folder = self.ping.sequence.folder
        return folder / f"camera_{plane}.npy", folder / "camera" / f"{self.ping.stem}{_FILES[plane]}"

    def _stored(self, name: str) -> np.ndarray:
        packed, single = self._paths(name)
        if packed.exists():
            return np.array(read_row(packed, self.ping.row))
        if not single.exists():
            raise missing(single, f"camera {name}")
        if single.suffix == ".png":
            return read_png(single)
        if single.name not in self._channels:
            self._channels[single.name] = read_exr(single, 0)
        with told_of(single):
            return self._channels[single.name][name]
