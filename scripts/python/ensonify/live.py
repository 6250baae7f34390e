"""Pings that come from the generator, with the interface of those that are read from files."""
from __future__ import annotations

import json
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional, Tuple

import numpy as np
from ensonify_dataset import CameraImage, DatasetError, ElevationEchoes, FrontView, Ping, Pose, SequenceFolder, View

if TYPE_CHECKING:
    from . import _core
    from .scenario import Scenario


def _pose(numbers: List[float]) -> Pose:
    return Pose(np.array(numbers[:3]), np.array(numbers[3:]))


class LiveView(View):
    """The images of a ping. What was not asked for is a DatasetError; `has` asks before."""

    ping: "LivePing"

    def has(self, name: str) -> bool:
        there = self.ping.core.array(self.kind, name) is not None
        return there or self._is_mapped(name) and self.ping.polar.has(name)

    def render(self, name: str) -> np.ndarray:
        raise DatasetError("renders are of finished data sets; `displayed` makes an image of any display")

    def _is_mapped(self, name: str) -> bool:
        return self.kind == "cartesian" and self.is_float(name) and self.ping.core.cartesian_map is not None

    def _stored(self, name: str) -> np.ndarray:
        array = self.ping.core.array(self.kind, name)
        if array is not None:
            return array
        if self._is_mapped(name):
            return self._mapped(name)
        raise DatasetError(f"{self.kind} {name} is not among what was asked for (`want`)")

    def _repr_html_(self) -> str:
        from .html import view_html
        return view_html(self)


class LiveFront(FrontView):
    """The front view of a ping."""

    ping: "LivePing"

    def has(self, name: str) -> bool:
        plane = {"normal": "normal_x", "position_m": "range_m"}.get(name, name)
        return self.ping.core.array("front", plane) is not None

    def _stored(self, name: str) -> np.ndarray:
        array = self.ping.core.array("front", name)
        if array is None:
            raise DatasetError(f"front {name} is not among what was asked for (`want`)")
        return array


class LiveCamera(CameraImage):
    """The image of the camera."""

    ping: "LivePing"

    def has(self, name: str) -> bool:
        plane = {"normal": "normal_x", "position_m": "depth_m", "flow_px": "flow_x_px"}.get(name, name)
        return self.ping.core.array("camera", plane) is not None

    def _stored(self, name: str) -> np.ndarray:
        array = self.ping.core.array("camera", name)
        if array is None:
            raise DatasetError(f"camera {name} is not among what was asked for (`want`)")
        return array


class LivePing(Ping):
    """One ping: series, images, poses. Its arrays are views of what the generator made and belong to it alone."""

    def __init__(self, scenario: "Scenario", core: "_core.Ping", sequence: "LiveSequence"):
        self.core, self.scenario = core, scenario
        self.sequence: "LiveSequence" = sequence
        self.number = core.number
        self.row = core.number
        self.stem = f"{core.number:06}"
        self.polar, self.cartesian = LiveView(self, "polar"), LiveView(self, "cartesian")
        self.front = LiveFront(self)
        self.camera = LiveCamera(self)

    @property
    def series(self) -> np.ndarray:
        return self._made(self.core.series, "the series")

    def layer(self, name: str) -> np.ndarray:
        return self._made(self.core.layer(name), f"layer {name}")

    @property
    def channels(self) -> np.ndarray:
        return self._made(self.core.channels, "channels")

    @property
    def elevation(self) -> ElevationEchoes:
        return ElevationEchoes(self.sequence, self._made(self.core.elevation, "elevation"))

    @property
    def recorded(self) -> np.ndarray:
        if self.core.recorded is None:
            raise DatasetError("recorded counts: the scenario has no sonar.recorder")
        return self.core.recorded

    def _row_gain(self) -> Optional[np.ndarray]:
        return self.core.row_gain

    @property
    def row_gain(self) -> np.ndarray:
        if self.core.row_gain is None:
            raise DatasetError("row gains: the scenario has no sonar.recorder.row_gain_db")
        return self.core.row_gain

    def _made(self, array: Any, what: str) -> np.ndarray:
        if array is None:
            raise DatasetError(f"{what}: not among what was asked for (`want`)")
        return np.asarray(array)

    @property
    def time_s(self) -> float:
        return self.core.time_s

    @property
    def pose(self) -> Pose:
        return _pose(self.core.pose)

    @property
    def object_poses(self) -> Dict[int, Pose]:
        return {i + 1: _pose(numbers) for i, numbers in enumerate(self.core.object_poses)}

    @property
    def first_return_m(self) -> np.ndarray:
        return self.core.first_return_m

    @property
    def annotated_images(self) -> List[Dict[str, Any]]:
        return json.loads(self.core.annotations)["images"]

    def __repr__(self) -> str:
        return f"<ping {self.number} of sequence {self.sequence.number} of {self.scenario.name}>"

    def _repr_html_(self) -> str:
        from .html import ping_html
        return ping_html(self)


class LiveSequence(SequenceFolder):
    """The sequence of a live ping: axes, and `info` as its sequence.json would have it."""

    def __init__(self, scenario: "Scenario", core: "_core.Ping"):
        super().__init__(Path(f"{scenario.name}/sequences/{core.sequence:06}"))
        self._scenario, self._core = scenario, core

    def __getitem__(self, ping: int) -> LivePing:
        if ping not in self.pings:
            raise IndexError(f"sequence {self.number} has pings 0 to {self.pings.stop - 1}, not {ping}")
        return self._scenario.ping(self.number, ping)

    def __iter__(self) -> Iterator[LivePing]:
        return iter(self._scenario.stream(sequences=[self.number]))

    @cached_property
    def info(self) -> Dict[str, Any]:
        return json.loads(self._core.info)

    @property
    def number(self) -> int:
        return self._core.sequence

    @cached_property
    def pings(self) -> range:
        return range(*self._core.pings)

    @cached_property
    def azimuth_rad(self) -> np.ndarray:
        return self._core.azimuth_rad

    @cached_property
    def range_m(self) -> np.ndarray:
        return self._core.range_m

    @cached_property
    def power_spread(self) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        if "elevation" not in self.info:
            raise DatasetError("elevation is not among what was asked for (`want`)")
        return self._core.power_spread

    @cached_property
    def front_azimuth_rad(self) -> np.ndarray:
        return self._core.front_azimuth_rad

    @cached_property
    def front_elevation_rad(self) -> np.ndarray:
        return self._core.front_elevation_rad

    @cached_property
    def cartesian_map(self) -> np.ndarray:
        return np.asarray(self._core.cartesian_map)

    @property
    def covisibility(self) -> Any:
        raise DatasetError("covisibility is of finished data sets (`output.covisibility`)")

    @property
    def height_map(self) -> Any:
        raise DatasetError("height maps are of finished data sets (`output.height_map`)")

    @property
    def navigation(self) -> Any:
        raise DatasetError("navigation sensors are of finished data sets (`navigation`)")

    @property
    def pose_rows(self) -> Any:
        raise DatasetError("tables are of finished data sets; each ping has its pose")

    @property
    def object_rows(self) -> Any:
        raise DatasetError("tables are of finished data sets; each ping has its object_poses")

    def annotated_images(self, ping: int) -> Any:
        raise DatasetError("annotations of all pings are of finished data sets; each ping has its own")

    def tracks(self, view: Optional[str] = None) -> Any:
        raise DatasetError("tracks are of finished data sets")

    @property
    def statistics(self) -> Any:
        raise DatasetError("statistics are of finished data sets (`output.statistics`)")

    @cached_property
    def first_return_m(self) -> np.ndarray:
        raise DatasetError("first returns of all pings are of finished data sets; each ping has its own")
