#!/usr/bin/python3
"""Runs the program on small scenarios and holds what it writes against closed forms.

    verify_physics.py PROGRAM [--only V6,pulse] [--report FILE --figures DIR] [--compare FILE]
                      [--keep DIR]

Exit status 0 only if every row passes and, with --compare, the report's numbers are those of
today. NumPy only; matplotlib is loaded for --figures alone.
"""
import argparse
import os
import pathlib
import sys
import tempfile
import time

import report
from bench import CASES, Bench, rows_of

# Importing a module registers its cases, in the order of the report.
import levels  # noqa: F401
import pattern  # noqa: F401
import pulse  # noqa: F401
import noise  # noqa: F401
import water  # noqa: F401
import speckle  # noqa: F401
import draws  # noqa: F401
import coherence  # noqa: F401
import series  # noqa: F401
import tank  # noqa: F401
import scattering  # noqa: F401
import coherent  # noqa: F401
import bounces  # noqa: F401
import wedge  # noqa: F401
import walls  # noqa: F401
import ringing  # noqa: F401
import volume  # noqa: F401
import line_array  # noqa: F401
import convergence  # noqa: F401


def chosen_cases(only):
    """Names of the cases to run; an unknown name is an error."""
    names = [name for name in (only or "").split(",") if name]
    unknown = sorted(set(names) - set(CASES))
    if unknown:
        raise SystemExit(f"no such case: {', '.join(unknown)}; there are {', '.join(CASES)}")
    return [name for name in CASES if not names or name in names]


def run_cases(bench, names):
    """All rows, each printed as it comes."""
    rows = []
    for name in names:
        start = time.monotonic()
        found = rows_of(name, bench)
        for row in found:
            print(report.console_line(row), flush=True)
        print(f"     {name}: {time.monotonic() - start:.1f} s", file=sys.stderr, flush=True)
        rows += found
    return rows


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--only", help="cases to run, separated by commas")
    parser.add_argument("--report", help="write the table here")
    parser.add_argument("--figures", help="write the figures into this folder")
    parser.add_argument("--compare", help="compare with the table in this file")
    parser.add_argument("--keep", help="keep the data sets in this folder")
    options = parser.parse_args(arguments)
    if options.only and (options.report or options.compare):
        parser.error("a report is of all cases: --only does not go with --report or --compare")
    return options


def main(arguments):
    options = parsed(arguments)
    names = chosen_cases(options.only)
    program = os.path.abspath(options.program)
    with tempfile.TemporaryDirectory(prefix="ensonify-") as scratch:
        bench = Bench(program, pathlib.Path(options.keep or scratch).absolute(), bool(options.figures))
        rows = run_cases(bench, names)
    faults = [f"{row.identity}: failed" for row in rows if not row.passed]
    if options.figures:
        import figures

        figures.draw_all(bench.curves, options.figures)
    if options.report:
        report.write(options.report, rows)
    if options.compare:
        faults += report.differences(options.compare, rows)
    for fault in faults:
        print(fault)
    print(
        f"verify_physics: {sum(row.passed for row in rows)} of {len(rows)} rows pass"
        + (f", {len(faults)} faults" if faults else "")
    )
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
