#!/usr/bin/env python3
"""Compares whole data sets, ensembles and streams of a CUDA device with the processor of the same machine.

    scripts/gpu_check.py --program build/release/ensonify --bench build/cuda/bench.txt --json build/gpu_check.json

scripts/gpu_check.sh builds what this needs and runs it; scripts/make_performance.py makes a table of the JSON file. Ends
with 1 if a figure is worse than wanted or could not be measured. --small has tiny sonars and few pings, so that tests
run it on a device which is the host.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np
from make_performance import processor

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES, FULL = ROOT / "scenes", ROOT / "configs/bench/full.yaml"
# What is measured: its unit, the bound, whether more is better, and what it is.
FIGURES = {
    "full": ("pings/s", 15000, True, "physics of `full`, series left in device memory"),
    "full_of_bus": ("", 0.8, True, "… with series in host memory, as a share of what the bus carries"),
    "array": ("pings/s", 1500, True, "physics of `array`: 256 elements"),
    "ensemble": ("s", 20, False, "100,000 realizations of `speckle_wall`"),
    "stream": ("pings/s", 1000, True, "series of `full` to memory by the whole program"),
    "sets": ("", 1.5, True, "whole default data sets of `full`, as a multiple of all CPU threads"),
    "scenes": ("", 1e-5, False, "largest relative L2 difference of an array in `scenes/`"),
    "arrays": ("", 1e-5, False, "… with an array of elements"),
    "statistics": ("", 1e-5, False, "… of the statistics of the ensemble"),
}
# What some scenes need so that their arrays can be compared: series, and an ADC whose steps are finer than 1e-5.
SETTINGS = {"speckle_wall": ["output.pings=true"], "calibration_sphere": ["sonar.receiver.adc.bits=24"]}
ARRAYS = {"seabed_and_target": ["sonar.receiver.mode=array"],
          "pile_inspection": ["sonar.receiver.mode=array", "motion_within_ping=true"]}
LONGEST_S = 300  # of a command
SMALL = ["sonar.beams.count=32", "sonar.beams.fov_deg=60", "sonar.rays.elevation=12"]
SMALL_WALL = ["sonar.beams={count: 20, fov_deg: 20}"]


# What the data sets of a run take; a folder in memory that has as much is used, so that no disk is measured.
FOLDER_BYTES = 8e9
MEMORY = pathlib.Path("/dev/shm")


class NotMeasured(Exception):
    """Why a figure could not be measured."""


class Device:
    """The program, where it writes, and how much of everything it makes."""

    def __init__(self, program, folder, small=False):
        self.program, self.folder, self.small, self.name = program, folder, small, None

    def make(self, backend, scenario, pings, settings=()):
        """The folder of a new data set, and the seconds that it took."""
        output = pathlib.Path(tempfile.mkdtemp(prefix=f"{backend}-", dir=self.folder)) / "set"
        words = [word for setting in settings for word in ("--set", setting)]
        started = time.monotonic()
        try:
            done = subprocess.run(
                [self.program, "generate", scenario, "-o", output, "--backend", backend, "--pings", f"0:{pings}",
                 "--sequences", "0:1", "--quiet", *words], capture_output=True, text=True, timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            raise NotMeasured(f"{scenario.stem} by {backend} took longer than {LONGEST_S} s") from None
        seconds = time.monotonic() - started
        if done.returncode != 0:
            raise NotMeasured(f"{scenario.stem} by {backend}: {done.stderr.strip()}")
        if backend == "cuda":
            numerics = json.loads((output / "work.json").read_text(encoding="utf-8"))["numerics"]
            self.name = numerics["backend"].removeprefix("cuda, ")
        return output, seconds

    def pair(self, scenario, pings, settings=()):
        """The same data set by both, and the seconds that each took."""
        (cpu, cpu_s), (cuda, cuda_s) = (self.make(backend, scenario, pings, settings) for backend in ("cpu", "cuda"))
        return cpu, cuda, cpu_s, cuda_s


def difference(got, expected, known=None):
    """The relative L2 difference of two arrays; infinite where their shapes or what they leave out differ."""
    if got.shape != expected.shape or got.dtype != expected.dtype:
        return float("inf")
    if not np.array_equal(np.isfinite(got), np.isfinite(expected)):
        return float("inf")
    known = np.isfinite(expected) if known is None else known & np.isfinite(expected)
    got, expected = (part[known].astype(complex) for part in (got, expected))
    wrong, whole = np.linalg.norm(got - expected), np.linalg.norm(expected)
    return float(wrong / whole) if whole > 0 else float(0 if wrong == 0 else "inf")


def statistics_difference(name, got, expected, power):
    if name == "intensity_histogram.npy":  # rounding moves few intensities to the next bin
        return float(np.abs(got.astype(float) - expected).sum() / expected.sum())
    # A ratio where hardly anything is heard is one of rounding errors.
    rows, columns = expected.shape
    heard = power > 1e-6 * power.max()
    known = heard[:rows, :columns].copy()
    known[:, 1:] &= heard[:rows, :columns - 1]
    if rows < len(heard):  # of neighboring beams
        known &= heard[1:, :columns]
    return difference(got, expected, known)


def differences(cuda, cpu):
    """The difference of each array of two data sets, by name; both have the same files."""
    names = [{str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()} for folder in (cuda, cpu)]
    if names[0] != names[1]:
        raise NotMeasured(f"files of one backend alone: {', '.join(sorted(names[0] ^ names[1]))}")
    found = {}
    for name in sorted(name for name in names[0] if name.endswith(".npy")):
        got, expected = np.load(cuda / name), np.load(cpu / name)
        folder = (cpu / name).parent
        if folder.name == "statistics":
            power = np.load(folder / "mean_intensity.npy")
            found[name] = statistics_difference(pathlib.Path(name).name, got, expected, power)
        else:
            found[name] = difference(got, expected)
    return found


def worst(found):
    name = max(found, key=found.get)
    return {"value": found[name], "where": name}


def compared(device, chosen):
    """Scenes by name, with their settings: one ping each or a few, by both."""
    found = {}
    for name, settings in chosen.items():
        words = [*settings, *(SMALL if device.small else [])]
        cpu, cuda, *_ = device.pair(SCENES / f"{name}.yaml", 1 if device.small else 3, words)
        found.update({f"{name}/{file}": value for file, value in differences(cuda, cpu).items()})
        for folder in (cpu, cuda):
            shutil.rmtree(folder.parent)
    return found


def scenes(device, names):
    return {"scenes": worst(compared(device, {name: SETTINGS.get(name, []) for name in names}))}


def arrays(device):
    return {"arrays": worst(compared(device, ARRAYS))}


def ensemble(device):
    realizations = 12 if device.small else 100000
    settings = [f"trajectory.pings={realizations}", *(SMALL_WALL if device.small else [])]
    cpu, cuda, cpu_s, cuda_s = device.pair(SCENES / "speckle_wall.yaml", realizations, settings)
    return {"ensemble": {"value": cuda_s, "cpu": cpu_s}, "statistics": worst(differences(cuda, cpu))}


def sets(device):
    """Whole default data sets by turns, so that other programs disturb both alike."""
    pings, turns = (1, 1) if device.small else (200, 3)
    rates = {"cpu": [], "cuda": []}
    for backend in ("cpu", "cuda") * turns:
        output, seconds = device.make(backend, FULL, pings, SMALL if device.small else [])
        rates[backend].append(pings / seconds)
        shutil.rmtree(output.parent)
    cpu, cuda = (float(np.median(rates[backend])) for backend in ("cpu", "cuda"))
    return {"sets": {"value": cuda / cpu, "cpu": cpu, "cuda": cuda}}


def stream(device):
    """Pings of a live scenario, whose series Python takes from memory."""
    sys.path.insert(0, str(device.program.parent / "python"))
    os.environ.setdefault("ENSONIFY_COMPANIONS", str(device.program.parent))
    try:
        import ensonify
    except ImportError as error:
        raise NotMeasured(f"the Python package: {error}") from None
    small = {"sonar.beams.count": 32, "sonar.rays.elevation": 12} if device.small else {}
    first = [ensonify.Scenario.load(FULL, small, device=on).ping(want=["series"]).series for on in (False, True)]
    if np.array_equal(*first):  # the device rounds differently
        raise NotMeasured("a stream runs on the processor")
    pings = 4 if device.small else 1000
    rates = []
    for on_device in (False, True):
        made = ensonify.Scenario.load(FULL, small, device=on_device).stream(want=["series"], pings=(0, pings + 1))
        next(made)  # the world is built
        started = time.monotonic()
        count = sum(1 for _ in made)
        rates.append(count / (time.monotonic() - started))
    return {"stream": {"value": rates[1], "cpu": rates[0]}}


def bench(text):
    """What ensonify_gpu_bench printed: a row for each case, with rates and bounds by the names of its columns."""
    rows, names = {}, None
    for line in text.splitlines():
        words = line.replace("|", " ").split()
        if words[:2] == ["case", "echoes"]:
            names = words[1:]
        elif names and len(words) == len(names) + 1:
            rows[words[0]] = dict(zip(names, map(float, words[1:])))
    if not {"full", "array"} <= rows.keys():
        raise NotMeasured("the benchmark printed no rows: " + text.strip()[-300:])
    full = rows["full"]
    return {"full": {"value": full["device"], **full}, "array": {"value": rows["array"]["device"], **rows["array"]},
            "full_of_bus": {"value": full["series"] / full["down"], "series": full["series"], "bus": full["down"]}}


def first_match(pattern, *command):
    try:
        found = re.search(pattern, subprocess.run(command, capture_output=True, text=True).stdout)
    except OSError:
        return "unknown"
    return found[1] if found else "unknown"


def checked(values):
    """These figures with their bounds: `met` is whether it is as good as wanted, None where it was not measured."""
    figures = {}
    for name in (name for name in FIGURES if name in values):
        (unit, wanted, more, text), entry = FIGURES[name], values[name]
        value = entry.get("value")
        met = None if value is None else value >= wanted if more else value <= wanted
        figures[name] = {"what": text, "unit": unit, "wanted": wanted, "at_least": more, **entry, "met": met}
    return figures


def measured(device, parts, names, bench_file):
    steps = {"bench": lambda: bench(bench_file.read_text(encoding="utf-8")), "scenes": lambda: scenes(device, names),
             "arrays": lambda: arrays(device), "ensemble": lambda: ensemble(device), "sets": lambda: sets(device),
             "stream": lambda: stream(device)}
    figures_of = {"bench": ("full", "full_of_bus", "array"), "ensemble": ("ensemble", "statistics")}
    values = {}
    for part in parts:
        started = time.monotonic()
        try:
            values.update(steps[part]())
        except (NotMeasured, OSError) as reason:
            values.update({name: {"not_measured": str(reason)} for name in figures_of.get(part, (part,))})
        print(f"{part}: {time.monotonic() - started:.0f} s", file=sys.stderr)
    return values


def line_of(name, figure):
    if figure["met"] is None:
        return f"not measured {name}: {figure['not_measured']}"
    sign, met = "≥" if figure["at_least"] else "≤", "met" if figure["met"] else "NOT MET"
    return f"{met:12} {name}: {figure['value']:.4g} {figure['unit']} ({sign} {figure['wanted']:g}): {figure['what']}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="ensonify, with its CUDA module")
    parser.add_argument("--bench", type=pathlib.Path, help="what ensonify_gpu_bench printed")
    parser.add_argument("--json", type=pathlib.Path, required=True, help="the file to write")
    parser.add_argument("--only", nargs="+", choices=["bench", "scenes", "arrays", "ensemble", "sets", "stream"])
    parser.add_argument("--scenes", nargs="+", default=sorted(file.stem for file in SCENES.glob("*.yaml")))
    parser.add_argument("--small", action="store_true", help="tiny sonars and few pings")
    arguments = parser.parse_args()
    parts = arguments.only or [*(["bench"] if arguments.bench else []), "scenes", "arrays", "ensemble", "stream", "sets"]
    in_memory = MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > FOLDER_BYTES
    with tempfile.TemporaryDirectory(prefix="ensonify-gpu-check-", dir=MEMORY if in_memory else None) as folder:
        device = Device(arguments.program.resolve(), pathlib.Path(folder), arguments.small)
        figures = checked(measured(device, parts, arguments.scenes, arguments.bench))
    machine = {"device": device.name, "driver": first_match(r"(\S+)", "nvidia-smi", "--query-gpu=driver_version",
                                                            "--format=csv,noheader"),
               "toolkit": first_match(r"release ([\d.]+)", "nvcc", "--version"), "processor": processor(),
               "threads": len(os.sched_getaffinity(0)),
               "program": first_match(r"ensonify (.*)", arguments.program, "--version"), "in_memory": in_memory}
    report = {"machine": machine, "small": arguments.small, "figures": figures}
    arguments.json.write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    for name, figure in figures.items():
        print(line_of(name, figure))
    return 0 if all(figure["met"] for figure in figures.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
