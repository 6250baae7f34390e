"""Links of the documentation lead somewhere, and every page stands in the index."""

import re
import tempfile
import unittest
from functools import lru_cache
from pathlib import Path
from urllib.parse import unquote

import pages
from pages import ROOT, all_pages

parse = lru_cache(maxsize=None)(pages.parse)  # many links lead to a page

INDEX = "docs/README.md"
GROUPS = ["Start here", "How-to", "Reference", "Background"]


def broken(name, root=ROOT):
    """["PAGE:LINE: what is wrong"] of the links within the repository."""
    faults, page = [], parse(name, root)
    for line, target in page.links:
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = unquote(target).partition("#")
        file = (root / name).parent / path if path else root / name
        where = f"{name}:{line}: {target}"
        if not file.exists():
            faults.append(f"{where}: not there")
        elif not file.resolve().is_relative_to(root.resolve()):
            faults.append(f"{where}: outside of the repository")
        elif anchor and file.suffix == ".md":
            to = parse(str(file.resolve().relative_to(root.resolve())), root)
            if anchor not in to.anchors:
                faults.append(f"{where}: no such heading")
    return faults


def linked_from(name, root):
    return {((root / name).parent / target.partition("#")[0]).resolve()
            for _, target in parse(name, root).links}


def not_in_index(root=ROOT):
    """Pages below docs/ that neither the index names nor the README.md of a folder that it names."""
    linked = linked_from(INDEX, root)
    for folder in (root / "docs").glob("*/README.md"):
        if folder.resolve() in linked:
            linked |= linked_from(str(folder.relative_to(root)), root)
    return [name for name in all_pages(root) if name.startswith("docs/") and name != INDEX
            and (root / name).resolve() not in linked]


class Links(unittest.TestCase):
    def test_links_lead_somewhere(self):
        faults = [fault for name in all_pages() + ["CHANGELOG.md"] for fault in broken(name)]
        self.assertEqual(faults, [])

    def test_the_index_has_every_page(self):
        self.assertEqual(not_in_index(), [])
        text = (ROOT / INDEX).read_text(encoding="utf-8")
        self.assertEqual(re.findall(r"^## (.*)$", text, re.M), GROUPS)

    def test_that_faults_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "docs").mkdir()
            (root / "docs/README.md").write_text("[a](a.md) [b](gone.md) [h](how/README.md)\n", encoding="utf-8")
            (root / "docs/a.md").write_text(
                "# One `two`: three\n\n[x](#one-two-three) [y](#four) [z](README.md) ![p](p.png)\n"
                "[w](../../etc)\n[v](https://example.org)\n", encoding="utf-8")
            (root / "docs/b.md").write_text("# B\n", encoding="utf-8")
            for group in ("how", "why"):
                (root / "docs" / group).mkdir()
                (root / f"docs/{group}/README.md").write_text("[to](to.md)", encoding="utf-8")
                (root / f"docs/{group}/to.md").write_text("", encoding="utf-8")
            (root / "README.md").write_text("", encoding="utf-8")
            self.assertEqual(broken("docs/README.md", root), ["docs/README.md:1: gone.md: not there"])
            self.assertEqual([fault.split(": ", 1)[1] for fault in broken("docs/a.md", root)],
                             ["#four: no such heading", "p.png: not there", "../../etc: not there"])
            self.assertEqual(not_in_index(root), ["docs/b.md", "docs/why/README.md", "docs/why/to.md"])


if __name__ == "__main__":
    unittest.main()
