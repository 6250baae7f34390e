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


def header_group(header, folder, root):
    """An own header by its path below the root, a foreign one by its package: the folder below /usr/include."""
    path = (folder / header).resolve()
    if root in path.parents:
        return "own header", str(path.relative_to(root))
    below = path.parts[3:] if path.parts[:3] == ("/", "usr", "include") else ()
    is_package = len(below) > 1 and below[0] not in ("c++", "x86_64-linux-gnu", "asm-generic", "linux", "bits")
    return ("package", below[0]) if is_package else None


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

    groups = collections.defaultdict(collections.Counter)
    units = collections.Counter()
    for output, headers in headers_of_units(arguments.folder).items():
        for group in {header_group(h, arguments.folder, root) for h in headers} - {None}:
            groups[group[0]][group[1]] += seconds.get(output, 0)
            units[group] += 1
    for title, reached in sorted(groups.items()):
        print(f"\nseconds  units  {title}")
        for name, s in reached.most_common(arguments.rows):
            print(f"{s:7.0f}  {units[title, name]:5}  {name}")


if __name__ == "__main__":
    main()
