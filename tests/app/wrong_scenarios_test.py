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
        return result.stderr

    def test_unknown_key_with_the_nearest(self):
        self.refuse(SMALL.replace("range_max_m", "range_mx_m"), "wrong.yaml:7:3: sonar.range_mx_m",
                    "range_max_m")

    def test_key_given_twice(self):
        self.refuse(SMALL + "seed: 8\n", "wrong.yaml:15:1: seed", "twice")

    def test_wrong_type(self):
        self.refuse(SMALL.replace("pings: 30", "pings: many"), ":13:38: trajectory.pings", "many")

    def test_octal_looking_number(self):
        self.refuse(SMALL.replace("range_max_m: 4", "range_max_m: 010"), ":7:16: sonar.range_max_m",
                    "010")

    def test_negative_and_nan_numbers(self):
        text = SMALL.replace("reflectivity: 1e-3", "reflectivity: -1e-3")
        self.refuse(text, ":10:31: materials.m.reflectivity", "-1e-3")
        self.refuse(SMALL.replace("range_max_m: 4", "range_max_m: .nan"), "sonar.range_max_m")

    def test_missing_file(self):
        mesh = SMALL.replace("{box: {size_m: [7, 7, 2], inward_facing: true}}", "{mesh: {file: gone.stl}}")
        self.refuse(mesh, "objects.0.shape.mesh.file", "gone.stl")
        self.assertEqual(run("generate", self.folder / "no.yaml", "-o", self.folder / "o").returncode, 2)

    def test_broken_mesh_and_path(self):
        (self.folder / "bad.stl").write_text("nothing")
        mesh = SMALL.replace("{box: {size_m: [7, 7, 2], inward_facing: true}}", "{mesh: {file: bad.stl}}")
        self.refuse(mesh, "bad.stl")
        (self.folder / "bad.tum").write_text("1 2 3\n")
        self.refuse(SMALL.replace("{ping_rate_hz: 5, pings: 30}", "{file: bad.tum}"), "bad.tum:1")

    def test_wrong_pulse_table(self):
        (self.folder / "pulse.csv").write_text(
            "frequency_hz,amplitude,phase_deg\n890e3,1,0\n880e3,1,0\n900e3,loud,0\n")
        self.refuse(SMALL.replace("range_max_m: 4", "range_max_m: 4\n  pulse: {table: {file: pulse.csv}}"),
                    "sonar.pulse.table.file", "pulse.csv:3", "pulse.csv:4")

    def test_negative_absorption(self):
        self.refuse(SMALL + "water: {absorption: {fixed_db_m: -0.1}}\n",
                    "wrong.yaml:15:34: water.absorption.fixed_db_m", "-0.1")

    def test_grazing_table_with_gaps(self):
        (self.folder / "sand.csv").write_text("grazing_deg,strength_db\n0,-60\n10,\n20,-30\n60,-20\n")
        self.refuse(SMALL.replace("{reflectivity: 1e-3}", "{law: {table: {file: sand.csv}}}"),
                    "materials.m.law.table.file", "sand.csv:3", "sand.csv:5")

    def test_noise_against_a_signal_that_is_not_there(self):
        text = SMALL.replace("objects:", "noise: {snr_db: 20}\nobjects:")
        self.refuse(text.replace("range_max_m: 4", "range_max_m: 1"), "noise.snr_db", "ping 0")

    def test_all_broken_input_files_at_once(self):
        for name in ("a.stl", "b.stl"):
            (self.folder / name).write_text("nothing")
        (self.folder / "bad.tum").write_text("1 2 3\n")
        text = SMALL.replace("{box: {size_m: [7, 7, 2], inward_facing: true}}", "{mesh: {file: a.stl}}")
        text = text.replace("trajectory:", "  - {name: b, material: m, shape: {mesh: {file: b.stl}}}\ntrajectory:")
        self.refuse(text.replace("{ping_rate_hz: 5, pings: 30}", "{file: bad.tum}"),
                    "objects.0.shape.mesh.file", "a.stl", "objects.1.shape.mesh.file", "b.stl",
                    "bad.tum:1")

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

    def test_all_faults_at_once(self):
        text = SMALL.replace("range_max_m: 4", "range_max_m: -4").replace("seed: 7", "seed: x")
        errors = self.refuse(text.replace("material: m,", "material: n,"), "sonar.range_max_m",
                             "seed", "objects.0.material")
        self.assertGreaterEqual(len(errors.strip().splitlines()), 3)

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
