"""The classes of targets, and the data sets that are made of them.

    TARGETS                     one entry for each class of crops
    simulated_sets(...)         makes the missing data sets; [(class, folder), ...]
"""
from dataclasses import dataclass
from pathlib import Path

from .data_sets import command_of, folder_of, make
from .meshes import write_if_new, write_meshes
from .parts import part_settings

SCENE = Path(__file__).with_name("scene.yaml")
# The fan holds the main lobe of the vertical pattern; fewer rays than the preset has, since scenes are empty.
MODES = {"hf": ("sonar.preset=oculus_m750d_hf", "sonar.rays.elevation=128", "sonar.elevation.fan_deg=20",
               "sonar.beams.receive_width_deg={uniform: [0.6, 0.9]}"),
         "lf": ("sonar.preset=oculus_m750d_lf", "sonar.rays.elevation=160", "sonar.elevation.fan_deg=30",
               "sonar.beams.receive_width_deg={uniform: [1.0, 1.5]}")}
FIRST_SEED = 41


@dataclass(frozen=True)
class Target:
    name: str
    material: str           # of `ensonify presets materials`
    shape: str = ""         # of the scenario; a mesh where it is empty
    scale_m: tuple = ()     # radius of the smallest and largest mesh, which has the radius 1
    rotation_deg: str = "[{uniform: [-90, 90]}, {uniform: [-90, 90]}, {uniform: [0, 360]}]"
    most_behind: float = 0.8    # the largest margin behind, of the box: a part of the tail is seen there


TARGETS = [
    Target("big_propeller", "steel_smooth", scale_m=(0.15, 0.32)),
    Target("cylinder", "steel_smooth",
           shape="{cylinder: {radius_m: {uniform: [0.08, 0.16]}, height_m: {uniform: [0.2, 0.45]}}}",
           rotation_deg="[{uniform: [-90, 90]}, {uniform: [-40, 40]}, {uniform: [0, 360]}]"),
    Target("small_propeller", "aluminum_smooth", scale_m=(0.1, 0.24)),
    Target("soft_pipeline", "rubber", rotation_deg="[{uniform: [-20, 20]}, {uniform: [-20, 20]}, {uniform: [0, 360]}]",
           most_behind=0.35),
]
CLASSES = [target.name for target in TARGETS]


def shape_of(target, meshes):
    """The shape of a target in YAML; each sequence samples one of the meshes."""
    if target.shape:
        return target.shape
    scale = ", scale: {uniform: [%g, %g]}" % target.scale_m if target.scale_m else ""
    choices = [f"{{mesh: {{file: meshes/{name}, normals: smooth{scale}}}}}" for name in meshes[target.name]]
    return "{choice: [" + ", ".join(choices) + "]}"


def target_settings(target, mode, parts, meshes):
    """All settings KEY=VALUE that make the data set of a class from scene.yaml; each has a seed of its own."""
    seed = FIRST_SEED + TARGETS.index(target) * len(MODES) + list(MODES).index(mode)
    return [*MODES[mode], f"seed={seed}", f"name={target.name}_{mode}", f"objects.target.class={target.name}",
            f"objects.target.shape={shape_of(target, meshes)}",
            f"objects.target.pose.rotation_deg={target.rotation_deg}", f"materials.body.preset={target.material}",
            *part_settings(parts, target)]


def simulated_sets(options, parts, report):
    """Makes one data set for each class and frequency in `options.keep`, and returns [(class, folder), ...]."""
    root = Path(options.keep)
    meshes = write_meshes(root / "meshes")
    scene = root / SCENE.name
    write_if_new(scene, SCENE.read_text())
    found, commands = [], {}
    for target in TARGETS:
        for mode in MODES:
            settings = target_settings(target, mode, parts, meshes) + options.set
            shapes = [(root / "meshes" / name).read_text() for name in meshes.get(target.name, ())]
            folder = folder_of(root, f"{target.name}_{mode}", "\n".join([scene.read_text(), *settings, *shapes]))
            commands[folder.name] = command_of(options.program, scene, folder,
                                               [*settings, f"sequences={options.sequences}"])
            found.append((target.name, folder))
    make(options.program, commands, options.threads, report)
    return found
