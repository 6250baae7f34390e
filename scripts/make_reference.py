#!/usr/bin/env python3
"""Makes docs/scenario_keys.md and docs/file_members.md from output_schema and configs/sonars.

    scripts/make_reference.py            writes both pages
    scripts/make_reference.py --check    writes nothing; exit status 1 where a page is not up to date
"""
import argparse
import pathlib
import sys

from reference import files_page, scenario_page

ROOT = pathlib.Path(__file__).resolve().parent.parent


def pages(root=ROOT):
    return {"scenario_keys.md": scenario_page.make(root)[0], "file_members.md": files_page.make(root)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only say which pages are not up to date")
    check = parser.parse_args().check
    old = []
    for name, text in pages().items():
        path = ROOT / "docs" / name
        if path.exists() and path.read_text() == text:
            continue
        old.append(name)
        if not check:
            path.write_text(text)
    for name in old if check else []:
        print(f"docs/{name} is not up to date; run scripts/make_reference.py", file=sys.stderr)
    return 1 if check and old else 0


if __name__ == "__main__":
    sys.exit(main())
