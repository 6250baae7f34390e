"""A data set for PyTorch. Nothing else of this package needs torch."""
from __future__ import annotations

from typing import Any, Callable, Dict, Optional, Sequence

import numpy as np
import torch
import torch.utils.data

from .dataset import Ping, SonarDataset
from .transforms import Display
from .views import View

Sample = Dict[str, Any]


class TorchPings(torch.utils.data.Dataset):
    """Each ping as a dict of tensors.

    `image`: float32 [channels, rows, columns], the arrays of the view named in `inputs`, of which
    surface_normal has three channels;
    each of `targets`: int64 [rows, columns] for ids, as cross_entropy wants them, float32 for
    others; `sequence` and `ping`: its numbers.
    `transform(sample, ping)` gets the dict while it holds NumPy arrays, and the Ping; what it
    returns becomes tensors. It must be picklable where workers are spawned rather than forked.
    Pictures of one batch need one size: a transform has to see to it where the scenario draws
    what decides on it (range, beams).
    `grey` among the inputs is the image in `png/`, that of the render of the name `render`, or what
    `display` makes of the levels on the fly.
    """

    def __init__(self, dataset: SonarDataset, inputs: Sequence[str] = ("level_db",),
                 targets: Sequence[str] = ("semantic",), view: str = "polar",
                 transform: Optional[Callable[[Sample, Ping], Sample]] = None,
                 render: Optional[str] = None, display: Optional[Display] = None):
        if view not in ("polar", "cartesian"):
            raise ValueError(f"view is {view!r}; expected polar or cartesian")
        for name in (*inputs, *targets):
            if not isinstance(getattr(View, name, None), property) or name == "annotations":
                raise ValueError(f"a view has no array {name!r}")
        if render is not None and display is not None:
            raise ValueError("render and display are both given; expected one of them")
        if (render is not None or display is not None) and "grey" not in inputs:
            raise ValueError("render and display are of the input grey, which is not asked for")
        self.dataset, self.view, self.transform = dataset, view, transform
        self.render, self.display = render, display
        self.inputs, self.targets = tuple(inputs), tuple(targets)

    def __len__(self) -> int:
        return len(self.dataset)

    def __getitem__(self, item: int) -> Sample:
        ping = self.dataset[item]
        view = getattr(ping, self.view)
        sample: Sample = {name: getattr(view, name) for name in self.targets}
        inputs = [self._input(view, name) for name in self.inputs]
        if len({array.shape[:2] for array in (*inputs, *sample.values())}) > 1:
            raise ValueError("the arrays of a sample differ in size; a render or display with range_m, samples or "
                             "beams shows a part of the pixels, without targets and other inputs")
        channels = [np.moveaxis(np.atleast_3d(array), -1, 0) for array in inputs]
        sample["image"] = np.concatenate(channels).astype(np.float32)
        sample["sequence"], sample["ping"] = ping.sequence.number, ping.number
        if self.transform is not None:
            sample = self.transform(sample, ping)
        return {name: to_tensor(value) for name, value in sample.items()}

    def _input(self, view: View, name: str) -> np.ndarray:
        if name == "grey" and self.render is not None:
            return view.render(self.render)
        if name == "grey" and self.display is not None:
            return view.displayed(self.display)
        return getattr(view, name)


def to_tensor(value: Any) -> Any:
    """Integer arrays as int64 (torch has no uint16), but for uint8; the rest in its own type.

    What is no array stays as it is. Memory-mapped arrays are copied: tensors must be writable.
    """
    if not isinstance(value, np.ndarray):
        return value
    if value.dtype.kind in "iu" and value.dtype != np.uint8:
        return torch.from_numpy(value.astype(np.int64))
    return torch.from_numpy(np.array(value))
