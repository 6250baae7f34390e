#!/usr/bin/python3
"""Makes the paper's figures and tables, and holds what the paper says against the program.

    paper_figures.py PROGRAM [--pings N] [--page FILE --figures DIR [--keep-times]] [--compare FILE]
                     [--keep DIR]

Exit status 0 only if every statement holds and, with --compare, the page's numbers are those of
today. NumPy only; matplotlib is loaded for --figures alone, and `ensonify bench` run for --page.
"""
import argparse
import os
import pathlib
import sys
import tempfile

import paper_page
import paper_times
import report
from bench import BREAKS, Bench, broken_row
from paper_claims import (
    SET_UP,
    Claim,
    Tanks,
    figure_10,
    figure_11,
    figure_7,
    figure_8,
    figure_9,
)
from paper_sonar import differences, parameters, table_1

PARTS = {
    "7": figure_7,
    "8": figure_8,
    "9": figure_9,
    "10": figure_10,
    "11": figure_11,
    "Table 1": table_1,
    "differences": differences,
}


def claims_of(name, tanks):
    """The claims of one figure; one that breaks is a claim that fails and says why."""
    try:
        return list(PARTS[name](tanks))
    except BREAKS as error:
        return [Claim(name, "", SET_UP, broken_row(name, "could not be made", error))]


def all_claims(tanks):
    """Every claim, each printed as it comes."""
    claims = []
    for name in PARTS:
        found = claims_of(name, tanks)
        for claim in found:
            print(report.console_line(claim.row), flush=True)
        claims += found
    return claims


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--pings", type=int, default=100, help="pings of statistical rows")
    parser.add_argument("--page", help="write the page here")
    parser.add_argument("--figures", help="write the pictures into this folder")
    parser.add_argument(
        "--keep-times", action="store_true", help="keep the times that the page has"
    )
    parser.add_argument("--compare", help="compare with the page in this file")
    parser.add_argument("--keep", help="keep the data sets in this folder")
    options = parser.parse_args(arguments)
    if options.pings < 3:
        parser.error("--pings: three at least, for a standard error")
    if options.keep_times and not options.page:
        parser.error("--keep-times is of --page")
    return options


def write_page(options, claims, tanks):
    if options.keep_times:
        times = paper_times.kept(options.page)
    else:
        times = paper_times.block(*paper_times.measured(tanks.bench.program))
    text = paper_page.page(claims, parameters(tanks), times, options.pings)
    pathlib.Path(options.page).write_text(text, encoding="utf-8")


def main(arguments):
    options = parsed(arguments)
    program = os.path.abspath(options.program)
    with tempfile.TemporaryDirectory(prefix="ensonify-") as scratch:
        tanks = Tanks(
            Bench(program, pathlib.Path(options.keep or scratch).absolute()), options.pings
        )
        claims = all_claims(tanks)
        faults = [f"{claim.row.identity}: fails" for claim in claims if not claim.row.passed]
        whole = not any(claim.row.trouble for claim in claims)
        if options.figures and whole:
            import paper_plots

            paper_plots.draw_all(tanks, options.figures)
        if options.page and whole:
            write_page(options, claims, tanks)
    if options.compare:
        faults += paper_page.differences(options.compare, claims)
    for fault in faults:
        print(fault)
    print(f"paper_figures: {sum(c.row.passed for c in claims)} of {len(claims)} rows agree")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
