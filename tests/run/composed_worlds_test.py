"""Parents, variables and scales against the same world written out: every ping has the same bytes.

ENSONIFY is the program, SCENES the folder of scenes.
"""
import json
import unittest

import program

HEAD = """ensonify: 1
name: composed
seed: 2
sequences: {sequences}
sonar: {{preset: blueview_p900_90, range_max_m: 6, beams: {{count: 64, fov_deg: 64}}, rays: {{elevation: 24}}}}
materials: {{m: {{reflectivity: 1e-2}}}}
trajectory: {{ping_rate_hz: 1, pings: 3}}
motion_within_ping: true
output: {{png: {{db: [60, 120]}}}}
"""
WEDGE = "v {0} 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"


def pings(folder):
    """Hashes of all files of sequences but those that hold draws and materials."""
    return {name: value for name, value in program.hashes(folder).items()
            if name.startswith("sequences/") and not name.endswith("sequence.json")}


class Composed(program.Case):
    def made(self, name, world, sequences=1, *more):
        scenario = self.folder / f"{name}.yaml"
        scenario.write_text(HEAD.format(sequences=sequences) + world)
        done = program.run("generate", scenario, "-o", self.folder / name, "--quiet", *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / name

    def same(self, one, other, count):
        self.assertEqual(pings(one), pings(other))
        self.assertGreaterEqual(len(pings(one)), count)

    def test_a_parent_on_a_trajectory_is_the_composed_trajectory(self):
        way = "{poses: [{time_s: 0, position_m: [3, %s, 0]}, {time_s: 4, position_m: [5, %s, 0]}]}"
        ball = "material: m, shape: {sphere: {radius_m: 0.25}}"
        carried = self.made("carried", f"""objects:
  - {{name: hull, {ball}, trajectory: {way % (-1, -1)}}}
  - {{name: pod, {ball}, pose: {{parent: hull, position_m: [0, 1.5, 0]}}}}
""")
        written = self.made("written", f"""objects:
  - {{name: hull, {ball}, trajectory: {way % (-1, -1)}}}
  - {{name: pod, {ball}, trajectory: {way % (0.5, 0.5)}}}
""")
        self.same(carried, written, 20)

    def test_a_scale_for_each_axis_is_a_stretched_file(self):
        for name, x in ("plain", 1), ("long", 2):
            (self.folder / f"{name}.obj").write_text(WEDGE.format(x))
        world = "objects:\n  - {{name: wedge, material: m, shape: {{mesh: {{file: {}}}}}, pose: {{position_m: [3, 0, 0]}}}}\n"
        scaled = self.made("scaled", world.format("plain.obj, scale: [2, 1, 1]"))
        self.same(scaled, self.made("stretched", world.format("long.obj")), 20)
        self.assertNotEqual(pings(scaled), pings(self.made("unscaled", world.format("plain.obj"))))

    def test_the_resolved_scenario_and_the_drawn_values_make_the_same_pings(self):
        world = """variables:
  x: {uniform: [2.0, 4]}
  n: {uniform: [1, 3]}
objects:
  - {name: ball, count: $n, material: m, shape: {sphere: {radius_m: "= 0.1 * x"}}, pose: {position_m: [$x, "= 1.5 * index - 1", 0]}}
"""
        first = self.made("first", world, 3)
        again = self.folder / "again"
        done = program.run("generate", first / "scenario.yaml", "-o", again, "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(program.hashes(first), program.hashes(again))
        draws = json.loads((first / "sequences/000000/sequence.json").read_text())["draws"]
        self.assertEqual(sorted(draws), ["variables.n", "variables.x"])
        plain = self.made("plain_values", world, 3, "--sequences", "0:1", "--set", f"variables.x={draws['variables.x']}",
                          "--set", f"variables.n={draws['variables.n']}")
        own = {name: value for name, value in pings(first).items() if "000000" in name.split("/")[1]}
        self.assertEqual(pings(plain), own)


if __name__ == "__main__":
    unittest.main()
