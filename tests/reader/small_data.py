"""Small data sets for the tests of the reader. ENSONIFY is the program, SOURCE the source tree."""
import atexit
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SOURCE = pathlib.Path(os.environ.get("SOURCE", pathlib.Path(__file__).resolve().parents[2]))
SCENES = SOURCE / "scenes"
sys.path.insert(0, str(SOURCE / "scripts"))
sys.path.insert(0, str(SOURCE / "tests/independent"))

SMALL = ["--set", "sonar.beams.count=32", "--set", "sonar.rays.elevation=24", "--set", "output.png=true",
         "--set", "output.cartesian={height_px: 60}"]

# A fan instead of azimuths that the preset gives for each beam.
OWN = {"watertank": ["--set", "sonar.beams.fov_deg=30"]}


def generate(scene, folder, *more, expected=0):
    """Of a scene of the project, few beams and rays."""
    command = [PROGRAM, "generate", SCENES / f"{scene}.yaml", "-o", folder, "--quiet", *SMALL, *OWN.get(scene, ()), *more]
    # What tests of a sanitized extension preload does not go with a sanitized program.
    environment = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}
    result = subprocess.run([*map(str, command)], capture_output=True, text=True, env=environment)
    assert result.returncode == expected, result.stderr
    return folder


# Scenes that differ in what a data set holds; other_scenes_test.py of either folder takes the others.
KINDS = ("bubble_plume", "calibration_sphere", "echo_trains", "pile_inspection", "random_debris", "seabed_and_target",
         "shallow_water", "speckle_wall")


def other_scenes():
    return sorted({path.stem for path in SCENES.glob("*.yaml")} - set(KINDS))


_shared = {}


def shared(scene, *more):
    """A data set that the tests of a process have in common. Nobody changes it: see `copied`."""
    if not _shared:
        _shared[None] = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        atexit.register(shutil.rmtree, _shared[None], ignore_errors=True)
    if (scene, *more) not in _shared:
        _shared[scene, *more] = generate(scene, _shared[None] / str(len(_shared)), *more)
    return _shared[scene, *more]


def copied(folder, scene, *more):
    """A copy of it of one's own."""
    return shutil.copytree(shared(scene, *more), folder)
