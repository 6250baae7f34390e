"""Data sets, sequences, pings and their pictures. Every array is read when it is asked for."""
from __future__ import annotations

import json
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from .files import DatasetError, decode_rle, read_bytes, read_exr, read_npy, read_png
from .footprints import Footprints
from .manifest import listed_pings, missing, need_finished, read_manifest, read_row, read_table, render_name, told_of
from .recorded import recorded_counts, recorded_level_db
from .statistics import Statistics, statistics_of
from .transforms import Display

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


@dataclass(frozen=True)
class Annotation:
    """An instance in a picture: bbox [x, y, width, height] and area in pixels, boolean mask.

    `truncated` is the share of its surface outside of the fan, None for planes, points and volumes; `contrast_db` its
    mean expected power over that of the ground around it, None where there is no ground.
    With `output.amodal` also its share hidden by others, and the mask that it had without them.
    """

    instance: int
    name: str
    class_id: int
    bbox: Tuple[int, ...]
    area: int
    mask: np.ndarray
    occlusion: Optional[float] = None
    amodal_mask: Optional[np.ndarray] = None
    truncated: Optional[float] = None
    contrast_db: Optional[float] = None


def _pose(row: Dict[str, str]) -> Pose:
    return Pose(np.array([float(row[key]) for key in ("x", "y", "z")]),
                np.array([float(row[key]) for key in ("qw", "qx", "qy", "qz")]))


class _Plane(property):
    """A plane of a view under the attribute's name: int32 ids of a PNG file, float32 of an EXR channel."""

    def __init__(self, kind: type, doc: str):
        super().__init__(lambda view: view._stored(self.name).astype(kind, copy=False), doc=doc)
        self.kind, self.name = kind, ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name


# What Cartesian pixels outside the fan hold, where it is not NaN.
_OUTSIDE = {"level_db": -99, "clean_db": -99, "instance_fraction": 0, "surface_count": 0}
# Planes of surfaces have a file of their own.
_SURFACES = ("surface_", "lowest_", "highest_")


class View:
    """The pictures of a ping, `polar` or `cartesian`; arrays are [rows, columns].

    Levels and angles are float32, grey is uint8, ids are int32 (PyTorch has no uint16), 0: none.
    Cartesian levels and angles that are not stored are the polar ones through the sequence's map.
    What the data set does not hold is a DatasetError; `has` asks before.
    """

    def __init__(self, ping: "Ping", kind: str):
        self.ping, self.kind = ping, kind
        self._parts: Dict[Tuple[str, int], Dict[str, np.ndarray]] = {}

    level_db = _Plane(np.float32, "Level of the series, with speckle and noise, dB re 1 uPa; -99 without energy.")
    clean_db = _Plane(np.float32, "Level of the expected power: no speckle, no noise.")
    elevation_rad = _Plane(np.float32, "Mean elevation of all echoes of the pixel, on no surface where it holds several.")
    elevation_std_rad = _Plane(np.float32, "Spread of the elevation; NaN without echo.")
    instance_fraction = _Plane(np.float32, "Share of the winning instance in the pixel's energy.")
    instance = _Plane(np.int32, "Instance ids.")
    semantic = _Plane(np.int32, "Class ids; id k is `classes[k - 1]`.")
    # With `output.surfaces`, of the pixel's instance.
    surface_elevation_rad = _Plane(np.float32, "Elevation of the strongest echo; NaN without.")
    surface_range_m = _Plane(np.float32, "Slant range of the strongest echo.")
    surface_normal_x = _Plane(np.float32, "Unit normal there, along the boresight; see `surface_normal`.")
    surface_normal_y = _Plane(np.float32, "Unit normal there, to port.")
    surface_normal_z = _Plane(np.float32, "Unit normal there, up.")
    lowest_elevation_rad = _Plane(np.float32, "Elevation of the lowest echo.")
    lowest_range_m = _Plane(np.float32, "Slant range of the lowest echo.")
    highest_elevation_rad = _Plane(np.float32, "Elevation of the highest echo.")
    highest_range_m = _Plane(np.float32, "Slant range of the highest echo.")
    surface_count = _Plane(np.float32, "Number of surfaces; 0 without echo.")
    shadow = _Plane(np.int32, "The instance whose shadow it is.")
    multipath = _Plane(np.int32, "The instance heard over mirrors, where that is more than what comes straight.")
    artifact = _Plane(np.int32, "Bits of what the electronics changed: 1 clipped, 2 streak, 4 interference, 8 leakage, "
                                "16 blanked.")

    @property
    def surface_normal(self) -> np.ndarray:
        """float32 [rows, columns, 3]: the surface's unit normal there, sonar frame, towards the sonar; NaN without."""
        return np.stack([self.surface_normal_x, self.surface_normal_y, self.surface_normal_z], axis=-1)

    @property
    def grey(self) -> np.ndarray:
        """The 8-bit image; `data.display()` says how it was made."""
        return np.array(self._stored("grey"))

    def render(self, name: str) -> np.ndarray:
        """uint8: the image that `ensonify render --name NAME` has made; its gray levels where it has colors."""
        sequence = self.ping.sequence
        folder = sequence.folder.parent.parent / "renders" / render_name(name)
        path = folder / "sequences" / sequence.folder.name / f"{self.ping.stem}_{self.kind}.png"
        if not path.exists():
            raise DatasetError(f"{path}: is not there. `ensonify render` makes it, where it has been given no "
                               "other --view or --sequences")
        return read_png(path)

    def displayed(self, display: Display) -> np.ndarray:
        """uint8: the image that `ensonify render` would make with this display, of the stored levels."""
        sequence = self.ping.sequence
        with told_of(sequence.folder / "sequence.json"):
            step_m = float(sequence.info["record"]["range_step_m"])
            first_m = float(sequence.info["record"].get("first_range_m", 0))
            alpha = float(sequence.info["water"].get("absorption_db_m", 0))  # a recording has none
        level_db = self.ping.polar.level_db
        if self.kind == "cartesian" and display.resampling == "bilinear":
            with told_of(sequence.map_path):
                if sequence.cartesian_map.max(initial=-1) >= level_db.size:
                    raise ValueError("names pixels that the polar image does not have")
            return display.flipped(display.cartesian_grey(level_db, sequence.footprints, step_m, alpha, first_m))
        grey = display.grey(level_db, step_m, alpha, first_m)
        if self.kind == "cartesian":
            pixels = sequence.cartesian_map
            with told_of(sequence.map_path):
                if pixels.max(initial=-1) >= grey.size:
                    raise ValueError("names pixels that the polar image does not have")
                grey = np.where(pixels < 0, np.uint8(0), grey.ravel()[np.maximum(pixels, 0)])
        return display.flipped(grey)

    @property
    def annotations(self) -> List[Annotation]:
        """Boxes and masks of the instances in the picture, the seabed's among them."""
        sequence = self.ping.sequence
        with told_of(sequence.folder / "sequence.json"):
            named = {i["id"]: (i["name"], i["class_id"]) for i in sequence.info["instances"]}
        found = []
        with told_of(sequence.folder / "annotations.jsonl"):
            for image in self.ping.annotated_images:
                size = image["height"], image["width"]
                for a in image["annotations"] if image["view"] == self.kind else ():
                    amodal = decode_rle(a["amodal_counts"], *size) if "amodal_counts" in a else None
                    found.append(Annotation(
                        a["instance"], *named[a["instance"]], tuple(a["bbox"]), a["area"],
                        decode_rle(a["counts"], *size), a.get("occlusion"), amodal,
                        a.get("truncated"), a.get("contrast_db")))
        return found

    def has(self, name: str) -> bool:
        """Whether the data set holds the array of that name, or the polar one that it follows from."""
        if name != "level_db" and self.is_float(name) and "recording" in self.ping.sequence.info:
            return False  # the file of labels is that of the level, too
        stored = self._packed(name).exists() or self._single(name).exists()
        return stored or self._is_mapped(name) and self.ping.polar.has(name)

    def _is_mapped(self, name: str) -> bool:
        """Whether the sequence's map makes this array of the polar one."""
        return self.kind == "cartesian" and self.is_float(name) and self.ping.sequence.map_path.exists()

    @classmethod
    def is_float(cls, name: str) -> bool:
        """Whether it is an array of levels, angles and the like, not of ids or gray levels."""
        return getattr(getattr(cls, name, None), "kind", None) is np.float32

    def _mapped(self, name: str) -> np.ndarray:
        polar, pixels = self.ping.polar._stored(name).ravel(), self.ping.sequence.cartesian_map
        with told_of(self.ping.sequence.map_path):
            if pixels.max(initial=-1) >= polar.size:
                raise ValueError("names pixels that the polar image does not have")
            outside = polar.dtype.type(_OUTSIDE.get(name, np.nan))
            return np.where(pixels < 0, outside, polar[np.maximum(pixels, 0)])

    def _packed(self, name: str) -> Path:
        return self.ping.sequence.folder / f"{self.kind}_{name}.npy"

    def _single(self, name: str) -> Path:
        folder, stem = self.ping.sequence.folder, self.ping.stem
        if name == "grey":
            return folder / "png" / f"{stem}_{self.kind}.png"
        is_mask = getattr(getattr(type(self), name, None), "kind", None) is np.int32
        if name.startswith(_SURFACES):
            return folder / self.kind / f"{stem}_surfaces.exr"
        return folder / self.kind / (f"{stem}_{name}.png" if is_mask else f"{stem}.exr")

    def _stored(self, name: str) -> np.ndarray:
        packed, single = self._packed(name), self._single(name)
        if packed.exists():
            return np.array(read_row(packed, self.ping.row))
        if not single.exists():
            if self._is_mapped(name):
                return self._mapped(name)
            raise missing(single, f"{self.kind} {name}")
        if single.suffix == ".png":
            return read_png(single)
        part = 0 if name == "level_db" or name.startswith(_SURFACES) else 1
        if part == 1 and "recording" in self.ping.sequence.info:
            raise missing(single, f"{self.kind} {name}")
        key = single.name, part
        if key not in self._parts:
            self._parts[key] = read_exr(single, part)
        with told_of(single):
            return self._parts[key]["Y" if name == "level_db" else name]


class Ping:
    """One ping: its series, its pictures `polar` and `cartesian`, and where everything was."""

    def __init__(self, sequence: "SequenceFolder", number: int):
        self.sequence, self.number = sequence, number
        self.row = number - sequence.pings.start
        self.stem = f"{number:06}"
        self.polar, self.cartesian = View(self, "polar"), View(self, "cartesian")

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
    def recorded(self) -> np.ndarray:
        """uint8 or uint16 [samples, beams]: what the instrument stores (`sonar.recorder`, or a recording)."""
        return recorded_counts(self.sequence.folder, self.sequence.info, self.row, self.stem)

    @property
    def recorded_level_db(self) -> np.ndarray:
        """float32 [samples, beams]: the levels of `recorded`, without row gains; -99 for a count of 0 of amplitudes."""
        return recorded_level_db(self.sequence.folder, self.sequence.info, self.row, self.stem)

    def _array(self, packed: Path, single: Path, what: str) -> np.ndarray:
        if packed.exists():
            return read_row(packed, self.row)
        if not single.exists():
            raise missing(single, what)
        return read_npy(single)

    @property
    def row_gain(self) -> np.ndarray:
        """float32 [samples]: amplitudes are `recorded` divided by its root."""
        folder = self.sequence.folder
        return self._array(folder / "recorded_row_gain.npy", folder / "recorded" / f"{self.stem}_row_gain.npy",
                           "row gains")

    @property
    def annotated_images(self) -> List[Dict[str, Any]]:
        """`images` of the ping in annotations.jsonl."""
        return self.sequence.annotated_images(self.number)

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

    def annotated_images(self, ping: int) -> List[Dict[str, Any]]:
        """`images` of the ping in annotations.jsonl."""
        with told_of(self.folder / "annotations.jsonl"):
            return json.loads(self._annotation_lines[ping - self.pings.start])["images"]


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
