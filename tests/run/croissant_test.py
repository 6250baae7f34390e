"""croissant.json: the members that Croissant 1.1 requires, by the tables of its specification, and what they point at."""
import csv
import fnmatch
import hashlib
import json
import re
import unittest

from program import fresh, made, run, scratch

SCENARIO = """ensonify: 1
name: "a \\"small\\" one"
seed: 5
sequences: 2
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 3, beams: {count: 16, fov_deg: 40}, rays: {elevation: 8}}
materials: {m: {reflectivity: 1e-2}}
objects: [{name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [2, 0, 0]}}]
trajectory: {pings: 2, ping_rate_hz: 2}
splits: {train: 1, val: 1, test: 0}
output: {cartesian: {height_px: 40}, surfaces: true, front: true, motion: true, elevation: true, covisibility: true}
"""
STATED = """dataset: {license: CC-BY-4.0, creator: "A. Person", citation: "A. Person, 2026", url: "https://example.org/d",
  published: "2026-11-26"}
"""
# Properties of a dataset that the specification requires, and its kinds of resources.
REQUIRED = {"@context", "@type", "conformsTo", "description", "license", "name", "url", "creator", "distribution"}
TYPES = {"sc:Integer", "sc:Float", "sc:Text", "sc:URL", "sc:ImageObject", "cr:SegmentationMask"}


def nodes(value):
    """Every object in a JSON value."""
    if isinstance(value, dict):
        yield value
        for member in value.values():
            yield from nodes(member)
    if isinstance(value, list):
        for member in value:
            yield from nodes(member)


class Croissant(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = made(SCENARIO)
        cls.text = (cls.folder / "croissant.json").read_text()
        cls.json = json.loads(cls.text)

    def test_required_members(self):
        self.assertEqual(REQUIRED - set(self.json), set())
        self.assertNotIn("datePublished", self.json, "no date is true of a data set that is not published")
        stated = json.loads((made(SCENARIO + STATED) / "croissant.json").read_text())
        self.assertEqual((REQUIRED | {"datePublished"}) - set(stated), set())
        self.assertEqual(stated["datePublished"], "2026-11-26")
        self.assertEqual(stated["license"], "https://spdx.org/licenses/CC-BY-4.0")
        self.assertEqual(stated["creator"]["name"], "A. Person")
        self.assertEqual(stated["citeAs"], "A. Person, 2026")
        self.assertEqual(stated["url"], "https://example.org/d")

    def test_values(self):
        self.assertEqual(self.json["@type"], "sc:Dataset")
        self.assertIn("http://mlcommons.org/croissant/1.1", self.json["conformsTo"])
        self.assertEqual(self.json["name"], 'a "small" one')
        self.assertEqual((self.json["license"], self.json["creator"]["name"]), ("unspecified",) * 2)
        self.assertIs(self.json["rai:hasSyntheticData"], True)

    def test_every_term_is_in_the_context(self):
        """A member without a prefix is of schema.org unless the context says that it is of Croissant."""
        of_schema = {"name", "description", "license", "creator", "url", "keywords", "distribution", "contentUrl",
                     "contentSize", "encodingFormat", "sha256"}
        for node in nodes({k: v for k, v in self.json.items() if k != "@context"}):
            for term in node:
                if ":" in term or term.startswith("@") or "/" in term:
                    continue
                self.assertIn(term, of_schema | set(self.json["@context"]))

    def test_files_have_their_hashes(self):
        objects = [n for n in self.json["distribution"] if n["@type"] == "cr:FileObject"]
        self.assertIn("index.csv", {n["@id"] for n in objects})
        for n in objects:
            content = (self.folder / n["contentUrl"]).read_bytes()
            self.assertEqual(n["sha256"], hashlib.sha256(content).hexdigest())
            self.assertEqual(n["contentSize"], f"{len(content)} B")

    def test_file_sets_hold_every_file_of_a_sequence_once(self):
        patterns = [n["includes"] for n in self.json["distribution"] if n["@type"] == "cr:FileSet"]
        for path in (self.folder / "sequences").rglob("*"):
            if path.is_file():
                name = path.relative_to(self.folder).as_posix()
                found = [p for p in patterns if fnmatch.fnmatch(name, p) and p.count("/") == name.count("/")]
                self.assertEqual(len(found), 1, (name, found))

    def test_ids_are_unique_and_references_have_targets(self):
        defined = [n["@id"] for n in nodes(self.json) if set(n) > {"@id", "@type"} and n["@type"].startswith("cr:")]
        self.assertEqual(len(defined), len(set(defined)))
        for n in nodes({k: v for k, v in self.json.items() if k != "@context"}):
            if set(n) == {"@id"}:
                self.assertIn(n["@id"], defined)

    def test_record_sets(self):
        sets = {s["@id"]: s for s in self.json["recordSet"]}
        for s in sets.values():
            for f in s["field"]:
                types = f["dataType"] if isinstance(f["dataType"], list) else [f["dataType"]]
                self.assertLessEqual(set(types), TYPES)
                self.assertTrue("source" in f or "data" in s, f["@id"])
        with open(self.folder / "index.csv", newline="") as file:
            header = next(csv.reader(file))
        columns = {f["source"]["extract"]["column"] for f in sets["pings"]["field"]}
        self.assertEqual(columns, set(header))
        self.assertEqual([row["classes/name"] for row in sets["classes"]["data"]], ["ball"])
        mask = {f["name"]: f for f in sets["images-polar-instance-png"]["field"]}
        self.assertIn("cr:SegmentationMask", mask["pixels"]["dataType"])
        path = "sequences/000001/polar/000000_instance.png"
        numbers = [int(re.match(mask[k]["source"]["transform"]["regex"], path)[1]) for k in ("sequence", "ping")]
        self.assertEqual(numbers, [1, 0])

    def test_packed_sequences(self):
        folder = made(SCENARIO, "--set", "output.one_file_per=sequence")
        croissant = json.loads((folder / "croissant.json").read_text())
        names = {n["includes"] for n in croissant["distribution"] if n["@type"] == "cr:FileSet"}
        self.assertIn("sequences/*/polar_instance.npy", names)

    def test_equal_data_sets_have_equal_descriptions(self):
        self.assertEqual((fresh(SCENARIO) / "croissant.json").read_text(), self.text)
        self.assertNotIn(str(self.folder), self.text)


class Verified(unittest.TestCase):
    def test_a_changed_description_is_damage(self):
        folder = fresh(SCENARIO)
        self.assertEqual(run("verify", folder).returncode, 0)
        path = folder / "croissant.json"
        path.write_text(path.read_text().replace("unspecified", "CC0-1.0"))
        result = run("verify", folder)
        self.assertEqual(result.returncode, 1)
        self.assertIn("croissant.json", result.stdout + result.stderr)


class HuggingFace(unittest.TestCase):
    def header(self, text, *options):
        card = (made(text, *options) / "README.md").read_text()
        start, header, body = re.split(r"^---\n", card, maxsplit=2, flags=re.M)
        self.assertEqual(start, "")
        self.assertTrue(body.lstrip().startswith("# "))
        # Each line is `key: value` or an item of a list; values in quotes are JSON.
        found, key = {}, None
        for line in header.splitlines():
            if line.startswith("- "):
                found.setdefault(key, []).append(line[2:])
            else:
                key, _, value = line.partition(":")
                if value:
                    value = value.strip()
                    found[key] = json.loads(value) if value.startswith('"') else value
        return found

    def test_header(self):
        header = self.header(SCENARIO)
        self.assertEqual(header["pretty_name"], 'a "small" one')
        self.assertEqual(header["license"], "other")
        self.assertEqual(header["size_categories"], ["n<1K"])
        self.assertIn("object-detection", header["task_categories"])

    def test_a_license_by_name_or_address(self):
        self.assertEqual(self.header(SCENARIO + STATED)["license"], "cc-by-4.0")
        address = self.header(SCENARIO + 'dataset: {license: "https://example.org/terms"}\n')
        self.assertEqual((address["license"], address["license_link"]), ("other", "https://example.org/terms"))


class Scenario(unittest.TestCase):
    def test_a_wrong_date(self):
        for day in ("2026-02-30", "yesterday", "2026-1-1"):
            result = run("check", scratch(SCENARIO + f'dataset: {{published: "{day}"}}\n') / "scenario.yaml")
            self.assertEqual(result.returncode, 2)
            self.assertIn("dataset.published", result.stderr)
            self.assertIn("YYYY-MM-DD", result.stderr)


if __name__ == "__main__":
    unittest.main()
