"""The table of sonar presets, from configs/sonars/*.yaml."""
import re

from .schema_words import table

HEAD = ("preset", "instrument", "f, kHz", "b, kHz", "source level, dB re 1 µPa·m", "range, m", "beams", "fan, °",
        "beam width, °", "rays in elevation")


def value(text):
    """A plain value or a flow map, which is all that presets hold behind a key."""
    if text.startswith("{"):
        return {key: value(inner) for key, inner in (part.split(": ", 1) for part in parts(text[1:-1]))}
    return float(text) if re.fullmatch(r"-?[0-9.]+(e-?[0-9]+)?", text) else text


def parts(text):
    """The entries of a flow map: split at commas outside inner braces."""
    depth, found = 0, [""]
    for letter in text:
        depth += {"{": 1, "}": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            found.append("")
        else:
            found[-1] += letter
    return [part.strip() for part in found]


def read(path):
    """A preset: `key: value`, and lists of flow maps, one a line."""
    found, comment = {}, []
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            comment.append(line[1:].strip())
            continue
        item = re.fullmatch(r"  - (\{.*\})", line)
        match = re.fullmatch(r"(\w+):(?: (\S.*))?", line)
        if item:
            found[key].append(value(item[1]))
        elif match:
            key = match[1]
            found[key] = value(match[2]) if match[2] else []
        else:
            raise ValueError(f"{path}: not understood: {line}")
    # The comment's first sentence, without titles of papers and what stands behind a colon.
    found["instrument"] = re.split(r"\. (?=[A-Z])|: |, \"", " ".join(comment))[0]
    return found


def bandwidth(sonar):
    """In kHz, with the range up to which it holds where it depends on the range."""
    rows = sonar.get("by_range_max_m")
    if not rows:
        return f"{sonar['bandwidth_hz'] / 1e3:g}"
    return ", ".join(f"{row['bandwidth_hz'] / 1e3:g} (≤ {row['up_to_m']:g} m)" for row in rows)


def row(path):
    sonar = read(path)
    beams, elevation = sonar["beams"], sonar["elevation"]
    return (f"`{path.stem}`", sonar["instrument"], f"{sonar['frequency_hz'] / 1e3:g}",
            bandwidth(sonar), f"{sonar['source_level_db']:g}",
            f"{sonar['range_min_m']:g} to {sonar['range_max_m']:g}", f"{beams['count']:g}",
            f"{beams['fov_deg']:g} × {elevation['width_deg']:g}", f"{beams['receive_width_deg']:g}",
            f"{sonar['rays']['elevation']:g}")


def section(root):
    paths = sorted((root / "configs/sonars").glob("*.yaml"))
    return ("## Presets\n\n`sonar.preset` stands for these keys; `ensonify presets NAME` prints one, and which of its "
            "numbers are public and which are assumed. All have the pulse `gaussian`. Where b depends on the range, "
            "`sonar.range_max_m` selects it ([scenario.md](scenario.md#sonar)).\n\n"
            + table(HEAD, [row(path) for path in paths]))
