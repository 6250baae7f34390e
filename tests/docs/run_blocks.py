"""Runs the blocks of a page, by language."""

import importlib.util
import json
import re
import shutil
from dataclasses import dataclass, field

from compare import difference, split_console
from python_session import left_out

# Shown, and no more than that.
SHOWN = {"text", "xml", "html", "css", "javascript", "cpp", "c", "cmake", "bibtex", "toml", "make", "lua"}

# What a part of a scenario is laid beside where it has none of its own. `check` traces pings, so a small sonar.
BASE = """ensonify: 1
name: part
sonar: {frequency_hz: 9e5, bandwidth_hz: 3e4, source_level_db: 220, range_max_m: 10, elevation: {width_deg: 20},
  beams: {count: 16, fov_deg: 90, receive_width_deg: 1}, rays: {elevation: 32}}
"""


@dataclass
class Outcome:
    counts: dict = field(default_factory=dict)      # what -> how many were run
    failures: list = field(default_factory=list)    # (line, text)
    skips: list = field(default_factory=list)       # (line, reason)
    renewed: list = field(default_factory=list)     # (block, its new text)
    differences: int = 0                            # failures that the new texts settle
    printed: str | None = None                      # by the block before

    def count(self, what, number=1):
        self.counts[what] = self.counts.get(what, 0) + number


def lacking(needs):
    """Those of NAME,NAME that are neither a program here nor a module of Python, or are to be left out."""
    return [name for name in (part.strip() for part in needs.split(","))
            if name in left_out() or not shutil.which(name, path="/usr/local/bin:/usr/bin:/bin:/usr/sbin")
            and importlib.util.find_spec(name) is None]


def needs_a_place(block):
    """Whether the block is run or written in the reader's folder."""
    return "skip" not in block.directives and (
        block.language in {"sh", "console", "python", "yaml"} or "file" in block.directives)


def _sections(text):
    """[(key, text)] of a scenario's first level; what comes before the first key has key None."""
    sections = [(None, "")]
    for line in text.splitlines(keepends=True):
        key = re.match(r"([A-Za-z_]\w*):", line)
        if key:
            sections.append((key.group(1), line))
        else:
            sections[-1] = (sections[-1][0], sections[-1][1] + line)
    return sections


def merged(fragment, base):
    """The fragment with those keys of the base that it has not got."""
    own = {key for key, _ in _sections(fragment)}
    return "".join(text for key, text in _sections(base) if key not in own) + fragment


def _run(place, command, block, outcome, line):
    """What the command printed, or None where it failed."""
    status, printed = place.shell(command)
    wanted = int(block.directives.get("fails", 0))
    if status == wanted:
        return printed
    outcome.failures.append((line, f"exit status {status}, not {wanted}, of\n{command.rstrip()}\n"
                                   f"which printed\n{printed[-4000:]}"))
    return None


def run_sh(place, block, outcome):
    outcome.printed = _run(place, block.text, block, outcome, block.line)
    outcome.count("shell blocks")


def run_console(place, block, outcome):
    commands = split_console(block.text)
    if commands is None:
        outcome.failures.append((block.line, "a console block begins with `$ COMMAND`"))
        return
    lines = block.text.split("\n")[:-1]
    shift, different = 0, False
    for command, shown, first, last in commands:
        outcome.count("console commands")
        printed = _run(place, command, block, outcome, block.line + 1)
        if printed is None or not shown.strip():
            continue
        fault = difference(shown, printed, block.directives.get("varies"))
        if fault:
            different = True
            outcome.differences += 1
            outcome.failures.append((block.line + first, f"$ {command}\n{fault}"))
            fresh = printed.strip("\n").split("\n")
            lines[first + shift:last + shift] = fresh
            shift += len(fresh) - (last - first)
    if different:
        outcome.renewed.append((block, "".join(line.rstrip() + "\n" for line in lines)))


def run_output(block, outcome):
    if outcome.printed is None:
        outcome.failures.append((block.line, "output: no sh or python block before it has run"))
        return
    outcome.count("outputs")
    fault = difference(block.text, outcome.printed, block.directives.get("varies"))
    if fault:
        outcome.differences += 1
        outcome.failures.append((block.line, fault))
        outcome.renewed.append((block, outcome.printed.strip("\n") + "\n"))


def run_python(place, block, outcome, name):
    answer = place.run_python(block.text, f"{name}:{block.line}")
    outcome.count("Python blocks")
    for reason in sorted(set(answer["skipped"])):
        number = answer["skipped"].count(reason)
        outcome.skips.append((block.line, f"{number} statement{'s' * (number > 1)}: {reason}"))
    outcome.printed = answer["printed"]
    if answer["error"]:
        outcome.failures.append((block.line, answer["error"]))


def _check_yaml(place, block, outcome, command, text):
    """Through the program, from a file where the block's own would lie."""
    path = block.directives.get("file")
    temporary = path is None
    path = place.write(path or ".docs-test.yaml", text)
    status, printed = place.shell(f'{command.format(path)} >/dev/null')
    wanted = int(block.directives.get("fails", 0))
    if status != wanted:
        outcome.failures.append((block.line, f"{command.format(path.name)}: exit status {status}, "
                                             f"not {wanted}\n{printed[-2000:]}"))
    if temporary:
        path.unlink()


def run_yaml(place, block, outcome):
    if re.search(r"^ensonify_sweep:", block.text, re.M):
        outcome.count("sweeps")
        _check_yaml(place, block, outcome, 'ensonify sweep "{}" --list', block.text)
        return
    text = block.text
    if not any(line.strip() and not line.lstrip().startswith("#") for line in text.split("\n")):
        return  # comments alone
    whole = re.search(r"^ensonify:", text, re.M)
    outcome.count("scenarios" if whole else "parts of scenarios")
    if not whole:
        base = block.directives.get("base")
        text = merged(text, (place.folder() / base).read_text(encoding="utf-8") if base else BASE)
    # A file is for the blocks below as it is.
    few = "" if "file" in block.directives or "preset:" not in text else " --set sonar.beams.count=16"
    _check_yaml(place, block, outcome, f'ensonify check "{{}}"{few}', text)


def run_json(block, outcome):
    outcome.count("JSON texts")
    try:
        json.loads(block.text)
    except ValueError as error:
        try:
            json.loads("{" + block.text + "}")  # members of an object, as for a settings file
        except ValueError:
            outcome.failures.append((block.line, str(error)))


def run_csv(block, outcome):
    outcome.count("tables")
    widths = {len(line.split(",")) for line in block.text.split("\n") if line}
    if len(widths) != 1:
        outcome.failures.append((block.line, f"rows of {sorted(widths)} columns"))


def _write_file(place, block, outcome):
    path = place.write(block.directives["file"], block.text)
    if block.text.startswith("#!"):
        path.chmod(0o755)
    outcome.count("files")


def run_block(place, block, outcome, name):
    language, directives = block.language, block.directives
    if "skip" in directives:
        outcome.skips.append((block.line, directives["skip"]))
        outcome.printed = None
        return
    if "minutes" in directives and "minutes" in left_out():
        outcome.skips.append((block.line, "takes minutes"))
        outcome.printed = None
        return
    missing = lacking(directives["needs"]) if "needs" in directives else []
    if missing:
        outcome.skips.append((block.line, "not installed: " + ", ".join(missing)))
        outcome.printed = None
        return
    if "output" in directives:
        run_output(block, outcome)
    elif language == "yaml":
        run_yaml(place, block, outcome)
    elif language == "json":
        run_json(block, outcome)
    elif language == "csv":
        run_csv(block, outcome)
    elif language == "sh" and "file" not in directives:
        run_sh(place, block, outcome)
    elif language == "console":
        run_console(place, block, outcome)
    elif language == "python" and "file" not in directives:
        run_python(place, block, outcome, name)
    elif language not in SHOWN | {"sh", "python"}:
        outcome.failures.append((block.line, f"unknown language '{language}'; ```text where it is none"))
    if "file" in directives and language != "yaml":
        _write_file(place, block, outcome)
