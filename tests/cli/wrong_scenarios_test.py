"""Wrong scenarios and wrong usage: exit status, message, and nothing written.

Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SCENES=scenes python3 -m unittest wrong_scenarios_test
"""
import resource
import unittest

from program import SMALL, Case, run


def processor_s():
    """What all processes took that were started here, of the processor: others on the machine do not change it."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


class WrongScenarios(Case):
    """Every class of wrong scenario ends with 2, names place and key, and writes nothing."""

    def refuse(self, text, *expected, name="wrong.yaml", mode="w"):
        file = self.folder / name
        with open(file, mode) as stream:
            stream.write(text)
        output = self.folder / "out"
        start = processor_s()
        result = run("generate", file, "-o", output)
        self.assertLess(processor_s() - start, 10, "took too long to refuse")
        self.assertEqual(result.returncode, 2, result.stderr)
        for part in expected:
            self.assertIn(part, result.stderr)
        self.assertFalse(output.exists(), "something was written")

    BOX = "{box: {size_m: [7, 7, 2], inward_facing: true}}"
    FILES = {
        "bad.stl": "nothing", "b.stl": "nothing", "bad.tum": "1 2 3\n",
        "pulse.csv": "frequency_hz,amplitude,phase_deg\n890e3,1,0\n880e3,1,0\n900e3,loud,0\n",
        "sand.csv": "grazing_deg,strength_db\n0,-60\n10,\n20,-30\n60,-20\n",
    }
    # What of SMALL is replaced by what, and what is told. More cases: tests/scenario, by the parser alone.
    CASES = [
        ([("range_max_m", "range_mx_m")], "wrong.yaml:7:3: sonar.range_mx_m", "range_max_m"),
        ([("trajectory:", "seed: 8\ntrajectory:")], "wrong.yaml:13:1: seed", "twice"),
        ([("pings: 30", "pings: many")], ":13:38: trajectory.pings", "many"),
        ([("range_max_m: 4", "range_max_m: 010")], ":7:16: sonar.range_max_m", "010"),
        ([("reflectivity: 1e-3", "reflectivity: -1e-3")], ":10:31: materials.m.reflectivity", "-1e-3"),
        ([("range_max_m: 4", "range_max_m: .nan")], "sonar.range_max_m"),
        ([("materials:", "water: {absorption: {fixed_db_m: -0.1}}\nmaterials:")],
         "wrong.yaml:10:34: water.absorption.fixed_db_m", "-0.1"),
        ([(BOX, "{mesh: {file: gone.stl}}")], "objects.0.shape.mesh.file", "gone.stl"),
        ([(BOX, "{mesh: {file: bad.stl}}")], "bad.stl"),
        ([("{ping_rate_hz: 5, pings: 30}", "{file: bad.tum}")], "bad.tum:1"),
        ([("range_max_m: 4", "range_max_m: 4\n  pulse: {table: {file: pulse.csv}}")],
         "sonar.pulse.table.file", "pulse.csv:3", "pulse.csv:4"),
        ([("{reflectivity: 1e-3}", "{law: {table: {file: sand.csv}}}")],
         "materials.m.law.table.file", "sand.csv:3", "sand.csv:5"),
        ([("objects:", "noise: {snr_db: 20}\nobjects:"), ("range_max_m: 4", "range_max_m: 1")], "noise.snr_db", "ping 0"),
        # All broken input files, and all errors of the text, at once.
        ([(BOX, "{mesh: {file: bad.stl}}"), ("{ping_rate_hz: 5, pings: 30}", "{file: bad.tum}"),
          ("trajectory:", "  - {name: b, material: m, shape: {mesh: {file: b.stl}}}\ntrajectory:")],
         "objects.0.shape.mesh.file", "bad.stl", "objects.1.shape.mesh.file", "b.stl", "bad.tum:1"),
        ([("range_max_m: 4", "range_max_m: -4"), ("seed: 7", "seed: x"), ("material: m,", "material: n,")],
         "sonar.range_max_m", "seed", "objects.0.material"),
    ]

    def test_each_error_has_its_place(self):
        for name, text in self.FILES.items():
            (self.folder / name).write_text(text)
        for changes, *expected in self.CASES:
            text = SMALL
            for old, new in changes:
                self.assertIn(old, text)
                text = text.replace(old, new, 1)
            with self.subTest(changes):
                self.refuse(text, *expected)
        self.assertEqual(run("generate", self.folder / "no.yaml", "-o", self.folder / "o").returncode, 2)

    def test_empty_and_no_yaml(self):
        self.refuse("", "wrong.yaml")
        self.refuse("a: [1, 2\n", "wrong.yaml")
        self.refuse(bytes(range(256)) * 20, "wrong.yaml", mode="wb")
        self.refuse("just words", "wrong.yaml")

    def test_bombs(self):
        levels = "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 12))
        self.refuse("ensonify: 1\na0: &a0 [1]\n" + levels, "wrong.yaml")
        self.refuse("[" * 1_000_000, "wrong.yaml")
        self.refuse("ensonify: 1\nname: &n {x: *n}\n", "wrong.yaml")

    def test_wrong_usage(self):
        output = self.folder / "out"
        for arguments in ([], ["generate"], ["generate", self.scenario], ["paint"],
                          ["generate", self.scenario, "-o", ""],
                          ["generate", self.scenario, "-o", output, "--pings", "3"],
                          ["generate", self.scenario, "-o", output, "--pings", "5:5"],
                          ["generate", self.scenario, "-o", output, "--pings", "0:31"],
                          ["generate", self.scenario, "-o", output, "--backend", "opencl"],
                          ["generate", self.scenario, "-o", output, "--set", "seed"],
                          ["generate", self.scenario, "-o", output, "--seed", "-1"],
                          ["generate", self.scenario, "-o", output, "--set", "sonar.nothing=1"],
                          ["presets", "nothing"]):
            with self.subTest(arguments=arguments[:1] + arguments[-2:]):
                self.assertEqual(run(*arguments).returncode, 2)
        self.assertFalse(output.exists())


if __name__ == "__main__":
    unittest.main()
