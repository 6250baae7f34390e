"""What a page shows against what a command printed."""

import difflib
import re

# A number with a unit of time, size or speed.
NUMBER = r"[-+]?\d[\d,]*(?:\.\d+)?(?:[eE][-+]?\d+)?"
UNIT = r"(?:[kMGT]?i?B|[mµun]?s|min|h|days?|[A-Za-z ]{0,24}/s|[A-Za-z]+ (?:per|a) second)(?:/s)?"
MEASURED = re.compile(rf"{NUMBER}\s*{UNIT}(?![A-Za-z])")
ANY_NUMBER = re.compile(NUMBER)


def _lines(text):
    lines = [line.rstrip() for line in text.split("\n")]
    while lines and not lines[-1]:
        lines.pop()
    while lines and not lines[0]:
        lines.pop(0)
    return lines


def _blank_numbers(line, varies):
    if varies is None:
        return line
    line = re.sub(r"\s+", " ", line)  # columns move with the width of their numbers
    return (ANY_NUMBER if varies == "numbers" else MEASURED).sub("#", line)


def difference(shown, printed, varies=None):
    """None where they agree, else a unified difference.

    In what is shown `…` stands for any text within a line, and alone on a line for any lines. With
    varies "" numbers with a unit of time, size or speed may differ, with "numbers" all of them."""
    shown, printed = _lines(shown), _lines(printed)
    pattern = ""
    for line in shown:
        if line.strip() == "…":
            pattern += r"(?:.*\n)*?"
        else:
            parts = (re.escape(part) for part in _blank_numbers(line, varies).split("…"))
            pattern += ".*?".join(parts) + r"\n"
    text = "".join(_blank_numbers(line, varies) + "\n" for line in printed)
    if re.fullmatch(pattern, text):
        return None
    return "\n".join(difflib.unified_diff(shown, printed, "shown", "printed", lineterm=""))


def split_console(text):
    """[(command, output, index of the output's first line, of its last + 1)] of a console block.

    A command begins with `$ `; it goes on behind a backslash and with lines that begin with `> `.
    None where the block does not begin with a command."""
    commands = []
    lines = text.split("\n")[:-1]
    index = 0
    while index < len(lines):
        if not lines[index].startswith("$ "):
            return None
        command = lines[index][2:]
        index += 1
        while index < len(lines) and (command.endswith("\\") or lines[index].startswith("> ")):
            line = lines[index]
            command += "\n" + (line[2:] if line.startswith("> ") else line)
            index += 1
        first = index
        while index < len(lines) and not lines[index].startswith("$ "):
            index += 1
        commands.append((command, "\n".join(lines[first:index]), first, index))
    return commands
