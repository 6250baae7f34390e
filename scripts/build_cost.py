#!/usr/bin/python3
"""./scripts/build_cost.py [BUILD_DIR] [--build] [--rows N]

Prints what compiling a build folder cost: by folder, the dearest units, and the headers that reach the dearest sum of
units. --build first compiles the program there from nothing, as scripts/generate.sh does but without a compiler cache,
and notes the CPU time of every unit; its default folder is build/cost. Without it the times are those of Ninja's log, in
seconds of one job, which rise with whatever else the machine was doing; their order hardly changes.
"""
import argparse
import collections
import pathlib
import resource
import subprocess
import sys

CPU_LOG = "cpu_seconds"


def cpu_seconds_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def launch(log, command):
    """Runs the compiler and appends what it took, as Ninja starts several at once."""
    status = subprocess.run(command).returncode
    output = command[command.index("-o") + 1] if "-o" in command else ""
    with open(log, "a") as file:
        file.write(f"{cpu_seconds_of_children():.2f}\t{output}\n")
    return status


def build(root, folder):
    """Compiles the program from nothing. Returns the CPU-seconds of all that Ninja started."""
    folder.mkdir(parents=True, exist_ok=True)
    log = folder.resolve() / CPU_LOG
    launcher = ";".join([sys.executable, str(pathlib.Path(__file__).resolve()), "--launch", str(log)])
    subprocess.run(["cmake", "--preset", "release", "-B", folder.resolve(), "-DENSONIFY_TESTS=OFF", "-DENSONIFY_CCACHE=",
                    f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}"], cwd=root, check=True, stdout=subprocess.DEVNULL)
    log.unlink(missing_ok=True)  # configuring compiles too
    before = cpu_seconds_of_children()
    done = subprocess.run(["cmake", "--build", folder, "--target", "ensonify", "--clean-first"], stdout=subprocess.PIPE,
                          text=True)
    if done.returncode:
        sys.exit(done.stdout)
    return cpu_seconds_of_children() - before


def logged_cpu_seconds(log):
    """{output: CPU-seconds} of the last time that each output was made."""
    fields = [line.split("\t") for line in log.read_text().splitlines()]
    return {output: float(seconds) for seconds, output in fields}


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
    """generator/run/unity_0 of generator/run/CMakeFiles/ensonify_run.dir/Unity/unity_0_cxx.cxx.o"""
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


def print_by_folder(seconds):
    folders = collections.Counter()
    for output, s in seconds.items():
        folders["/".join(output.split("/CMakeFiles/")[0].split("/")[:2])] += s
    print("seconds  folder")
    for name, s in folders.most_common():
        print(f"{s:7.1f}  {name}")


def main():
    if sys.argv[1:2] == ["--launch"]:
        sys.exit(launch(sys.argv[2], sys.argv[3:]))
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[1])
    root = pathlib.Path(__file__).resolve().parent.parent
    parser.add_argument("folder", nargs="?", type=pathlib.Path)
    parser.add_argument("--build", action="store_true", help="compile the program from nothing first")
    parser.add_argument("--rows", type=int, default=10)
    arguments = parser.parse_args()
    folder = arguments.folder or root / ("build/cost" if arguments.build else "build/release")
    if arguments.build:
        print(f"{build(root, folder):.0f} CPU-seconds to build the program, links included")
    if not (folder / ".ninja_log").exists():
        sys.exit(f"{folder}: no .ninja_log; expected a folder that Ninja has built in")
    log = folder / CPU_LOG
    unit, seconds = ("CPU", logged_cpu_seconds(log)) if log.exists() else ("job", job_seconds(folder / ".ninja_log"))
    seconds = {output: s for output, s in seconds.items() if output.endswith((".o", ".gch", ".pch"))}
    print(f"{len(seconds)} compiled units, {sum(seconds.values()):.0f} {unit}-seconds\n")
    print_by_folder(seconds)
    print("\nseconds  unit")
    for output, s in sorted(seconds.items(), key=lambda item: -item[1])[: arguments.rows]:
        print(f"{s:7.1f}  {unit_name(output)}")

    groups = collections.defaultdict(collections.Counter)
    units = collections.Counter()
    for output, headers in headers_of_units(folder).items():
        for group in {header_group(h, folder, root) for h in headers} - {None}:
            groups[group[0]][group[1]] += seconds.get(output, 0)
            units[group] += 1
    for title, reached in sorted(groups.items()):
        print(f"\nseconds  units  {title}")
        for name, s in reached.most_common(arguments.rows):
            print(f"{s:7.0f}  {units[title, name]:5}  {name}")


if __name__ == "__main__":
    main()
