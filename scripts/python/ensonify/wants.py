"""What may be asked of a ping, and which outputs of the scenario bring it."""
from __future__ import annotations

from difflib import get_close_matches
from typing import Dict, Iterable, List, Optional, Set

from ensonify_dataset import View
from ensonify_dataset.manifest import OUTPUTS
from ensonify_dataset.views import PLANES

# Names beside those of planes.
_WHOLE = {"series": {"timeseries"}, "layers": {"layers"}, "channels": {"channels"},
          "elevation": {"elevation"}}
# Arrays of `ping.front`, where a normal is one array.
_FRONT = {"position_m", *(row["name"].replace("normal_x", "normal") for row in OUTPUTS["front"])} - {"normal_y", "normal_z"}
# Of `ping.camera`, where normals and flow are one array each.
_CAMERA = {**{{"normal_x": "normal", "flow_x_px": "flow_px"}.get(row["name"], row["name"]): set(row["needs"])
              for row in OUTPUTS["camera"] if row["name"] not in ("normal_y", "normal_z", "flow_y_px")},
           "position_m": {"camera_geometry"}}


def planes() -> List[str]:
    """The arrays of a view, as `View` has them."""
    return sorted(PLANES)


def _flags_of_plane(view: str, plane: str) -> Set[str]:
    flags = {view, *PLANES[plane]["needs"]}
    if view == "cartesian" and View.is_float(plane):
        flags |= {"polar", "cartesian_exr"}
    return flags


def _table() -> Dict[str, Set[str]]:
    table = {**_WHOLE, **{f"front.{name}": {"front"} for name in _FRONT}}
    table.update({f"camera.{name}": flags for name, flags in _CAMERA.items()})
    for view in ("polar", "cartesian"):
        table[f"{view}.annotations"] = {view, "amodal"}
        table[f"{view}.grey"] = {view, "png"}
        for plane in planes():
            table[f"{view}.{plane}"] = _flags_of_plane(view, plane)
    for name in [name for name in table if name.startswith("polar.")]:
        table[name.split(".", 1)[1]] = table[name]
    return table


# Outputs that are left out without a word where the scenario has them off: others stand in for them.
_OPTIONAL = {"cartesian_exr", "amodal"}


def flags_of(want: Optional[Iterable[str]], made: Iterable[str]) -> List[str]:
    """The outputs of `made`, those of the scenario, that `want` needs; all where it is None.

    Errors: ValueError for an unknown name, with the nearest one, and for one that the scenario does not make.
    """
    there = set(made)
    if want is None:
        return sorted(there)
    table, needed = _table(), set()
    for name in want:
        if name not in table:
            near = get_close_matches(name, table, 1)
            hint = f" (did you mean {near[0]!r}?)" if near else ""
            raise ValueError(f"want: {name!r} is not part of a ping{hint}; expected series, layers, channels, elevation, "
                             f"annotations, grey and the planes of a view, with cartesian., front. or camera. before those of these views")
        flags = table[name]
        if name == "series" and "timeseries" not in there:
            flags = {"timeseries_exr"}
        missing = sorted(flags - there - _OPTIONAL)
        if missing:
            key = "timeseries" if missing[0] == "timeseries_exr" else missing[0]
            raise ValueError(f"want: {name!r} needs output.{key}, which the scenario has off; set it, as in "
                             f"set={{\"output.{key}\": ...}}")
        needed |= flags & there
    return sorted(needed)
