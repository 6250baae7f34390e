"""No text uses a word that docs/glossary.md replaces: messages, help, schemas, pages and comments.

Run by ctest; by hand, in this folder:
    python3 -m unittest words_test
"""
import json
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

SOURCES = (".h", ".cpp", ".cu", ".py", ".sh")


def replaced_words(text=None):
    """The words in the column "not" of the glossary."""
    text = text or (ROOT / "docs/glossary.md").read_text()
    rows = re.findall(r"^\|[^|]+\|([^|]+)\|$", text.split("| write | not |")[1], re.MULTILINE)
    return [word for row in rows for word in re.findall("`([^`]+)`", row)]


def pattern(words):
    return re.compile(r"(?<![\w`.])(" + "|".join(re.escape(word).replace(r"\ ", r"\s+") for word in words) + r")(?![\w`])",
                      re.IGNORECASE)


def prose(page):
    """A page without its code and the targets of its links."""
    text = re.sub(r"```.*?```|<!--.*?-->", lambda block: "\n" * block[0].count("\n"), page, flags=re.DOTALL)
    return re.sub(r"`[^`\n]*`|\]\([^)]*\)", "``", text)


def comments(path):
    text = path.read_text()
    if path.suffix in (".py", ".sh"):
        return "\n".join(re.findall(r"(?<!\S)#[^\n]*|\"\"\"(?:.|\n)*?\"\"\"", text))
    return re.sub(r"\n\s*//", " ", "\n".join(re.findall(r"//[^\n]*", text)))


def messages(path):
    """The string literals of a source that have three words or more."""
    joined = re.sub(r'"\s*\n\s*"', "", path.read_text())
    return "\n".join(one for one in re.findall(r'"((?:[^"\\\n]|\\.)*)"', joined) if len(one.split()) >= 3)


def descriptions(node):
    if isinstance(node, dict):
        for key in ("title", "description"):
            if isinstance(node.get(key), str):
                yield node[key]
    for value in node.values() if isinstance(node, dict) else node if isinstance(node, list) else ():
        yield from descriptions(value)


def texts():
    """(place, text) of all that people read, quotations in backticks apart."""
    for path in [*ROOT.glob("*.md"), *sorted((ROOT / "docs").rglob("*.md"))]:
        if path.name != "glossary.md":
            yield path.relative_to(ROOT).as_posix(), prose(path.read_text())
    for path in sorted((ROOT / "output_schema").glob("*.json")):
        for text in descriptions(json.loads(path.read_text())):
            yield path.name, text
    for folder in ("generator", "scripts"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in SOURCES:
                yield path.relative_to(ROOT).as_posix(), comments(path)
            if path.suffix in (".h", ".cpp", ".cu"):
                yield path.relative_to(ROOT).as_posix(), re.sub("`[^`]*`", "", messages(path))


class Words(unittest.TestCase):
    def test_no_text_has_a_word_that_the_glossary_replaces(self):
        wrong, known = [], pattern(replaced_words())
        for place, text in texts():
            for found in known.finditer(text):
                around = " ".join(text[max(0, found.start() - 40):found.end() + 40].split())
                wrong.append(f"{place}: {found[1]!r} in: {around}")
        self.assertEqual(wrong, [], "docs/glossary.md has the words to write instead")

    def test_it_can_find_them(self):
        words = replaced_words("| write | not |\n|---|---|\n| image | `grey picture`, `grey pictures` |\n")
        self.assertEqual(words, ["grey picture", "grey pictures"])
        self.assertTrue(pattern(words).search("A Grey\npicture."))
        self.assertFalse(pattern(words).search("A grey pictureless `grey picture`."))
        self.assertNotIn("centre", prose("The [x](centre.md) of `centre`."))
        self.assertGreater(len(replaced_words()), 40)
        self.assertGreater(len({place for place, _ in texts()}), 300)


if __name__ == "__main__":
    unittest.main()
