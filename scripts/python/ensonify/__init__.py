"""Multibeam sonar data from scenarios: single pings, endless streams for training, whole data sets.

    import ensonify as en
    scene = en.Scenario.load("scenes/random_debris.yaml", set={"sonar.range_max_m": 8})
    ping = scene.ping(sequence=3, ping=0)          # arrays, no files
    ping.polar.level_db                            # float32 [samples, beams], dB re 1 uPa
    for ping in scene.stream(sequences=range(1000), want=["level_db", "instance"]):
        ...
    en.generate(scene, "out/set")                  # the files that the program writes

docs/python.md describes it. `ensonify.dataset` reads finished data sets with NumPy alone;
`ensonify.torch` is for PyTorch.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .errors import Fault, ScenarioError

if TYPE_CHECKING:
    from ensonify_dataset import flow_to_image, project, unproject

    from .generation import generate
    from .live import LivePing, LiveSequence, LiveView
    from .scenario import Scenario, Stream

__all__ = ["Fault", "LivePing", "LiveSequence", "LiveView", "Scenario", "ScenarioError", "Stream",
           "flow_to_image", "generate", "project", "unproject"]

_PLACES = {"generate": "generation", "LivePing": "live", "LiveSequence": "live", "LiveView": "live",
           "Scenario": "scenario", "Stream": "scenario", "__version__": "_core",
           "flow_to_image": "dataset", "project": "dataset", "unproject": "dataset"}


def __getattr__(name: str) -> Any:
    """Imports the extension only where something of it is asked for."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module
    return getattr(import_module(f".{_PLACES[name]}", __name__), name)
