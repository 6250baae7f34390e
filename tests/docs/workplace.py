"""The folder in which a page's commands run: what a reader sees in the repository's root."""

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from pages import ROOT
from small_scenes import make_small

# Copies, so that no command can change the repository; sources, which nobody writes to, are links.
COPIED = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", "CITATION.cff",
          "CMakeLists.txt", "CMakePresets.json", "configs", "docs", "output_schema", "scenes",
          "scripts")
LINKED = ("generator", "tests")

# How the folder's own path is shown in a page.
SHOWN_ROOT = "/home/me/ensonify"
LIMIT_S = 600

# generate.sh and its like build before they run. Here the program is there already, and none is made.
CMAKE = """#!/bin/sh
[ "$*" = "--build --preset release --target ensonify" ] && exit 0
echo "cmake $*: commands of the documentation are tested without a build" >&2
exit 1
"""
NOTHING_TO_INSTALL = """#!/bin/sh
echo "$0 $*: the test of the documentation installs nothing" >&2
exit 1
"""


def _executable(path, text):
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)


class Workplace:
    """A temporary folder with a shell whose variables and folder last from block to block, and one
    Python process."""

    def __init__(self, program, root=ROOT, small=False):
        self.base = Path(tempfile.mkdtemp(prefix="ensonify-docs-"))
        self.root = self.base / "ensonify"
        self.state = self.base / "state"
        (self.base / "home").mkdir()
        self._copy(root)
        if small:
            make_small(self.root / "scenes")
        self._programs(program)
        self.python = None

    def _copy(self, root):
        self.root.mkdir()
        for name in COPIED:
            if (root / name).is_dir():
                shutil.copytree(root / name, self.root / name,
                                ignore=shutil.ignore_patterns("__pycache__"))
            elif (root / name).exists():
                shutil.copy2(root / name, self.root / name)
        for name in LINKED:
            (self.root / name).symlink_to(root / name)

    def _programs(self, program):
        release, bin_folder = self.root / "build/release", self.base / "bin"
        release.mkdir(parents=True)
        bin_folder.mkdir()
        (release / "build.ninja").touch()
        (release / "ensonify").symlink_to(program)
        (release / "python").symlink_to(Path(program).resolve().parent / "python")
        (bin_folder / "ensonify").symlink_to(program)
        (bin_folder / "python3").symlink_to("/usr/bin/python3")
        _executable(bin_folder / "cmake", CMAKE)
        for name in ("apt-get", "apt", "sudo"):
            _executable(bin_folder / name, NOTHING_TO_INSTALL)

    def environment(self):
        kept = {key: value for key, value in os.environ.items()
                if key == "ENSONIFY_DOCS_WITHOUT" or
                not key.startswith(("SLURM", "ENSONIFY", "PYTHON", "XDG", "BASH"))}
        return kept | {"PATH": f"{self.base / 'bin'}:/usr/local/bin:/usr/bin:/bin", "LC_ALL": "C.UTF-8",
                       "HOME": str(self.base / "home"), "PYTHONDONTWRITEBYTECODE": "1",
                       "COLUMNS": "100", "PWD": str(self.root)}

    def folder(self):
        """Where the shell stands."""
        place = self.base / "place"
        return Path(place.read_text(encoding="utf-8").rstrip("\n")) if place.exists() else self.root

    def shell(self, text):
        """(exit status, what it printed) of a piece of bash that stops at its first fault."""
        script = self.base / "block.sh"
        script.write_text(
            f'[ ! -f "{self.state}" ] || . "{self.state}"\n'
            f'trap \'status=$?; export -p >"{self.state}"; pwd >"{self.base}/place"; exit $status\' EXIT\n'
            f"set -eo pipefail\n{text}", encoding="utf-8")
        with tempfile.TemporaryFile() as printed:
            try:
                status = subprocess.run(["bash", str(script)], cwd=self.folder(), stdin=subprocess.DEVNULL,
                                        stdout=printed, stderr=subprocess.STDOUT,
                                        env=self.environment(), timeout=LIMIT_S).returncode
            except subprocess.TimeoutExpired:
                status = f"none: still running after {LIMIT_S} s"
            printed.seek(0)
            return status, self.as_shown(printed.read().decode("utf-8", "replace"))

    def run_python(self, text, name):
        """{"error", "printed", "skipped"}: see python_session.py."""
        if self.python is None:
            session = Path(__file__).with_name("python_session.py")
            # Through the shell's variables: PYTHONPATH may have been exported.
            start = f'[ ! -f "{self.state}" ] || . "{self.state}"; exec python3 -u "{session}"'
            self.python = subprocess.Popen(["bash", "-c", start], cwd=self.root, text=True,
                                           stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                           env=self.environment())
        request = {"text": text, "name": name, "cwd": str(self.folder())}
        self.python.stdin.write(json.dumps(request) + "\n")
        self.python.stdin.flush()
        line = self.python.stdout.readline()
        if not line:
            return {"error": f"python3 ended with {self.python.wait()}", "printed": "", "skipped": []}
        answer = json.loads(line)
        return answer | {"printed": self.as_shown(answer["printed"])}

    def as_shown(self, text):
        return text.replace(str(self.root), SHOWN_ROOT)

    def write(self, name, text):
        path = self.folder() / name
        if not path.resolve().is_relative_to(self.root.resolve()):
            raise ValueError(f"file={name} lies outside of the reader's folder")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def close(self, keep=False):
        if self.python is not None:
            self.python.stdin.close()
            self.python.stdout.close()
            self.python.wait()
        if not keep:
            shutil.rmtree(self.base, ignore_errors=True)
