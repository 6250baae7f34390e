"""`ensonify report` from outside: what it prints, and the statuses that it ends with."""
import pathlib
import sys
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "app"))
from program import made, run  # noqa: E402

SCENARIO = """ensonify: 1
name: told
seed: 3
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 3, beams: {count: 16, fov_deg: 16}, rays: {elevation: 8}}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: wall, class: wall, material: m, shape: {plane: {}}, pose: {position_m: [2, 0, 0], rotation_deg: [0, -90, 0]}}
trajectory: {ping_rate_hz: 5, pings: 6}
output: {cartesian: false, png: false}
"""


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = made(SCENARIO).parent

    def test_the_last_line_tells_page_pings_and_bytes(self):
        result = run("report", self.folder / "set", "--pings", 4, "--threads", 1)
        self.assertEqual(result.returncode, 0, result.stderr)
        page = self.folder / "set_report.html"
        self.assertIn(f"{page}: 4 of 6 pings, ", result.stderr.splitlines()[-1])
        self.assertTrue(page.read_text().startswith("<!-- a page of ensonify report -->\n<!doctype html>"))
        self.assertEqual(run("verify", self.folder / "set").returncode, 0)

    def test_quiet_says_nothing(self):
        page = self.folder / "quiet.html"
        result = run("report", self.folder / "set", "-o", page, "--quiet")
        self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""))
        self.assertGreater(page.stat().st_size, 10_000)

    def test_statuses(self):
        mine = self.folder / "mine.html"
        mine.write_text("mine")
        refused = run("report", self.folder / "set", "-o", mine)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--overwrite", refused.stderr)
        self.assertEqual(mine.read_text(), "mine")
        self.assertEqual(run("report", self.folder / "set", "-o", mine, "--overwrite").returncode, 0)
        self.assertEqual(run("report", self.folder).returncode, 2)
        self.assertEqual(run("report", self.folder / "set", "--pings", 0).returncode, 2)


if __name__ == "__main__":
    unittest.main()
