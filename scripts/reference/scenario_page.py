"""docs/scenario_keys.md: every key of a scenario, from its schema."""
import json

from .schema_words import code, describe, meaning, meant, own_keys, slug, table

# A heading, the definition whose keys it lists, and the heading of docs/scenario.md that explains them.
# Parents come before their parts. The table of a parent includes definitions without a heading.
SECTIONS = [
    ("Top level", "", "Top level"), ("sonar", "sonar", "sonar"), ("rig", "rig_item", "rig"), ("pulse", "pulse", "Pulses"),
    ("receiver", "receiver", "Array of elements"), ("electronics", "electronics", "Electronics and recorder"),
    ("detector", "detector", "Detector"), ("recorder", "recorder", "Electronics and recorder"), ("Shading", "shading", "Shading"),
    ("camera", "camera", "camera"), ("water", "scenario_water", "water"), ("scattering", "scattering", "scattering"),
    ("materials", "materials_item", "materials"), ("objects", "objects_item", "objects"),
    ("shape", "shape", "objects"), ("heightfield", "heightfield", "Terrain"),
    ("place", "place", "Places"), ("point_targets", "point_targets_item", "point_targets"),
    ("volumes", "volumes_item", "volumes"), ("multipath", "multipath", "multipath"),
    ("trajectory", "scenario_trajectory", "trajectory"), ("lawnmower", "lawnmower", "Paths by formula"),
    ("orbit", "orbit", "Paths by formula"),
    ("spline", "spline", "Paths by formula"), ("wave_motion", "wave_motion", "wave_motion"),
    ("Timed poses", "poses_item", "trajectory"), ("Poses", "pose", "Poses"),
    ("Poses of objects", "item_pose", "Poses"), ("noise", "noise", "noise"), ("navigation", "navigation", "navigation"),
    ("synthesis", "synthesis", "synthesis"), ("output", "output", "output"), ("splits", "splits", "splits"),
    ("dataset", "dataset", "dataset"),
]
HEAD = ("key", "type", "unit", "default", "accepted", "meaning")
INTRODUCTION = """\
*Made by `scripts/make_reference.py` from the `fields` functions in `generator/scenario`; change those, not this page.*

# Scenario keys

Every key of a scenario: what it holds, in which unit, what it is when left out, what is accepted, and what
it means. [scenario.md](scenario.md) explains them together, with examples, and says which go with which.

- `objects[]` stands for each item of a list, `materials.NAME` for a name that is free to choose.
- *required*: must be there where the map around it is. *keys' defaults*: left out, every key of
  the map has its own default.
- *switch*: `true`, `false`, `on` or `off`. *switch or map*: a map of options turns it on. *word or map*: a word
  stands for the map of that kind with its defaults.
- Any value but `ensonify`, `seed`, `sequences`, names and kinds of classes may be sampled
  ([Sampled values](#sampled-values)), or be that of a [variable](scenario.md#variables).
"""


class Page:
    def __init__(self, whole):
        self.whole = whole
        self.sections = {name: (title, link) for title, name, link in SECTIONS}
        self.places = {name: [] for name in self.sections}
        self.places[""] = [""]
        self.rows_of = {}
        self.seen = {}      # path of each map that has rows, by the map's identity
        self.shown = []     # (map, key) of every row

    def default(self, where, key, use):
        """The value of a key that is left out."""
        if "default" in use:
            value = json.dumps(use["default"]).replace('"', "").replace("e-0", "e-")
            return f"`{value}`"
        if "left_out" in use:
            return code(use["left_out"])
        raise ValueError(f"{where or 'top level'}: {key}: no default, not required, and no \"left out: ...\"")

    def row(self, node, name, path, key, use):
        said = describe(self.whole, use)
        flat, _ = meant(self.whole, use)
        default = self.default(name, key, use)
        unit = use.get("unit", "")
        section = next((n for n in said.names if n in self.sections), None)
        more = ""
        if section is not None:
            self.places[section].append(path + said.step)
            more = f" Keys: [{self.sections[section][0]}](#{slug(self.sections[section][0])})."
        elif said.inner is not None and id(said.inner) in self.seen:
            more = f" Keys as of `{self.seen[id(said.inner)]}`."
        self.shown.append((id(node), key))
        row = (f"`{path}`", said.kind, unit, default, said.accepted, meaning(flat["title"], flat["description"]) + more)
        return row, None if section is not None else said

    def rows(self, node, name, prefix):
        self.seen[id(node)] = prefix.rstrip(".") or name
        found = []
        for key, use in own_keys(node).items():
            path = prefix + key
            row, said = self.row(node, name, path, key, use)
            found.append(row)
            if said is not None and said.inner is not None and id(said.inner) not in self.seen:
                inner = next((n for n in said.names if self.whole["definitions"][n] is said.inner), "")
                found += self.rows(said.inner, inner, path + said.step + ".")
        return found

    def section(self, title, name, link):
        node = self.whole["definitions"][name] if name else self.whole
        node = next((part for part in node.get("anyOf", []) if "object" in part.get("type", "")), node)
        places = self.places[name]
        one = len(places) == 1
        prefix = places[0] + "." if one and places[0] else ""
        text = f"## {title}\n\n"
        if not one:
            text += "At " + ", ".join(f"`{place}`" for place in dict.fromkeys(places)) + ". "
        text += f"Explained in [{link}](scenario.md#{slug(link)}).\n\n"
        return text + table(HEAD, self.rows(node, name, prefix)) + "\n"


def sampled_values(whole):
    draws = whole["definitions"]["number"]["properties"]
    rows = [(f"`{key}`", use["title"], code(use["description"])) for key, use in draws.items()]
    return ("## Sampled values\n\nA map with one of these keys in place of a value: each sequence samples its own. "
            "Explained in [Sampled values](scenario.md#sampled-values).\n\n"
            + table(("key", "what", "meaning"), rows))


def make(root):
    whole = json.loads((root / "output_schema/scenario.schema.json").read_text())
    explained = {slug(line.lstrip("# ")) for line in (root / "docs/scenario.md").read_text().splitlines()
                 if line.startswith("#")}
    page = Page(whole)
    text = INTRODUCTION + "\n"
    for title, name, link in SECTIONS:
        if slug(link) not in explained:
            raise ValueError(f"docs/scenario.md has no heading {link}")
        text += page.section(title, name, link)
    return text + sampled_values(whole), page
