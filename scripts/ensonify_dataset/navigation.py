"""Navigation sensors of a sequence: the tables of its folder `navigation`."""
from __future__ import annotations

import io
from typing import TYPE_CHECKING, Dict

import numpy as np

from .files import read_bytes
from .manifest import missing, told_of

if TYPE_CHECKING:
    from .dataset import SequenceFolder

SENSORS = ("imu", "dvl", "depth", "altimeter", "usbl", "gps", "odometry")


def navigation_of(sequence: "SequenceFolder") -> Dict[str, np.ndarray]:
    folder = sequence.folder / "navigation"
    sensors = sequence.info.get("navigation")
    if sensors is None:
        raise missing(folder, "navigation sensors")
    names = [name for name in SENSORS if name in sensors] + ["imu_truth"] * ("imu" in sensors)
    tables = {}
    for name in names:
        path = folder / f"{name}.csv"
        with told_of(path):
            header, _, rows = read_bytes(path).decode().partition("\n")
            columns = header.split(",")
            kind = np.dtype([(column, np.float64) for column in columns])
            values = np.loadtxt(io.StringIO(rows), delimiter=",", ndmin=2) if rows else np.empty((0, len(columns)))
            tables[name] = np.ascontiguousarray(values).view(kind)[:, 0]
    return tables
