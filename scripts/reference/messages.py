"""docs/messages.txt: every error, warning and help text of the program, by the file that holds it.

The texts are the string literals of generator/ with three words or more, adjacent ones joined. Titles and
meanings of keys are left out: docs/scenario_keys.md has them.
"""
import re

HEAD = """\
Every error, warning and help text of the program, by source file. Made by scripts/make_reference.py, so that all of
them can be read in one sitting and a change of one shows in review. {…} stands for what a message fills in.
"""
# Scripts and styles of the report page, which no user reads.
LEFT_OUT = ("report/page/",)
LITERAL = re.compile(r'(?:u8|R)?"((?:[^"\\\n]|\\.)*)"')
ESCAPES = {"n": "\n", "t": "\t", '"': '"', "\\": "\\", "'": "'"}


def without_comments(text):
    pattern = r'"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\'|//[^\n]*|/\*.*?\*/'
    return re.sub(pattern, lambda found: " " if found[0].startswith("/") else found[0], text, flags=re.DOTALL)


def literals(text):
    """The string literals of a source in their order, adjacent ones joined."""
    text = re.sub(r'R"(\w*)\((.*?)\)\1"', lambda raw: '"' + raw[2].replace("\\", "\\\\").replace('"', '\\"').replace(
        "\n", "\\n") + '"', without_comments(re.sub(r"^\s*#include.*$", "", text, flags=re.MULTILINE)), flags=re.DOTALL)
    joined, end = [], None
    for found in LITERAL.finditer(text):
        if end is not None and not text[end:found.start()].strip():
            joined[-1] += found[1]
        else:
            joined.append(found[1])
        end = found.end()
    return [re.sub(r"\\(.)", lambda escape: ESCAPES.get(escape[1], escape[0]), one) for one in joined]


def is_text(one):
    return len(re.findall(r"(?<![\w$.{-])[A-Za-z][a-z']*(?![\w(=])", one)) >= 3 and not re.search(r"[;{]\s*$|</?\w", one)


def texts(root):
    """[(file, text)] in the order of the sources."""
    keys = (root / "output_schema/scenario.schema.json").read_text()
    for path in sorted((root / "generator").rglob("*")):
        name = path.relative_to(root).as_posix()
        if path.suffix not in (".cpp", ".h", ".cu") or any(part in name for part in LEFT_OUT):
            continue
        for one in literals(path.read_text()):
            plain = re.sub(r"\{[^{}]*\}", "{…}", one)
            if is_text(plain) and one.strip('"')[:60] not in keys:
                yield name, " ".join(plain.split())


def make(root):
    lines, last = [HEAD.rstrip("\n")], None
    for name, one in texts(root):
        if name != last:
            lines += ["", name]
        lines.append("  " + one)
        last = name
    return "\n".join(lines) + "\n"
