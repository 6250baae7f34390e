"""The extension. What users need is in the modules beside it; arrays are views that keep their ping alive."""
from typing import List, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

__version__: str

class Scenario:
    """Checked when it is made: ScenarioError with every fault. `label` is the file's name, also where there is none."""

    def __init__(self, text: str, label: str, overrides: List[Tuple[str, str]], on_device: bool) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def sequences(self) -> int: ...
    @property
    def classes(self) -> List[str]: ...
    @property
    def class_kinds(self) -> List[str]: ...
    @property
    def flags(self) -> List[str]:
        """The outputs that the scenario has on."""
    def split(self, sequence: int) -> str: ...
    def sample(self, sequence: int) -> dict: ...
    def pings_of(self, sequence: int) -> int: ...
    def stream(self, request: StreamRequest) -> Stream:
        """Builds the first world."""
    def new_warnings(self) -> List[str]: ...

class LaneRequest:
    """Sequences that come one after another, listed or in a range."""

    listed: List[int]
    start: int
    stop: int
    step: int
    skipped: int

class StreamRequest:
    """Which pings, and how many are made ahead: generator/run/ping_stream.h."""

    lanes: List[LaneRequest]
    turn: int
    split: str
    flags: List[str]
    pings: Optional[Tuple[int, int]]
    threads: int
    threads_within: int
    ahead: int

class Stream:
    def wait(self, milliseconds: int) -> bool:
        """Whether `next` has an answer, after at most so long."""
    @property
    def ready(self) -> int:
        """Pings that are made and not taken."""
    @property
    def is_resting(self) -> bool:
        """Whether the threads have nothing to do before a ping is taken."""
    def next(self) -> Union[Ping, str, None]:
        """A ping; the error of a sequence that cannot be made; None at the end."""

class Ping:
    @property
    def sequence(self) -> int: ...
    @property
    def number(self) -> int: ...
    @property
    def pings(self) -> Tuple[int, int]:
        """[first, last) of the sequence."""
    @property
    def time_s(self) -> float: ...
    @property
    def pose(self) -> List[float]:
        """x, y, z in m and qw, qx, qy, qz of the sonar in the world."""
    @property
    def object_poses(self) -> List[List[float]]:
        """Likewise, of each object and point target."""
    @property
    def info(self) -> str:
        """JSON: sequence.json without its files."""
    @property
    def annotations(self) -> str:
        """JSON: the line of annotations.jsonl."""
    @property
    def azimuth_rad(self) -> NDArray[np.float64]: ...
    @property
    def range_m(self) -> NDArray[np.float64]: ...
    @property
    def front_azimuth_rad(self) -> NDArray[np.float64]: ...
    @property
    def front_elevation_rad(self) -> NDArray[np.float64]: ...
    @property
    def cartesian_map(self) -> Optional[NDArray[np.int32]]: ...
    @property
    def first_return_m(self) -> NDArray[np.float32]: ...
    @property
    def series(self) -> Optional[NDArray[np.complex64]]:
        """[beams, samples]; None: not asked for."""
    @property
    def channels(self) -> Optional[NDArray[np.complex64]]:
        """[elements, samples]."""
    @property
    def recorded(self) -> Union[NDArray[np.uint8], NDArray[np.uint16], None]:
        """[samples, beams]; None without a recorder."""
    @property
    def row_gain(self) -> Optional[NDArray[np.float32]]:
        """[samples]; None without row gains."""
    @property
    def elevation(self) -> Optional[NDArray]:
        """Structured array, as elevation/*.npy."""
    @property
    def power_spread(self) -> Optional[Tuple[NDArray[np.float32], NDArray[np.complex64]]]:
        """beam_power.npy and pulse_power.npy; None: with an array of elements."""
    def layer(self, name: str) -> Optional[NDArray[np.complex64]]: ...
    def array(self, view: str, name: str) -> Optional[NDArray]:
        """A plane or "grey" of "polar" or "cartesian", or a plane of "front", [rows, columns]."""

class Generation:
    """A thread that writes a data set. Deleting it stops it."""

    def __init__(self, scenario: Scenario, folder: str, sequences: Optional[Tuple[int, int]], threads: int,
                 overwrite: bool) -> None: ...
    def wait(self, milliseconds: int) -> bool:
        """Whether it has ended, after at most so long."""
    def stop(self) -> None: ...
    def progress(self) -> Tuple[int, int]:
        """Pings that are done, and all."""
    def warnings(self) -> List[str]: ...
    def check(self) -> None:
        """Raises what went wrong."""
