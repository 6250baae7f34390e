"""The images of a ping, polar and Cartesian. Every array is read when it is asked for."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple

import numpy as np

from .files import DatasetError, decode_rle, read_exr, read_jpeg, read_png
from .manifest import OUTPUTS, missing, read_row, render_name, told_of
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


# The planes by name: a row of outputs.json for each.
PLANES: Dict[str, Dict[str, Any]] = {row["name"]: row for row in OUTPUTS["planes"]}


class View:
    """The pictures of a ping, `polar` or `cartesian`; arrays are [rows, columns].

    Levels and angles are float32, grey is uint8, ids are int32 (PyTorch has no uint16), 0: none.
    Cartesian levels and angles that are not stored are the polar ones through the sequence's map.
    What the data set does not hold is a DatasetError; `has` asks before.
    """

    def __init__(self, ping: "Ping", kind: str):
        self.ping, self.kind = ping, kind
        self._parts: Dict[Tuple[str, int], Dict[str, np.ndarray]] = {}

    # One array for each plane, with the plane's name: levels and the like are float32, ids int32. Those with
    # `output.surfaces` are of the pixel's instance. Those with `output.motion` are of the point of its strongest echo, in
    # polar pixels also where the view is Cartesian; the other ping is `sequence.info["motion"]["pings"]` pings later.
    if TYPE_CHECKING:
        def __getattr__(self, name: str) -> np.ndarray: ...

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
        return name in PLANES and np.dtype(PLANES[name]["type"]).kind == "f"

    def _mapped(self, name: str) -> np.ndarray:
        polar, pixels = self.ping.polar._stored(name).ravel(), self.ping.sequence.cartesian_map
        with told_of(self.ping.sequence.map_path):
            if pixels.max(initial=-1) >= polar.size:
                raise ValueError("names pixels that the polar image does not have")
            outside = polar.dtype.type(np.nan if PLANES[name]["blank"] is None else PLANES[name]["blank"])
            return np.where(pixels < 0, outside, polar[np.maximum(pixels, 0)])

    def _packed(self, name: str) -> Path:
        return self.ping.sequence.folder / f"{self.kind}_{name}.npy"

    def _single(self, name: str) -> Path:
        folder, stem = self.ping.sequence.folder, self.ping.stem
        if name == "grey":
            return folder / "png" / f"{stem}_{self.kind}.png"
        end = PLANES[name]["group"] if self.is_float(name) else name
        return folder / self.kind / (f"{stem}_{end}".rstrip("_") + (".exr" if self.is_float(name) else ".png"))

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
        part = 0 if name == "level_db" or PLANES[name]["group"] else 1
        if part == 1 and "recording" in self.ping.sequence.info:
            raise missing(single, f"{self.kind} {name}")
        key = single.name, part
        if key not in self._parts:
            self._parts[key] = read_exr(single, part)
        with told_of(single):
            return self._parts[key]["Y" if name == "level_db" else name]


def _plane(name: str, doc: str) -> property:
    kind = np.float32 if View.is_float(name) else np.int32
    return property(lambda view: view._stored(name).astype(kind, copy=False), doc=doc)


for _row in PLANES.values():
    setattr(View, _row["name"], _plane(_row["name"], _row["meaning"]))
