"""A page of Markdown in parts: fenced blocks with their directives, headings, links, code in lines."""

import re
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

DIRECTIVES = {"skip", "file", "output", "varies", "fails", "needs", "base", "minutes"}
NEED_A_VALUE = {"skip", "file", "fails", "needs", "base"}

FENCE = re.compile(r"^( *)(```+)(.*)$")
COMMENT = re.compile(r"^ *<!-- docs-test: (.*?) -->\s*$")
# A command where it would not be run: set off by four spaces.
INDENTED = re.compile(r"    (?:[\w/.]*ensonify |\./|scripts/|import |from \w+ import|python3 |cmake |for \w+ in )")
HEADING = re.compile(r"^#{1,6} +(.*?)#* *$")
SPAN = re.compile(r"`([^`\n]+(?:\n[^`\n]+)?)`")  # over two lines at most
LINK = re.compile(r"!?\[[^\]]*\]\(([^()\s]+(?:\([^()\s]*\))?)\)")


class BadPage(Exception):
    """The page itself is wrong: a fence that stays open, an unknown directive."""


@dataclass
class Block:
    language: str
    text: str          # without the page's indentation; ends in a newline unless empty
    line: int          # of the opening fence, from 1
    first: int         # text is lines[first:last] of the page, from 0
    last: int
    indent: str
    directives: dict = field(default_factory=dict)


@dataclass
class Page:
    name: str                                       # relative to the repository
    path: Path
    lines: list
    small: bool = False                             # scenes with few beams do
    blocks: list = field(default_factory=list)
    anchors: set = field(default_factory=set)
    links: list = field(default_factory=list)       # (line, target)
    spans: list = field(default_factory=list)       # (line, code between back quotes)


def all_pages(root=ROOT):
    """Pages whose commands are run, relative to the repository."""
    return ["README.md", "CONTRIBUTING.md", "output_schema/README.md"] + sorted(
        str(path.relative_to(root)) for path in (root / "docs").rglob("*.md"))


def _directives(text, where):
    found = {}
    # A reason may hold a `;` that no key follows.
    for item in re.split(r";\s*(?=[a-z]+\s*(?:=|;|$))", text):
        key, equals, value = (part.strip() for part in item.partition("="))
        if key not in DIRECTIVES:
            raise BadPage(f"{where}: unknown directive '{key}', known are {sorted(DIRECTIVES)}")
        if key in NEED_A_VALUE and not value:
            raise BadPage(f"{where}: {key}= needs a value" +
                          (", the reason" if key == "skip" else ""))
        found[key] = value
    return found


def _slug(heading, taken):
    """The anchor that GitHub gives a heading."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    slug = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
    name, count = slug, 0
    while name in taken:
        count += 1
        name = f"{slug}-{count}"
    return name


def _read_block(page, index, fence, directives):
    """The block that opens at lines[index]; the index after its closing fence."""
    indent, ticks, language = fence.groups()
    end = index + 1
    while end < len(page.lines) and page.lines[end].strip() != ticks:
        end += 1
    if end == len(page.lines):
        raise BadPage(f"{page.name}:{index + 1}: this fence is never closed")
    body = [line[len(indent):] if line.startswith(indent) else line.lstrip()
            for line in page.lines[index + 1:end]]
    page.blocks.append(Block(language.strip(), "".join(line + "\n" for line in body), index + 1,
                             index + 1, end, indent, directives))
    return end + 1


def _read_prose(page):
    """Headings, code and links of what is in no block."""
    lines = list(page.lines)
    for block in page.blocks:
        lines[block.line - 1:block.last + 1] = [""] * (block.last + 2 - block.line)
    for line in lines:
        heading = HEADING.match(line)
        if heading:
            page.anchors.add(_slug(heading.group(1), page.anchors))
        page.anchors.update(re.findall(r'<a (?:id|name)="([^"]+)"', line))
    text = "\n".join(lines)
    for code in SPAN.finditer(text):
        page.spans.append((text.count("\n", 0, code.start()) + 1, code.group(1).replace("\n", " ")))
    prose = SPAN.sub(lambda code: "`" + "\n" * code.group(1).count("\n") + "`", text)
    for link in LINK.finditer(prose):
        page.links.append((prose.count("\n", 0, link.start(1)) + 1, link.group(1)))


def parse(name, root=ROOT):
    path = root / name
    page = Page(name, path, path.read_text(encoding="utf-8").split("\n"))
    pending, index = {}, 0
    while index < len(page.lines):
        line = page.lines[index]
        where = f"{name}:{index + 1}"
        fence, comment = FENCE.match(line), COMMENT.match(line)
        if comment and comment.group(1) == "small":
            page.small = True
        elif comment:
            pending |= _directives(comment.group(1), where)
        elif "docs-test:" in line and line.lstrip().startswith("<!--"):
            raise BadPage(f"{where}: a directive is one line, <!-- docs-test: KEY=VALUE; KEY -->")
        elif fence:
            index = _read_block(page, index, fence, pending)
            pending = {}
            continue
        else:
            if line.strip() and pending:
                raise BadPage(f"{where}: the directive above is not followed by a block")
            if INDENTED.match(line) and not page.lines[index - 1].strip():
                raise BadPage(f"{where}: a command set off by spaces would not be run; fence it")
        index += 1
    if pending:
        raise BadPage(f"{name}: the last directive is not followed by a block")
    _read_prose(page)
    return page
