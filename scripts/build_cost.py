#!/usr/bin/python3
"""./scripts/build_cost.py [BUILD_DIR] [--rows N]

Prints what the last compile of every object of a build folder cost: the dearest units, and the headers that reach the
dearest sum of units. The times are those of Ninja's log, in seconds of one job, so they rise with whatever else the
machine was doing; the order hardly changes. Build from nothing and without a compiler cache to compare two commits:

    cmake --preset release -DENSONIFY_CCACHE= && cmake --build --preset release --clean-first
"""
import argparse
import collections
import pathlib
import subprocess
import sys


def job_seconds(log):
    """{output: seconds} of the last time that each output was made."""
    seconds = {}
    for line in log.read_text().splitlines():
        fields = line.split("\t")
        if len(fields) == 5:
            start_ms, end_ms, _, output, _ = fields
            seconds[output] = (int(end_ms) - int(start_ms)) / 1000
    return seconds


def headers_of_units(folder):
    """{object: [header, ...]}, from the dependencies that Ninja has recorded."""
    printed = subprocess.run(["ninja", "-t", "deps"], cwd=folder, capture_output=True, text=True, check=True).stdout
    headers, unit = collections.defaultdict(list), None
    for line in printed.splitlines():
        if line and not line.startswith(" "):
            unit = line.split(": #deps")[0]
        elif line.strip():
            headers[unit].append(line.strip())
    return headers


def unit_name(output):
    """generator/app/unity_0 of generator/app/CMakeFiles/ensonify_app.dir/Unity/unity_0_cxx.cxx.o"""
    folder, _, rest = output.partition("/CMakeFiles/")
    name = rest.split(".dir/")[-1].removeprefix("Unity/").removesuffix(".o")
    return f"{folder}/{name.removesuffix('_cxx.cxx')}"


def is_own(header, root):
    path = pathlib.Path(header)
    return not path.is_absolute() or root in path.parents


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[1])
    root = pathlib.Path(__file__).resolve().parent.parent
    parser.add_argument("folder", nargs="?", type=pathlib.Path, default=root / "build/release")
    parser.add_argument("--rows", type=int, default=15)
    arguments = parser.parse_args()
    if not (arguments.folder / ".ninja_log").exists():
        sys.exit(f"{arguments.folder}: no .ninja_log; expected a folder that Ninja has built in")
    seconds = {output: s for output, s in job_seconds(arguments.folder / ".ninja_log").items()
               if output.endswith((".o", ".gch", ".pch"))}
    print(f"{len(seconds)} compiled units, {sum(seconds.values()):.0f} job-seconds\n")
    print("seconds  unit")
    for output, s in sorted(seconds.items(), key=lambda item: -item[1])[: arguments.rows]:
        print(f"{s:7.1f}  {unit_name(output)}")

    reached, units = collections.Counter(), collections.Counter()
    for output, headers in headers_of_units(arguments.folder).items():
        for header in {h for h in headers if h.endswith((".h", ".hpp", ".inl"))}:
            reached[header] += seconds.get(output, 0)
            units[header] += 1
    for title, wanted in (("own header", True), ("foreign header", False)):
        print(f"\nseconds  units  {title}")
        rows = [row for row in reached.most_common() if is_own(row[0], root) == wanted]
        # Headers of the standard library reach every unit: only those of other packages say something.
        rows = [row for row in rows if wanted or "/c++/" not in row[0] and "/x86_64-linux-gnu/" not in row[0]]
        for header, s in rows[: arguments.rows]:
            path = pathlib.Path(header)
            shown = path.relative_to(root) if root in path.parents else path
            print(f"{s:7.0f}  {units[header]:5}  {shown}")


if __name__ == "__main__":
    main()
