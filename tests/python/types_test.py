"""The stub says what the extension has, and the package passes mypy."""
import ast
import shutil
import subprocess
import unittest

from ensonify import _core
from small_data import SOURCE

PACKAGE = SOURCE / "scripts/python/ensonify"


class Types(unittest.TestCase):
    def test_the_stub_names_all_there_is_and_nothing_else(self):
        tree = ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8"))
        told = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        there = {name for name in dir(_core) if not name.startswith("_")}
        self.assertEqual(set(told), there)
        for name, node in told.items():
            members = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
            members |= {part.target.id for part in node.body if isinstance(part, ast.AnnAssign)}
            own = {member for member in vars(getattr(_core, name)) if not member.startswith("_")}
            self.assertEqual(members - {"__init__"}, own, name)

    @unittest.skipUnless(shutil.which("mypy"), "no mypy")
    def test_mypy_has_nothing_to_say(self):
        run = subprocess.run(["mypy", "--python-version", "3.9", "--cache-dir", "/dev/null", str(PACKAGE)],
                             env={"MYPYPATH": str(SOURCE / "scripts"), "PATH": "/usr/bin:/bin"}, capture_output=True,
                             text=True)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
