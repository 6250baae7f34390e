"""A wheel of the package, installed into an environment of its own. Skips where Debian's python3-build or python3-venv
is not. ENSONIFY_BUILT is the build folder, SOURCE the source tree."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from importlib.util import find_spec
from pathlib import Path

SOURCE = Path(os.environ["SOURCE"])
PARTS = ("pyproject.toml", "setup.py", "README.md", "CMakeLists.txt", "scripts/python", "scripts/ensonify_dataset")
# A scene with a mesh and a distance field: the importer and a module have to be found beside the extension.
PROGRAM = """
import pathlib
import ensonify as en
import ensonify.dataset
scene = en.Scenario.load({scene!r}, set={{"sonar.beams.count": 24, "sonar.rays.elevation": 16}})
print(en.__file__, en.__version__, scene.ping(want=["instance"]).polar.instance.max() > 0)
field = en.Scenario.load({scene!r}, set={{"sonar.beams.count": 24, "sonar.rays.elevation": 16, "output.sdf.voxel_m": 1,
                                          "trajectory.pings": 1}})
en.generate(field, "with_field")
print(len(list(pathlib.Path("with_field").rglob("*.vdb"))))
"""


def run(*command, **more):
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, **more)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@unittest.skipUnless(find_spec("build") and find_spec("ensurepip"), "no python3-build or no python3-venv")
class Wheel(unittest.TestCase):
    def test_it_is_built_installed_and_makes_a_ping(self):
        clean = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        with tempfile.TemporaryDirectory() as folder:
            tree, wheels, place = Path(folder) / "tree", Path(folder) / "wheels", Path(folder) / "environment"
            for part in PARTS:
                copy = shutil.copytree if (SOURCE / part).is_dir() else shutil.copy2
                (tree / part).parent.mkdir(parents=True, exist_ok=True)
                copy(SOURCE / part, tree / part)
            run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", wheels, tree, env=clean)
            (wheel,) = wheels.glob("ensonify-*.whl")
            run(sys.executable, "-m", "venv", "--system-site-packages", place, env=clean)
            run(place / "bin/pip", "install", "--no-index", wheel, env=clean)
            scene = str(SOURCE / "scenes/wreck_survey.yaml")
            told = run(place / "bin/python", "-c", PROGRAM.format(scene=scene), env=clean, cwd=folder).split()
            self.assertTrue(told[0].startswith(str(place)), told)
            self.assertEqual(told[2:], ["True", "1"])


if __name__ == "__main__":
    unittest.main()
