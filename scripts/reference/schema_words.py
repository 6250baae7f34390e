"""Describes the values in a JSON Schema in the words of the reference pages."""
import re

# Members of a map that describe how a value is sampled, not what it holds.
DRAWS = {"choice", "uniform", "log_uniform", "normal"}
PATTERNS = {
    "^[0-9a-f]{64}$": "64 hexadecimal digits",
    "^[0-9a-f]{16}$": "16 hexadecimal digits",
    "^[0-9]{6,}/[0-9]{6,}$": "as `000000/000003`",
    "^\\d{4}-\\d\\d-\\d\\dT\\d\\d:\\d\\d:\\d\\dZ$": "as `2024-01-31T12:00:00Z`",
    "\\{ping\\}": "with `{ping}`",
    "^[A-Za-z0-9][A-Za-z0-9_-]*$": "letters, digits, `_` and `-`",
    "^[A-Za-z0-9_-][A-Za-z0-9._-]{0,63}$": "1 to 64 letters, digits, `-`, `_` and `.`",
}
# Patterns of text that refers to a variable, in place of any other value.
VARIABLES = {r"^\$[A-Za-z]", r"^=|^\$[A-Za-z]"}
NAMES = {"number": "number", "integer": "integer", "boolean": "true or false", "string": "text", "null": "null",
         "array": "list of numbers"}    # next to a number
RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def meant(whole, use):
    """`use` merged over the definitions to which it refers, and the names of these definitions."""
    if "$ref" in use:
        name = use["$ref"].rsplit("/", 1)[-1]
        under, names = meant(whole, whole["definitions"][name])
        return under, [name, *names]
    parts = use.get("allOf", [])
    if len(parts) == 1 and "$ref" in parts[0]:
        under, names = meant(whole, parts[0])
        return {**under, **{key: value for key, value in use.items() if key != "allOf"}}, names
    return use, []


def number(value):
    """A limit as text: 2⁶⁴ − 1 and powers of ten as powers, thousands separated by commas."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    if value == 2**64 - 1:
        return "2⁶⁴ − 1"
    size = abs(value)
    sign = "−" if value < 0 else ""
    if size >= 1e6 or 0 < size < 1e-3:
        mantissa, exponent = f"{size:e}".split("e")
        power = "10" + str(int(exponent)).translate(RAISED)
        if float(mantissa) == 1:
            return sign + power
    return sign + (f"{size:,}" if isinstance(value, int) else f"{size:g}")


def limits(use):
    low, above, high = use.get("minimum"), use.get("exclusiveMinimum"), use.get("maximum")
    if above is not None:
        return f"> {number(above)}" + (f", at most {number(high)}" if high is not None else "")
    if low is not None and high is not None:
        return f"{number(low)} to {number(high)}"
    if low is not None:
        return f"≥ {number(low)}"
    return f"at most {number(high)}" if high is not None else ""


def words(values):
    return ", ".join(f"`{'null' if value is None else value}`" for value in values)


def drawn_only(use):
    """Whether an object is accepted only to sample a value of another type."""
    return set(use.get("properties", {})) <= DRAWS and use.get("additionalProperties") is False


def own_keys(node):
    """The keys of a map, without those that only sample it."""
    hidden = DRAWS if drawn_only(node) else {"choice"}
    return {key: use for key, use in node.get("properties", {}).items() if isinstance(use, dict) and key not in hidden}


class Said:
    """The description of a value: its type, what is accepted, and the schema of its map or of the map that it holds."""

    def __init__(self, kind, accepted="", names=(), inner=None, step=""):
        self.kind, self.accepted, self.names = kind, accepted, list(names)
        self.inner, self.step = inner, step    # step: "", "[]" for items, ".NAME" for free names


def of_text(use):
    if "pattern" in use:
        return PATTERNS[use["pattern"]]
    if "maxLength" in use:
        return f"{use['minLength']} to {number(use['maxLength'])} bytes"
    return ""


def several(item):
    return "values" if " or " in item.kind and item.inner is None else item.kind + "s"


def of_map(whole, use, names, also):
    free = use.get("additionalProperties")
    if isinstance(free, dict):
        item = describe(whole, free)
        return Said(f"map of names to {several(item)}{also}", "", [*names, *item.names], item.inner,
                    ".NAME" + item.step if item.inner is not None else "")
    if free is True:
        return Said("map of names to values" + also, "", names)
    if not own_keys(use) and free is False:
        return Said("map" + also, "`{}`", names)
    return Said("map" + also, "", names, whole["definitions"][names[-1]] if names else use)


def of_list(whole, use, names):
    item = describe(whole, use.get("items", {}))
    least, most = use.get("minItems"), use.get("maxItems")
    plural = several(item)
    if item.kind[0].isdigit():
        plural = f"lists of {item.kind}"
    elif item.kind.startswith("list of"):
        plural = item.kind.replace("list", "lists", 1)
    kind = f"{least} {plural}" if least is not None and least == most and least > 0 else f"list of {plural}"
    accepted = item.accepted if not item.accepted or item.accepted.startswith("each") else f"each {item.accepted}"
    counts = {(1, None): "at least one", (2, None): "at least two"}.get((least, most), "")
    if most is not None and least is None:
        counts = f"at most {number(most)}" if most else "none"
    accepted = "; ".join(part for part in (counts, accepted) if part)
    return Said(kind, accepted, [*names, *item.names], item.inner, "[]" + item.step if item.inner else "")


def of_alternatives(whole, use, names):
    """A word or a map, true or false or a map, a number or a map."""
    kinds, accepted, all_names, inner = [], [], list(names), None
    for part in use["anyOf"]:
        if part.get("$ref", "").endswith("/sampled_word") or part.get("enum") == ["on", "off"]:
            continue
        said = describe(whole, part)
        all_names += said.names
        if said.accepted == "`{}`":    # a map without options
            continue
        kinds.append(said.kind)
        accepted += [said.accepted] if said.accepted else []
        inner = inner if said.inner is None else said.inner
    if {"enum": ["on", "off"]} in use["anyOf"]:
        kinds[0] = "switch"
    return Said(" or ".join(dict.fromkeys(kinds)), ", ".join(accepted), all_names, inner)


def describe(whole, use):
    """The description of a value by its schema."""
    use, names = meant(whole, use)
    if "anyOf" in use and "properties" not in use:
        return of_alternatives(whole, use, names)
    if "const" in use:
        return Said("text" if isinstance(use["const"], str) else "integer", words([use["const"]]), names)
    if "enum" in use:
        return Said("word", words(use["enum"]), names)
    kinds = use.get("type", "object")
    kinds = [kinds] if isinstance(kinds, str) else list(kinds)
    if use.get("pattern") in VARIABLES:
        kinds.remove("string")
    if len(kinds) > 1 and kinds[1] == "object" and drawn_only(use):
        kinds.pop()
    also = "" if "null" not in kinds or kinds == ["null"] else " or null"
    kinds = [kind for kind in kinds if kind != "null" or len(kinds) == 1]
    if len(kinds) > 1:
        return Said(" or ".join(NAMES[kind] for kind in kinds) + also, "", names)
    if kinds[0] == "array":
        said = of_list(whole, use, names)
        said.kind += also
        return said
    if kinds[0] == "object":
        return of_map(whole, use, names, also)
    accepted = of_text(use) if kinds[0] == "string" else limits(use)
    return Said(NAMES[kinds[0]] + also, accepted, names)


def slug(heading):
    """The anchor of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


# First words of descriptions that keep their capital letter.
PROPER = {"Francois", "Frictionless", "Slurm", "Python"}


def without_unit(text, unit):
    """A description without the unit, which has its own column."""
    for name in [unit, {"°": "degrees", "px": "pixels"}.get(unit, unit)] if unit else []:
        at = f"(?:{re.escape(name)}|{re.escape(name.capitalize() if len(name) > 4 else name)})"
        text = re.sub(rf"^{at}(?:, |; |: |\.$)", "", text)
        text = re.sub(rf", {at}(?=[.,;:]|$)", "", text)
    return text


def code(text):
    """A description with keys, files and maps marked as code."""
    return re.sub(r"(`[^`]*`)|(\{(?:[^{}]|\{[^{}]*\})*\}|\b(?!\w_\w\b)\w+(?:[._]\w*[a-z]\w*)+\b)",
                  lambda found: found[1] or f"`{found[2]}`", text)


def meaning(title, text, unit=""):
    """The text of the last column: title and description as one phrase."""
    text = without_unit(text, unit).strip()
    first = re.match(r"[A-Z][a-z]*\b(?!_)", text)
    if first and (len(first[0]) > 1 or first[0] == "A") and first[0] not in PROPER:
        text = text[0].lower() + text[1:]
    return code(f"{title} – {text}" if text.strip(".") else f"{title}.")


def cell(text):
    return text.replace("|", "\\|").replace("\n", " ").strip() or "–"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(cell, row)) + " |" for row in rows]) + "\n"
