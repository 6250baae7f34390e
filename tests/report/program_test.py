"""`ensonify report` from outside: what it prints, and the statuses that it ends with."""
import csv
import json
import pathlib
import re
import shutil
import sys
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from program import made, run, scratch, swept  # noqa: E402

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


SONAR = """{preset: paper_table1, bandwidth_hz: 29900, range_max_m: 3, beams: {count: 16, fov_deg: 16}, rays: {elevation: 8},
    mount: {position_m: [0, 0.5, 0], rotation_deg: [0, 0, 90]}}"""
RIG = SCENARIO.replace(SCENARIO[SCENARIO.index("sonar:"):SCENARIO.index("materials:")], f"""rig:
  - {{name: a, sonar: {SONAR}}}
  - {{name: b, sonar: {SONAR}, ping_rate_hz: 20, time_offset_s: 0.11}}
  - {{name: eye, camera: {{width_px: 8, height_px: 6, fov_deg: 60}}}}
  - {{name: nav, navigation: {{depth: {{rate_hz: 5}}}}}}
""").replace("name: told", 'name: "</script><b>told"').replace("seed: 3", "seed: 3\nsequences: 2")


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


def data_of(page):
    text = page.read_text()
    chunks = re.findall(r'<script type="text/plain" id="chunk-\d+">([^<]*)</script>', text)
    return json.loads(re.search(r'id="report">(.*?)</script>', text)[1]), chunks


def table_of(sweep):
    return list(csv.reader((sweep / "runs.csv").read_text().splitlines()))


class OverRuns(unittest.TestCase):
    def test_the_page_has_the_table_and_an_image_of_each_run(self):
        page = scratch() / "page.html"
        result = run("report", swept(), "-o", page, "--threads", 1)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"{page}: 8 runs, 8 with an image, ", result.stderr)
        data, chunks = data_of(page)
        self.assertEqual(data["table"], table_of(swept()))
        self.assertEqual((data["axes"], len(chunks)), (3, 8))
        self.assertEqual({shown["picture"]["what"] for shown in data["runs"]}, {"ping 0 of sequence 0"})
        again = scratch() / "again.html"
        run("report", swept(), "-o", again, "--threads", 2)
        self.assertEqual(again.read_bytes(), page.read_bytes())

    def test_what_is_not_done_is_shown_with_its_reason(self):
        sweep = shutil.copytree(swept(), scratch() / "sweep")
        whole = table_of(sweep)
        status = whole[0].index("status")
        (sweep / "runs.csv").unlink()
        for row in whole[1:3]:
            shutil.rmtree(sweep / "runs" / row[0])
        (sweep / "failed").mkdir()
        (sweep / "failed" / f"{whole[1][0]}.json").write_text('{"kind": "usage", "message": "too steep"}')
        result = run("report", sweep)
        self.assertIn("8 runs, 6 with an image, ", result.stderr)
        data, _ = data_of(sweep.parent / "sweep_report.html")
        self.assertEqual([row[status] for row in data["table"][1:]], ["failed", "missing"] + 6 * ["done"])
        self.assertEqual([shown["reason"] for shown in data["runs"]], ["too steep"] + 7 * [""])
        # Without the table, the numbers are computed from the data.
        self.assertEqual(data["table"][3:], whole[3:])

    def test_refusals(self):
        for options, words in [(["--pings", 3], "--pings"), (["-o", swept() / "page.html"], "folder of the sweep")]:
            refused = run("report", swept(), *options)
            self.assertEqual(refused.returncode, 2)
            self.assertIn(words, refused.stderr)


class OverInstruments(unittest.TestCase):
    def test_pings_of_one_time_stand_in_a_row(self):
        rig = made(RIG)
        page = scratch() / "page.html"
        result = run("report", rig, "-o", page, "--threads", 1)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"{page}: 12 of 12 pings, ", result.stderr)
        data, chunks = data_of(page)
        self.assertEqual(data["rows"], [{"sequence": s, "time_s": k / 5} for s in range(2) for k in range(6)])
        a, b, eye, nav = data["instruments"]
        self.assertEqual([(i["name"], i["report"]) for i in data["instruments"]],
                         [("a", "page_a.html"), ("b", "page_b.html"), ("eye", None), ("nav", None)])
        self.assertEqual((b["position_m"], b["ping_rate_hz"], b["time_offset_s"]), ([0, 0.5, 0], 20, 0.11))
        self.assertEqual([cell["ping"] for cell in a["cells"]], 2 * list(range(6)))
        # Pings of b are at 0.11 s + k / 20.
        self.assertEqual([cell["ping"] for cell in b["cells"]], 2 * [0, 2, 6, 10, 14, 18])
        self.assertEqual([round(cell["time_s"], 9) for cell in b["cells"][:3]], [0.11, 0.21, 0.41])
        for cell in a["cells"] + b["cells"]:
            self.assertEqual((cell["level"]["beams"], cell["color"], cell["depth"]), (16, None, None))
            self.assertLess(cell["level"]["level"], len(chunks))
        for cell in eye["cells"]:
            self.assertEqual((cell["level"], cell["rows"], cell["columns"]), (None, 6, 8))
            self.assertLess(cell["color"], len(chunks))
            # The wall is perpendicular to the axis of view.
            self.assertAlmostEqual(cell["depth"]["min_m"], 2, delta=1e-5)
            self.assertAlmostEqual(cell["depth"]["max_m"], 2, delta=1e-5)
        self.assertEqual({(cell["level"], cell["color"], cell["depth"]) for cell in nav["cells"]}, {(None, None, None)})
        self.assertEqual([i["scale"] is None for i in data["instruments"]], [False, False, True, True])
        for name in "ab":
            self.assertIn("a page of ensonify report", (page.parent / f"page_{name}.html").read_text())
        self.assertEqual(run("verify", rig).returncode, 0)

    def test_fewer_pings_and_the_same_bytes(self):
        rig, page, again = made(RIG), scratch() / "page.html", scratch() / "page.html"
        for path, threads in ((page, 1), (again, 2)):
            self.assertIn("3 of 12 pings", run("report", rig, "-o", path, "--pings", 3, "--threads", threads).stderr)
        self.assertEqual(again.read_bytes(), page.read_bytes())
        refused = run("report", rig, "-o", rig / "page.html")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("folder of the rig", refused.stderr)


if __name__ == "__main__":
    unittest.main()
