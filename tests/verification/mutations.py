#!/usr/bin/python3
"""Spoils one formula at a time and shows that its experiments notice.

    mutations.py [--list mutations.json] [--only TEXT] [--keep DIR] [--jobs N]

A developer's tool. The tree is copied, built once, and then for every entry of the list: one text
is replaced, the program built again, its cases run. They must fail (by rows, not by a crash of the
program). Before that every case that is named must pass on the sound program. Exit status 0 only
if every fault is noticed.
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LEFT_OUT = shutil.ignore_patterns(".git", "build", "out", "__pycache__")


def read_list(path, only):
    """Entries of the list, without the skipped ones."""
    entries = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    for number, entry in enumerate(entries, 1):
        for key in ("file", "text", "replacement", "cases"):
            if key not in entry:
                raise SystemExit(f"{path}: entry {number} has no {key}")
    return [
        entry
        for entry in entries
        if not entry.get("skip") and (not only or only in json.dumps(entry))
    ]


def command(words, **options):
    return subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, check=False, **options
    )


def copy_new(source, target):
    """Copy what differs, as of now: a kept build must see that a fault was taken out again."""
    target = pathlib.Path(target)
    content = pathlib.Path(source).read_bytes()
    if not target.exists() or target.read_bytes() != content:
        target.write_bytes(content)
        shutil.copymode(source, target)
    return str(target)


def build(tree, jobs):
    """Build the program; its output where that fails."""
    if not (tree / "build/release/build.ninja").exists():
        result = command(["cmake", "--preset", "release", "-DENSONIFY_TESTS=OFF"], cwd=tree)
        if result.returncode:
            return result.stdout + result.stderr
    result = command(
        ["cmake", "--build", "--preset", "release", "--target", "ensonify", "-j", jobs], cwd=tree
    )
    return "" if result.returncode == 0 else result.stdout + result.stderr


def failed_rows(tree, cases):
    """Exit status of the cases and the rows that fail; the suite is this tree's, not the copy's."""
    result = command(
        [
            sys.executable,
            HERE / "verify_physics.py",
            tree / "build/release/ensonify",
            "--only",
            ",".join(cases),
        ]
    )
    rows = re.findall(r"^FAIL ([^:]+): (.*)$", result.stdout, re.MULTILINE)
    return result.returncode, rows, result.stderr


def mutate(tree, entry):
    """Put the fault in; the text must stand in the file exactly once."""
    path = tree / entry["file"]
    if not path.is_file():
        return None, "no such file"
    sound = path.read_text(encoding="utf-8")
    if sound.count(entry["text"]) != 1:
        return None, f"the text stands there {sound.count(entry['text'])} times"
    path.write_text(sound.replace(entry["text"], entry["replacement"]), encoding="utf-8")
    return sound, ""


def try_entry(tree, entry, jobs):
    """Verdict in words; begins with "noticed" where all is well."""
    sound, trouble = mutate(tree, entry)
    if trouble:
        return trouble
    try:
        trouble = build(tree, jobs)
        if trouble:
            return "does not build: " + trouble.strip().splitlines()[-1][:80]
        silent = []
        for name in entry["cases"]:
            status, rows, error = failed_rows(tree, [name])
            crashed = [row for row in rows if "could not be made" in row[1]]
            if status != 1 or not rows:
                silent.append(name)
            elif crashed or "Traceback" in error:
                silent.append(f"{name} (crashed, which is no measurement)")
        return "not noticed by " + ", ".join(silent) if silent else "noticed"
    finally:
        (tree / entry["file"]).write_text(sound, encoding="utf-8")


def sound_program(tree, entries, jobs):
    """Build the copy and run every named case on it; what is wrong in words."""
    trouble = build(tree, jobs)
    if trouble:
        return "the sound program does not build:\n" + trouble[-2000:]
    cases = sorted({name for entry in entries for name in entry["cases"]})
    status, rows, error = failed_rows(tree, cases)
    return "" if status == 0 else f"cases fail on the sound program: {rows or error[-500:]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--list", default=HERE / "mutations.json")
    parser.add_argument("--only", help="only entries that hold this text")
    parser.add_argument("--keep", help="keep the copy of the tree (and its build) here")
    parser.add_argument("--jobs", default="2")
    options = parser.parse_args()
    entries = read_list(options.list, options.only)
    with tempfile.TemporaryDirectory(prefix="ensonify-") as scratch:
        tree = pathlib.Path(options.keep or scratch) / "tree"
        shutil.copytree(ROOT, tree, ignore=LEFT_OUT, dirs_exist_ok=True, copy_function=copy_new)
        trouble = sound_program(tree, entries, options.jobs)
        if trouble:
            print(trouble)
            return 1
        missed = 0
        print("| file | replacement | cases | verdict |\n|---|---|---|---|")
        for entry in entries:
            verdict = try_entry(tree, entry, options.jobs)
            missed += verdict != "noticed"
            print(
                f"| {entry['file']} | `{entry['replacement'].strip()[:60]}` | "
                f"{', '.join(entry['cases'])} | {verdict} |",
                flush=True,
            )
    print(f"mutations: {len(entries) - missed} of {len(entries)} noticed")
    return 1 if missed or not entries else 0


if __name__ == "__main__":
    sys.exit(main())
