"""What the help of a program says, read from the text that it prints: the measure of the man page and the
completions, which the program makes from the parser's tables.

    commands   names of all commands
    entries    name of an option or positional -> Entry
"""
import re
import subprocess
from typing import NamedTuple


class Entry(NamedTuple):
    names: list  # ["-o", "--output"]
    takes_value: bool
    choices: list


HEAD = re.compile(r"^  ((?:-\w,)?--[a-z][\w-]*|-\w)(?: ([A-Z]+)(\S*))?")
POSITIONAL = re.compile(r"^  ([A-Z]+) ([A-Z]+)(\S*)")


def help_of(program, *command):
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True,
                          encoding="utf-8").stdout


def commands(program):
    listed = help_of(program).partition("Subcommands:\n")[2]
    return re.findall(r"^  (\w+) ", listed, re.M)


def _choices(type_tail):
    inside = re.search(r":\{(.*)\}", type_tail or "")
    return inside.group(1).split(",") if inside else []


def entries(program, *command):
    text = help_of(program, *command).partition("Subcommands:\n")[0]
    found = []
    for line in text.splitlines():
        if head := HEAD.match(line):
            found.append(Entry(head.group(1).split(","), bool(head.group(2)), _choices(head.group(3))))
        elif head := POSITIONAL.match(line):
            found.append(Entry([head.group(1)], True, _choices(head.group(3))))
    return found
