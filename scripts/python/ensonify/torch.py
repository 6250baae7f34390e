"""A scenario as an endless data set for PyTorch: worlds that are never stored and never repeat."""
from __future__ import annotations

from itertools import groupby, islice
from os import cpu_count
from typing import Any, Callable, Dict, Iterator, Optional, Sequence, Tuple

import numpy as np
import torch.utils.data
from ensonify_dataset.pytorch import Sample, to_tensor

from .live import LivePing
from .scenario import _ALL, _request, Scenario, Stream

Transform = Callable[[Sample, LivePing], Sample]


class SonarStream(torch.utils.data.IterableDataset):
    """Each ping as a dict of tensors, made when it is needed.

        stream = SonarStream(scene, want=["level_db", "semantic"], split="train", batch_size=8)
        for batch in DataLoader(stream, batch_size=None, num_workers=2): ...

    `want`: names as for `Scenario.stream`; arrays of ids become int64, others keep their type; `sequence` and `ping`
    are the numbers. `transform(sample, ping)` gets the dict of NumPy arrays, and the ping; what it returns becomes
    tensors. It must be picklable where workers are spawned.
    `split`: the sequences of that split alone. `sequences`: how many numbers from 0 on are looked at; None: all 2^32.
    `batch_size`: that many pings stacked, in place of DataLoader's, which must be None; None: single pings.

    Sequences are dealt to `lanes` in turn, and items come from the lanes in turn, so that a batch has pings of one
    sequence and neighbouring batches are of different ones. Workers share the lanes: their number must divide
    `lanes`, and then the items and their order do not depend on it. Only the last sequences of a stream with
    an end, where some lanes have run out, may come in another order.
    `threads` make the pings of each process; None: the machine's cores, shared out among the workers. `ahead`: how many
    pings each process makes before they are taken, and keeps in memory; None: two batches, and at least two pings a thread.
    A process may be forked as long as it has built no world; later workers must be spawned.
    """

    def __init__(self, scenario: Scenario, want: Sequence[str], transform: Optional[Transform] = None,
                 split: Optional[str] = None, sequences: Optional[int] = None, batch_size: Optional[int] = None,
                 lanes: int = 4, threads: Optional[int] = None, ahead: Optional[int] = None):
        super().__init__()
        self.scenario, self.want, self.transform = scenario, list(want), transform
        self.split, self.sequences, self.batch_size = split, sequences, batch_size
        self.lanes, self.threads, self.ahead = lanes, threads, ahead
        self._taken = 0

    def __iter__(self) -> Iterator[Dict[str, Any]]:
        worker = torch.utils.data.get_worker_info()
        index, count = (worker.id, worker.num_workers) if worker else (0, 1)
        if self.lanes % count:
            raise ValueError(f"{count} workers do not share {self.lanes} lanes evenly; give lanes={count} or a multiple")
        start = self._taken
        # The loader asks worker 0 first, whatever lane the next item is from.
        mine = range((index + start) % count, self.lanes, count)
        order = sorted(mine, key=lambda lane: (lane - start) % self.lanes)
        threads = self.threads or max(1, (cpu_count() or 1) // count)
        turn = self.batch_size or 1
        request = _request(self.scenario, [self._lane(lane) for lane in order], self.want, self.split, threads,
                           self.ahead or 2 * max(threads, turn))
        request.turn = turn
        for item in self._items(Stream(self.scenario, request)):
            if worker is None:
                self._taken += 1
            yield item

    def state_dict(self, taken: Optional[int] = None) -> Dict[str, int]:
        """The position. With workers, which count for themselves, `taken` is how many items the loader has given."""
        return {"taken": self._taken if taken is None else taken}

    def load_state_dict(self, state: Dict[str, int]) -> None:
        """Goes on from there; `taken` counts from the very first item."""
        self._taken = int(state["taken"])

    def _lane(self, lane: int) -> Tuple[range, int]:
        """The sequences of a lane that are still to come, and how many pings of the first have been taken."""
        done = -(-max(self._taken - lane, 0) // self.lanes) * (self.batch_size or 1)
        numbers = range(lane, self.sequences or _ALL, self.lanes)
        first = 0
        while done > 0:
            while self.split and first < len(numbers) and self.scenario.split(numbers[first]) != self.split:
                first += 1
            if first == len(numbers):
                break
            pings = self.scenario.pings_of(numbers[first])
            if pings > done:
                break
            done -= pings
            first += 1
        return numbers[first:], done

    def _items(self, pings: Iterator[LivePing]) -> Iterator[Dict[str, Any]]:
        if self.batch_size is None:
            yield from map(self._sample, pings)
            return
        # A lane that ends may leave a part of a batch, which is not used.
        for _, turn in groupby(pings, lambda ping: ping.sequence.number % self.lanes):
            samples = map(self._sample, turn)
            while len(batch := list(islice(samples, self.batch_size))) == self.batch_size:
                yield torch.utils.data.default_collate(batch)

    def _sample(self, ping: LivePing) -> Dict[str, Any]:
        sample: Sample = {name: _array(ping, name) for name in self.want}
        sample["sequence"], sample["ping"] = ping.sequence.number, ping.number
        if self.transform is not None:
            sample = self.transform(sample, ping)
        return {name: to_tensor(value) for name, value in sample.items()}


def _array(ping: LivePing, name: str) -> Any:
    if name in ("series", "channels"):
        return getattr(ping, name)
    view, _, plane = name.rpartition(".")
    array = getattr(ping if name == "elevation" else getattr(ping, view or "polar"), plane)
    if not isinstance(array, np.ndarray):
        raise ValueError(f"want: {name!r} is no array; a transform can take it from its second argument")
    return array
