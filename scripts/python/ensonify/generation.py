"""Whole data sets."""
from __future__ import annotations

import warnings
from pathlib import Path
from typing import Callable, Optional, Tuple, Union

from . import _core
from .scenario import _POLL_MS, Scenario


def generate(scenario: Scenario, folder: Union[str, Path], sequences: Optional[Tuple[int, int]] = None,
             threads: int = 0, overwrite: bool = False,
             progress: Optional[Callable[[int, int], None]] = None) -> None:
    """Writes a data set, or goes on with it: the files that `ensonify generate` writes.

    `sequences`: those from the first to before the second; None: all. `progress(done, all)` is called with numbers of
    pings, about ten times a second. Ctrl-C, and an exception of `progress`, end the run when the pings under way are
    written; the same call goes on from there. Warnings are those of the program.
    Errors: those of Scenario; ScenarioError where sequences could not be made, when all others are; OSError.
    """
    core = _core.Generation(scenario._core, str(folder), sequences, threads, overwrite)
    try:
        told = None
        while not core.wait(_POLL_MS):
            now = core.progress()
            if progress is not None and now != told and now[1] > 0:
                progress(*now)
                told = now
    except BaseException:
        core.stop()
        while not core.wait(_POLL_MS):
            pass
        raise
    for text in core.warnings():
        warnings.warn(text, UserWarning, stacklevel=2)
    core.check()
    if progress is not None and core.progress()[1] > 0 and core.progress() != told:
        progress(*core.progress())
