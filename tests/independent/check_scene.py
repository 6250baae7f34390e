#!/usr/bin/python3
"""Generates a scenario into a temporary folder and runs every check on it.

    check_scene.py PROGRAM SCENARIO PINGS [CHECK...]

CHECK names further scripts (check_physics_tank) beside those that fit every data set.
"""
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
CHECKS = ["check_files", "check_series", "check_scatterers", "check_labels", "check_coco"]
NOTHING_TO_CHECK = 77


def main(program: str, scenario: str, pings: str, *more: str) -> int:
    failed = []
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
                "--set",
                "sonar.rays.min_per_cell=0",  # what check_scatterers can number
                "--quiet",
            ],
            check=True,
        )
        for check in CHECKS + list(more):
            result = subprocess.run(
                [sys.executable, HERE / f"{check}.py", data],
                capture_output=True,
                text=True,
                check=False,
            )
            print(f"== {check}: exit {result.returncode}\n{result.stdout}{result.stderr}")
            if result.returncode not in (0, NOTHING_TO_CHECK):
                failed.append(check)
    print("failed:", ", ".join(failed) or "none")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
