"""The parts of the physics that scripts/real_study.py can switch, one entry each.

A part is a list of settings KEY=VALUE of the scenario. `on` is used with the part and `off` without it; `off` is needed
only where scene.yaml or the preset of a material has the part already. With `classes` the part belongs to these targets
alone. A part that `needs` another one is left out with it. `mirrored` has no settings: crops.py draws the images. To
report the share of a new part, add an entry.
"""
from dataclasses import dataclass
from typing import Tuple


@dataclass(frozen=True)
class Part:
    meaning: str
    on: Tuple[str, ...] = ()
    off: Tuple[str, ...] = ()
    classes: Tuple[str, ...] = ()  # empty: all classes
    needs: str = ""


PARTS = {
    "bounces": Part("paths over up to two further surfaces", on=("bounces=2",)),
    "texture": Part(
        "random variation of the reflectivity over a body",
        on=("materials.body.texture={model: gamma, shape: {log_uniform: [0.5, 4]}, "
            "correlation_m: {log_uniform: [0.01, 0.05]}}",),
        off=("materials.body.texture={model: gamma, shape: 10000, correlation_m: 0.03}",)),
    "growth": Part(
        "patches of mussels",
        on=("materials.fouling={preset: mussels, backscatter_strength_db: {uniform: [-30.0, -20]}}",
            "materials.body.growth={material: fouling, cover: {uniform: [0.0, 0.3]}, correlation_m: 0.1}")),
    "kirchhoff": Part(
        "specular echoes of smooth surfaces",
        on=("materials.body.coherent.roughness_rms_m={log_uniform: [1e-4, 4e-4]}",),
        off=("materials.body.coherent.roughness_rms_m=0.01",)),
    "roughness": Part(
        "energy that roughness takes from specular echoes and scatters around them",
        on=("materials.body.coherent.roughness_correlation_m={log_uniform: [1e-3, 2e-2]}",),
        classes=("big_propeller", "small_propeller"), needs="kirchhoff"),
    "edges": Part(
        "diffraction at sharp edges",
        on=("materials.body.coherent.edges=true",),
        classes=("big_propeller", "small_propeller"), needs="kirchhoff"),
    "walls": Part(
        "cylinders of steel that are full of water",
        on=("materials.body.wall={thickness_m: {log_uniform: [5e-4, 4e-3]}, density_kg_m3: 7850, speed_m_s: 5900, "
            "shear_speed_m_s: 3230}",),
        classes=("cylinder",)),
    "hoses": Part(
        "pipes of rubber that are full of water",
        on=("materials.body.wall={thickness_m: {uniform: [0.003, 0.008]}, density_kg_m3: 1100, speed_m_s: 1600, "
            "loss: 0.1}",),
        classes=("soft_pipeline",)),
    "surface_speckle": Part("scatterers that are fixed on the surfaces", on=("scattering.speckle=surface",)),
    "tail": Part(
        "a rope that leans away from the sonar, so that its echoes lie behind the target",
        on=("materials.rope={preset: netting, backscatter_strength_db: {uniform: [-18.0, -6]}}",
            "objects.rope.material=rope", "variables.rope_m={uniform: [0.3, 1.2]}",
            "variables.lean_rad={uniform: [0.5, 1.1]}", "objects.rope.shape.cylinder.radius_m={uniform: [0.008, 0.02]}"),
        classes=("big_propeller", "cylinder", "small_propeller")),
    "reverberation": Part(
        "echo of the water",
        on=("volumes=[{name: water, class: reverberation, uniform: {strength_db: {uniform: [-58, -46]}}}]",)),
    "noise": Part("noise of the receiver", on=("noise.spectrum_level_db={uniform: [38, 56]}",)),
    "half_beams": Part("256 beams in half of the worlds, 512 in the others", on=("sonar.beams.count={choice: [256, 512]}",)),
    "mirrored": Part("a viewer that draws each beam mirrored in azimuth"),
    "stripes": Part(
        "gain errors of beams, and cross-talk",
        on=("sonar.electronics.beam_gain_error_db=0.5", "sonar.electronics.crosstalk_db={uniform: [-50, -35]}")),
    "streaks": Part(
        "saturation with a tail behind what is clipped",
        on=("sonar.electronics.saturation={level_db: {uniform: [150, 170]}, streak_db: {uniform: [-30, -18]}, "
            "streak_m: {log_uniform: [0.1, 1]}}",)),
    "detector": Part("levels that are means over samples", on=("sonar.detector={integrate: {uniform: [1, 1.4]}}",)),
    "array": Part("a line array whose elements have errors",
                  on=("sonar.receiver={mode: array, gain_error_db: 0.3, phase_error_deg: 3}",)),
}


def chosen_parts(only, without):
    """The names of the parts to use; a ValueError names an unknown one."""
    for name in [*(only or []), *without]:
        if name not in PARTS:
            raise ValueError(f"there is no part {name!r}; expected some of {', '.join(PARTS)}")
    chosen = [name for name in PARTS if (only is None or name in only) and name not in without]
    return [name for name in chosen if PARTS[name].needs in ("", *chosen)]


def part_settings(parts, target):
    """The settings KEY=VALUE of all parts for a target."""
    settings = []
    for name, part in PARTS.items():
        applies = not part.classes or target.name in part.classes
        settings += part.on if name in parts and applies else part.off
    return settings
