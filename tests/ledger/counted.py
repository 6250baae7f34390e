"""What a command costs: instructions and their stages, bytes, memory, and what starting it takes."""
import collections
import os
import pathlib
import queue
import re
import subprocess

VALGRIND = ["valgrind", "--trace-children=yes", "--vgdb=no"]
COUNTS_SOURCE = pathlib.Path(__file__).with_name("counts.cpp")


class Place:
    """A folder for the files of all jobs, an environment that is the same for everyone, and processors to lend.

    A job gets one processor, so that the number of threads that libraries start does not depend on the machine.
    """

    def __init__(self, folder, build):
        self.folder = folder
        self.environment = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "TMPDIR": str(folder), "LANG": "C.UTF-8",
                            "PYTHONPATH": str(build / "python"), "PYTHONHASHSEED": "0",
                            "PYTHONPYCACHEPREFIX": str(folder / "pycache"), "OPENBLAS_NUM_THREADS": "1"}
        self.processors = queue.Queue()
        for processor in sorted(os.sched_getaffinity(0))[:2]:
            self.processors.put(processor)

    def run(self, words, *variables):
        processor = self.processors.get()
        try:
            done = subprocess.run(["taskset", "-c", str(processor), "env", *variables, *map(str, words)],
                                  cwd=self.folder, env=self.environment, capture_output=True, text=True,
                                  errors="replace")
        finally:
            self.processors.put(processor)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, words))}: exit status {done.returncode}\n{done.stderr[-2000:]}")
        return done


def instructions_printed(done):
    return sum(int(n.replace(",", "")) for n in re.findall(r"I\s+refs:\s+([\d,]+)", done.stderr))


def instructions(place, words):
    """Of the command and of all processes that it starts. Valgrind emulates a processor with AVX2 on every machine
    that has it, so the choice of libraries by processor is the same."""
    return instructions_printed(place.run(
        [*VALGRIND, "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", *words]))


def inclusive(profile):
    """{function: instructions in it and in what it calls} of a file of callgrind."""
    names, counts, function = {}, collections.Counter(), None
    with profile.open(encoding="utf-8", errors="replace") as lines:
        for line in lines:
            if line.startswith(("fn=", "cfn=")):
                number, name = re.match(r"c?fn=(\(\d+\))(?: (.*))?", line).groups()
                if name:
                    names[number] = name
                if line.startswith("fn="):
                    function = number
            elif line[0] in "+-*0123456789":  # the cost of a line, or of a call from it
                counts[function] += int(line.split()[-1])
    by_name = collections.Counter()
    for number, count in counts.items():
        by_name[names[number]] += count
    return by_name


def of_functions(counts, functions):
    """{function: instructions} of those that were called. A function is given by the beginning of its name with its
    arguments, as a debugger prints it, without `ensonify::`. Overloads are one; what a function defines inside is not
    counted again."""
    found = {}
    for name, count in counts.items():
        for function in functions:
            if name.startswith("ensonify::" + function) and "::{" not in name and not name.endswith("'2"):
                found[function] = found.get(function, 0) + count
    return found


def stages(place, name, words, functions):
    """The instructions of the command, and those of the functions."""
    done = place.run([*VALGRIND, "--tool=callgrind", f"--callgrind-out-file={name}.%p.profile", *words])
    counts = collections.Counter()
    for file in place.folder.glob(f"{name}.*.profile"):
        counts.update(inclusive(file))
    return instructions_printed(done), of_functions(counts, functions)


def bytes_of(place, words):
    """{read, hashed, written} of the command and of all processes that it starts."""
    library, counts = place.folder / "counts.so", place.folder / "counts"
    if not library.exists():
        place.run(["c++", "-shared", "-fPIC", "-O1", "-o", library, COUNTS_SOURCE])
    counts.unlink(missing_ok=True)
    place.run(words, f"LD_PRELOAD={library}", f"LEDGER_COUNTS={counts}")
    sums = [sum(column) for column in zip(*(map(int, line.split()) for line in counts.read_text().splitlines()))]
    return dict(zip(("read", "hashed", "written"), sums))


def peak_kb(place, words):
    """The largest resident size of the command."""
    return int(place.run(["/usr/bin/python3", "-c", PEAK, *words]).stdout.split()[-1])


PEAK = """
import os, resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def start(place, words):
    """Libraries that the command loads, and the symbols that the dynamic linker looks up."""
    printed = place.run(words, "LD_DEBUG=statistics,files").stderr
    return {"libraries": printed.count("calling init: "),
            "relocations": int(re.findall(r"final number of relocations: (\d+)", printed)[-1])}
