"""The counts of a recorder, and the levels that they stand for."""
from pathlib import Path
from typing import Any, Dict, Optional

import numpy as np

from .files import read_npy, read_png
from .manifest import missing, read_row


def recorded_counts(folder: Path, info: Dict[str, Any], row: int, stem: str) -> np.ndarray:
    """uint8 or uint16 [samples, beams] of a ping."""
    bits = _recorder(folder, info)["bits"]
    packed, single = folder / f"recorded_{bits}bit.npy", folder / "recorded" / f"{stem}_{bits}bit.png"
    if packed.exists():
        return np.array(read_row(packed, row))
    if not single.exists():
        raise missing(single, "recorded counts")
    return read_png(single)


def level_of_counts(recorder: Dict[str, Any], counts: np.ndarray, gain: Optional[np.ndarray]) -> np.ndarray:
    """float32 [samples, beams]: level = lo + count (hi - lo)/m, or hi + 20/gamma log10(count/m) - 10 log10(row gain),
    m = 2^bits - 1. `recorder` is that of sequence.json; `gain` is None without row gains."""
    lo, hi = recorder["db"]
    share = counts / (2.0 ** recorder["bits"] - 1)
    if recorder["scale"] == "db":
        return (lo + share * (hi - lo)).astype(np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        level_db = hi + 20 / recorder["gamma"] * np.log10(share)
        if gain is not None:  # a log can have 0
            share = share * (gain[:, None] > 0)
            level_db -= 10 * np.log10(gain.astype(float))[:, None]
    return np.where(share > 0, level_db, -99).astype(np.float32)


def _recorder(folder: Path, info: Dict[str, Any]) -> Dict[str, Any]:
    if "recorder" not in info:
        raise missing(folder / "recorded", "recorded counts")
    return info["recorder"]


def row_gain(folder: Path, row: int, stem: str) -> Optional[np.ndarray]:
    """float32 [samples] of a ping; None without row gains."""
    packed, single = folder / "recorded_row_gain.npy", folder / "recorded" / f"{stem}_row_gain.npy"
    if packed.exists():
        return np.array(read_row(packed, row))
    return read_npy(single) if single.exists() else None
