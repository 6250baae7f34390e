"""`ensonify sweep --list` from outside: the table, exit statuses, what it must not write.

ENSONIFY is the program, SWEEPS the folder of sweeps. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify SWEEPS=configs/sweeps python3 -m unittest program_test
"""
import hashlib
import os
import pathlib
import re
import sys
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from program import Case, run  # noqa: E402

SWEEPS = pathlib.Path(os.environ.get("SWEEPS", "configs/sweeps"))

BASE = """ensonify: 1
name: small
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 4, beams: {count: 24, fov_deg: 24}, rays: {elevation: 4}}
materials: {m: {reflectivity: 1e-3}}
objects: [{name: ball, material: m, shape: {sphere: {radius_m: 1}}, pose: {position_m: [3, 0, 0]}}]
trajectory: {pings: 2}
output: {cartesian: false, png: false, shadow: false, amodal: false}
"""
SWEEP = """ensonify_sweep: 1
base: base.yaml
axes:
  - {key: sonar.range_max_m, values: [3, 4]}
  - {key: trajectory.pings, values: [1, 2, 8]}
"""


def ids(result):
    return re.findall(r"^([0-9a-f]{16}) ", result.stdout, re.MULTILINE)


class List(Case):
    def setUp(self):
        super().setUp()
        (self.folder / "base.yaml").write_text(BASE)
        self.sweep = self.folder / "s.yaml"
        self.sweep.write_text(SWEEP)

    def test_the_table_has_every_run_and_its_files(self):
        """Protects whoever looks before the night: the count of files is what `generate` writes."""
        listed = run("sweep", self.sweep, "--list")
        self.assertEqual((listed.returncode, listed.stderr), (0, ""))
        self.assertEqual(len(ids(listed)), 6)
        self.assertIn("# s: 6 runs\n", listed.stdout)
        self.assertIn("# 22 pings, ", listed.stdout)
        two = run("sweep", self.sweep, "--list", "--threads", 2).stdout
        self.assertRegex(two, r"\n# time: about [\d.]+ s with 2 threads, [\d.]+ s of one core; disk: about [\d.]+ MB "
                              r"\(measured: pings of 3 runs\)\n$")
        row = next(line for line in listed.stdout.splitlines()
                   if line.endswith("range_max_m=3,pings=2")).split()
        out = self.folder / "out"
        made = run("generate", self.folder / "base.yaml", "-o", out, "--quiet", "--set", "sonar.range_max_m=3")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(int(row[1]), 2)
        # The id is that of the scenario that the data set holds, by an implementation that is not ours.
        self.assertEqual(row[0], hashlib.sha256((out / "scenario.yaml").read_bytes()).hexdigest()[:16])
        self.assertEqual(int(row[2]), sum(path.is_file() for path in out.rglob("*")))

    def test_it_writes_nothing(self):
        out = self.folder / "out"
        self.assertEqual(run("sweep", self.sweep, "-o", out, "--list").returncode, 0)
        self.assertFalse(out.exists())

    def test_shards_share_the_runs(self):
        whole = ids(run("sweep", self.sweep, "--list"))
        parts = [ids(run("sweep", self.sweep, "--list", "--shard", f"{k}/3")) for k in range(3)]
        self.assertEqual(sorted(sum(parts, [])), sorted(whole))
        self.assertTrue(all(parts))
        wrong = run("sweep", self.sweep, "--list", "--shard", "3/3")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("0/N", wrong.stderr)

    def test_faults_are_told_with_place_and_run(self):
        self.sweep.write_text(SWEEP.replace("[3, 4]", "[3, -4]") + "seedz: 3\n")
        refused = run("sweep", self.sweep, "--list")
        self.assertEqual((refused.returncode, refused.stdout), (2, ""))
        self.assertIn(f"{self.sweep}:6:1: seedz: unknown key (did you mean seed?)", refused.stderr)
        self.sweep.write_text(SWEEP.replace("[3, 4]", "[3, -4]"))
        refused = run("sweep", self.sweep, "--list")
        self.assertEqual((refused.returncode, refused.stdout), (2, ""))
        self.assertRegex(refused.stderr, r"s\.yaml:4:42: sonar\.range_max_m: .*\(run range_max_m=-4,pings=1 "
                                         r"and 2 more\)")
        self.assertEqual(run("sweep", self.folder / "none.yaml", "--list").returncode, 2)

    def test_a_plan_that_is_there_is_compared(self):
        """Protects finished work: what another plan would drop is said before the night."""
        out = self.folder / "out"
        out.mkdir()
        plan = [f'{{"run":"{name}","name":"n","values":{{}},"seed":0,"pings":1,"cost":1.0}}\n'
                for name in ids(run("sweep", self.sweep, "--list"))[:4]]
        (out / "plan.jsonl").write_text("".join(plan))
        grown = run("sweep", self.sweep, "-o", out, "--list")
        self.assertEqual(grown.returncode, 0, grown.stderr)
        self.assertIn("4 of these runs are in its plan, 2 are new", grown.stdout)
        (out / "plan.jsonl").write_text("".join(plan).replace('"run":"', '"run":"0', 1))
        damaged = run("sweep", self.sweep, "-o", out, "--list")
        self.assertEqual(damaged.returncode, 2)
        self.assertIn("plan.jsonl:1: ", damaged.stderr)
        (out / "plan.jsonl").write_text(re.sub(r'"run":"\w{16}"', '"run":"' + 16 * "0" + '"', plan[0]))
        other = run("sweep", self.sweep, "-o", out, "--list")
        self.assertEqual(other.returncode, 2)
        self.assertIn("1 of its 1 run is not in this one", other.stderr)

    def test_the_examples_cost_something(self):
        for sweep in sorted(SWEEPS.glob("*.yaml")):
            listed = run("sweep", sweep, "--list")
            self.assertEqual((listed.returncode, listed.stderr), (0, ""), sweep)
            self.assertGreater(len(ids(listed)), 9)


if __name__ == "__main__":
    unittest.main()
