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


def _is_close(shown, printed):
    """Whether two numbers differ by no more than another class of processor makes them: by two units
    of the last place or a hundredth. Whole numbers below a thousand must be equal."""
    if shown == printed:  # also what only looks like a number, such as 0594e336 in an identifier
        return True
    first, second = (float(text.replace(",", "")) for text in (shown, printed))
    if "." not in shown and abs(first) < 1000:
        return first == second
    place = 10.0 ** -len(shown.split(".")[1]) if re.fullmatch(r"[^eE]*\.\d+", shown) else 0
    return abs(first - second) <= max(2.001 * place, 0.01 * abs(first))


def _pattern(line, varies):
    """The line as a regular expression with a group for each number that must be close, and these."""
    if varies is not None:
        line = (ANY_NUMBER if varies == "numbers" else MEASURED).sub("#", line)
    numbers = ANY_NUMBER.findall(line)
    parts = (".*?".join(map(re.escape, part.split("…"))) for part in ANY_NUMBER.split(line))
    return f"({NUMBER})".join(parts) + r"\n", numbers


def _one_blank(line):
    return re.sub(r"\s+", " ", line)  # columns move with the width of their numbers


def difference(shown, printed, varies=None):
    """None where they agree, else a unified difference.

    In what is shown `…` stands for any text within a line, and alone on a line for any lines. With
    varies "" numbers with a unit of time, size or speed may differ, with "numbers" all of them. The
    others must be close."""
    shown, printed = _lines(shown), _lines(printed)
    pattern, numbers = "", []
    for line in shown:
        if line.strip() == "…":
            pattern += r"(?:.*\n)*?"
            continue
        expression, more = _pattern(_one_blank(line), varies)
        pattern += expression
        numbers += more
    text = "".join(_one_blank(line) + "\n" for line in printed)
    if varies is not None:
        text = (ANY_NUMBER if varies == "numbers" else MEASURED).sub("#", text)
    match = re.fullmatch(pattern, text)
    if match and all(map(_is_close, numbers, match.groups())):
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
