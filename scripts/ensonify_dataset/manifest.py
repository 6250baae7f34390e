"""Manifests and tables of a data set: what they list is checked before it names a file or a size."""
from __future__ import annotations

import csv
import json
import re
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

import numpy as np

from .files import FAULTS, DatasetError, read_bytes, read_npy, unreadable

FORMAT_VERSION = 1
# The planes of images and front views, as `ensonify --help-format outputs` prints them.
OUTPUTS: Dict[str, List[Dict[str, Any]]] = json.loads(Path(__file__).with_name("outputs.json").read_text("utf-8"))
_MAX_PINGS = 1 << 40


def missing(path: Path, what: str) -> DatasetError:
    return DatasetError(f"{path}: is not there. Either the scenario does not write the {what} "
                        "(`output` in scenario.yaml), or files are missing: `ensonify verify` tells")


@contextmanager
def told_of(path: Path) -> Iterator[None]:
    """What a file's content makes fail inside is a DatasetError of that file."""
    try:
        yield
    except FAULTS as fault:
        raise unreadable(path, fault) from fault


def listed_pings(entry: Dict[str, Any]) -> Tuple[int, range]:
    """Number and pings of a sequence. Numbers only: they become names of folders and of files."""
    number, (first, last) = entry["sequence"], entry["pings"]
    if {type(number), type(first), type(last)} != {int}:
        raise ValueError(f"sequence {number!r} with pings {first!r} to {last!r}: not whole numbers")
    if min(number, first) < 0 or not first <= last <= _MAX_PINGS:
        raise ValueError(f"sequence {number} with pings {first} to {last}")
    return number, range(first, last)


def render_name(name: str) -> str:
    """The name, which becomes that of a folder."""
    if not re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,63}", name):
        raise DatasetError(f"{name!r} is no name of a render")
    return name


def read_row(packed: Path, row: int) -> np.ndarray:
    with told_of(packed):
        return read_npy(packed)[row]


def need_finished(folder: Path) -> None:
    """A data set is done when it has its dataset.sha256."""
    if (folder / "dataset.sha256").exists():
        return
    if (folder / "work.json").exists():
        raise DatasetError(f"{folder}: this data set is not finished. The same `ensonify generate` "
                           "command again goes on where the last one ended")
    if (folder / "sequence.json").exists():
        raise DatasetError(f"{folder}: this is one sequence; give the folder of its data set, or "
                           "open it as SequenceFolder")
    if (folder / "rig.json").exists():
        names = ", ".join(str(folder / entry["name"])
                          for entry in read_manifest(folder / "rig.json", "ensonify_rig")["instruments"])
        raise DatasetError(f"{folder}: this is the folder of a rig; open the data set of one of its instruments: {names}")
    if (folder / "sweep.json").exists():
        raise DatasetError(f"{folder}: this is the folder of a sweep; open it as SonarSweep, which gives the data set "
                           "of each run")
    raise DatasetError(f"{folder}: no data set of ensonify is here (no dataset.sha256)")


def read_manifest(path: Path, version_key: str) -> Dict[str, Any]:
    try:
        content = json.loads(read_bytes(path))
    except (ValueError, RecursionError) as fault:
        raise DatasetError(f"{path}: is no JSON ({fault})") from fault
    version = content.get(version_key) if isinstance(content, dict) else None
    if version != FORMAT_VERSION:
        raise DatasetError(f"{path}: {version_key} is {version}, and this reader knows version "
                           f"{FORMAT_VERSION}. Take scripts/ensonify_dataset of the ensonify that "
                           "made the data set")
    return content


def read_table(path: Path) -> List[Dict[str, str]]:
    with told_of(path):
        return list(csv.DictReader(read_bytes(path).decode("utf-8").splitlines()))
