#!/usr/bin/env python3
"""frozen.py PROGRAM [--write | --against OTHER] [SCENE...]

Makes two pings of every scene of scenes/, by ping and packed, and compares a hash over all files with the list of
the instruction sets that the program used (tests/frozen/SIMD_EMBREE.txt). A change that is meant to move code alone
must leave the lists as they are. What names the build is left out: work.json, provenance.json, dataset.sha256, and of
dataset.json `program`, `numerics`, `bytes` and what it says of work.json.

  --write     makes the list anew, for a change of the bytes that is meant; CHANGELOG.md says why
  --against   another program in place of the list: the files that differ are named

Ends with 0 where all are equal, with 1 where one differs, with 77 where there is no list for this processor.
"""
import argparse
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "scenes"
MODES = {"by ping": [], "packed": ["--set", "output.one_file_per=sequence"]}
LEFT_OUT = ("work.json", "provenance.json", "dataset.sha256")


def made(program, scene, mode, folder):
    """The data set's folder."""
    out = folder / f"{scene.stem} {mode}"
    command = [program, "generate", scene, "-o", out, "--pings", "0:2", "--sequences", "0:1", "--quiet", *MODES[mode]]
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


def instruction_sets(out):
    numerics = json.loads((out / "dataset.json").read_text())["numerics"]
    return f"{numerics['simd']}_{numerics['embree_isa']}"


def one_hash(files):
    lines = "".join(f"{digest}  {name}\n" for name, digest in sorted(files.items()))
    return hashlib.sha256(lines.encode()).hexdigest()


def compare_programs(program, other, scenes):
    """The number of scenes and modes whose files differ."""
    differ = 0
    for scene in scenes:
        for mode in MODES:
            with tempfile.TemporaryDirectory(prefix="ensonify-frozen-") as folder:
                ours, theirs = (digests(made(p, scene, mode, pathlib.Path(folder) / str(k)))
                                for k, p in enumerate((program, other)))
            names = sorted(name for name in ours.keys() | theirs.keys() if ours.get(name) != theirs.get(name))
            differ += bool(names)
            print(f"{scene.stem}, {mode}: {len(ours)} files, {', '.join(names) or 'all equal'}")
    return differ


def make_list(program, scenes):
    """(instruction sets, {scene and mode: hash})."""
    found, sets = {}, None
    for scene in scenes:
        for mode in MODES:
            with tempfile.TemporaryDirectory(prefix="ensonify-frozen-") as folder:
                out = made(program, scene, mode, pathlib.Path(folder))
                sets = instruction_sets(out)
                found[f"{scene.stem}, {mode}"] = one_hash(digests(out))
    return sets, found


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n")[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--against", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*")
    wanted = parser.parse_intermixed_args()
    scenes = [scene for scene in sorted(SCENES.glob("*.yaml")) if not wanted.scenes or scene.stem in wanted.scenes]
    if wanted.against:
        return min(compare_programs(wanted.program, wanted.against, scenes), 1)
    sets, found = make_list(wanted.program, scenes)
    path = HERE / f"{sets}.txt"
    if wanted.write:
        path.write_text("".join(f"{digest}  {name}\n" for name, digest in found.items()))
        print(f"{path}: {len(found)} hashes")
        return 0
    if not path.is_file():
        print(f"skipped: there is no list {path.name}")
        return 77
    frozen = {name: digest for digest, name in (line.split("  ") for line in path.read_text().splitlines())}
    differ = [name for name, digest in found.items() if frozen.get(name) != digest]
    for name in differ:
        print(f"{name}: other bytes than when the list was made; --against the program of then names the files")
    print(f"{len(found) - len(differ)} of {len(found)} equal, {sets}")
    return min(len(differ), 1)


if __name__ == "__main__":
    sys.exit(main())
