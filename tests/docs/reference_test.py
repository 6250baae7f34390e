"""docs/scenario_keys.md, docs/file_members.md and the tables of docs/sonars.md: up to date, whole, and true.

ENSONIFY is the program. Run by ctest; by hand, in this folder:
    ENSONIFY=../../build/release/ensonify python3 -m unittest reference_test
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True
from make_reference import PRINTED, pages, printed                      # noqa: E402
from reference import member_schema, presets, scenario_page                              # noqa: E402
from reference.schema_words import describe, own_keys             # noqa: E402

PROGRAM = os.environ.get("ENSONIFY", "ensonify")
SCHEMAS = ROOT / "output_schema"
# Ends of names, longest first, and the unit that they promise.
UNITS = [("_per_m", "1/m"),
         ("_m_s", "m/s"), ("_db_m", "dB/m"), ("_pa_m", "Pa·m"), ("_pa2", "Pa²"), ("_pa", "Pa"), ("_hz", "Hz"),
         ("_deg", "°"), ("_rad", "rad"), ("_psu", "psu"), ("_px", "px"), ("_db", "dB"), ("_voxels", "voxels"),
         ("_seconds", "s"), ("_c", "°C"), ("_m", "m"), ("_s", "s")]
# The shortest one, and two in which every map of options stands with what it requires and nothing else.
SCENARIOS = ["ensonify: 1\nsonar: {preset: blueview_p900_90}\n", """\
ensonify: 1
sonar: {preset: blueview_p900_90, pulse: {lfm: {duration_s: 1e-3}}, beams: {shading: {taylor: {}}},
        receiver: {mode: array}}
water: {profile: {depth_m: [0], sound_speed_m_s: [1500]}, absorption: {model: ainslie_mccolm}}
output: {png: {tvg: {}}, sdf: {voxel_m: 1}, height_map: {spacing_m: 1}}
splits: {val: 1}
""", """\
ensonify: 1
sonar: {frequency_hz: 9e5, bandwidth_hz: 3e4, source_level_db: 200, range_max_m: 10, elevation: {width_deg: 20},
        beams: {count: 8, fov_deg: 80, receive_width_deg: 1, shading: {chebyshev: {}}}, rays: {elevation: 8}}
materials: {a: {reflectivity: 1, coherent: {model: kirchhoff}}}
objects:
  - {name: ground, material: a, shape: {heightfield: {size_m: [40, 40], cell_m: 1, roughness: {rms_m: 0},
     ripples: [{height_m: 0, wavelength_m: 9}]}}}
  - {name: box, material: a, shape: {box: {size_m: [1, 1, 1]}}, trajectory: {wave_motion: {period_s: 5}, spline: {
     points_m: [[0, 0, 0], [1, 0, 0]], speed_m_s: 1}}}
  - {name: ball, material: a, shape: {sphere: {radius_m: 1}}, trajectory: {orbit: {center_m: [0, 0, 0],
     radius_m: 9, speed_m_s: 1}}}
  - {name: rod, material: a, shape: {cylinder: {radius_m: 1, height_m: 1}}, trajectory: {lawnmower: {
     corner_m: [0, 0, 0], length_m: 9, width_m: 4, spacing_m: 2, speed_m_s: 1}}}
  - {name: thing, material: a, shape: {sphere: {radius_m: 0.1}}, place: {on: ground, area_m: [[12, 12], [15, 15]]}}
  - {name: mesh, material: a, shape: {mesh: {file: a.obj}}}
point_targets: [{name: p, target_strength_db: 0, position_m: [1, 0, 0]}]
volumes:
  - {name: leak, plume: {radius_m: 0.2, height_m: 5, strength_db: -20}}
  - {name: haze, uniform: {strength_db: -50, size_m: [1, 1, 1]}}
multipath: {surface: {z_m: 1, reflection: -1}}
"""]
# What these give themselves and a resolved scenario leaves out where it is the default, or says in other words.
GIVEN = {"sonar.receiver.mode", "objects[].shape.heightfield.ripples", "output.cartesian", "output.png.tvg",
         "output.sdf", "output.height_map"}


def schemas():
    return {path.name.split(".")[0]: json.loads(path.read_text()) for path in sorted(SCHEMAS.glob("*.schema.json"))}


# What says which members go together, not what they are.
CONDITIONS = {"if", "then", "else", "dependencies", "not", "whole_sonar"}


def members(node, way=""):
    """Every member of a schema, wherever it stands, with the way to it."""
    if isinstance(node, dict):
        inner = node.get("properties")
        for key, use in inner.items() if isinstance(inner, dict) else ():
            if isinstance(use, dict) and key != "choice":
                yield f"{way}/{key}", key, use
        for key, value in node.items():
            if key not in CONDITIONS:
                yield from members(value, f"{way}/{key}")
    elif isinstance(node, list):
        for value in node:
            yield from members(value, way)


def flow(text):
    """A value of one line of resolved YAML."""
    def as_json(found):
        plain = found[0][0] == '"' or re.fullmatch(r"true|false|null|-?\d+(\.\d+)?(e[-+]?\d+)?", found[0])
        return found[0] if plain else json.dumps(found[0])

    return json.loads(re.sub(r'"(?:[^"\\]|\\.)*"|[^\s{}\[\],:][^{}\[\],:]*', as_json, text))


def block(lines):
    """Resolved YAML: maps and lists by indent, values of one line."""
    found, at = None, 0
    while at < len(lines):
        depth = len(lines[at]) - len(lines[at].lstrip())
        end = at + 1
        item = lines[at].lstrip().startswith("- ")
        while end < len(lines) and len(lines[end]) - len(lines[end].lstrip()) > depth:
            end += 1
        if item:
            found = [] if found is None else found
            text = lines[at].lstrip()[2:]
            whole = [" " * (depth + 2) + text, *lines[at + 1:end]]
            found.append(flow(text) if text[0] in "{[" else block(whole))
        else:
            found = {} if found is None else found
            key, text = lines[at].strip().split(":", 1)
            more = lines[at + 1:end]
            found[key.strip('"')] = flow(" ".join([text, *more]).strip()) if text.strip() else block(more)
        at = end
    return found


def resolved(text):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "a.yaml"
        file.write_text(text)
        (file.parent / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        result = subprocess.run([PROGRAM, "check", file], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return block([line for line in result.stdout.splitlines() if line.strip() and not line.startswith("#")])


def at(value, path):
    """What stands at a key path of the page: any item of `[]`, any name for NAME."""
    if not path:
        yield value
    elif isinstance(value, list):
        for item in value:
            yield from at(item, path[1:] if path[0] == "[]" else path)
    elif isinstance(value, dict):
        for key in value if path[0] == "NAME" else [path[0]] if path[0] in value else []:
            yield from at(value[key], path[1:])


def keys_and_defaults():
    """(key path, default) of every row of the page that has a value for it."""
    places = [""]
    for line in (ROOT / "docs/scenario_keys.md").read_text().splitlines():
        if line.startswith("## "):
            places = [""]
        elif line.startswith("At `"):
            places = [place + "." for place in re.findall("`([^`]*)`", line)]
        found = re.match(r"\| `([\w.\[\]]+)` \|[^|]*\|[^|]*\| `([^`|]*)` \|", line)
        if found:
            yield from ((place + found[1], found[2]) for place in places)


def sonar_tables():
    """Of each preset in docs/sonars.md the cells of the table of numbers, that of bandwidths, and those of kinds."""
    page, found = (ROOT / "docs/sonars.md").read_text(), {}
    for name, cells in re.findall(r"^\| `(\w+)` \| (.*) \|$", page, re.MULTILINE):
        found.setdefault(name, []).append(cells)
    rows = {name: cells for name, cells in found.items() if "_" in name and len(cells) == 3}
    return {name: (numbers.split(" | "), bandwidths, kinds) for name, (numbers, bandwidths, kinds) in rows.items()}


class Reference(unittest.TestCase):
    def test_pages_are_up_to_date(self):
        for name, text in pages().items():
            self.assertEqual((ROOT / "docs" / name).read_text(), text, f"run scripts/make_reference.py: {name}")
            self.assertRegex(text, r"[Mm]ade by `?scripts/make_reference.py")
        for name, what in PRINTED.items():
            self.assertEqual((ROOT / name).read_text(), printed(PROGRAM, what), f"run scripts/make_reference.py: {name}")

    def test_every_key_of_a_scenario_has_a_row(self):
        text, page = scenario_page.make(ROOT)
        shown = set(page.shown)
        for name, node in [("", page.whole), *page.whole["definitions"].items()]:
            for key in own_keys(node) if name != "whole_sonar" else ():
                self.assertIn((id(node), key), shown, f"{name}.{key}")
        self.assertGreater(len(shown), 200)
        self.assertEqual(len(shown), text.split("\n## Sampled values")[0].count("\n| `"))

    def test_every_member_is_described_and_has_its_unit(self):
        count = 0
        for name, whole in schemas().items():
            for way, key, use in members(whole):
                if "$ref" in use:
                    use = whole["definitions"][use["$ref"].split("/")[-1]]
                self.assertTrue(use.get("title") and use.get("description"), f"{name}{way}")
                unit = next((unit for end, unit in UNITS if key.endswith(end)), None)
                if unit and describe(whole, use).kind.replace(" or null", "") not in ("text", "map"):
                    self.assertTrue(use.get("unit", "").startswith(unit), f"{name}{way} {unit}")
                    count += 1
        self.assertGreater(count, 100)

    def test_a_member_needs_a_text_and_a_text_a_member(self):
        texts = json.loads((SCHEMAS / "sequence_members.json").read_text())
        members = subprocess.run([PROGRAM, "--help-format", "sequence"], capture_output=True, text=True, check=True).stdout
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "output_schema/sequence_members.json"
            file.parent.mkdir()
            for change, what in (({"sonar.colour": {"title": "Color", "description": "None."}}, "no member sonar.colour"),
                                 ({"sonar.pulse": {"title": "Pulse"}}, "sonar.pulse needs a title and a description")):
                file.write_text(json.dumps({**texts, **change}))
                with self.assertRaisesRegex(ValueError, what):
                    member_schema.make(pathlib.Path(folder), "sequence", members)

    def test_defaults_are_those_that_the_program_fills_in(self):
        texts = [resolved(text) for text in SCENARIOS]
        confirmed, unseen, wrong = set(), set(), []
        for path, default in keys_and_defaults():
            way = [step for part in path.split(".") for step in re.findall(r"\[\]|\w+", part)]
            values = [value for text in texts for value in at(text, way)]
            # 0 is not false, which Python takes for equal.
            same = any(json.dumps(value) == json.dumps(flow(default)) for value in values)
            (confirmed if same else unseen).add(path)
            if values and not same and path not in GIVEN:
                wrong.append(f"{path}: {default} on the page, {values} by check")
        self.assertEqual("\n".join(wrong), "")
        self.assertGreaterEqual(len(confirmed), 85, sorted(unseen))

    def test_presets_are_those_of_the_schema(self):
        known = schemas()["scenario"]["definitions"]["sonar"]["properties"]["preset"]["anyOf"][0]["enum"]
        self.assertEqual(sorted(known), [path.stem for path in sorted((ROOT / "configs/sonars").glob("*.yaml"))])
        self.assertEqual(sorted(sonar_tables()), sorted(known))

    def test_sonars_are_what_the_program_prints(self):
        for name, (numbers, bandwidths, _) in sonar_tables().items():
            printed = subprocess.run([PROGRAM, "presets", name], capture_output=True, text=True, check=True).stdout
            sonar = block([line for line in printed.splitlines() if line.strip() and not line.startswith("#")])
            beams, elevation, rays = sonar["beams"], sonar["elevation"], sonar["rays"]
            shading = beams.get("shading", {"uniform": {}})
            azimuths = beams.get("azimuths_deg")
            chirp = sonar["pulse"]["lfm"] if isinstance(sonar["pulse"], dict) else None
            self.assertEqual(re.findall("[a-z]{4,}", " ".join(numbers)),
                             ["taper" if chirp else sonar["pulse"], *["unequal"] * bool(azimuths),
                              *shading, elevation.get("shading", "uniform")], name)
            # From the outer border of the first cell to that of the last one.
            fan_deg = round(azimuths[-1] + (azimuths[-1] - azimuths[-2]) / 2
                            - azimuths[0] + (azimuths[1] - azimuths[0]) / 2, 1) if azimuths else beams["fov_deg"]
            self.assertEqual(
                [float(text) for text in re.findall(r"-?[\d.]+", " ".join(numbers).replace("−", "-"))],
                [sonar["frequency_hz"] / 1e3, *((round(chirp["duration_s"] * 1e3, 9), chirp["taper"]) if chirp else ()),
                 sonar["range_min_m"], sonar["range_max_m"], sonar["source_level_db"],
                 beams["count"], fan_deg, beams["receive_width_deg"],
                 *(keys["side_lobe_db"] for keys in shading.values() if keys), elevation["width_deg"],
                 elevation.get("fan_deg", elevation["width_deg"]), rays["elevation"], rays["azimuth"]], name)
            rows = sonar.get("by_range_max_m", [{"bandwidth_hz": sonar["bandwidth_hz"]}])
            self.assertEqual(len(rows), len(bandwidths.split(", ")))
            for row, cell in zip(rows, bandwidths.split(", ")):
                found = re.fullmatch(r"([\d.]+)(?: up to ([\d.]+) m)? \(([\d.]+) mm\)", cell)
                self.assertEqual(float(found[1]), row["bandwidth_hz"] / 1e3, name)
                self.assertEqual(found[2] and float(found[2]), row.get("up_to_m"), name)
                self.assertAlmostEqual(float(found[3]) * 2 * row["bandwidth_hz"] / 1500e3, 1, delta=5e-3, msg=name)

    def test_each_key_of_a_preset_has_one_kind_of_source(self):
        for name, (*_, cell) in sonar_tables().items():
            sonar, head = presets.read(ROOT / f"configs/sonars/{name}.yaml")
            kinds, all_keys = presets.named(head), presets.keys(sonar)
            names = [key for _, keys in kinds.values() for key in keys]
            self.assertEqual(len(names), len(set(names)), f"{name} names a key twice")
            unused = [key for key in names if not any(presets.covers(key, way) for way in all_keys)]
            self.assertEqual(unused, [], f"{name} names keys that it does not have")
            for key in all_keys:
                self.assertEqual(len(presets.kinds_of(key, kinds)), 1, f"{name}: {key}")
            self.assertTrue("Recording" not in kinds or kinds["Recording"][0], f"{name} names no recording")
            self.assertEqual(re.findall(r"`([^`]+)`", cell),
                             [key for kind in presets.KINDS for key in kinds.get(kind, (None, ()))[1]], name)


if __name__ == "__main__":
    unittest.main()
