"""docs/file_members.md: every member of the JSON files and every column of the tables, from their schemas."""
import json

from .schema_words import code, describe, limits, meaning, meant, own_keys, slug, table, without_unit, words, PATTERNS

# File, schema, and the page and heading that explain it.
FILES = [
    ("dataset.json", "dataset", "dataset.md", "Top level"),
    ("work.json", "work", "dataset.md", "Top level"),
    ("provenance.json", "provenance", "dataset.md", "Top level"),
    ("sequence.json", "sequence", "dataset.md", "A sequence"),
    ("annotations.jsonl", "annotations", "dataset.md", "A sequence"),
    ("coco.json", "coco", "dataset.md", "Top level"),
    ("render.json", "render", "dataset.md", "Renders"),
    ("rig.json", "rig", "dataset.md", "A rig"),
    ("sweep.json", "sweep", "sweeps.md", "The folder"),
    ("plan.jsonl", "plan", "sweeps.md", "The plan"),
    ("`failed/<id>.json`", "failed_run", "sweeps.md", "The folder"),
    ("index.json", "sweep_index", "sweeps.md", "The folder"),
]
TABLES = [("tables", "dataset.md", {"index.csv": "Top level"}, "A sequence"),
          ("sweep_tables", "sweeps.md", {}, "The folder")]
HEAD = ("member", "type", "unit", "accepted", "there", "meaning")
INTRODUCTION = """\
*Made by `scripts/make_reference.py` from `output_schema/`; change the schemas, not this page.*

# Members of files

Every member of the JSON files and every column of the CSV tables of a data set and of a sweep.
[dataset.md](dataset.md) and [sweeps.md](sweeps.md) explain the files; arrays, pictures and point clouds,
whose layout has no schema, are there alone. Axes, signs and ids are in [conventions.md](conventions.md).

- `files[]` stands for each item of a list, `arrays.NAME` for each name in a map.
- *there*: where a member is not always there, its meaning, or that of the map around it, says when it is.
"""


class Rows:
    """The rows of one schema; a definition that is used again refers to its first place."""

    def __init__(self, whole):
        self.whole, self.seen, self.found, self.kinds = whole, {}, [], []

    def add(self, node, prefix):
        self.seen.setdefault(id(node), prefix.rstrip("."))
        needed = node.get("required", [])
        for key, use in own_keys(node).items():
            self.add_member(use, prefix + key, key in needed)

    def add_member(self, use, path, always):
        said = describe(self.whole, use)
        flat, _ = meant(self.whole, use)
        text = meaning(flat["title"], flat["description"], use.get("unit", ""))
        inner = said.inner
        if said.step == "" and inner is not None and "anyOf" in flat:
            text = text.rstrip(".") + "; or null." if "null" not in text else text
        kinds = [rule["then"]["$ref"].rsplit("/", 1)[-1] for rule in (inner or {}).get("allOf", [])
                 if "$ref" in rule.get("then", {})]
        first = self.seen.get(id(inner))
        if first is not None:
            text += f" Members as of `{first}`."
        elif kinds:
            self.seen[id(inner)] = path + said.step
            self.kinds += [(path + said.step, kind) for kind in kinds]
            text += " Members by `kind`, below."
        self.found.append((f"`{path}`", said.kind, use.get("unit", ""), said.accepted,
                           "always" if always else "not always", text))
        if inner is not None and first is None and not kinds:
            self.add(inner, path + said.step + ".")


def file_section(root, name, schema, page, heading):
    whole = json.loads((root / f"output_schema/{schema}.schema.json").read_text())
    rows = Rows(whole)
    rows.add(whole, "")
    text = (f"## {name}\n\n{code(whole['description'])} Explained in [{heading}]({page}#{slug(heading)}); schema "
            f"[{schema}.schema.json](../output_schema/{schema}.schema.json).\n\n" + table(HEAD, rows.found) + "\n")
    for path, kind in rows.kinds:
        part = Rows(whole)
        part.seen = rows.seen
        node = whole["definitions"][kind]
        part.add(node, path + ".")
        rows.seen.update(part.seen)
        text += f"Members of `{path}` with `kind` `{kind}`:\n\n" + table(HEAD, part.found) + "\n"
    for part, node in whole.get("definitions", {}).items():
        if own_keys(node) and id(node) not in rows.seen:
            raise ValueError(f"{schema}.schema.json: the definition {part} has no rows")
    return text


def column(field):
    rules = field["constraints"]
    accepted = words(rules["enum"]) if "enum" in rules else PATTERNS.get(rules.get("pattern"), limits(rules))
    kind = {"string": "text"}.get(field["type"], field["type"])
    unit = field.get("unit", "")
    return (f"`{field['name']}`", kind, unit, accepted, "always" if rules.get("required") else "not always",
            code(without_unit(field["description"], unit)))


def table_sections(root, name, page, headings, otherwise):
    whole = json.loads((root / f"output_schema/{name}.json").read_text())
    text = ""
    for file, schema in whole["tables"].items():
        heading = headings.get(file, otherwise)
        text += (f"## {file}\n\n{schema['description']} "
                 + ("Between `name` and `seed` stands a column for each axis. " if name == "sweep_tables" else "")
                 + f"Explained in [{heading}]({page}#{slug(heading)}).\n\n"
                 + table(("column", *HEAD[1:]), [column(field) for field in schema["fields"]]) + "\n")
    return text


def make(root):
    headings = {page: {slug(line.lstrip("# ")) for line in (root / "docs" / page).read_text().splitlines()
                       if line.startswith("#")} for page in ("dataset.md", "sweeps.md")}
    for page, heading in [file[2:] for file in FILES] + [(t[1], t[3]) for t in TABLES]:
        if slug(heading) not in headings[page]:
            raise ValueError(f"docs/{page} has no heading {heading}")
    text = INTRODUCTION + "\n" + "".join(file_section(root, *file) for file in FILES)
    text += "".join(table_sections(root, *tables) for tables in TABLES)
    return text.rstrip("\n") + "\n"
