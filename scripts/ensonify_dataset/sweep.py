"""Sweeps: many runs of one scenario, found by the values that vary (docs/sweeps.md)."""
from __future__ import annotations

import json
import math
import re
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Union

from .dataset import SonarDataset
from .files import DatasetError, read_bytes
from .manifest import read_manifest, read_table, told_of

_NUMBERS = ("mean_level_db", "max_level_db", "noise_level_db", "first_return_m", "labelled_px", "instances",
            "contrast", "contrast_se")
_COLUMNS = ("run", "name", "seed", "pings", "folder", "status")
_MOST_NAMED = 5


class SweepRun(SonarDataset):
    """The data set of a run, with its id `run`, its `values` by axis and its `settings` by key path."""

    def __init__(self, sweep: "SonarSweep", row: Dict[str, Any]):
        super().__init__(sweep.folder / row["folder"])
        self.run: str = row["run"]
        self.row = row
        self.values: Dict[str, Any] = {axis: row[column] for axis, column in sweep.columns.items()}
        self.settings: Dict[str, Any] = sweep.settings[self.run]


class SonarSweep:
    """The runs of a sweep, in the order of its plan.

        sweep = SonarSweep("out/scan")
        for data in sweep.select(frequency_hz=550e3, material=["sand", "rock"]):
            print(data.values, data[0].polar.level_db.max())

    `table` has a row of each run, as runs.csv. A name in `select` is that of an axis or a column, a key path, or its
    last part; a condition is a value, a list of values, or a function of the value.
    """

    def __init__(self, folder: Union[str, Path]):
        self.folder = Path(folder)
        if not (self.folder / "sweep.json").exists():
            raise DatasetError(f"{self.folder}: is not the folder of a sweep (no sweep.json); SonarDataset opens a data "
                               "set")
        self.info = read_manifest(self.folder / "sweep.json", "ensonify_sweep_folder")
        path = self.folder / "plan.jsonl"
        with told_of(path):
            plan = [json.loads(line) for line in read_bytes(path).decode("utf-8").splitlines()]
            for line in plan:
                # It becomes the name of a folder.
                if not re.fullmatch("[0-9a-f]{16}", line["run"]):
                    raise ValueError(f"{line['run']!r} is not the id of a run")
            self.settings = {line["run"]: _leaves(line.get("settings", {})) for line in plan}
            self.columns = _columns(list(plan[0]["values"]))
            self.table = self._rows(plan)

    def _rows(self, plan: Sequence[Dict[str, Any]]) -> List[Dict[str, Any]]:
        path = self.folder / "runs.csv"  # only of a finished sweep
        tabled = {row["run"]: row for row in read_table(path)} if path.exists() else {}
        rows = []
        for line in plan:
            run = line["run"]
            of = tabled.get(run, {})
            row = {"run": run, "name": line["name"]}
            row.update((column, line["values"][axis]) for axis, column in self.columns.items())
            row.update(seed=line["seed"], pings=line["pings"], folder=f"runs/{run}", status=self._status(run))
            if of.get("status") == "damaged":
                row["status"] = "damaged"
            row.update((name, float(of[name]) if of.get(name) else None) for name in _NUMBERS)
            rows.append(row)
        return rows

    def _status(self, run: str) -> str:
        folder = self.folder / "runs" / run
        if (folder / "dataset.sha256").exists() and not (folder / ".work").exists():
            return "done"
        if (self.folder / "failed" / f"{run}.json").exists():
            return "failed"
        return "running" if folder.exists() else "missing"

    @property
    def name(self) -> str:
        return self.info["name"]

    @property
    def axes(self) -> Dict[str, List[Any]]:
        """The values of each axis that these runs have, in the order of the plan."""
        return {axis: _distinct(row[column] for row in self.table) for axis, column in self.columns.items()}

    @property
    def unfinished(self) -> List[Dict[str, Any]]:
        """The rows of runs that are not done; `reason` is why a run failed."""
        return [{**row, "reason": self._reason(row)} for row in self.table if row["status"] != "done"]

    def _reason(self, row: Dict[str, Any]) -> Optional[str]:
        if row["status"] != "failed":
            return None
        path = self.folder / "failed" / f"{row['run']}.json"
        with told_of(path):
            return str(json.loads(read_bytes(path))["message"])

    def __len__(self) -> int:
        return len(self.table)

    def __iter__(self) -> Iterator[SweepRun]:
        rest = self.unfinished
        if rest:
            more = f"\n  and {len(rest) - _MOST_NAMED} more" if len(rest) > _MOST_NAMED else ""
            raise DatasetError(
                f"{self.folder}: {len(rest)} of {len(self)} runs are not done; the command of the sweep makes them, and "
                "select(status=\"done\") leaves them out" + "".join(map(_told, rest[:_MOST_NAMED])) + more)
        return (SweepRun(self, row) for row in self.table)

    def run(self, which: Union[str, int]) -> SweepRun:
        """By id, by the first digits of one, by name, or by place in `table`."""
        row = self.table[which] if isinstance(which, int) else self._row_of(which)
        if row["status"] != "done":
            raise DatasetError(f"{self.folder}: this run is not done:{_told({**row, 'reason': self._reason(row)})}")
        return SweepRun(self, row)

    def _row_of(self, which: str) -> Dict[str, Any]:
        found = [row for row in self.table if which in (row["run"], row["name"])]
        found = found or [row for row in self.table if which and row["run"].startswith(which)]
        if len(found) == 1:
            return found[0]
        if found:
            raise DatasetError(f"{self.folder}: {which!r} is ambiguous; expected one of the ids "
                               f"{_joined([row['run'] for row in found])}")
        known = [text for row in self.table for text in (row["name"], row["run"])]
        raise DatasetError(f"{self.folder}: no run is {which!r}{_meant(which, known)}; `table` lists them")

    def select(self, **conditions: Any) -> "SonarSweep":
        """The runs that meet all conditions."""
        chosen = self.table
        for name, condition in conditions.items():
            value_of = self._values(name)
            kept = [row for row in chosen if _meets(value_of(row), condition)]
            if not kept:
                known = _distinct(map(value_of, chosen))
                asked = "that value" if callable(condition) else repr(condition)
                raise DatasetError(f"{self.folder}: none of {len(chosen)} runs has {name} = {asked}"
                                   f"{_meant(condition, known)}; expected one of {_joined(known)}")
            chosen = kept
        selected = object.__new__(SonarSweep)
        selected.__dict__.update(self.__dict__, table=chosen)
        selected.__dict__.pop("_keys", None)
        return selected

    @cached_property
    def _keys(self) -> List[str]:
        return _distinct(key for row in self.table for key in self.settings[row["run"]])

    def _values(self, name: str) -> Callable[[Dict[str, Any]], Any]:
        """What a name in `select` means: a function from row to value."""
        if name in self.columns:
            return lambda row: row[self.columns[name]]
        if name in self._keys:
            return lambda row: self.settings[row["run"]].get(name)
        found = [key for key in self._keys if key.endswith("." + name)]
        if len(found) == 1:
            return lambda row: self.settings[row["run"]].get(found[0])
        if found:
            raise DatasetError(f"{self.folder}: {name} is ambiguous; expected one of the keys {_joined(found)}, as in "
                               f"select(**{{\"{found[0]}\": …}})")
        if name in _COLUMNS + _NUMBERS or name in self.columns.values():
            return lambda row: row[name]
        known = [*self.columns, *self._keys, *(key.rsplit(".", 1)[-1] for key in self._keys), *_COLUMNS, *_NUMBERS]
        # Plans of earlier versions have no key paths.
        keys = f" or a key ({_joined(self._keys)})" if self._keys else ""
        raise DatasetError(f"{self.folder}: nothing is named {name}{_meant(name, known)}; expected an axis "
                           f"({_joined(list(self.columns))}){keys}")


def _columns(axes: Sequence[str]) -> Dict[str, str]:
    """The column of each axis in runs.csv, whose own columns keep their names."""
    columns = {}
    for axis in axes:
        name = axis
        while name in _COLUMNS + _NUMBERS or (name != axis and name in axes):
            name = "axis_" + name
        columns[axis] = name
    return columns


def _leaves(settings: Dict[str, Any], before: str = "") -> Dict[str, Any]:
    """Key paths down to values that are not maps."""
    leaves: Dict[str, Any] = {}
    for key, value in settings.items():
        path = f"{before}{key}"
        leaves.update(_leaves(value, path + ".") if isinstance(value, dict) and value else {path: value})
    return leaves


def _meets(value: Any, condition: Any) -> bool:
    if callable(condition):
        return value is not None and bool(condition(value))
    if _equal(value, condition):
        return True
    return isinstance(condition, (list, tuple, set, frozenset, range)) and any(_equal(value, one) for one in condition)


def _equal(value: Any, other: Any) -> bool:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            # Values of `log` and random axes are rounded in the plan.
            return math.isclose(value, float(other), rel_tol=1e-6, abs_tol=1e-12)
        except (TypeError, ValueError):
            return False
    if isinstance(value, list) and isinstance(other, (list, tuple)):
        return len(value) == len(other) and all(map(_equal, value, other))
    return bool(value == other)


def _distinct(values: Any) -> List[Any]:
    found: Dict[str, Any] = {}
    for value in values:
        found.setdefault(json.dumps(value, sort_keys=True), value)
    return list(found.values())


def _joined(values: Sequence[Any]) -> str:
    shown = ", ".join(value if isinstance(value, str) else json.dumps(value) for value in values[:12])
    return shown + (f" and {len(values) - 12} more" if len(values) > 12 else "")


def _meant(given: Any, known: Sequence[Any]) -> str:
    near = get_close_matches(given, [text for text in known if isinstance(text, str)], 1) if isinstance(given, str) else []
    return f" (did you mean {near[0]}?)" if near else ""


def _told(row: Dict[str, Any]) -> str:
    reason = f": {row['reason']}" if row["reason"] else ""
    return f"\n  {row['run']} {row['name']}: {row['status']}{reason}"
