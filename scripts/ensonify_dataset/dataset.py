"""Data sets, sequences and pings. Every array is read when it is asked for."""
from __future__ import annotations

import json
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from .camera import Camera, CameraImage
from .elevation import ElevationEchoes
from .files import DatasetError, read_bytes, read_exr, read_npy
from .footprints import Footprints
from .front import FrontView
from .manifest import listed_pings, missing, need_finished, read_manifest, read_row, read_table, render_name, told_of
from .navigation import navigation_of
from .recorded import level_of_counts, recorded_counts, row_gain
from .scene import HeightMap, Track, height_map_of, tracks_of
from .statistics import Statistics, statistics_of
from .transforms import Display
from .views import View

SPLITS = ("train", "val", "test")


@dataclass(frozen=True)
class Pose:
    """A frame in the world: p_world = rotation @ p + position_m."""

    position_m: np.ndarray
    quaternion_wxyz: np.ndarray

    @property
    def rotation(self) -> np.ndarray:
        w, x, y, z = self.quaternion_wxyz
        return np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ])

    def __matmul__(self, inner: "Pose") -> "Pose":
        """The pose of a frame that is given in this one."""
        (aw, ax, ay, az), (bw, bx, by, bz) = self.quaternion_wxyz, inner.quaternion_wxyz
        return Pose(self.rotation @ inner.position_m + self.position_m,
                    np.array([aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
                              aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw]))


def _pose(row: Dict[str, str]) -> Pose:
    return Pose(np.array([float(row[key]) for key in ("x", "y", "z")]),
                np.array([float(row[key]) for key in ("qw", "qx", "qy", "qz")]))


class Ping:
    """One ping: its series, its images `polar` and `cartesian`, its `front` view, its image of the `camera`, and where everything was."""

    def __init__(self, sequence: "SequenceFolder", number: int):
        self.sequence, self.number = sequence, number
        self.row = number - sequence.pings.start
        self.stem = f"{number:06}"
        self.polar, self.cartesian = View(self, "polar"), View(self, "cartesian")
        self.front = FrontView(self)
        self.camera = CameraImage(self)

    @property
    def series(self) -> np.ndarray:
        """complex64 [beams, samples], Pa, baseband; memory-mapped where it is kept as NPY."""
        single = self.sequence.folder / "timeseries" / f"{self.stem}.npy"
        picture = single.with_suffix(".exr")
        if not picture.exists() or single.exists():
            return self._array(self.sequence.folder / "timeseries.npy", single, "time series")
        channels = read_exr(picture)
        series = np.empty(channels["p.re"].T.shape, np.complex64)
        series.real, series.imag = channels["p.re"].T, channels["p.im"].T
        return series

    def layer(self, name: str) -> np.ndarray:
        """As `series`: what it adds up from, "noise", "volume", ... (`output.layers`)."""
        folder = self.sequence.folder
        single = folder / "layers" / f"{self.stem}_{name}.npy"
        return self._array(folder / f"layers_{name}.npy", single, f"layer {name}")

    @property
    def channels(self) -> np.ndarray:
        """complex64 [elements, samples], Pa: what each element hears (`output.channels`)."""
        folder = self.sequence.folder
        single = folder / "channels" / f"{self.stem}.npy"
        return self._array(folder / "channels.npy", single, "channels")

    @property
    def elevation(self) -> ElevationEchoes:
        """The echo power over elevation (`output.elevation`)."""
        path = self.sequence.folder / "elevation" / f"{self.stem}.npy"
        if not path.exists():
            raise missing(path, "echoes over elevation")
        return ElevationEchoes(self.sequence, np.array(read_npy(path)))

    @property
    def recorded(self) -> np.ndarray:
        """uint8 or uint16 [samples, beams]: what the instrument stores (`sonar.recorder`, or a recording)."""
        return recorded_counts(self.sequence.folder, self.sequence.info, self.row, self.stem)

    @property
    def recorded_level_db(self) -> np.ndarray:
        """float32 [samples, beams]: the levels of `recorded`, without row gains; -99 for a count of 0 of amplitudes."""
        counts, gain = self.recorded, self._row_gain()
        with told_of(self.sequence.folder / "sequence.json"):
            return level_of_counts(self.sequence.info["recorder"], counts, gain)

    def _array(self, packed: Path, single: Path, what: str) -> np.ndarray:
        if packed.exists():
            return read_row(packed, self.row)
        if not single.exists():
            raise missing(single, what)
        return read_npy(single)

    @property
    def row_gain(self) -> np.ndarray:
        """float32 [samples]: amplitudes are `recorded` divided by its root."""
        gain = self._row_gain()
        if gain is None:
            raise missing(self.sequence.folder / "recorded" / f"{self.stem}_row_gain.npy", "row gains")
        return gain

    def _row_gain(self) -> Optional[np.ndarray]:
        return row_gain(self.sequence.folder, self.row, self.stem)

    @property
    def annotated_images(self) -> List[Dict[str, Any]]:
        """`images` of the ping in annotations.jsonl."""
        return self.sequence.annotated_images(self.number)

    @property
    def groups(self) -> List[Dict[str, Any]]:
        """`groups` of the ping in annotations.jsonl; empty if all beams transmit together."""
        return self.sequence.annotated_ping(self.number).get("groups", [])

    @property
    def time_s(self) -> float:
        with told_of(self.sequence.folder / "poses.csv"):
            return float(self.sequence.pose_rows[self.row]["time_s"])

    @property
    def pose(self) -> Pose:
        """The sonar in the world, its mount included."""
        with told_of(self.sequence.folder / "poses.csv"):
            return _pose(self.sequence.pose_rows[self.row])

    @property
    def object_poses(self) -> Dict[int, Pose]:
        """Objects and point targets in the world, by instance."""
        with told_of(self.sequence.folder / "objects.csv"):
            rows = self.sequence.object_rows.get(self.number, [])
            return {int(row["instance"]): _pose(row) for row in rows}

    @property
    def first_return_m(self) -> np.ndarray:
        """float32 [beams]: slant range of the nearest echo; NaN without."""
        with told_of(self.sequence.folder / "first_return_m.npy"):
            return self.sequence.first_return_m[self.row]


class SequenceFolder:
    """One sequence: `info` (its sequence.json), axes, tables; `sequence[3]` is ping 3."""

    def __init__(self, folder: Union[str, Path]):
        self.folder = Path(folder)

    def __getitem__(self, ping: int) -> Ping:
        if ping not in self.pings:
            first, last = self.pings.start, self.pings.stop - 1
            raise IndexError(f"{self.folder} has pings {first} to {last}, not {ping}")
        return Ping(self, ping)

    def __iter__(self) -> Iterator[Ping]:
        return (Ping(self, ping) for ping in self.pings)

    def __len__(self) -> int:
        return len(self.pings)

    @cached_property
    def info(self) -> Dict[str, Any]:
        return read_manifest(self.folder / "sequence.json", "ensonify_sequence")

    @property
    def number(self) -> int:
        return self.info["sequence"]

    @cached_property
    def pings(self) -> range:
        with told_of(self.folder / "sequence.json"):
            return listed_pings(self.info)[1]

    @cached_property
    def azimuth_rad(self) -> np.ndarray:
        """float64 [beams], most negative (starboard) first."""
        return np.array(read_npy(self.folder / "azimuth_rad.npy"))

    @cached_property
    def range_m(self) -> np.ndarray:
        """float64 [samples], slant range."""
        return np.array(read_npy(self.folder / "range_m.npy"))

    @cached_property
    def front_elevation_rad(self) -> np.ndarray:
        """float64 [elevations] of the rays of front views (`output.front`), lowest first."""
        return np.array(read_npy(self.folder / "front_elevation_rad.npy"))

    @cached_property
    def front_azimuth_rad(self) -> np.ndarray:
        """float64 [azimuths] of the rays of front views, starboard first."""
        return np.array(read_npy(self.folder / "front_azimuth_rad.npy"))

    @cached_property
    def camera(self) -> Camera:
        """The camera, of the section `camera`."""
        return Camera(self)

    @cached_property
    def first_return_m(self) -> np.ndarray:
        """float32 [pings, beams]."""
        return np.array(read_npy(self.folder / "first_return_m.npy"))

    @property
    def map_path(self) -> Path:
        return self.folder / "cartesian_map.npy"

    @cached_property
    def cartesian_map(self) -> np.ndarray:
        """int32 [rows, columns] of the Cartesian images: sample * beams + beam, the index of the
        pixel's polar one in a flattened plane; -1 outside the fan."""
        return np.array(read_npy(self.map_path))

    @cached_property
    def footprints(self) -> Footprints:
        """Of the pixels of 8-bit Cartesian images."""
        with told_of(self.folder / "sequence.json"):
            return Footprints(self.info, self.cartesian_map)

    @property
    def statistics(self) -> Statistics:
        """Of every pixel over all pings (`output.statistics`)."""
        return statistics_of(self.folder, self.info)

    @cached_property
    def covisibility(self) -> np.ndarray:
        """float32 [pings, pings]: the share of what a ping (row) sees that another (column) sees as well, by solid
        angle; NaN in the row of a ping that sees nothing. With `output.covisibility`."""
        path = self.folder / "covisibility.npy"
        if not path.exists():
            raise missing(path, "covisibility")
        return np.array(read_npy(path))

    @property
    def height_map(self) -> HeightMap:
        """Heights of the scene at the first ping, over the region of the fans (`output.height_map`)."""
        return height_map_of(self)

    @cached_property
    def navigation(self) -> Dict[str, np.ndarray]:
        """The tables of navigation sensors by name, such as "imu", float64 by column (`navigation`)."""
        return navigation_of(self)

    def tracks(self, view: Optional[str] = None) -> Dict[int, Track]:
        """Every instance over the pings, by its id: poses, 3-D boxes, and boxes and areas of its masks in a view, by
        default the polar one, otherwise the Cartesian one; without images they are 0."""
        return tracks_of(self, view)

    @cached_property
    def power_spread(self) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """float32 [beams, beams] and complex64 [frequencies]: how beams and pulse spread the power of echoes, with
        `output.elevation`; None for an array of elements."""
        paths = [self.folder / "beam_power.npy", self.folder / "pulse_power.npy"]
        if not paths[0].exists():
            if "elevation" in self.info:
                return None
            raise missing(paths[0], "echoes over elevation")
        return np.array(read_npy(paths[0])), np.array(read_npy(paths[1]))

    @cached_property
    def pose_rows(self) -> List[Dict[str, str]]:
        return read_table(self.folder / "poses.csv")

    @cached_property
    def object_rows(self) -> Dict[int, List[Dict[str, str]]]:
        """Rows of objects.csv by ping."""
        rows: Dict[int, List[Dict[str, str]]] = {}
        with told_of(self.folder / "objects.csv"):
            for row in read_table(self.folder / "objects.csv"):
                rows.setdefault(int(row["ping"]), []).append(row)
        return rows

    @cached_property
    def _annotation_lines(self) -> List[bytes]:
        return read_bytes(self.folder / "annotations.jsonl").splitlines()

    def annotated_ping(self, ping: int) -> Dict[str, Any]:
        """The line of the ping in annotations.jsonl."""
        with told_of(self.folder / "annotations.jsonl"):
            return json.loads(self._annotation_lines[ping - self.pings.start])

    def annotated_images(self, ping: int) -> List[Dict[str, Any]]:
        """`images` of the ping in annotations.jsonl."""
        with told_of(self.folder / "annotations.jsonl"):
            return self.annotated_ping(ping)["images"]


class SonarDataset:
    """A data set, or some of its sequences, as a list of pings.

    data[7] is the eighth ping, data[12, 3] ping 3 of sequence 12, data.split("train") the
    sequences of that split as a data set of its own.
    """

    def __init__(self, folder: Union[str, Path], sequences: Optional[Sequence[int]] = None):
        self.folder = Path(folder)
        need_finished(self.folder)
        self.info = read_manifest(self.folder / "dataset.json", "ensonify_dataset")
        with told_of(self.folder / "dataset.json"):
            listed = dict(listed_pings(entry) for entry in self.info["sequences"])
        unknown = [number for number in sequences or () if number not in listed]
        if unknown:
            raise IndexError(f"{self.folder} has no sequence {unknown[0]}")
        self.sequences = sorted(listed if sequences is None else sequences)
        self._pings = [listed[number] for number in self.sequences]
        self._ends = list(accumulate(len(pings) for pings in self._pings))
        self._opened: Dict[int, SequenceFolder] = {}

    @property
    def name(self) -> str:
        return self.info["name"]

    @property
    def classes(self) -> List[str]:
        """Names; id k is `classes[k - 1]`."""
        return self.info["classes"]

    @property
    def class_kinds(self) -> List[str]:
        """`thing` or `stuff` of each class: what has a box in exports, and what surrounds it."""
        return self.info["class_kinds"]

    @property
    def renders(self) -> List[str]:
        """Names of the renders, of `ensonify render`."""
        return sorted(path.parent.name for path in (self.folder / "renders").glob("*/render.json"))

    def display(self, render: Optional[str] = None) -> Display:
        """Of the images in `png/`, or of a render."""
        path, told = self.folder / "dataset.json", self.info.get("png")
        if render is not None:
            path = self.folder / "renders" / render_name(render) / "render.json"
            told = read_manifest(path, "ensonify_render").get("display")
        if told is None:
            raise DatasetError(f"{self.folder}: has no 8-bit images (`output.png` in scenario.yaml)")
        with told_of(path):
            return Display.of(told)

    @property
    def index(self) -> List[Tuple[int, int]]:
        """(sequence, ping) of every item, in order."""
        return [(number, ping) for number, pings in zip(self.sequences, self._pings) for ping in pings]

    def __len__(self) -> int:
        return self._ends[-1] if self._ends else 0

    def __getitem__(self, which: Union[int, Tuple[int, int]]) -> Ping:
        if isinstance(which, tuple):
            return self.sequence(which[0])[which[1]]
        item = range(len(self))[which]
        place = bisect_right(self._ends, item)
        return self.sequence(self.sequences[place])[self._pings[place][item - self._ends[place]]]

    def __iter__(self) -> Iterator[Ping]:
        return (self[i] for i in range(len(self)))

    def sequence(self, number: int) -> SequenceFolder:
        if number not in self._opened:
            if number not in self.sequences:
                raise IndexError(f"{self.folder}: sequence {number} is not in this list")
            self._opened[number] = SequenceFolder(self.folder / "sequences" / f"{number:06}")
        return self._opened[number]

    def split(self, name: str) -> "SonarDataset":
        """The sequences that splits/NAME.txt lists; it may be empty."""
        if name not in SPLITS:
            raise DatasetError(f"no split {name!r}; expected one of {', '.join(SPLITS)}")
        path = self.folder / "splits" / f"{name}.txt"
        with told_of(path):
            listed = {int(stem.split("/")[0]) for stem in read_bytes(path).decode().split()}
        return SonarDataset(self.folder, [number for number in self.sequences if number in listed])
