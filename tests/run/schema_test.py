"""Data sets against output_schema, by a validator that is not ours; it finds whatever is missing, too many or of
another type. That `verify` finds the same, with its place, is tested in tests/dataset/verify_schema_test.cpp and
schema_test.cpp.

ENSONIFY is the program, SCENES the folder of scenes, SCHEMAS that of schemas. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCENES=scenes SCHEMAS=output_schema PYTHONPATH=scripts:tests/cli python3 -m unittest schema_test
"""
import copy
import csv
import json
import os
import pathlib
import re
import tempfile
import unittest

import jsonschema

import program
from program import SCENES, run

SCHEMAS = pathlib.Path(os.environ.get("SCHEMAS", "output_schema"))
SMALL = ["--quiet", "--pings", "0:1", "--sequences", "0:1", "--set", "sonar.beams.count=24", "--set",
         "sonar.rays.elevation=8", "--set", "output.cartesian.height_px=60", "--set", "output.scatterers=true",
         "--set", "output.polygons=true"]


def generate(scene, folder, *more):
    result = run("generate", scene, "-o", folder, *SMALL, *more)
    assert result.returncode == 0, result.stderr


def validator(name):
    return jsonschema.Draft7Validator(json.loads((SCHEMAS / f"{name}.schema.json").read_text()))


VALIDATORS = {name: validator(name)
              for name in ("work", "dataset", "sequence", "annotations", "coco", "provenance", "render")}
TABLES = json.loads((SCHEMAS / "tables.json").read_text())["tables"]


def schema_faults(folder):
    """What jsonschema says of every JSON of a data set, as 'file: message'."""
    found = []

    def check(path, name, data):
        for error in VALIDATORS[name].iter_errors(data):
            found.append(f"{path.relative_to(folder)}: {list(error.absolute_path)} {error.message}")

    for name in ("work", "dataset", "coco", "provenance"):
        check(folder / f"{name}.json", name, json.loads((folder / f"{name}.json").read_text()))
    for sequence in sorted((folder / "sequences").iterdir()):
        check(sequence / "sequence.json", "sequence", json.loads((sequence / "sequence.json").read_text()))
        for line in (sequence / "annotations.jsonl").read_text().splitlines():
            check(sequence / "annotations.jsonl", "annotations", json.loads(line))
    return found


def table_faults(path):
    """What is wrong with a CSV table, by its Frictionless schema."""
    fields = TABLES[path.name]["fields"]
    types = {"integer": int, "number": float, "string": str}
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    if rows[0] != [field["name"] for field in fields]:
        return [f"header {rows[0]}"]
    found = []
    for row in rows[1:]:
        if len(row) != len(fields):
            found.append(f"{len(row)} columns")
            continue
        for cell, field in zip(row, fields):
            limits = field["constraints"]
            try:
                value = types[field["type"]](cell)
            except ValueError:
                found.append(f"{field['name']} {cell}")
                continue
            if "minimum" in limits and value < limits["minimum"] or "enum" in limits and \
                    value not in limits["enum"] or "pattern" in limits and not re.search(limits["pattern"], cell):
                found.append(f"{field['name']} {cell}")
    return found


def faults(folder):
    """What is wrong with the JSON files and the tables of a data set of one sequence, and what `verify` finds."""
    tables = [folder / "index.csv", *folder.glob("sequences/*/*.csv"), *folder.glob("sequences/*/navigation/*.csv")]
    absent = {"index.csv", "poses.csv", "objects.csv", "boxes.csv"} - {table.name for table in tables}
    found = schema_faults(folder) + [f"{table}: {fault}" for table in tables for fault in table_faults(table)]
    verified = run("verify", folder)
    return found + [verified.stderr] * bool(verified.returncode) + sorted(absent)


class Scenes(program.Case):
    def test_data_sets_are_as_the_schemas_say(self):
        """With statistics, layers, sampled worlds and meshes; tests/frozen/every_scene_test.py has the other scenes."""
        for scene in ("speckle_wall", "shallow_water", "random_debris", "seabed_and_target"):
            with self.subTest(scene):
                generate(SCENES / f"{scene}.yaml", self.folder / scene)
                self.assertEqual(faults(self.folder / scene), [])

    def test_navigation_sensors_are_as_the_schemas_say(self):
        clock = "rate_hz: 5"
        sensors = ("{imu: {%s, mount: {}, gyroscope: {}, accelerometer: {}}, dvl: {%s, range_max_m: 9}, depth: {%s}, "
                   "altimeter: {%s, range_max_m: 9}, usbl: {%s, transceiver_m: [0, 0, 9]}, "
                   "gps: {%s, latitude_deg: 0, longitude_deg: 0}, odometry: {%s}}" % (7 * (clock,)))
        out = self.folder / "out"
        generate(self.scenario, out, "--set", f"navigation={sensors}")
        self.assertEqual(faults(out), [])
        tables = {path.name for path in out.glob("sequences/*/navigation/*.csv")}
        self.assertEqual(len(tables), len(TABLES) - 4, "each is looked at")

    def test_every_scene_names_its_schema(self):
        """Protects completion in editors: the line leads to the schema from where the scene stands."""
        for scene in SCENES.glob("*.yaml"):
            first = scene.read_text().splitlines()[0]
            found = re.fullmatch(r"# yaml-language-server: \$schema=(\S+)", first)
            self.assertIsNotNone(found, scene)
            self.assertTrue((scene.parent / found[1]).samefile(SCHEMAS / "scenario.schema.json"))


class Schemas(unittest.TestCase):
    def test_every_schema_is_a_draft_7_schema_of_its_own_name(self):
        for path in SCHEMAS.glob("*.schema.json"):
            schema = json.loads(path.read_text())
            jsonschema.Draft7Validator.check_schema(schema)
            name = path.name[:-len(".schema.json")]
            self.assertEqual(schema["$schema"], "http://json-schema.org/draft-07/schema#")
            self.assertEqual(schema["$id"], f"urn:ensonify:{name}:{schema['ensonify_schema']}")

    def test_every_member_has_a_title_and_a_description(self):
        def walk(schema, whole, path):
            while "$ref" in schema:
                schema = whole["definitions"][schema["$ref"].split("/")[-1]]
            self.assertIn("title", schema, path)
            self.assertIn("description", schema, path)
            for key, inner in schema.get("properties", {}).items():
                walk(inner, whole, f"{path}.{key}")
            for inner in [schema["items"]] if "$ref" in schema.get("items", {}) else []:
                walk(inner, whole, path + "[]")

        for name in VALIDATORS:
            whole = json.loads((SCHEMAS / f"{name}.schema.json").read_text())
            walk(whole, whole, name)


def parts(value, path=()):
    """Every object and list inside a JSON value, with the way to it; of lists the first item."""
    if isinstance(value, (dict, list)) and value:
        yield path, value
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from parts(inner, path + (key,))
    elif isinstance(value, list) and value:
        yield from parts(value[0], path + (0,))


def at(value, path):
    for step in path:
        value = value[step]
    return value


# Where users of ensonify choose the keys.
FREE = {("draws",), ("model", "symbols")}
# Members that hang on an output alone: a file without them is whole too.
OPTIONAL = {"polygons"}


def damages(data):
    """(what, damaged) for every object: one member gone, one too many, one of another type each."""
    for path, value in parts(data):
        if isinstance(value, dict) and path not in FREE:
            changed = copy.deepcopy(data)
            at(changed, path)["unheard_of"] = 1
            yield f"{path} unheard_of", changed
            for key in value:
                if key not in OPTIONAL:
                    changed = copy.deepcopy(data)
                    del at(changed, path)[key]
                    yield f"{path} without {key}", changed
                changed = copy.deepcopy(data)
                at(changed, path)[key] = {"a": []}
                yield f"{path} {key} of another type", changed


class Damage(unittest.TestCase):
    """One data set, damaged in each place that an object has."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.whole = pathlib.Path(cls.temporary.name) / "whole"
        generate(SCENES / "seabed_and_target.yaml", cls.whole, "--set", "objects.0.shape={plane: {}}")
        assert run("render", cls.whole, "--name", "plain").returncode == 0

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_jsonschema_finds_every_damage(self):
        sequence = self.whole / "sequences/000000"
        documents = {name: json.loads((self.whole / f"{name}.json").read_text())
                     for name in ("work", "dataset", "coco", "provenance")}
        documents["sequence"] = json.loads((sequence / "sequence.json").read_text())
        documents["annotations"] = json.loads((sequence / "annotations.jsonl").read_text().splitlines()[0])
        documents["render"] = json.loads((self.whole / "renders/plain/render.json").read_text())
        count = 0
        for name, data in documents.items():
            self.assertTrue(VALIDATORS[name].is_valid(data))
            for what, changed in damages(data):
                count += 1
                self.assertFalse(VALIDATORS[name].is_valid(changed), f"{name}: {what}")
        self.assertGreater(count, 200)


if __name__ == "__main__":
    unittest.main()
