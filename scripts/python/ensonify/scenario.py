"""Scenarios, and the pings that come from them."""
from __future__ import annotations

import json
import warnings
from itertools import islice
from os import cpu_count
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

from . import _core
from .live import LivePing, LiveSequence
from .wants import flags_of

# The last sequence there can be, and one.
_ALL = 2 ** 32
_POLL_MS = 100  # how long Ctrl-C may wait


class Scenario:
    """A checked scenario. Nothing is built before a ping, a sample or a stream is asked for.

    Errors of all its methods: ScenarioError, with every fault; OSError where a file cannot be read;
    RuntimeError in a process that was forked after its parent had built a world.
    """

    def __init__(self, text: str, label: str, overrides: Sequence[Tuple[str, str]] = (), device: bool = False):
        self._made_of = text, label, tuple(overrides), device
        self._core = _core.Scenario(text, label, list(overrides), device)

    @classmethod
    def load(cls, file: Union[str, Path], set: Optional[Mapping[str, Any]] = None, device: bool = False) -> "Scenario":
        """Reads a YAML file. `set` replaces keys by their paths, as --set does; `device`: CUDA where there is one
        that has room for a ping; otherwise the processor, and a warning."""
        return cls(Path(file).read_text(encoding="utf-8"), str(file), _overrides(set), device)

    @classmethod
    def from_yaml(cls, text: str, folder: Union[str, Path] = ".", set: Optional[Mapping[str, Any]] = None,
                  device: bool = False) -> "Scenario":
        """Reads YAML text. Paths in it are relative to `folder`."""
        return cls(text, str(Path(folder) / "scenario"), _overrides(set), device)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], folder: Union[str, Path] = ".",
                  set: Optional[Mapping[str, Any]] = None, device: bool = False) -> "Scenario":
        """Takes the keys of a scenario as dicts and lists. Paths in it are relative to `folder`."""
        return cls.from_yaml(json.dumps(values, indent=1), folder, set, device)

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def seed(self) -> int:
        return self._core.seed

    @property
    def sequences(self) -> int:
        """How many the scenario says; others can be made all the same, up to 2^32."""
        return self._core.sequences

    @property
    def classes(self) -> List[str]:
        """Names; id k is `classes[k - 1]`."""
        return self._core.classes

    @property
    def class_kinds(self) -> List[str]:
        """`thing` or `stuff` of each class."""
        return self._core.class_kinds

    def split(self, sequence: int) -> str:
        """`train`, `val` or `test`: a draw of the seed and the number, the same whatever else is made."""
        return self._core.split(sequence)

    def pings_of(self, sequence: int) -> int:
        """How many pings a sequence has."""
        return self._core.pings_of(sequence)

    def sample(self, sequence: int) -> Dict[str, Any]:
        """The scenario as it is drawn for a sequence: every key with its value, as dicts and lists."""
        return self._core.sample(sequence)

    def ping(self, sequence: int = 0, ping: int = 0, want: Optional[Iterable[str]] = None, threads: int = 0) -> LivePing:
        """One ping. The world of the last sequence is kept, so that its other pings come faster.

        `want`: as for `stream`. `threads`: 0: as many as the machine has.
        """
        request = _request(self, [([sequence], 0)], want)
        request.pings = (ping, ping + 1)
        request.threads_within = threads or cpu_count() or 1
        for made in Stream(self, request, raises=True):
            return made
        raise IndexError(f"sequence {sequence} has pings 0 to {self.pings_of(sequence) - 1}, not {ping}")

    def stream(self, sequences: Optional[Iterable[int]] = None, threads: int = 0,
               want: Optional[Iterable[str]] = None, split: Optional[str] = None,
               pings: Optional[Tuple[int, int]] = None, skipped: int = 0, ahead: Optional[int] = None) -> "Stream":
        """The pings of sequences in order, made ahead by threads: an iterator in bounded memory.

        `sequences`: their numbers; None: all that the scenario says. `want`: what a ping has, None: all that the
        scenario's `output` makes; "series", "layers", "channels", "annotations", "grey", planes as "level_db" or
        "cartesian.instance". `split`: leaves out the sequences of others. `pings`: those from the first to before
        the second of each sequence. `skipped` pings of the first sequence are not made. `ahead`: how many pings are made
        before they are taken, and kept in memory; None: twice as many as threads. A sequence that cannot be made is
        a warning, and the next one follows.
        """
        numbers = range(self.sequences) if sequences is None else sequences
        request = _request(self, [(numbers, skipped)], want, split, threads, ahead)
        request.pings = pings
        return Stream(self, request)

    def __reduce__(self) -> Any:
        return Scenario, self._made_of

    def __repr__(self) -> str:
        return f"<scenario {self.name}: {self.sequences} sequences, seed {self.seed}>"

    def _repr_html_(self) -> str:
        from .html import scenario_html
        return scenario_html(self)


class Stream(Iterator[LivePing]):
    """An iterator over pings. `failed` has the sequences that could not be made so far, with the reason."""

    def __init__(self, scenario: Scenario, request: "_core.StreamRequest", raises: bool = False):
        self._scenario, self._raises = scenario, raises
        self._core: Optional[_core.Stream] = scenario._core.stream(request)
        for text in scenario._core.new_warnings():
            warnings.warn(text, RuntimeWarning, stacklevel=3)
        self._sequence: Optional[LiveSequence] = None
        self.failed: List[str] = []

    def __next__(self) -> LivePing:
        while self._core is not None:
            while not self._core.wait(_POLL_MS):
                pass
            made = self._core.next()
            if isinstance(made, str):
                self._tell(made)
            elif made is None:
                self.close()
            else:
                return LivePing(self._scenario, made, self._sequence_of(made))
        raise StopIteration

    def _tell(self, failure: str) -> None:
        if self._raises:
            from .errors import ScenarioError
            raise ScenarioError(failure)
        self.failed.append(failure)
        warnings.warn(f"a sequence could not be made: {failure}", RuntimeWarning, stacklevel=3)

    def _sequence_of(self, core: "_core.Ping") -> LiveSequence:
        if self._sequence is None or self._sequence.number != core.sequence:
            self._sequence = LiveSequence(self._scenario, core)
        return self._sequence

    @property
    def ready(self) -> int:
        """How many pings are made and not taken. If it is often 0, the stream is slower than the loop."""
        return self._core.ready if self._core is not None else 0

    def close(self) -> None:
        """Ends the threads. Iteration stops; pings taken before stay whole."""
        self._core = None


def _overrides(values: Optional[Mapping[str, Any]]) -> List[Tuple[str, str]]:
    return [(path, json.dumps(value)) for path, value in (values or {}).items()]


def _request(scenario: Scenario, lanes: Iterable[Tuple[Iterable[int], int]], want: Optional[Iterable[str]],
             split: Optional[str] = None, threads: int = 1, ahead: Optional[int] = None) -> "_core.StreamRequest":
    """`lanes`: the sequences of each, and how many pings of its first sequence are skipped."""
    if isinstance(want, str):
        raise ValueError(f"want is {want!r}; expected a list of names, as [{want!r}]")
    request = _core.StreamRequest()
    request.flags = flags_of(want, scenario._core.flags)
    request.lanes = [_lane(sequences, skipped) for sequences, skipped in lanes]
    request.split = split or ""
    request.threads = threads or cpu_count() or 1
    request.ahead = ahead or 2 * request.threads
    return request


def _lane(sequences: Iterable[int], skipped: int) -> "_core.LaneRequest":
    lane = _core.LaneRequest()
    lane.skipped = skipped
    if isinstance(sequences, range) and sequences.step > 0:
        lane.start, lane.stop, lane.step = sequences.start, min(sequences.stop, _ALL), sequences.step
    else:
        lane.listed = list(islice(sequences, _ALL))
    return lane
