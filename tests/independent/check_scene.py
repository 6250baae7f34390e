#!/usr/bin/python3
"""Generates a scenario into a temporary folder and runs every check on it.

    check_scene.py PROGRAM SCENARIO PINGS [KEY=VALUE...] [CHECK...]

KEY=VALUE overrides a key of the scenario. CHECK names further scripts (check_physics_tank) beside those
that fit every data set.
"""
import pathlib
import subprocess
import sys
import tempfile

from checklist import SKIPPED, run_check

CHECKS = ["check_files", "check_series", "check_scatterers", "check_labels", "check_coco"]


HERE = pathlib.Path(__file__).resolve().parent


def generate(program, scenario, data, pings, settings):
    """Data set of the first pings of a scenario, with scatterers; settings are KEY=VALUE."""
    # What check_scatterers can number has no more rays than the fan.
    settings = ["sonar.rays.min_per_cell=0", *settings]
    command = [program, "generate", scenario, "-o", data, "--pings", f"0:{pings}", "--export-scatterers", "--quiet"]
    subprocess.run([*command, *(word for setting in settings for word in ("--set", setting))], check=True)


def main(program: str, scenario: str, pings: str, *more: str) -> int:
    failed = []
    with tempfile.TemporaryDirectory(prefix="ensonify-") as folder:
        data = pathlib.Path(folder) / "data"
        generate(program, scenario, data, pings, [word for word in more if "=" in word])
        for check in CHECKS + [word for word in more if "=" not in word]:
            status, printed = run_check(check, data)
            print(f"== {check}: exit {status}\n{printed}")
            if status not in (0, SKIPPED):
                failed.append(check)
    print("failed:", ", ".join(failed) or "none")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
