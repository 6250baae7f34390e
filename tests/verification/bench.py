"""The test bench: rows of the report, the list of cases, and runs of the program.

A case is a function that takes a Bench and yields its rows. It runs the program through
Bench.run and works out what to expect by itself; what a case does not get to say (the program
refuses the scenario, a file is missing) becomes a row that fails.
"""
import json
import math
import pathlib
import subprocess
import sys
from dataclasses import dataclass

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "independent"))

import numpy as np  # noqa: E402

from sequence import DataSet  # noqa: E402

SCENES = HERE.parent.parent / "scenes"


@dataclass(frozen=True)
class Row:
    """One line of the report; standard_error and draws belong to statistical experiments."""

    identity: str
    experiment: str
    expected: float
    obtained: float
    tolerance: float
    unit: str = "dB"
    standard_error: float | None = None
    draws: int | None = None
    trouble: str = ""

    @property
    def passed(self):
        return not self.trouble and abs(self.obtained - self.expected) <= self.tolerance


def statistical(identity, experiment, expected, obtained, error, draws, unit="dB", tolerance=None):
    """A row of a mean with this standard error, three of them wide unless a tolerance is given."""
    width = 3 * error if tolerance is None else tolerance
    return Row(identity, experiment, expected, obtained, width, unit, standard_error=error, draws=draws)


CASES = {}


def case(identity):
    """Register a function as the case of this name; names are in the order of the report."""

    def register(function):
        CASES[identity] = function
        return function

    return register


def default_scenario():
    """The conditions of the closed forms: 900 kHz, 29.9 kHz, 1500 m/s, 1 x 20 degrees, 220 dB."""
    return {
        "ensonify": 1,
        "seed": 1,
        "sonar": {
            "frequency_hz": 900000.0,
            "bandwidth_hz": 29900.0,
            "source_level_db": 220,
            "range_max_m": 6,
            "beams": {"count": 41, "spacing_deg": 0.25, "receive_width_deg": 1},
            "elevation": {"width_deg": 20},
            # As many rays as a case asks for.
            "rays": {"elevation": 8, "azimuth": 1, "min_per_cell": 0},
        },
        "water": {"sound_speed_m_s": 1500, "absorption": {"fixed_db_m": 0}},
        "output": {"timeseries": "npy", "polar": False, "cartesian": False, "png": False},
    }


def merged(base, changes):
    """A copy of a tree of maps with changes put in; None takes a key out."""
    out = dict(base)
    for key, value in changes.items():
        if isinstance(value, dict) and isinstance(out.get(key), dict):
            out[key] = merged(out[key], value)
        elif value is None:
            out.pop(key, None)
        else:
            out[key] = value
    return out


def diffuse(name, shape, position_m=(0, 0, 0), rotation_deg=(0, 0, 0), material="m"):
    """One entry of objects."""
    return {
        "name": name,
        "material": material,
        "shape": shape,
        "pose": {"position_m": list(position_m), "rotation_deg": list(rotation_deg)},
    }


def point_target(name, strength_db, position_m):
    """One entry of point_targets."""
    return {
        "name": name,
        "target_strength_db": strength_db,
        "position_m": list(map(float, position_m)),
    }


class Bench:
    """Runs the program into a folder; a scenario that was run before is not run again."""

    def __init__(self, program, folder, figures=False):
        """figures: whether cases add what only a figure shows."""
        self.program, self.folder, self.figures = program, pathlib.Path(folder), figures
        self.done, self.curves, self.places = {}, {}, 0

    def run(self, changes, scatterers=False, files=None, arguments=()):
        """Generate default_scenario with changes; files are written beside it. A Sequence."""
        scenario = merged(default_scenario(), changes)
        return self.run_text(json.dumps(scenario, indent=1), scatterers, files, arguments)[0]

    def run_worlds(self, changes, count):
        """The same of a number of sequences, which differ in all that is random: a list of Sequence."""
        scenario = merged(default_scenario(), {**changes, "sequences": count})
        return self.run_text(json.dumps(scenario, indent=1))

    def run_text(self, text, scatterers=False, files=None, arguments=()):
        key = json.dumps([text, scatterers, files, list(arguments)], default=repr)
        if key not in self.done:
            place = self._new_place()
            for name, content in (files or {}).items():
                (place / name).write_text(content, encoding="utf-8")
            (place / "scenario.yaml").write_text(text, encoding="utf-8")
            self.done[key] = self._generate(
                place / "scenario.yaml", place / "data", scatterers, arguments
            )
        return self.done[key]

    def run_scene(self, name, scatterers=True, arguments=()):
        """Generate one of scenes/*.yaml."""
        key = (name, scatterers, tuple(arguments))
        if key not in self.done:
            place = self._new_place()
            self.done[key] = self._generate(SCENES / name, place / "data", scatterers, arguments)[0]
        return self.done[key]

    def _new_place(self):
        place = self.folder / f"{self.places:03d}"
        self.places += 1
        place.mkdir(parents=True)
        return place

    def _generate(self, scenario, data, scatterers, arguments):
        command = [self.program, "generate", str(scenario), "-o", str(data), "--quiet", *arguments]
        command += ["--export-scatterers"] if scatterers else []
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode != 0:
            # Only what the program says, without the folder it was said of.
            words = result.stderr.strip().splitlines() or ["no message"]
            raise ProgramFailed(
                f"exit {result.returncode}: " f"{words[0].replace(str(self.folder), '')[:160]}"
            )
        return DataSet(str(data)).sequences

    def curve(self, figure, label, x, obtained, expected=None):
        """Keep a curve for the figures."""
        self.curves.setdefault(figure, []).append(
            (
                label,
                np.asarray(x),
                None if obtained is None else np.asarray(obtained),
                None if expected is None else np.asarray(expected),
            )
        )


class ProgramFailed(Exception):
    """The program did not make the data set."""


# What a case may break by.
BREAKS = (ProgramFailed, ValueError, KeyError, IndexError, OSError, TypeError, ArithmeticError)


def broken_row(identity, words, error):
    """The row of a case that gave none, which fails and says why."""
    trouble = str(error) if isinstance(error, str) else f"{type(error).__name__}: {error}"
    trouble = trouble.replace("|", "/").replace("\n", " ")
    return Row(identity, words, math.nan, math.nan, math.nan, "", trouble=trouble)


def rows_of(identity, bench):
    """The rows of one case; a case that breaks gives one row that says so."""
    try:
        rows = list(CASES[identity](bench))
    except BREAKS as error:
        return [broken_row(identity, "could not be made", error)]
    return rows or [broken_row(identity, "no rows", "no rows")]
