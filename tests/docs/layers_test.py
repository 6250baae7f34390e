"""The layers of generator/: modules do not include each other in a cycle, and a folder includes only
folders that its row of the table in docs/architecture.md allows, or that these may use themselves.

A module is a header with the source of the same name. Run by ctest; by hand, in this folder:
    python3 -m unittest layers_test
"""
import re
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CODE = (".h", ".inl", ".cpp", ".cu")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def includes(root=ROOT):
    """{file: [included files]} of generator/, as paths below it. Files that the build makes are left out."""
    base = root / "generator"
    files = {path.relative_to(base).as_posix(): path for path in base.rglob("*") if path.suffix in CODE}
    return {name: [found for found in INCLUDE.findall(path.read_text(encoding="utf-8")) if found in files]
            for name, path in sorted(files.items())}


def module(file):
    return file.rsplit(".", 1)[0]


def reached(edges):
    """{node: every node on a path of one step or more from it}"""
    reach = {}
    for start in edges:
        seen, waiting = set(), [start]
        while waiting:
            for following in edges.get(waiting.pop(), ()):
                if following not in seen:
                    seen.add(following)
                    waiting.append(following)
        reach[start] = seen
    return reach


def cycles(root=ROOT):
    """["a, b: a.cpp includes b.h; b.h includes a.h"]: the modules of each cycle, and what closes it."""
    of_files = includes(root)
    edges = {}
    for file, found in of_files.items():
        edges.setdefault(module(file), set()).update({module(other) for other in found} - {module(file)})
    reach = reached(edges)
    groups = {tuple(sorted(other for other in reach[name] if name in reach[other]))
              for name in reach if name in reach[name]}
    return [", ".join(group) + ": " + "; ".join(
                f"{file} includes {other}" for file, found in of_files.items() for other in found
                if module(file) in group and module(other) in group and module(file) != module(other))
            for group in sorted(groups)]


def table(root=ROOT):
    """{folder: the folders that its row names under "uses"}; "all" stands for those of the rows above."""
    page = (root / "docs/architecture.md").read_text(encoding="utf-8")
    head = re.search(r"^\| folder \| task \| uses \|.*\n\|[-|]+\n((?:\|.*\n?)+)", page, re.MULTILINE)
    if head is None:
        raise ValueError("docs/architecture.md has no table with the columns folder, task, uses")
    uses = {}
    for line in head[1].splitlines():
        folder, _, named = [cell.strip(" `/") for cell in line.strip("|").split("|")][:3]
        uses[folder] = set(uses) if named == "all" else set(re.findall(r"[a-z]+", named))
    return uses


def wrong_uses(root=ROOT):
    """["a/x.h includes b/y.h, which the row of a does not allow"], folders without a row, rows without a folder, and
    rows that lead back to themselves."""
    allowed = reached(table(root))
    folders = {path.name for path in (root / "generator").iterdir() if path.is_dir()}
    faults = [f"{folder}/ has no row" for folder in sorted(folders - set(allowed))]
    faults += [f"the row of {folder} names no folder" for folder in sorted(set(allowed) - folders)]
    faults += [f"the row of {folder} leads back to it" for folder in allowed if folder in allowed[folder]]
    for file, found in includes(root).items():
        folder = file.split("/")[0]
        for other in found:
            used = other.split("/")[0]
            if folder in allowed and used != folder and used not in allowed[folder]:
                faults.append(f"{file} includes {other}, which the row of {folder} does not allow")
    return faults


class Layers(unittest.TestCase):
    def test_no_modules_include_each_other(self):
        if found := cycles():
            self.fail("modules that include each other:\n" + "\n".join(found))

    def test_folders_use_what_the_table_allows(self):
        if found := wrong_uses():
            self.fail("not as the table of docs/architecture.md says:\n" + "\n".join(found))


class PlantedFaults(unittest.TestCase):
    """A small tree of four folders, in which single files are changed."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        self.page(("core", "–"), ("world", "core"), ("labels", "core"), ("app", "all"))
        self.write("core/vec.h", "<vector>")
        self.write("world/mesh.h", '"core/vec.h"')
        self.write("world/mesh.cpp", '"world/mesh.h"', "<vector>")
        self.write("world/path.h", '"world/mesh.h"')
        self.write("labels/mask.h", '"core/vec.h"', '"made/by_the_build.h"')
        self.write("app/main.cpp", '"world/path.h"', '"labels/mask.h"')

    def page(self, *rows):
        (self.root / "docs").mkdir(exist_ok=True)
        (self.root / "docs/architecture.md").write_text(
            "| other | table |\n|---|---|\n| a | b |\n\n| folder | task | uses | private |\n|---|---|---|---|\n" +
            "".join(f"| `{folder}/` | a task with words | {uses} | fmt |\n" for folder, uses in rows) + "\ntext\n",
            encoding="utf-8")

    def write(self, name, *included):
        path = self.root / "generator" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(f"#include {one}\n" for one in included), encoding="utf-8")

    def test_a_good_tree_has_no_faults(self):
        self.assertEqual(cycles(self.root), [])
        self.assertEqual(wrong_uses(self.root), [])

    def test_a_cycle_through_a_source_is_found(self):
        self.write("world/mesh.cpp", '"world/mesh.h"', '"world/path.h"')
        self.assertEqual(cycles(self.root), [
            "world/mesh, world/path: world/mesh.cpp includes world/path.h; world/path.h includes world/mesh.h"])
        self.assertEqual(wrong_uses(self.root), [])

    def test_a_cycle_of_three_modules_is_one(self):
        self.write("world/mesh.h", '"world/file.h"')
        self.write("world/file.h", '"world/path.h"')
        self.assertEqual([cycle.split(":")[0] for cycle in cycles(self.root)], ["world/file, world/mesh, world/path"])

    def test_a_use_outside_the_row_is_found(self):
        self.write("labels/mask.h", '"world/path.h"')
        self.assertEqual(wrong_uses(self.root), [
            "labels/mask.h includes world/path.h, which the row of labels does not allow"])

    def test_what_a_used_folder_may_use_is_allowed(self):
        self.page(("core", "–"), ("world", "core"), ("labels", "world"), ("app", "all"))
        self.write("labels/mask.h", '"core/vec.h"', '"world/path.h"')
        self.assertEqual(wrong_uses(self.root), [])

    def test_folders_and_rows_belong_together(self):
        self.page(("core", "–"), ("world", "core"), ("tracing", "world"), ("app", "all"))
        self.assertEqual(wrong_uses(self.root), ["labels/ has no row", "the row of tracing names no folder",
                                                 "app/main.cpp includes labels/mask.h, which the row of app does not allow"])

    def test_rows_that_use_each_other_are_found(self):
        self.page(("core", "–"), ("world", "core, labels"), ("labels", "world"), ("app", "all"))
        self.assertEqual(wrong_uses(self.root), ["the row of world leads back to it", "the row of labels leads back to it"])

    def test_a_page_without_the_table_is_refused(self):
        (self.root / "docs/architecture.md").write_text("| a | b |\n|---|---|\n", encoding="utf-8")
        with self.assertRaises(ValueError):
            wrong_uses(self.root)


if __name__ == "__main__":
    unittest.main()
