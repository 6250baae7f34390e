#!/usr/bin/env python3
"""frozen.py PROGRAM [--all | --write | --against OTHER] [--simd LEVEL] [SCENE...]

Makes one ping of every scene of scenes/, two packed ones of three of them, and compares a hash over all files of each
data set with the list of this class of machine, tests/frozen/SIMD_EMBREE_SYSTEM.txt: the instruction sets that the
program used, and the release of the system, whose libraries pack images and do the transforms. Where there is no
list, the sums of every array are compared with tests/frozen/sums.txt instead (sums.py says how closely). A change that
is meant to move code alone must leave both as they are. What names the build is left out of the hashes: work.json,
provenance.json, dataset.sha256, and of dataset.json `program`, `numerics`, `bytes` and what it says of work.json.

  --all       two pings of every scene, by ping and packed, in place of one; sums too
  --write     makes the list of this class anew, for a change of the bytes that is meant, and the sums where they are
              others; CHANGELOG.md says why
  --against   another program in place of the list: the files that differ are named
  --simd      the instruction set that the program is to use

Ends with 0 where all are equal, with 1 where one differs.
"""
import argparse
import hashlib
import json
import pathlib
import platform
import subprocess
import sys
import tempfile

import sums

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "scenes"
PACKED = ["--set", "output.one_file_per=sequence"]
# Name of what is made -> pings and options.
MODES = {"one ping": ("0:1", []), "by ping": ("0:2", []), "packed": ("0:2", PACKED)}
# An ADC, layers, statistics, several paths: what packing has to do with.
PACKED_ONES = ("calibration_sphere", "shallow_water", "speckle_wall")
LEFT_OUT = ("work.json", "provenance.json", "dataset.sha256")


def made(program, scene, mode, folder, simd="auto"):
    """The data set's folder."""
    out = folder / f"{scene.stem} {mode}"
    pings, more = MODES[mode]
    command = [program, "generate", scene, "-o", out, "--pings", pings, "--sequences", "0:1", "--quiet", "--simd", simd,
               *more]
    done = subprocess.run([*map(str, command)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{scene.name}, {mode}: {done.stderr}")
    return out


def digests(out):
    """SHA-256 of every file, by name."""
    found = {}
    for path in sorted(out.rglob("*")):
        if path.is_dir() or path.name in LEFT_OUT:
            continue
        content = path.read_bytes()
        if path == out / "dataset.json":
            manifest = json.loads(content)
            del manifest["program"], manifest["numerics"], manifest["bytes"]
            manifest["files"] = [entry for entry in manifest["files"] if entry["path"] not in LEFT_OUT]
            content = json.dumps(manifest).encode()
        found[path.relative_to(out).as_posix()] = hashlib.sha256(content).hexdigest()
    return found


def class_of(out):
    """Instruction sets and system, as lists are named."""
    numerics = json.loads((out / "dataset.json").read_text())["numerics"]
    system = platform.freedesktop_os_release()
    name = f"{numerics['simd']}_{numerics['embree_isa']}_{system['ID']}{system.get('VERSION_ID', '')}"
    return name.replace(" ", "_")  # "avx2 on avx512"


def one_hash(files):
    lines = "".join(f"{digest}  {name}\n" for name, digest in sorted(files.items()))
    return hashlib.sha256(lines.encode()).hexdigest()


def wanted_modes(scene, wanted):
    if wanted.write:
        return list(MODES)
    if wanted.all or wanted.against:
        return ["by ping", "packed"]
    return ["one ping"] + ["packed"] * (scene.stem in PACKED_ONES)


def compare_programs(wanted, scenes):
    """The number of scenes and modes whose files differ."""
    differ = 0
    for scene in scenes:
        for mode in wanted_modes(scene, wanted):
            with tempfile.TemporaryDirectory(prefix="ensonify-frozen-") as folder:
                ours, theirs = (digests(made(p, scene, mode, pathlib.Path(folder) / str(k), wanted.simd))
                                for k, p in enumerate((wanted.program, wanted.against)))
            names = sorted(name for name in ours.keys() | theirs.keys() if ours.get(name) != theirs.get(name))
            differ += bool(names)
            print(f"{scene.stem}, {mode}: {len(ours)} files, {', '.join(names) or 'all equal'}")
    return differ


def read_list(path):
    lines = path.read_text().splitlines() if path.is_file() else []
    return {name: digest for digest, name in (line.split("  ") for line in lines)}


def make_all(wanted, scenes, stored):
    """(class of machine, {scene and mode: hash}, {(scene, pings): sums}); sums where they will be needed."""
    machine, listed, found, arrays = None, True, {}, {}
    for scene in scenes:
        for mode in wanted_modes(scene, wanted):
            if mode == "packed" and not listed:
                continue  # its arrays are those of the files
            with tempfile.TemporaryDirectory(prefix="ensonify-frozen-") as folder:
                out = made(wanted.program, scene, mode, pathlib.Path(folder), wanted.simd)
                machine = class_of(out)
                listed = wanted.write or (HERE / f"{machine}.txt").is_file()
                found[f"{scene.stem}, {mode}"] = one_hash(digests(out))
                if mode != "packed" and (wanted.all or wanted.write or not listed):
                    key = scene.stem, MODES[mode][0]
                    arrays[key] = sums.sums_of(out, stored.get(key))
    return machine, found, arrays


def unlike_sums(arrays, stored):
    """What differs from the stored sums, in words."""
    return [f"{scene}, pings {pings}: {what}" for (scene, pings), got in arrays.items()
            for what in sums.differences(got, stored.get((scene, pings), {}))]


def write(path, found, arrays, stored):
    known = read_list(path)
    known.update(found)
    path.write_text("".join(f"{digest}  {name}\n" for name, digest in sorted(known.items())))
    print(f"{path}: {len(found)} hashes")
    if unlike_sums(arrays, stored):
        sums.write({**stored, **arrays})
        print(f"{sums.FILE}: sums of {sum(map(len, arrays.values()))} arrays")


def compare(machine, found, arrays, stored):
    """What to print, and how many data sets or arrays differ."""
    path, lines, differ = HERE / f"{machine}.txt", [], []
    if path.is_file():
        frozen = read_list(path)
        differ = [name for name, digest in found.items() if frozen.get(name) != digest]
        lines = [f"{name}: other bytes than when the list was made; --against the program of then names the files"
                 for name in differ]
        lines.append(f"{len(found) - len(differ)} of {len(found)} data sets have the bytes of the list {path.name}")
    else:
        lines.append(f"there is no list {path.name} for this class of machine: sums are compared, not bytes")
    unlike = unlike_sums(arrays, stored)
    if arrays:
        lines += [*unlike, f"{sum(map(len, arrays.values()))} arrays compared with their sums, {len(unlike)} differ"]
    return lines, len(differ) + len(unlike)


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--against", type=pathlib.Path)
    parser.add_argument("--simd", default="auto")
    parser.add_argument("scenes", nargs="*")
    wanted = parser.parse_intermixed_args()
    scenes = [scene for scene in sorted(SCENES.glob("*.yaml")) if not wanted.scenes or scene.stem in wanted.scenes]
    if wanted.against:
        return min(compare_programs(wanted, scenes), 1)
    stored = sums.read() if sums.FILE.is_file() else {}
    machine, found, arrays = make_all(wanted, scenes, stored)
    path = HERE / f"{machine}.txt"
    if wanted.write:
        write(path, found, arrays, stored)
        return 0
    lines, differ = compare(machine, found, arrays, stored)
    print(*lines, sep="\n")
    return min(differ, 1)


if __name__ == "__main__":
    sys.exit(main())
