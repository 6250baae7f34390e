"""The extension, built by CMake into build/release as scripts/generate.sh builds the program.

ENSONIFY_BUILT=FOLDER takes that of a build folder as it is.
"""
import os
import re
import shutil
import subprocess
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        folder = Path(os.environ.get("ENSONIFY_BUILT", ROOT / "build/release"))
        if "ENSONIFY_BUILT" not in os.environ:
            subprocess.run(["cmake", "--preset", "release", "-DENSONIFY_PYTHON=ON"], cwd=ROOT, check=True)
            subprocess.run(["cmake", "--build", "--preset", "release", "--target", "ensonify_python"], cwd=ROOT,
                           check=True)
        target = Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        (built,) = (folder / "python/ensonify").glob("_core*.so")
        shutil.copy2(built, target)
        copied = [target]
        for companion in (folder / "ensonify_import", *folder.glob("libensonify_*.so")):
            copied.append(Path(shutil.copy2(companion, target.parent)))
        subprocess.run(["strip", "--strip-unneeded", *map(str, copied)], check=True)


version = re.search(r"project\(ensonify VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
setup(version=version[1], ext_modules=[Extension("ensonify._core", [])], cmdclass={"build_ext": CMakeBuild})
