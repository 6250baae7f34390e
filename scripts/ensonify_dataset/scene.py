"""What a sequence holds over all its pings: tracks of the instances, and heights of the scene."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from .files import DatasetError, read_npy
from .manifest import missing, read_table, told_of

if TYPE_CHECKING:
    from .dataset import SequenceFolder


class HeightMap(NamedTuple):
    """Heights in the world: point (row, column) lies at x_m[column], y_m[row]."""

    height_m: np.ndarray  # float32 [rows, columns]; NaN: no surface
    x_m: np.ndarray       # [columns], west first
    y_m: np.ndarray       # [rows], north first


@dataclass(frozen=True)
class Track:
    """An instance in the pings of its sequence; arrays have a row for each ping of `pings`.

    The pose is that of the object, and the box lies around the whole instance; both are in the world, and NaN where
    there is none: volumes have no pose, planes, point targets and unbounded volumes no box.
    """

    instance: int
    name: str
    class_id: int
    class_name: str
    pings: np.ndarray              # int [pings]
    time_s: np.ndarray             # float [pings]
    position_m: np.ndarray         # float [pings, 3]
    quaternion_wxyz: np.ndarray    # float [pings, 4]
    box_position_m: np.ndarray     # float [pings, 3], of the center
    box_quaternion_wxyz: np.ndarray  # float [pings, 4]
    box_size_m: np.ndarray         # float [pings, 3], along its own axes
    bbox: np.ndarray               # int [pings, 4]: x, y, width, height of the mask; 0 where it is not seen
    area: np.ndarray               # int [pings]: pixels of the mask
    amodal_area: np.ndarray        # int [pings]: ... if everything else were transparent; 0 without `output.amodal`

    @property
    def seen(self) -> np.ndarray:
        """bool [pings]: whether the image shows the instance."""
        return self.area > 0


def _numbers(row: Dict[str, str], keys: Tuple[str, ...]) -> List[float]:
    return [float(row[key]) for key in keys]


def _empty(instance: Dict[str, Any], classes: List[str], pings: np.ndarray, time_s: np.ndarray) -> Track:
    def nan(width: int) -> np.ndarray:
        return np.full((len(pings), width), np.nan)

    count, class_id = len(pings), instance["class_id"]
    return Track(instance["id"], instance["name"], class_id, classes[class_id - 1], pings, time_s, nan(3), nan(4),
                 nan(3), nan(4), nan(3), np.zeros((count, 4), int), np.zeros(count, int), np.zeros(count, int))


def _row_of(ping: int, pings: range) -> int:
    if ping not in pings:
        raise ValueError(f"ping {ping} is none of this sequence")
    return ping - pings.start


def _add_poses(sequence: "SequenceFolder", tracks: Dict[int, Track]) -> None:
    with told_of(sequence.folder / "objects.csv"):
        for ping, rows in sequence.object_rows.items():
            for row in rows:
                track, i = tracks[int(row["instance"])], _row_of(ping, sequence.pings)
                track.position_m[i] = _numbers(row, ("x", "y", "z"))
                track.quaternion_wxyz[i] = _numbers(row, ("qw", "qx", "qy", "qz"))


def _add_boxes(sequence: "SequenceFolder", tracks: Dict[int, Track]) -> None:
    path = sequence.folder / "boxes.csv"
    with told_of(path):
        for row in read_table(path):
            track, i = tracks[int(row["instance"])], _row_of(int(row["ping"]), sequence.pings)
            track.box_size_m[i] = _numbers(row, ("size_x", "size_y", "size_z"))
            track.box_position_m[i] = _numbers(row, ("x", "y", "z"))
            track.box_quaternion_wxyz[i] = _numbers(row, ("qw", "qx", "qy", "qz"))


def _add_masks(sequence: "SequenceFolder", tracks: Dict[int, Track], view: str) -> None:
    path = sequence.folder / "annotations.jsonl"
    for i, ping in enumerate(sequence.pings):
        with told_of(path):
            image = next((image for image in sequence.annotated_images(ping) if image["view"] == view), None)
        if image is None:
            raise missing(path, f"masks of {view} images")
        with told_of(path):
            for mask in image["annotations"]:
                track = tracks[mask["instance"]]
                track.bbox[i], track.area[i] = mask["bbox"], mask["area"]
                track.amodal_area[i] = mask.get("amodal_area", 0)
            for mask in image.get("hidden", []):
                tracks[mask["instance"]].amodal_area[i] = mask["amodal_area"]


def _first_view(sequence: "SequenceFolder") -> Optional[str]:
    with told_of(sequence.folder / "annotations.jsonl"):
        views = {image["view"] for image in sequence.annotated_images(sequence.pings.start)} if sequence.pings else set()
    return next((view for view in ("polar", "cartesian") if view in views), None)


def tracks_of(sequence: "SequenceFolder", view: Optional[str]) -> Dict[int, Track]:
    if view not in ("polar", "cartesian", None):
        raise DatasetError(f"no view {view!r}; expected polar or cartesian")
    pings = np.array(sequence.pings, int)
    with told_of(sequence.folder / "poses.csv"):
        time_s = np.array([float(row["time_s"]) for row in sequence.pose_rows])
    with told_of(sequence.folder / "sequence.json"):
        info = sequence.info
        tracks = {instance["id"]: _empty(instance, info["classes"], pings, time_s) for instance in info["instances"]}
    _add_poses(sequence, tracks)
    _add_boxes(sequence, tracks)
    view = view or _first_view(sequence)
    if view:
        _add_masks(sequence, tracks, view)
    return tracks


def height_map_of(sequence: "SequenceFolder") -> HeightMap:
    path = sequence.folder / "height_map.npy"
    if not path.exists():
        raise missing(path, "height map")
    height_m = np.array(read_npy(path))
    with told_of(sequence.folder / "sequence.json"):
        grid = sequence.info["height_map"]
        if height_m.shape != (grid["rows"], grid["columns"]):
            raise ValueError(f"not the {grid['rows']} x {grid['columns']} points of sequence.json")
        rows, columns = np.arange(grid["rows"]), np.arange(grid["columns"])
        return HeightMap(height_m, grid["x_west_m"] + columns * grid["spacing_m"],
                         grid["y_north_m"] - rows * grid["spacing_m"])
