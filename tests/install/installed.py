"""The build installed into a temporary folder, once for all tests of a module. BUILD is the build's folder, CMAKE
the program cmake."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ.get("BUILD", pathlib.Path(__file__).parents[2] / "build/release")).absolute()
CMAKE = os.environ.get("CMAKE", "cmake")


def run(*command, **options):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, encoding="utf-8", **options)


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-install-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        # DESTDIR, as packages have it: no rule may write past it.
        done = run(CMAKE, "--install", BUILD, "--prefix", "/usr", env={**os.environ, "DESTDIR": str(cls.folder)})
        if done.returncode != 0:
            raise RuntimeError(done.stdout + done.stderr)
        cls.prefix = cls.folder / "usr"
        cls.program = cls.prefix / "bin/ensonify"
        cls.data = cls.prefix / "share/ensonify"
        cls.environment = {key: value for key, value in os.environ.items()
                           if not key.startswith(("ENSONIFY", "PYTHON"))}
