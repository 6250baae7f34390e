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


def main(program: str, scenario: str, pings: str, *more: str) -> int:
    failed = []
    # What check_scatterers can number has no more rays than the fan.
    settings = ["sonar.rays.min_per_cell=0", *(word for word in more if "=" in word)]
    with tempfile.TemporaryDirectory(prefix="ensonify-") as folder:
        data = pathlib.Path(folder) / "data"
        subprocess.run(
            [
                program,
                "generate",
                scenario,
                "-o",
                data,
                "--pings",
                f"0:{pings}",
                "--export-scatterers",
                "--quiet",
                *(word for setting in settings for word in ("--set", setting)),
            ],
            check=True,
        )
        for check in CHECKS + [word for word in more if "=" not in word]:
            status, printed = run_check(check, data)
            print(f"== {check}: exit {status}\n{printed}")
            if status not in (0, SKIPPED):
                failed.append(check)
    print("failed:", ", ".join(failed) or "none")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
