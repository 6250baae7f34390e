"""The parts of scenes/watertank.yaml that scripts/tank_study.py can switch off, one entry each: settings KEY=VALUE."""
from dataclasses import dataclass
from typing import Tuple

EVEN = "{model: gamma, shape: 10000, correlation_m: 0.02}"
TEXTURED = ("paint", "metal", "iron", "brass", "blades", "coated", "tread", "plastic")


@dataclass(frozen=True)
class Part:
    meaning: str
    off: Tuple[str, ...]


PARTS = {
    "detector": Part("looks, logarithmic amplifier and integration: levels of one look without it",
                     ("sonar.detector={looks: 1, noise_db: 0, integrate: 1, law: power}",)),
    "comb": Part("levels of the groups of beams", ("sonar.transmit={groups: 8, interval_s: 0.005}",)),
    "background": Part("echo of the water", ("volumes=[]",)),
    "texture": Part("random variation of the reflectivity of the floor and of bodies",
                    (*(f"materials.{name}.texture={EVEN}" for name in TEXTURED), "materials.paint.growth.cover=0")),
    "noise": Part("noise of the receiver", ("noise.spectrum_level_db=-60",)),
}


def chosen_parts(text):
    """The names in a list with commas; `all`: every part. A ValueError names an unknown one."""
    names = list(PARTS) if text == "all" else [name for name in (text or "").split(",") if name]
    for name in names:
        if name not in PARTS:
            raise ValueError(f"--ablate: there is no part {name!r}; expected all, or some of {', '.join(PARTS)}")
    return names
