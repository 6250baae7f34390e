"""The images of a ping, polar and Cartesian. Every array is read when it is asked for."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Dict, List, Optional, Tuple

import numpy as np

from .files import DatasetError, decode_rle, read_exr, read_jpeg, read_png
from .manifest import missing, read_row, render_name, told_of
from .transforms import Display

if TYPE_CHECKING:
    from .dataset import Ping


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


class _Plane(property):
    """A plane of a view under the attribute's name: int32 ids of a PNG file, float32 of an EXR channel."""

    def __init__(self, kind: type, doc: str):
        super().__init__(lambda view: view._stored(self.name).astype(kind, copy=False), doc=doc)
        self.kind, self.name = kind, ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name


# What Cartesian pixels outside the fan hold, where it is not NaN.
_OUTSIDE = {"level_db": -99, "clean_db": -99, "instance_fraction": 0, "surface_count": 0, "layover_count": 0,
            "second_fraction": 0}
# Planes with files of their own, by the beginning of their names.
_GROUPS = {"surface_": "surfaces", "lowest_": "surfaces", "highest_": "surfaces", "layover_": "surfaces",
           "second_": "surfaces", "point_": "motion", "motion_": "motion"}


def _group_of(name: str) -> str:
    """The end of the name of the plane's EXR file; empty: it is in the file of the labels."""
    return next((group for start, group in _GROUPS.items() if name.startswith(start)), "")


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
    layover_count = _Plane(np.float32, "Number of surfaces of all instances in the pixel.")
    second_fraction = _Plane(np.float32, "Share of the second instance in the pixel's energy.")
    second_instance = _Plane(np.int32, "The instance with the second most energy.")
    # With `output.motion`, of the point of the strongest echo of the pixel's instance. In polar pixels, also where the
    # view is Cartesian. The other ping is `sequence.info["motion"]["pings"]` pings later.
    point_sample = _Plane(np.float32, "Sample of the point, with its fraction; NaN without.")
    point_beam = _Plane(np.float32, "Beam of the point, with its fraction.")
    motion_samples = _Plane(np.float32, "Displacement to the other ping along range, in samples.")
    motion_beams = _Plane(np.float32, "Displacement to the other ping in azimuth, in beams.")
    motion_state = _Plane(np.int32, "The point in the other ping: 1 seen, 2 hidden, 3 outside; 0: no point or no ping.")
    motion_occluder = _Plane(np.int32, "The instance that hides it there.")
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
        if path.with_suffix(".jpg").exists():
            return read_jpeg(path.with_suffix(".jpg"))
        if not path.exists():
            raise DatasetError(f"{path}: is not there. `ensonify render` makes it, where it has been given no "
                               "other --view or --sequences")
        return read_png(path)

    def displayed(self, display: Display) -> np.ndarray:
        """uint8: the image that `ensonify render` would make with this display, of the stored levels; before JPEG."""
        sequence = self.ping.sequence
        with told_of(sequence.folder / "sequence.json"):
            step_m = float(sequence.info["record"]["range_step_m"])
            first_m = float(sequence.info["record"].get("first_range_m", 0))
            alpha = float(sequence.info["water"].get("absorption_db_m", 0))  # a recording has none
        level_db = self.ping.polar.level_db
        part = display.part(level_db.shape, step_m, first_m)
        if self.kind == "polar":
            return display.flipped(display.grey(level_db, step_m, alpha, first_m))
        whole = pixels = sequence.cartesian_map
        with told_of(sequence.map_path):
            if pixels.max(initial=-1) >= level_db.size:
                raise ValueError("names pixels that the polar image does not have")
        if part is not None:
            pixels = part.mapped(whole, level_db.shape[1])
        if display.resampling == "bilinear":
            grey = display.cartesian_grey(level_db, sequence.footprints, step_m, alpha, first_m)
            if part is not None:
                grey = np.where(pixels < 0, np.uint8(0), grey[part.rectangle(whole, level_db.shape[1])])
            return display.flipped(grey)
        grey = display.grey(level_db, step_m, alpha, first_m)
        return display.flipped(np.where(pixels < 0, np.uint8(0), grey.ravel()[np.maximum(pixels, 0)]))

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
        if not is_mask and _group_of(name):
            return folder / self.kind / f"{stem}_{_group_of(name)}.exr"
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
        part = 0 if name == "level_db" or _group_of(name) else 1
        if part == 1 and "recording" in self.ping.sequence.info:
            raise missing(single, f"{self.kind} {name}")
        key = single.name, part
        if key not in self._parts:
            self._parts[key] = read_exr(single, part)
        with told_of(single):
            return self._parts[key]["Y" if name == "level_db" else name]
