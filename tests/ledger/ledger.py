#!/usr/bin/python3
"""tests/ledger/ledger.py [--build FOLDER] [--source FOLDER] [--only KIND...] [--write | --page]

Prints what things cost now next to what tests/ledger/ledger.txt says that they cost. The exit status is 1 if a row is
more than 5 % above the file (a stage 10 %, a folder 200 lines). Rows other than lines follow compilers and libraries:
on systems other than Debian 12 they are printed, and not compared.
"""
import argparse
import pathlib
import platform
import re
import sys
import tempfile
import time

import counted
import jobs
import sources
import table

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PAGE = ROOT / "docs/performance.md"
FILES = {"7929de3": HERE / "ledger_7929de3.txt", "now": HERE / "ledger.txt"}
BLOCK = re.compile(r"(<!-- made by tests/ledger/ledger.py -->\n).*?(<!-- end of what is made -->)", re.DOTALL)
KINDS = ("lines", "preprocessed", "start", "bytes", "memory", "instructions")
ADVICE = """
If the growth is wanted, renew the file in the same commit, and give the reason in its message:
    tests/ledger/ledger.py --write     renews the rows that moved, and the table of docs/performance.md"""


def is_debian_12():
    try:
        system = platform.freedesktop_os_release()
    except OSError:
        return False
    return (system.get("ID"), system.get("VERSION_ID"), platform.machine()) == ("debian", "12", "x86_64")


def measure(source, build, kinds):
    """{name: value}; prints seconds, which are no rows, since they depend on what else the machine does."""
    rows = sources.lines_by_folder(source) if "lines" in kinds else {}
    if "preprocessed" in kinds:
        rows.update(sources.preprocessed(build))
        seconds = sources.job_seconds(build)
        if seconds is not None:
            print(f"compiling took {seconds:.0f} job-seconds by Ninja's log; a compiler cache may have helped")
    of_program = [kind for kind in kinds if kind in jobs.ROWS]
    if not of_program:
        return rows
    if not (build / "ensonify").exists():
        raise RuntimeError(f"{build}/ensonify: not found; expected a build of the preset release")
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="ledger-", dir="/tmp") as folder:
        place = counted.Place(pathlib.Path(folder), build)
        jobs.prepare(place, build / "ensonify", source)
        for kind in of_program:
            rows.update(jobs.ROWS[kind](place, build, source))
    print(f"the jobs took {time.monotonic() - start:.0f} s")
    return rows


def filled(page):
    """The page with the table of both files."""
    made = table.markdown({name: table.read(file) for name, file in FILES.items()})
    return BLOCK.sub(lambda old: old[1] + made + "\n" + old[2], page)


def fill_page():
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


def write(committed, measured, kinds):
    """Rows that hold keep their values, so that a commit shows what it moved; so do rows of other kinds."""
    renewed = {name: value for name, value in committed.items() if table.group(name) not in kinds}
    for name, value in measured.items():
        holds = name in committed and not table.verdict(name, committed[name], value)
        renewed[name] = committed[name] if holds else value
    table.write(FILES["now"], dict(sorted(renewed.items(), key=lambda row: KINDS.index(table.group(row[0])))))
    fill_page()
    moved = [row for row in table.compare(committed, renewed) if row[1] != row[2]]
    print(table.text(moved) if moved else "no row moved")


def check(committed, measured, is_reference):
    """The exit status. `is_reference`: the system is the one that the file was measured on."""
    rows = table.compare(committed, measured)
    if not is_reference:
        print("This system is not Debian 12 on x86-64: only lines are compared.")
        rows = [row if table.kind(row[0]) == "lines" else (*row[:3], "") for row in rows]
    print(table.text(rows))
    failed = table.failures(rows)
    if failed:
        print(f"\nof {len(rows)} rows, {len(failed)} failed:\n{table.text(failed)}\n{ADVICE}")
    return 1 if failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, help="a release build; default: build/release of --source")
    parser.add_argument("--source", type=pathlib.Path, default=ROOT, help="its checkout; default: this one")
    parser.add_argument("--only", choices=KINDS, nargs="+", default=KINDS, help="measure rows of these kinds alone")
    parser.add_argument("--write", action="store_true", help="renew the file and the table, and print what moved")
    parser.add_argument("--page", action="store_true", help="only renew the table of docs/performance.md")
    arguments = parser.parse_args()
    if arguments.page:
        return fill_page()
    source = arguments.source.resolve()
    build = (arguments.build or source / "build/release").resolve()
    try:
        committed = table.read(FILES["now"])
        measured = measure(source, build, arguments.only)
    except (RuntimeError, ValueError) as error:
        print(f"ledger: {error}", file=sys.stderr)
        return 2
    if arguments.write:
        return write(committed, measured, arguments.only)
    compared = {name: value for name, value in committed.items() if table.group(name) in arguments.only}
    return check(compared, measured, is_debian_12())


if __name__ == "__main__":
    sys.exit(main())
