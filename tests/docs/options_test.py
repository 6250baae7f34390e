"""The documentation names no command or option that the program has not got, and docs/command_line.md
leaves none out."""

import os
import re
import sys
import unittest

from pages import ROOT, all_pages, parse

sys.path.append(str(ROOT / "tests/install"))
from help_text import commands, help_of  # noqa: E402

PROGRAM = os.environ["ENSONIFY"]
REFERENCE = "docs/command_line.md"
OPTION = re.compile(r"(?<![\w-])--[a-z][\w-]*")
# `ensonify COMMAND ...` up to what ends it in a shell; a line goes on behind a backslash.
CALL = re.compile(r"(?:^|[\s`/\"$(])ensonify[ \t]+(?:\\\n[ \t]*)?([a-z]\w*)((?:\\\n|[^\n|;&)])*)")


def own_options(text):
    """Options that a help text begins a line with, in their long form."""
    heads = re.findall(r"^  (?:-\w,)?(--[a-z][\w-]*)", text, re.M)
    return set(heads) | {"--help"}


def unknown(text, known):
    """What is called in a piece of documentation and is not known: command -> its options."""
    faults = []
    for command, rest in CALL.findall(text):
        if command not in known:
            faults.append(f"ensonify {command}")
            continue
        rest = re.sub(r"\s#.*", "", rest)
        faults += [f"ensonify {command} {option}" for option in OPTION.findall(rest)
                   if option not in known[command]]
    return faults


class Options(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.known = {command: own_options(help_of(PROGRAM, command)) for command in commands(PROGRAM)}

    def test_what_is_named_is_there(self):
        faults = []
        for name in all_pages() + ["CHANGELOG.md"]:
            page = parse(name)
            texts = [(block.line, block.text) for block in page.blocks
                     if block.language in ("sh", "console")
                     or block.language == "text" and re.match(r"[\w/]*ensonify [a-z]+ ", block.text)]
            faults += [f"{name}:{line}: {fault}" for line, text in texts + page.spans
                       for fault in unknown(text, self.known)]
        self.assertEqual(faults, [])

    def test_what_is_there_is_named(self):
        page = parse(REFERENCE)
        shown = {}
        for block in page.blocks:
            call = re.match(r"\$ ensonify (?:(\w+) )?--help\n", block.text)
            if call:
                shown[call.group(1) or ""] = own_options(block.text)
        missing = [f"ensonify {command}" for command in self.known if command not in shown]
        missing += [f"ensonify {command} {option}" for command, options in self.known.items()
                    for option in sorted(options - shown.get(command, options))]
        self.assertEqual(missing, [])
        self.assertIn("", shown)

    def test_that_faults_are_found(self):
        known = {"generate": {"--output", "--pings"}, "check": {"--set"}}
        good = ["ensonify generate a.yaml --pings 0:1 | parallel --jobs 2", "ensonify check",
                "build/release/ensonify generate a \\\n   --pings 0:1", "ensonify 0.1.0", "ensonify: what"]
        self.assertEqual([unknown(text, known) for text in good], [[]] * len(good))
        bad = {"ensonify chek a": "ensonify chek", "ensonify check a --pings": "ensonify check --pings",
               "ensonify generate a \\\n  --frames 2": "ensonify generate --frames",
               "seq 7 | parallel \\\n  ensonify generate --seeds": "ensonify generate --seeds"}
        for text, fault in bad.items():
            self.assertEqual(unknown(text, known), [fault])


if __name__ == "__main__":
    unittest.main()
