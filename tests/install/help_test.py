"""The man page and the completions of the installed program hold every command, option and choice of its help.

BUILD is the build's folder, CMAKE the program. Run by ctest; by hand:
    python3 -m unittest help_test    (build/release)
"""
import gzip
import re
import shutil
import unittest

from help_text import commands, entries
from installed import Installed, run

# Words that bash offers for COMP_WORDS, as its own completion sets it; "" for the word at the cursor.
COMPLETE = r"""
source "$1"
while IFS=$'\t' read -r -a COMP_WORDS; do
  COMP_WORDS=("${COMP_WORDS[@]/#@/}")
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  COMPREPLY=()
  _ensonify
  echo "${COMPREPLY[*]}"
done
"""


class Help(Installed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.commands = commands(cls.program)
        cls.entries = {name: entries(cls.program, *name.split()) for name in ["", *cls.commands]}

    def test_help_is_read(self):
        self.assertIn("generate", self.commands)
        found = {name: entry for entry in self.entries["generate"] for name in entry.names}
        self.assertEqual(found["--simd"].choices, ["auto", "sse4", "avx2", "avx512"])
        self.assertTrue(found["-o"].takes_value)
        self.assertFalse(found["--quiet"].takes_value)
        self.assertIn("SCENARIO", found)

    def test_man_page(self):
        packed = (self.prefix / "share/man/man1/ensonify.1.gz").read_bytes()
        page = gzip.decompress(packed).decode().replace("\\-", "-")
        program, *parts = re.split(r'^\.SS "ensonify (\w+)"$', page, flags=re.M)
        sections = {"": program, **dict(zip(parts[::2], parts[1::2]))}
        self.assertEqual(sorted(sections), sorted(self.entries))
        for command, section in sections.items():
            listed = re.findall(r"^\.TP\n(.*)\n(.+)", section, re.M)
            heads = {tuple(re.findall(r"\\fB(.*?)\\fR", head)): head for head, _ in listed}
            for entry in self.entries[command]:
                head = heads.get(tuple(entry.names), "")
                self.assertTrue(head, f"{command}: {entry.names}")
                self.assertTrue(all(choice in head for choice in entry.choices), head)

    @unittest.skipUnless(shutil.which("man"), "needs man")
    def test_man_reads_its_page(self):
        done = run("man", "--warnings", "-l", self.prefix / "share/man/man1/ensonify.1.gz",
                   env={**self.environment, "MANWIDTH": "100", "LC_ALL": "C.UTF-8"})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("--export-scatterers", done.stdout)

    def completed(self, lines):
        """What bash offers for each list of words."""
        asked = "".join("\t".join("@" + word for word in words) + "\n" for words in lines)
        done = run("bash", "-euc", COMPLETE, "bash", self.prefix / "share/bash-completion/completions/ensonify",
                   input=asked)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return [line.split() for line in done.stdout.splitlines()]

    def test_bash(self):
        asked = [(["ensonify", ""], self.commands)]
        for command, found in self.entries.items():
            before = ["ensonify", *command.split()]
            options = [entry for entry in found if entry.names[0].startswith("-")]
            asked.append(([*before, "-"], [name for entry in options for name in entry.names]))
            if command:
                first = next((entry for entry in found if entry not in options), None)
                asked.append(([*before, ""], first.choices if first else []))
            for entry in options:
                for name in entry.names if entry.takes_value and entry.names != ["--set"] else []:
                    asked.append(([*before, name, ""], entry.choices))
                    asked.append(([*before, name, "="], entry.choices))
                    asked.append(([*before, name, "=", ""], entry.choices))
        for (words, expected), offered in zip(asked, self.completed(words for words, _ in asked), strict=True):
            self.assertEqual(sorted(offered), sorted(expected), words)

    def test_bash_offers_the_keys_of_a_scenario(self):
        offered, some = self.completed([["ensonify", "generate", "--set", ""], ["ensonify", "sweep", "--set", "water.a"]])
        self.assertGreater(len(offered), 60)
        self.assertTrue(all(word.endswith("=") for word in offered), offered)
        self.assertIn("sonar.beams.receive_width_deg=", offered)
        self.assertEqual(some, [word for word in offered if word.startswith("water.absorption.")])

    def holds(self, text, entry, forms, where):
        for name in entry.names:
            self.assertRegex(text, forms(name), f"{where} {name}")
        if entry.choices:
            self.assertIn(" ".join(entry.choices), text, f"{where} {entry.names}")

    def test_zsh(self):
        text = (self.prefix / "share/zsh/vendor-completions/_ensonify").read_text(encoding="utf-8")
        program, *parts = re.split(r"^    (\w+)\)$", text, flags=re.M)
        sections = {"": program, **dict(zip(parts[::2], parts[1::2]))}
        self.assertEqual(sorted(sections), sorted(self.entries))
        for command, section in sections.items():
            for entry in self.entries[command]:
                self.holds(section, entry, lambda name: rf"[\s*{{,:]{name}[\s'}},:=]", command)

    def test_fish(self):
        lines = (self.prefix / "share/fish/vendor_completions.d/ensonify.fish").read_text("utf-8").splitlines()
        for command, found in self.entries.items():
            condition = f"'__fish_seen_subcommand_from {command}'" if command else "'not __fish_seen"
            own = "\n".join(line for line in lines if condition in line)
            for entry in found:
                if entry.names[0].startswith("-"):
                    self.holds(own, entry, lambda name: rf" -[ls] {name.lstrip('-')} ", command)
                for choice in entry.choices:
                    self.assertRegex(own, rf"-a .*\b{choice}\b")

    def test_shells_accept_their_files(self):
        for shell, file in (("zsh", "share/zsh/vendor-completions/_ensonify"),
                            ("fish", "share/fish/vendor_completions.d/ensonify.fish")):
            if shutil.which(shell):
                done = run(shell, "-n", self.prefix / file)
                self.assertEqual((done.returncode, done.stderr), (0, ""), shell)


if __name__ == "__main__":
    unittest.main()
