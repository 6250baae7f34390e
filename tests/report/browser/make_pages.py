"""Data sets and pages for the browser's tests: make_pages.py PROGRAM FOLDER."""

import pathlib
import shutil
import subprocess
import sys

SCENES = pathlib.Path(__file__).parent.parent / "scenes"


def run(*arguments):
    subprocess.run([str(argument) for argument in arguments], check=True)


def main(program, folder):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("small", "statistics", "bare", "rig"):
        run(program, "generate", SCENES / f"{name}.yaml", "-o", folder / name, "--overwrite", "--quiet")
        run(program, "report", folder / name, "-o", folder / f"{name}.html", "--overwrite", "--quiet")
    run(program, "report", folder / "small", "-o", folder / "sampled.html", "--pings", 5,
        "--overwrite", "--quiet")
    run(program, "sweep", SCENES / "sweep.yaml", "-o", folder / "sweep", "--overwrite", "--quiet")
    run(program, "report", folder / "sweep", "-o", folder / "sweep.html", "--overwrite", "--quiet")
    part = folder / "part"
    shutil.rmtree(part, ignore_errors=True)
    shutil.copytree(folder / "sweep", part)
    (part / "runs.csv").unlink()
    shutil.rmtree(min((part / "runs").iterdir()))
    run(program, "report", part, "-o", folder / "part.html", "--overwrite", "--quiet")


main(*sys.argv[1:])
