"""Previews: which pings the page shows, what is left behind, and pages that follow their scenario.

ENSONIFY is the program. Run by ctest; by hand:
    ENSONIFY=build/release/ensonify python3 -m unittest preview_test
"""
import csv
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest

PROGRAM = os.path.abspath(os.environ.get("ENSONIFY", "ensonify"))

SMALL = """ensonify: 1
name: little_room
seed: 7
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 4
  beams: {count: 64, fov_deg: 64}
  rays: {elevation: 40, azimuth: 2, min_per_cell: 24}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, class: room, material: m, shape: {box: {size_m: [7, 7, 2], inward_facing: true}}}
trajectory:
  poses: [{time_s: 0, position_m: [0, -1, 0]}, {time_s: 5.8, position_m: [0, 1, 0]}]
  ping_rate_hz: 5
output: {cartesian: {height_px: 100}, scatterers: true, points: true, one_file_per: sequence}
"""

TETRAHEDRON = """v {0} -1 -1
v {0} 1 -1
v {0} 0 1
v 3.5 0 0
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
"""


def report_of(page):
    """The data of a page."""
    text = page.read_text()
    found = re.search(r'<script type="application/json" id="report">(.*?)</script>', text, re.DOTALL)
    return json.loads(found.group(1))


class Case(unittest.TestCase):
    def setUp(self):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        self.temporary = folder / "temporary"
        self.folder = folder / "work"
        self.temporary.mkdir()
        self.folder.mkdir()
        self.scenario = self.folder / "small.yaml"
        self.scenario.write_text(SMALL)
        self.page = self.folder / "small_preview.html"
        self.options = {"cwd": self.folder, "text": True,
                        "env": {**os.environ, "TMPDIR": str(self.temporary)}}

    def preview(self, *arguments, status=0):
        result = subprocess.run([PROGRAM, "preview", *map(str, arguments)], capture_output=True,
                                timeout=1200, **self.options)
        self.assertEqual(result.returncode, status, result.stderr)
        self.assert_nothing_left()
        return result

    def assert_nothing_left(self):
        self.assertEqual(list(self.temporary.iterdir()), [])

    def files(self):
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))

    def generate(self, *arguments):
        data = self.folder / "data"
        subprocess.run([PROGRAM, "generate", self.scenario, "-o", data, "--quiet", *arguments],
                       check=True, **self.options)
        return data


class Pages(Case):
    def test_first_middle_and_last_ping_where_and_when_they_are(self):
        told = self.preview("small.yaml").stderr
        self.assertRegex(told, r"\n  object .*\n  room +7 x 7 x 2 ")
        self.assertEqual(self.files(), ["small.yaml", "small_preview.html"])
        report = report_of(self.page)
        self.assertTrue(report["preview"])
        self.assertEqual(report["name"], "little_room")
        data = self.generate()
        with open(data / "sequences" / "000000" / "poses.csv") as table:
            poses = [[float(x) for x in list(row.values())[:5]] for row in csv.DictReader(table)]
        last = len(poses) - 1
        shown = report["pings"]
        self.assertEqual([ping["ping"] for ping in shown], [0, (last + 1) // 2, last])
        for ping in shown:
            wanted = poses[ping["ping"]]
            self.assertAlmostEqual(ping["time_s"], wanted[1])
            for got, pose in zip(ping["pose"][:3], wanted[2:5]):
                self.assertAlmostEqual(got, pose, 4)
            self.assertIsNotNone(ping["pictures"]["level"])
            self.assertIsNotNone(ping["pictures"]["labels"])
        self.assertEqual(shown[1]["stem"], f"000000/{(last + 1) // 2:06d}")
        self.assertEqual(report["totals"], {"sequences": 1, "pings": len(poses)})
        self.assertEqual(report["shown"]["pings"], 3)
        self.assertIn(f"3 of {len(poses)} pings, rays 64 x 20 instead of 128 x 40, "
                      "12 per cell instead of 24", told)

    def test_the_picture_and_the_way_are_those_of_the_data_set(self):
        self.preview("small.yaml")
        [sequence] = report_of(self.page)["sequences"]
        data = self.generate()
        stored = json.loads((data / "sequences" / "000000" / "sequence.json").read_text())
        self.assertEqual(sequence["beams"], 64)
        self.assertEqual(sequence["samples"], stored["record"]["samples"])
        pings = stored["pings"][1]
        self.assertEqual(sequence["pings"], pings)
        self.assertEqual(len(sequence["path"]), pings)
        with open(data / "sequences" / "000000" / "poses.csv") as table:
            rows = list(csv.reader(table))[1:]
        for point, row in zip(sequence["path"], rows):
            self.assertAlmostEqual(point[1], float(row[3]), 4)

    def test_as_many_pings_as_asked_for(self):
        for count, numbers in ((1, [0]), (2, [0, -1])):
            self.preview("small.yaml", "--pings", count)
            report = report_of(self.page)
            last = report["totals"]["pings"] - 1
            self.assertEqual([ping["ping"] for ping in report["pings"]],
                             [last if n < 0 else n for n in numbers])
        self.preview("small.yaml", "--pings", 200, "--set", "trajectory={ping_rate_hz: 1, pings: 4}")
        self.assertEqual([ping["ping"] for ping in report_of(self.page)["pings"]], [0, 1, 2, 3])

    def test_all_rays(self):
        told = self.preview("small.yaml", "--full").stderr
        self.assertIn("rays 128 x 40;", told)

    def test_neither_run_nor_threads_change_the_page(self):
        self.preview("small.yaml", "--threads", 1)
        once = self.page.read_bytes()
        self.preview("small.yaml", "--threads", 3)
        self.assertEqual(self.page.read_bytes(), once)
        self.preview("small.yaml", "--seed", 8)
        self.assertNotEqual(self.page.read_bytes(), once)

    def test_scenarios_that_write_no_pictures(self):
        still = re.sub("  poses: .*", "  pings: 20", SMALL)
        for output in ("{pings: false, statistics: true}",
                       "{polar: false, cartesian: false, png: false}"):
            self.scenario.write_text(re.sub("output: .*", f"output: {output}", still))
            self.preview("small.yaml")
            for ping in report_of(self.page)["pings"]:
                self.assertIsNotNone(ping["pictures"]["level"])
                self.assertIsNotNone(ping["pictures"]["labels"])

    def test_a_sequence_of_drawn_worlds(self):
        drawn = SMALL.replace("[7, 7, 2]", "[{uniform: [6.5, 7]}, 7, 2]") + "sequences: 4\n"
        self.scenario.write_text(drawn)
        told = self.preview("small.yaml", "--sequence", 2).stderr
        self.assertIn("of sequence 2 of 4", told)
        report = report_of(self.page)
        [sequence] = report["sequences"]
        self.assertEqual(sequence["sequence"], 2)
        data = self.generate("--sequences", "2:3")
        stored = json.loads((data / "sequences" / "000002" / "sequence.json").read_text())
        [value] = sequence["draws"].values()
        self.assertIn(str(value)[:6], json.dumps(stored))
        refused = self.preview("small.yaml", "--sequence", 4, status=2).stderr
        self.assertIn("--sequence 4: the scenario has sequences 0 to 3", refused)

    def test_quiet(self):
        result = self.preview("small.yaml", "--quiet", "-o", "other.html")
        self.assertEqual(result.stderr + result.stdout, "")
        self.assertEqual(self.files(), ["other.html", "small.yaml"])


class Failures(Case):
    def test_faults_of_the_scenario(self):
        self.scenario.write_text(SMALL.replace("range_max_m", "range_mx_m"))
        self.assertIn("small.yaml:7:3: sonar.range_mx_m",
                      self.preview("small.yaml", status=2).stderr)
        self.scenario.write_text(SMALL.replace("range_max_m: 4", "range_max_m: 1") +
                                 "noise: {snr_db: 20}\n")
        self.assertIn("noise.snr_db", self.preview("small.yaml", status=2).stderr)
        (self.folder / "bad.stl").write_text("nothing")
        self.scenario.write_text(SMALL.replace("box: {size_m: [7, 7, 2], inward_facing: true}",
                                               "mesh: {file: bad.stl}"))
        self.assertIn("small.yaml:12:", self.preview("small.yaml", status=2).stderr)
        self.assertEqual(self.files(), ["bad.stl", "small.yaml"])
        self.assertIn("gone.yaml", self.preview("gone.yaml", "--watch", status=2).stderr)

    def test_another_file_is_not_replaced_and_a_page_is(self):
        self.page.write_text("<html>mine</html>")
        self.assertIn("small_preview.html", self.preview("small.yaml", status=2).stderr)
        self.assertEqual(self.page.read_text(), "<html>mine</html>")
        self.preview("small.yaml", "--watch", status=2)
        self.preview("small.yaml", "-o", "small.yaml", status=2)
        self.assertEqual(self.scenario.read_text(), SMALL)
        self.page.unlink()
        self.preview("small.yaml")
        self.page.chmod(0o644)
        self.preview("small.yaml", "--pings", 1)
        self.assertEqual(len(report_of(self.page)["pings"]), 1)

    def test_no_folder_for_the_page_or_for_what_is_temporary(self):
        self.preview("small.yaml", "-o", "small.yaml/page.html", status=4)
        self.temporary.rmdir()
        result = subprocess.run([PROGRAM, "preview", "small.yaml"], capture_output=True,
                                **self.options)
        self.assertEqual(result.returncode, 4)
        self.assertIn("TMPDIR", result.stderr)
        self.temporary.mkdir()
        self.assertEqual(self.files(), ["small.yaml"])

    def test_signals_leave_nothing(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen(
                [PROGRAM, "preview", "small.yaml", "--full", "--quiet", "--pings", "200",
                 "--set", "trajectory={ping_rate_hz: 1, pings: 200}"],
                stderr=subprocess.PIPE, **self.options)
            while not list(self.temporary.glob("*/.work/sequences/*/*")):
                self.assertIsNone(process.poll(), "done before it was interrupted")
                time.sleep(0.005)
            process.send_signal(number)
            _, told = process.communicate(timeout=1200)
            self.assertEqual(process.returncode, 130, told)
            self.assert_nothing_left()
            self.assertEqual(self.files(), ["small.yaml"])


class Watched(Case):
    """`--watch` at work on a scenario with a mesh in it."""

    def setUp(self):
        super().setUp()
        self.mesh = self.folder / "rock.obj"
        self.mesh.write_text(TETRAHEDRON.format(2))
        self.with_mesh = SMALL.replace(
            "trajectory:", "  - {name: rock, material: m, shape: {mesh: {file: rock.obj}}}\ntrajectory:")
        self.told = []

    def start(self):
        process = subprocess.Popen([PROGRAM, "preview", "small.yaml", "--watch", "--pings", "1"],
                                   stderr=subprocess.PIPE, **self.options)
        listener = threading.Thread(target=lambda: self.told.extend(process.stderr))
        listener.start()

        def end():
            process.kill()
            process.wait()
            listener.join()
            process.stderr.close()

        self.addCleanup(end)
        self.process, self.listener = process, listener

    def await_lines(self, count, text):
        """Waits until so many of the lines on stderr hold the text."""
        deadline = time.monotonic() + 1200  # ends what hangs, and is no measure
        while sum(text in line for line in self.told) < count:
            self.assertIsNone(self.process.poll(), self.told)
            self.assertLess(time.monotonic(), deadline, f"no {count} x {text!r} in {self.told}")
            time.sleep(0.02)

    def replace(self, file, text):
        """As many editors write: another file takes the name."""
        new = file.with_name(file.name + "~")
        new.write_text(text)
        os.replace(new, file)

    def names(self):
        return [instance["name"] for instance in report_of(self.page)["sequences"][0]["instances"]]

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        self.assertEqual(self.process.wait(1200), 130)
        self.listener.join()
        self.assert_nothing_left()

    def test_a_page_that_follows_scenario_and_mesh(self):
        self.scenario.write_text(self.with_mesh)
        self.start()
        self.await_lines(1, "small_preview.html")
        self.assertEqual(self.names(), ["room", "rock"])
        first = self.page.read_bytes()
        self.scenario.write_text(self.with_mesh.replace("name: rock", "name: stone"))
        self.await_lines(1, "again in")
        self.assertEqual(self.names(), ["room", "stone"])
        self.replace(self.scenario, self.with_mesh)
        self.await_lines(2, "again in")
        self.assertEqual(self.page.read_bytes(), first)
        self.mesh.write_text(TETRAHEDRON.format(2.5))
        self.await_lines(3, "again in")
        second = self.page.read_bytes()
        self.assertNotEqual(second, first)
        # Of the same size, and as old.
        stamp = self.mesh.stat()
        new = self.folder / "new.obj"
        new.write_text(TETRAHEDRON.format(1.5))
        os.utime(new, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
        os.replace(new, self.mesh)
        self.await_lines(4, "again in")
        self.assertNotEqual(self.page.read_bytes(), second)
        self.stop()
        self.assertEqual(sum("small_preview.html" in line for line in self.told), 1)
        self.assertEqual(self.files(), ["rock.obj", "small.yaml", "small_preview.html"])

    def test_nothing_is_rendered_for_nothing(self):
        self.start()
        self.await_lines(1, "small_preview.html")
        self.mesh.write_text(TETRAHEDRON.format(1))
        (self.folder / "other.yaml").write_text(SMALL)
        time.sleep(1.5)
        self.assertEqual([line for line in self.told if "again in" in line], [])
        self.stop()

    def test_faults_are_told_and_waited_out(self):
        self.mesh.unlink()
        self.scenario.write_text(self.with_mesh)
        self.start()
        self.await_lines(1, "rock.obj")
        self.assertFalse(self.page.exists())
        # No file that the program knows has changed; one that it missed is there.
        self.mesh.write_text(TETRAHEDRON.format(2))
        self.await_lines(1, "small_preview.html")
        page = self.page.read_bytes()
        self.scenario.write_text(self.with_mesh.replace("range_max_m: 4", "range_max_m: -4"))
        self.await_lines(1, "sonar.range_max_m")
        self.assertEqual(self.page.read_bytes(), page)
        self.scenario.write_text(self.with_mesh)
        self.await_lines(1, "again in")
        self.mesh.write_text("nothing")
        self.await_lines(1, "objects.1.shape.mesh.file")
        self.assertEqual(self.page.read_bytes(), page)
        self.mesh.write_text(TETRAHEDRON.format(2))
        self.await_lines(2, "again in")
        self.assertEqual(self.page.read_bytes(), page)
        self.stop()

    def test_a_reader_never_sees_a_part_of_a_page(self):
        self.scenario.write_text(self.with_mesh)
        self.start()
        self.await_lines(1, "small_preview.html")
        for turn in range(3):
            self.scenario.write_text(self.with_mesh.replace("seed: 7", f"seed: {turn}"))
            while sum("again in" in line for line in self.told) <= turn:
                report_of(self.page)
                self.assertIsNone(self.process.poll(), self.told)
                time.sleep(0.002)
            self.assertEqual(report_of(self.page)["seed"], turn)
        self.stop()


if __name__ == "__main__":
    unittest.main()
