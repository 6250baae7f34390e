#!/usr/bin/env python3
"""Makes the reference pages, the schemas of scenarios and of most JSON files, and the table of image planes:

    output_schema/scenario.schema.json                from the program
    output_schema/NAME.schema.json                    from the program and output_schema/NAME_members.json
    scripts/ensonify_dataset/outputs.json             from the program
    docs/scenario_keys.md and docs/file_members.md    from output_schema/
    the tables of docs/sonars.md                      from configs/sonars/
    the help shown in docs/command_line.md            from the program (its test compares it)

    scripts/make_reference.py            writes them all
    scripts/make_reference.py --check    writes nothing; exit status 1 if one is not up to date
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys

from reference import files_page, member_schema, presets, scenario_page

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Schemas that the program prints without most texts.
DESCRIBED = ("sequence", "dataset", "annotations", "render")
# Files that the program prints, by what --help-format calls them.
PRINTED = {"output_schema/scenario.schema.json": "schema", "scripts/ensonify_dataset/outputs.json": "outputs",
           **{f"output_schema/{name}.schema.json": name for name in DESCRIBED}}


def pages(root=ROOT):
    return {"scenario_keys.md": scenario_page.make(root)[0], "file_members.md": files_page.make(root),
            "sonars.md": presets.make(root)}


def printed(program, what, root=ROOT):
    text = subprocess.run([program, "--help-format", what], check=True, capture_output=True, text=True).stdout
    if what in DESCRIBED:
        return member_schema.make(root, what, text)
    return member_schema.compact(json.loads(text)) + "\n" if what == "schema" else text


def replaced(path, text, write):
    """Whether the file did not hold `text`. Writes `text` to it if `write`."""
    if path.exists() and path.read_text() == text:
        return False
    if write:
        path.write_text(text)
    return True


def write_command_line(program):
    subprocess.run([sys.executable, ROOT / "tests/docs/commands_test.py", "--write", "docs/command_line.md"], check=True,
                   env={**os.environ, "ENSONIFY": str(program)}, stdout=subprocess.DEVNULL)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only say which pages are not up to date")
    parser.add_argument("--program", default=ROOT / "build/release/ensonify", help="the built ensonify")
    arguments = parser.parse_args()
    write = not arguments.check
    old = [ROOT / name for name, what in PRINTED.items()
           if replaced(ROOT / name, printed(arguments.program, what), write)]
    old += [ROOT / "docs" / name for name, text in pages().items() if replaced(ROOT / "docs" / name, text, write)]
    if write:
        write_command_line(arguments.program)
    for path in old if arguments.check else []:
        print(f"{path.relative_to(ROOT)} is not up to date; run scripts/make_reference.py", file=sys.stderr)
    return 1 if arguments.check and old else 0


if __name__ == "__main__":
    sys.exit(main())
