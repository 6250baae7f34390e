"""More rays must not change the mean level of a diffuse scene, here of 64 beams of it."""
import numpy as np

import physics
from bench import Row, case


def scene_level(bench, scene, settings):
    """Level of the mean clean power of ping 0."""
    arguments = ["--pings", "0:1"]
    for setting in settings:
        arguments += ["--set", setting]
    sequence = bench.run_scene(scene, arguments=tuple(arguments))
    surfaces = [i for i, instance in sequence.instances.items() if instance.kind == "surface"]
    scatterers = sequence.scatterers(0)
    scatterers = scatterers[np.isin(scatterers["instance"], surfaces)]
    return float(10 * np.log10(physics.expected_power(scatterers, sequence.sonar).mean()) + 120)


@case("convergence")
def twice_the_rays(bench):
    """The tank and the rippled seabed with twice the rays in either direction."""
    fan_alone = ("sonar.rays.min_per_cell=0", "sonar.beams.count=64")
    for scene, twice in (("sonar_tank.yaml", 228), ("seabed_and_target.yaml", 660)):
        before = scene_level(bench, scene, fan_alone)
        for direction, count in (("azimuth", 2), ("elevation", twice)):
            yield Row(
                f"convergence.{scene.split('.', maxsplit=1)[0]}.{direction}",
                f"{scene}: mean expected level with twice the rays in {direction}",
                before,
                scene_level(bench, scene, (*fan_alone, f"sonar.rays.{direction}={count}")),
                0.1,
            )
