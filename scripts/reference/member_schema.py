"""output_schema/NAME.schema.json: the structure that the program prints, with the texts of
output_schema/NAME_members.json.

The program lists which members the file has, their types and words, and which are always there. The texts
give each member by its path a title, a description, a unit if the name does not end with it, and rules that the
program does not know. "#NAME" in place of a text: the member is described once, under the paths `#NAME`, here or in
sequence_members.json, as are the `members` of a map that may be null. `as`: its members have the texts of those of
another path, unless they have their own.
"""
import json

UNITS = {"_m_s": "m/s", "_db_m": "dB/m", "_pa_m": "Pa·m", "_pa2": "Pa²", "_pa": "Pa", "_hz": "Hz", "_rad": "rad",
         "_db": "dB", "_kg_m3": "kg/m³", "_voxels": "voxels", "_wavelengths": "wavelengths", "_px": "px", "_m": "m",
         "_s": "s"}
NULL = {"type": "null"}
WIDTH = 120


def merged(one, other):
    """What holds for both of two variants: all members of either, and required what both require."""
    if "anyOf" in one and "anyOf" in other:
        return {**one, "anyOf": [merged(one["anyOf"][0], other["anyOf"][0]), *one["anyOf"][1:]]}
    if "properties" not in one or "properties" not in other:
        return one
    mine, others = one["properties"], other["properties"]
    both = {key: merged(use, others[key]) if key in others else use for key, use in mine.items()}
    return {**one, "properties": {**both, **{key: use for key, use in others.items() if key not in mine}},
            "required": [key for key in one["required"] if key in other["required"]]}


def only_there(variant, common):
    """What one variant requires in addition to what all have in common."""
    found = {}
    needed = [key for key in variant.get("required", []) if key not in common["required"]]
    if needed:
        found["required"] = needed
    inner = {key: only_there(use, common["properties"][key]) for key, use in variant.get("properties", {}).items()}
    if any(inner.values()):
        found["properties"] = {key: use for key, use in inner.items() if use}
    return found


def sentence(meaning, may_be_null, words):
    """A meaning as keys of scenarios have it, as the description of a member."""
    start, _, left_out = meaning.partition("; left out: ")
    if left_out and may_be_null:
        start += "; null: " + left_out
    return (f"For {' and '.join(words)}: " if words else "") + start + "."


def gathered(own, shared):
    """The texts of a file, with those that stand elsewhere."""
    texts, known = {}, {**shared, **own}
    for path, text in own.items():
        texts[path] = text
        like = text.get("as") if isinstance(text, dict) else None
        if like:
            texts.update({path + other[len(like):]: known[other] for other in known if other.startswith(like + ".")})
            texts[path] = {key: use for key, use in text.items() if key != "as"}
    return {**{path: text for path, text in shared.items() if path.startswith("#")}, **texts}


class Composer:
    def __init__(self, name, own, shared):
        self.file, self.texts, self.unused, self.definitions = f"{name}_members.json", gathered(own, shared), set(own), {}
        self.places = {path: place for place, path in enumerate(self.texts)}

    def text(self, path):
        self.unused.discard(path)
        return self.texts.get(path, {})

    def member(self, raw, path, words=()):
        """The schema of a member; `words`: those with which alone it is there."""
        text = self.text(path)
        if isinstance(text, str):
            return self.reference(raw, text)
        if "members" in text:
            own = {key: use for key, use in text.items() if key != "members"}
            return {**own, "anyOf": [self.reference(raw["anyOf"][0], text["members"]), NULL]}
        structure = self.structure(raw, path, text)
        kinds = structure.get("type", "")
        given = {key: structure.pop(key) for key in ("title", "description", "unit") if key in structure}
        if given:
            given["description"] = sentence(given["description"], "null" in kinds, words)
        unit = next((unit for end, unit in UNITS.items() if path.endswith(end)), None)
        # Lists may hold the unit, texts and maps do not.
        has_unit = {"number", "integer", "array"} & ({kinds} if isinstance(kinds, str) else set(kinds))
        given = {**given, **({"unit": unit} if unit and has_unit and "unit" not in given else {}), **text}
        if "title" not in given or "description" not in given:
            raise ValueError(f"output_schema/{self.file}: {path} needs a title and a description")
        if {"const", "enum"} & set(text):
            structure = {}
        return {**{key: given.pop(key) for key in ("title", "description", "unit") if key in given},
                **structure, **given}

    def reference(self, raw, name):
        schema = self.member(raw, name)
        if self.definitions.setdefault(name[1:], schema) != schema:
            raise ValueError(f"output_schema/{self.file}: members differ that refer to {name}")
        return {"$ref": "#/definitions/" + name[1:]}

    def structure(self, raw, path, text):
        if "anyOf" in raw:
            inner = self.structure(raw["anyOf"][0], path, text)
            inner["type"] = [inner["type"], "null"]
            return {**inner, **{key: use for key, use in raw.items() if key != "anyOf"}}
        if "oneOf" in raw:
            return self.by_word(raw["oneOf"], path, text)
        if "properties" in raw and not {"additionalProperties", "properties"} & set(text):
            return {**raw, "properties": {key: self.member(raw["properties"][key], f"{path}.{key}".lstrip("."))
                                          for key in self.ordered(raw["properties"], path)}}
        if raw.get("type") == "array" and "items" not in text:
            way = path + "[]"
            structured = {"properties", "oneOf"} & set(raw["items"])
            items = self.reference(raw["items"], self.text(way)) if isinstance(self.text(way), str) else \
                self.structure(raw["items"], way, {}) if structured else raw["items"]
            return {**raw, "items": items}
        return {key: use for key, use in raw.items() if key not in ("properties", "required")} \
            if "properties" in raw else dict(raw)

    def by_word(self, variants, path, text):
        """Of an object whose members depend on a word."""
        word = next(key for key in variants[0]["properties"]
                    if all("const" in variant["properties"].get(key, {}) for variant in variants))
        names = [variant["properties"][word]["const"] for variant in variants]
        rule = {name: {"if": {"properties": {word: {"const": name}}}} for name in names}
        if text.get("kinds"):
            for name, variant in zip(names, variants):
                schema = {**self.text("#" + name), **self.structure(variant, path, {})}
                schema["properties"][word] = {**self.text(f"{path}.{word}"), "const": name}
                self.definitions[name] = schema
            properties = {word: {**self.text(f"{path}.{word}"), "enum": names}}
            del text["kinds"]
            return {"type": "object", "required": [word], "properties": properties,
                    "allOf": [{**rule[name], "then": {"$ref": "#/definitions/" + name}} for name in names]}
        common = variants[0]
        for variant in variants[1:]:
            common = merged(common, variant)
        properties = {}
        for key in self.ordered(common["properties"], path):
            having = [name for name, variant in zip(names, variants) if key in variant["properties"]]
            raw = {"enum": names} if key == word else common["properties"][key]
            properties[key] = self.member(raw, f"{path}.{key}", having if len(having) < len(names) else ())
        rules = [{**rule[name], "then": only_there(variant, common)} for name, variant in zip(names, variants)]
        return {**common, "properties": properties, "allOf": [one for one in rules if one["then"]]}

    def ordered(self, properties, path):
        """Members in the order of the texts; one that the program describes follows the one before it."""
        place, found = 0, {}
        for key in properties:
            place = self.places.get(f"{path}.{key}".lstrip("."), place)
            found[key] = place
        return sorted(properties, key=found.get)


def compact(value, indent=0, before=0):
    """JSON with each list and map on one line where it fits, and its plain values on common lines."""
    line = json.dumps(value, ensure_ascii=False)
    if not isinstance(value, (dict, list)) or indent + before + len(line) < WIDTH:
        return line
    inner, lines, is_plain = " " * (indent + 2), [], False
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        name = f"{json.dumps(key)}: " if isinstance(value, dict) else ""
        text = name + compact(item, indent + 2, len(name) + 1)
        joins = is_plain and not isinstance(item, (dict, list)) and len(lines[-1]) + len(text) + 3 <= WIDTH
        is_plain = not isinstance(item, (dict, list))
        lines[len(lines) - joins:] = [f"{lines[-1]}, {text}" if joins else inner + text]
    ends = "[]" if isinstance(value, list) else "{}"
    return ends[0] + "\n" + ",\n".join(lines) + "\n" + " " * indent + ends[1]


def make(root, name, printed):
    """The text of the schema; `printed`: what ensonify --help-format NAME prints."""
    own, shared = (json.loads((root / f"output_schema/{file}_members.json").read_text()) for file in (name, "sequence"))
    common, rules = json.loads(printed), {}
    if "anyOf" in common:
        recording, bare, full, earlier, camera = common["anyOf"]
        simulated = merged(merged(full, earlier), bare)
        common = merged(merged(simulated, recording), camera)
        others = [{"required": ["recording"]}, {"required": ["instrument"]}]
        rules = {"if": {"not": {"anyOf": others}}, "then": only_there(simulated, common)}
    composer = Composer(name, own, shared)
    schema = composer.member(common, "")
    rules = {**rules, "additionalProperties": schema.pop("additionalProperties"),
             "definitions": dict(sorted(composer.definitions.items()))}
    if composer.unused:
        raise ValueError(f"output_schema/{composer.file}: no member {', '.join(sorted(composer.unused))}")
    return compact({**own[""], **schema, **rules}) + "\n"
