"""Sums of the arrays of a data set, for processors whose bytes nobody has stored: sums.txt.

    sums_of(folder)          {array: Sum} of the first sequence; arrays of a ping are named by ping
    differences(got, stored) what differs by more than rounding may, in words
    read, write              the text file: a line for each array, of scene, pings made, array, kind and numbers

Other instruction sets and libraries round differently in the last bits, so a pixel here and there takes the next step
of its format. Kinds of arrays, and what may differ:

    series    complex [beams, samples]: means, rms, samples and levels of beams by 1e-5 of the amplitude
    decibels  half floats of images [samples, beams]: means by 1e-5 of the amplitude, samples by one step of half floats
    halves    other half floats of images: mean and rms by 1e-5 of the rms, samples by that or one step
    numbers   other real arrays: mean, rms and samples by 1e-5 of the rms
    steps     counts and gray levels: mean and rms by 1e-5 or 1e-3 of a step, samples by one step
    labels    numbers of pixels of each value: by 1e-4, or one pixel

Levels are summed by groups of 32 beams, as logarithms: 1e-3 of one beam, however faint, is 3e-5 of its group.
"""
import math
import pathlib
import sys
from typing import NamedTuple

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "independent"))
import sonar_dataset  # noqa: E402

FILE = HERE / "sums.txt"
GROUP = 32
# Below this share of a series' mean power, and this far below an image's peak, rounding is heard.
FAINT, DEPTH_DB = 1e-10, 80
DB_OF_1E_5 = 20 * math.log10(1 + 1e-5)


class Sum(NamedTuple):
    kind: str
    size: int
    floor: float  # of decibels
    step: float  # of a converter, 0 without one
    numbers: tuple  # mean, rms, samples, groups, or value and count of labels by turns


def _samples(array):
    """Five fixed ones, none at an edge."""
    flat = array.ravel()
    return [flat[flat.size * k // 23] for k in (5, 9, 12, 14, 19)]


def _groups(levels):
    return [float(np.mean(levels[at : at + GROUP])) for at in range(0, len(levels), GROUP)]


def _series(array, step):
    power = np.mean(np.abs(array.astype(complex)) ** 2, axis=1)
    rms = math.sqrt(power.mean())
    mean = array.mean(dtype=complex)
    parts = [part for value in _samples(array) for part in (value.real, value.imag)]
    levels = 0.5 * np.log(power / power.mean() + FAINT) if rms else 0 * power
    return Sum("series", array.size, 0, step, (mean.real, mean.imag, rms, *parts, *_groups(levels)))


def _decibels(array, floor):
    array = array.astype(float)
    floor = math.floor(array.max()) - DEPTH_DB if floor is None else floor
    heard = np.maximum(array, floor)
    return Sum("decibels", array.size, floor, 0,
               (heard.mean(), heard.std(), *_samples(heard), *_groups(heard.mean(axis=0))))


def _plain(kind, array):
    array = array.astype(float)
    finite = array[np.isfinite(array)]
    rms = math.sqrt(np.mean(finite**2)) if finite.size else 0
    return Sum(kind, int(finite.size), 0, 0, (finite.mean() if finite.size else 0, rms, *_samples(array)))


def _labels(array):
    values, counts = np.unique(array, return_counts=True)
    return Sum("labels", array.size, 0, 0, tuple(n for pair in zip(values, counts) for n in pair))


def sum_of(name, array, floor=None, adc_step=0):
    if np.iscomplexobj(array):
        return _series(array, adc_step) if array.ndim == 2 else _plain("numbers", np.abs(array))
    if name.endswith(("_db", "/Y")):
        return _decibels(array, floor)
    if array.dtype.kind == "u":
        return _plain("steps", array) if name.startswith(("png/", "recorded/")) else _labels(array)
    return _plain("halves" if array.dtype == np.float16 else "numbers", array)


def arrays_of(sequence):
    """(name, array) of a sequence's folder, written by ping."""
    for path in sorted(sequence.rglob("*")):
        name = path.relative_to(sequence).with_suffix("").as_posix()
        if path.suffix == ".npy":
            array = sonar_dataset.read_npy(path)
            yield from ((f"{name}/{field}", array[field]) for field in array.dtype.names or ())
            if not array.dtype.names:
                yield name, array
        elif path.suffix == ".png":
            yield name, sonar_dataset.read_png(path)
        elif path.suffix == ".exr":
            for part in sonar_dataset.read_exr(path):
                yield from ((f"{name}/{channel}", array) for channel, array in part.channels.items())


def sums_of(out, stored=None):
    """Of the first sequence of a data set. An image's floor is the stored one, where there is one."""
    sequence = out / "sequences/000000"
    adc = sonar_dataset.read_json(sequence / "sequence.json")["sonar"].get("adc")
    step = adc["step_pa"] if adc else 0
    floors = {name: known.floor for name, known in (stored or {}).items()}
    return {name: sum_of(name, array, floors.get(name), step) for name, array in arrays_of(sequence)}


def _half_step(value):
    return float(np.spacing(np.float16(abs(value)))) if math.isfinite(value) else 0


def _step(kind, value):
    return {"steps": lambda: 1, "halves": lambda: _half_step(value), "numbers": lambda: 0}[kind]()


def _allowed(known):
    """How much each number may differ by."""
    numbers = known.numbers
    if known.kind == "series":
        rms, beams = numbers[2], len(numbers) - 13
        # A converter's step more or less in a sample or two of each beam.
        stepped = known.step / max(rms, 1e-300) * 8 / math.sqrt(known.size)
        near = (1e-5 + stepped) * rms
        samples = [max(1e-5 * max(rms, abs(value)), 1.001 * known.step) for value in numbers[3:13]]
        return [near] * 3 + samples + [1e-5 + stepped] * beams
    if known.kind == "decibels":
        return [DB_OF_1E_5] * 2 + [_half_step(v) for v in numbers[2:7]] + [DB_OF_1E_5] * (len(numbers) - 7)
    if known.kind == "labels":
        return [max(1, 1e-4 * count) for count in numbers[1::2]]
    near = max(1e-5 * numbers[1], 1e-3 if known.kind == "steps" else 0)
    return [near] * 2 + [max(near, _step(known.kind, value)) for value in numbers[2:]]


def _label_difference(got, known):
    found, stored = (dict(zip(s.numbers[::2], s.numbers[1::2])) for s in (got, known))
    for value in sorted(found.keys() | stored.keys()):
        most = max(1, 1e-4 * stored.get(value, 0))
        if abs(found.get(value, 0) - stored.get(value, 0)) > most:
            return f"{found.get(value, 0):g} pixels of label {value:g}, {stored.get(value, 0):g} stored"
    return None


def difference(got, known):
    """In words; None where there is none."""
    if got.kind != known.kind or len(got.numbers) != len(known.numbers) and got.kind != "labels":
        return f"{got.kind} of {len(got.numbers)} numbers, {known.kind} of {len(known.numbers)} stored"
    if abs(got.size - known.size) > 1e-4 * known.size:
        return f"{got.size} numbers, {known.size} stored"
    if got.kind == "labels":
        return _label_difference(got, known)
    for at, (value, stored, most) in enumerate(zip(got.numbers, known.numbers, _allowed(known))):
        if not (abs(value - stored) <= most or math.isnan(value) and math.isnan(stored)):
            return f"number {at} of its sums is {value:.7g}, {stored:.7g} stored, {most:.2g} allowed"
    return None


def differences(got, stored):
    found = [f"{name}: in one of them only" for name in sorted(got.keys() ^ stored.keys())]
    for name in sorted(got.keys() & stored.keys()):
        if what := difference(got[name], stored[name]):
            found.append(f"{name}: {what}")
    return found


def read(path=FILE):
    """{(scene, pings): {array: Sum}}. What two pings share with one stands once in the file."""
    found = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        scene, pings, name, kind, size, floor, step, *numbers = line.split()
        numbers = tuple(int(n) if kind == "labels" else float(n) for n in numbers)
        found.setdefault((scene, pings), {})[name] = Sum(kind, int(size), float(floor), float(step), numbers)
    return {(scene, pings): {**found.get((scene, "0:1"), {}), **arrays} for (scene, pings), arrays in found.items()}


def write(sums, path=FILE):
    lines = []
    for (scene, pings), arrays in sorted(sums.items()):
        one = sums.get((scene, "0:1"), {}) if pings != "0:1" else {}
        for name, known in sorted(arrays.items()):
            if str(one.get(name)) == str(known):  # as text NaN equals NaN
                continue
            words = [scene, pings, name, known.kind, known.size, f"{known.floor:g}", f"{known.step:.7g}"]
            words += [n if known.kind == "labels" else f"{n:.7g}" for n in known.numbers]
            lines.append(" ".join(map(str, words)) + "\n")
    path.write_text("".join(lines), encoding="utf-8")
