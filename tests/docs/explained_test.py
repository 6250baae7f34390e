"""What the program lists has its explanation, and the test by independent code that architecture.md asks for.

ENSONIFY is the program. Run by ctest; by hand, in this folder:
    ENSONIFY=../../build/release/ensonify python3 -m unittest explained_test
"""
import json
import os
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("ENSONIFY", "ensonify")
LAW_PAGES = ["docs/physics/1_scattering.md", "docs/physics/multipath.md"]
LAW_TESTS = ["tests/verification/scattering.py", "tests/independent/surface_laws.py"]


def text_of(*names):
    return "\n".join((ROOT / name).read_text() for name in names)


# The two files of the program's lists are held against it by reference_test.py.
def planes():
    outputs = json.loads(text_of("scripts/ensonify_dataset/outputs.json"))
    return [row["name"] for kind in ("planes", "front") for row in outputs[kind]]


def laws():
    return json.loads(text_of("output_schema/sequence.schema.json"))["definitions"]["law"]["properties"]["model"]["enum"]


def export_formats():
    text = subprocess.run([PROGRAM, "export", "--help"], check=True, capture_output=True, text=True).stdout
    return re.search(r"--format TEXT:\{([^}]*)\}", text)[1].split(",")


def unexplained(names, page):
    """The names that a page does not have in backticks, as a word, as `*_NAME.png`, or `_y` after `NAME_x`."""
    words = set(re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", page, flags=re.DOTALL)))
    words |= {found[1] for found in (re.fullmatch(r"\*_(\w+)\.png", word) for word in words) if found}
    short = {name[:-1] + axis for name in words if name.endswith("_x") for axis in "yz" if "_" + axis in words}
    return [name for name in names if name not in words | short]


def untested(names, code):
    return [name for name in names if f'"{name}"' not in code]


class Explained(unittest.TestCase):
    def test_planes(self):
        self.assertEqual(unexplained(planes(), text_of("docs/dataset.md")), [], "docs/dataset.md")

    def test_scattering_laws(self):
        for page in LAW_PAGES:
            formulas = re.findall(r"^ *(?:\(5\) +)?(\w+): +s_b = ", text_of(page), re.MULTILINE)
            rows = "".join(f"`{word}`" for word in formulas) + text_of(page)
            self.assertEqual(unexplained(laws(), rows), [], page)
        for code in LAW_TESTS:
            self.assertEqual(untested(laws(), text_of(code)), [], code)

    def test_export_formats(self):
        self.assertEqual(unexplained(export_formats(), text_of("docs/export.md")), [], "docs/export.md")
        tests = [path for folder in ("export", "recordings") for path in (ROOT / "tests" / folder).glob("*_test.py")]
        self.assertEqual(untested(export_formats(), text_of(*tests)), [], "tests/export/NAME_test.py")

    def test_what_is_missing_is_found(self):
        self.assertEqual(unexplained(["a_x", "a_y", "a_z", "b", "c"], "`a_x`, `_y` and `b`\n```\n`c`\n```\n"), ["a_z", "c"])
        self.assertEqual(untested(["one", "two"], 'law("one") # two'), ["two"])


if __name__ == "__main__":
    unittest.main()
