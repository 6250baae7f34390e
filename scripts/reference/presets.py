"""The tables and sources of sonar presets in docs/sonars.md, from configs/sonars/*.yaml."""
import re

from .schema_words import table

NUMBERS = ("preset", "f, kHz", "pulse", "range, m", "source level, dB", "beams", "field of view, °", "beam width, °",
           "shading", "vertical width, °", "fan of rays, °", "rays")
KINDS = ("Data sheet", "Recording", "Assumed")
# A paragraph that names the keys of one kind, and in parentheses the recording.
NAMED = re.compile(rf"({'|'.join(KINDS)})(?: \((.+)\))?: ((?:[a-z]\w*(?:\.\w+|\[\d+\])*(?:, |\.$))+)")
BANDWIDTHS = ("preset", "bandwidth, kHz, by range setting (range bin)")
SOUND_SPEED_M_S = 1500
# A paragraph that at least this many presets have is printed once.
COMMON = 5
MARK = "<!-- made by scripts/make_reference.py: {} -->\n"
END = "<!-- end of what is made -->"


def value(text):
    """A plain value, a flow map or a flow list: presets hold no other values."""
    if text.startswith("["):
        return [value(inner) for inner in parts(text[1:-1])]
    if text.startswith("{"):
        return {key: value(inner) for key, inner in (part.split(": ", 1) for part in parts(text[1:-1]))}
    return float(text) if re.fullmatch(r"-?[0-9.]+(e-?[0-9]+)?", text) else text


def parts(text):
    """The entries of a flow map or list: split at commas outside inner ones."""
    depth, found = 0, [""]
    for letter in text:
        depth += {"{": 1, "[": 1, "}": -1, "]": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            found.append("")
        else:
            found[-1] += letter
    return [part.strip() for part in found]


def paragraphs(lines):
    """The paragraphs of a head. One begins with a capital letter after a line that ends with a full stop."""
    found = []
    for line in lines:
        if found and not (found[-1].endswith(".") and line[:1].isupper()):
            found[-1] += " " + line
        else:
            found.append(line)
    return found


def read(path):
    """(values, paragraphs of the head) of a preset: `key: value`, and lists of flow maps, one per line. Lines of numbers
    continue a value."""
    found, comment = {}, []
    for line in re.sub(r"\n  (?=-?[0-9])", " ", path.read_text()).splitlines():
        item = re.fullmatch(r"  - (\{.*\})", line)
        match = re.fullmatch(r"(\w+):(?: (\S.*))?", line)
        if line.startswith("#"):
            comment.append(re.sub(r"(?<!\S)-(?=\d)", "−", line[1:].strip()))
        elif item:
            found[key].append(value(item[1]))
        elif match:
            key = match[1]
            found[key] = value(match[2]) if match[2] else []
        else:
            raise ValueError(f"{path}: not understood: {line}")
    return found, paragraphs(comment)


def keys(entry, path=""):
    """The dotted paths of all plain values, lists of numbers as one."""
    if isinstance(entry, dict):
        return [found for key, inner in entry.items() for found in keys(inner, f"{path}.{key}".lstrip("."))]
    if isinstance(entry, list) and isinstance(entry[0], dict):
        return [found for i, inner in enumerate(entry) for found in keys(inner, f"{path}[{i}]")]
    return [path]


def named(head):
    """{kind: (recording or None, names)} of the paragraphs that name keys."""
    found = (NAMED.fullmatch(paragraph) for paragraph in head)
    return {match[1]: (match[2], match[3].rstrip(".").split(", ")) for match in found if match}


def covers(name, key):
    return key == name or key.startswith((f"{name}.", f"{name}["))


def kinds_of(key, kinds):
    """Every kind with the longest name that covers a key: that of the key or of a map or list that holds it."""
    names = [(len(name), kind) for kind, (_, listed) in kinds.items() for name in listed if covers(name, key)]
    return [kind for length, kind in names if length == max(names)[0]]


def provenance(name, head):
    """The row of the table of kinds."""
    kinds = named(head)
    cells = []
    for kind in KINDS:
        source, names = kinds.get(kind, (None, []))
        cells.append((f"{source}: " if source else "") + ", ".join(f"`{key}`" for key in names) or "–")
    return f"`{name}`", *cells


def pulse(kind):
    """`gaussian`, or a chirp with its duration and taper."""
    if isinstance(kind, str):
        return kind
    return f"lfm, {kind['lfm']['duration_s'] * 1e3:g} ms, taper {kind['lfm']['taper']:g}"


def shading(kind):
    """`uniform`, or a kind of shading and its side lobes."""
    if isinstance(kind, str):
        return kind
    (name, keys), = kind.items()
    return f"{name}, {keys['side_lobe_db']:g} dB".replace("-", "−")


def field_of_view(beams):
    """Degrees from outer edge to outer edge; beams end halfway between their azimuths."""
    azimuths = beams.pop("azimuths_deg", None)
    if azimuths is None:
        return f"{beams.pop('fov_deg'):g}"
    outer = (azimuths[1] - azimuths[0] + azimuths[-1] - azimuths[-2]) / 2
    return f"{azimuths[-1] - azimuths[0] + outer:.1f}, unequal"


def numbers(name, sonar):
    """The row of the table of numbers. Removes the keys that it shows from `sonar`."""
    beams, elevation, rays = sonar["beams"], sonar["elevation"], sonar["rays"]
    width = elevation.pop("width_deg")
    return (f"`{name}`", f"{sonar.pop('frequency_hz') / 1e3:g}", pulse(sonar.pop("pulse")),
            f"{sonar.pop('range_min_m'):g} to {sonar.pop('range_max_m'):g}", f"{sonar.pop('source_level_db'):g}",
            f"{beams.pop('count'):g}", field_of_view(beams), f"{beams.pop('receive_width_deg'):g}",
            shading(beams.pop("shading", "uniform")), f"{width:g}, {shading(elevation.pop('shading', 'uniform'))}",
            f"{elevation.pop('fan_deg', width):g}", f"{rays.pop('elevation'):g} × {rays.pop('azimuth'):g}")


def bandwidths(name, sonar):
    """The row of the table of bandwidths. Removes the keys that it shows from `sonar`."""
    plain = sonar.pop("bandwidth_hz")
    settings = [(row["bandwidth_hz"], f" up to {row['up_to_m']:g} m") for row in sonar.pop("by_range_max_m", [])]
    return f"`{name}`", ", ".join(f"{hertz / 1e3:g}{where} ({SOUND_SPEED_M_S / (2 * hertz) * 1e3:.3g} mm)"
                                  for hertz, where in settings or [(plain, "")])


def written(entry):
    """A value as YAML."""
    if isinstance(entry, dict):
        return "{" + ", ".join(f"{key}: {written(inner)}" for key, inner in entry.items()) + "}"
    if isinstance(entry, list):
        return "[" + ", ".join(written(inner) for inner in entry) + "]"
    return entry if isinstance(entry, str) else f"{entry:.10g}"


def sources(heads, others):
    """The heads of all presets, with common paragraphs once, and the keys that no table shows."""
    every = [paragraph for head in heads.values() for paragraph in head[1:]]
    common = [text for text in dict.fromkeys(every) if every.count(text) >= COMMON]
    lines = []
    for text in common:
        with_it = [name for name, head in heads.items() if text in head]
        without = [name for name in heads if name not in with_it]
        whose = (f"all but {', '.join(f'`{name}`' for name in without)}" if len(without) < len(with_it)
                 else ", ".join(f"`{name}`" for name in with_it))
        lines.append(f"- {text} *({whose})*\n")
    for name, head in heads.items():
        lines.append(f"\n### {name}\n\n{head[0]}\n")
        own = [f"- {text}\n" for text in head[1:] if text not in common]
        own += [f"- Other keys: {others[name]}.\n"] if others[name] else []
        lines += ["\n", *own] if own else []
    return "".join(lines)


def made_parts(root):
    """The generated parts of docs/sonars.md, by name."""
    heads, others, rows, bands, sources_of = {}, {}, [], [], []
    for path in sorted((root / "configs/sonars").glob("*.yaml")):
        sonar, head = read(path)
        heads[path.stem] = [paragraph for paragraph in head if not NAMED.fullmatch(paragraph)]
        sources_of.append(provenance(path.stem, head))
        rows.append(numbers(path.stem, sonar))
        bands.append(bandwidths(path.stem, sonar))
        others[path.stem] = ", ".join(f"`{key}: {written(entry)}`" for key, entry in sonar.items() if entry)
    return {"numbers": table(NUMBERS, rows), "bandwidths": table(BANDWIDTHS, bands),
            "kinds": table(("preset", *(kind.lower() for kind in KINDS)), sources_of), "sources": sources(heads, others)}


def make(root):
    """docs/sonars.md with the parts between marks generated again."""
    text = (root / "docs/sonars.md").read_text()
    for name, made in made_parts(root).items():
        before, start, after = text.partition(MARK.format(name))
        _, end, after = after.partition(END)
        if not start or not end:
            raise ValueError(f"docs/sonars.md: no part {name!r} between marks")
        text = f"{before}{start}\n{made}\n{end}{after}"
    return text
