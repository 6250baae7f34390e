"""The table of sonar presets, from configs/sonars/*.yaml."""
import re

from .schema_words import table

HEAD = ("preset", "instrument", "f, kHz", "b, kHz", "source level, dB re 1 µPa·m", "range, m", "beams", "fan, °",
        "beam width, °", "rays in elevation")


def value(text):
    return float(text) if re.fullmatch(r"-?[0-9.]+(e-?[0-9]+)?", text) else text


def read(path):
    """A preset: `key: value` and `key: {key: value, ...}`, which is all that presets hold."""
    found, comment = {}, []
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            comment.append(line[1:].strip())
            continue
        match = re.fullmatch(r"(\w+): (?:\{(.*)\}|(\S+))", line)
        if not match:
            raise ValueError(f"{path}: not understood: {line}")
        key, inner, plain = match.groups()
        pairs = [part.split(": ") for part in inner.split(", ")] if inner else []
        found[key] = {k: value(v) for k, v in pairs} if inner else value(plain)
    # The comment's first sentence, without titles of papers and what stands behind a colon.
    found["instrument"] = re.split(r"\. (?=[A-Z])|: |, \"", " ".join(comment))[0]
    return found


def row(path):
    sonar = read(path)
    beams, elevation = sonar["beams"], sonar["elevation"]
    return (f"`{path.stem}`", sonar["instrument"], f"{sonar['frequency_hz'] / 1e3:g}",
            f"{sonar['bandwidth_hz'] / 1e3:g}", f"{sonar['source_level_db']:g}",
            f"{sonar['range_min_m']:g} to {sonar['range_max_m']:g}", f"{beams['count']:g}",
            f"{beams['fov_deg']:g} × {elevation['width_deg']:g}", f"{beams['receive_width_deg']:g}",
            f"{sonar['rays']['elevation']:g}")


def section(root):
    paths = sorted((root / "configs/sonars").glob("*.yaml"))
    return ("## Presets\n\n`sonar.preset` stands for these keys; `ensonify presets NAME` prints one, and which of its "
            "numbers are public and which are assumed. All have the pulse `gaussian`.\n\n"
            + table(HEAD, [row(path) for path in paths]))
