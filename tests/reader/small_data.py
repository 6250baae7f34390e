"""Small data sets for the tests of the reader. ENSONIFY is the program, SOURCE the source tree."""
import os
import pathlib
import subprocess
import sys

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SOURCE = pathlib.Path(os.environ.get("SOURCE", pathlib.Path(__file__).resolve().parents[2]))
SCENES = SOURCE / "scenes"
sys.path.insert(0, str(SOURCE / "scripts"))
sys.path.insert(0, str(SOURCE / "tests/independent"))

SMALL = ["--set", "sonar.beams.count=32", "--set", "sonar.rays.elevation=24", "--set", "output.png=true",
         "--set", "output.cartesian={height_px: 60}"]


def generate(scene, folder, *more, expected=0):
    """Of a scene of the project, few beams and rays."""
    command = [PROGRAM, "generate", SCENES / f"{scene}.yaml", "-o", folder, "--quiet", *SMALL, *more]
    # What tests of a sanitized extension preload does not go with a sanitized program.
    environment = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}
    result = subprocess.run([*map(str, command)], capture_output=True, text=True, env=environment)
    assert result.returncode == expected, result.stderr
    return folder


def has_key(*settings):
    """Whether the program takes these --set, for what may be switched off in it."""
    command = [PROGRAM, "check", SCENES / "sonar_tank.yaml"]
    for setting in settings:
        command += ["--set", setting]
    return subprocess.run([*map(str, command)], capture_output=True).returncode == 0
