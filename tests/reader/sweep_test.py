"""SonarSweep: runs by their values, what is not done, and names that are wrong. Tiny runs of one ping."""
import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import small_data
from ensonify_dataset import DatasetError, SonarDataset, SonarSweep

SCENES = small_data.SOURCE / "tests/report/scenes"
AXES = (SCENES / "sweep.yaml").read_text()


def make(folder, text, expected=0):
    (folder / "s.yaml").write_text(text)
    done = subprocess.run([small_data.PROGRAM, "sweep", folder / "s.yaml", "-o", folder / "out", "--quiet"],
                          capture_output=True, text=True)
    assert done.returncode == expected, done.stderr


class Sweep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="ensonify-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        shutil.copy(SCENES / "sweep_base.yaml", cls.folder)
        make(cls.folder, AXES)

    def setUp(self):
        self.sweep = SonarSweep(self.folder / "out")

    def refused(self, *words, call):
        with self.assertRaises(DatasetError) as caught:
            call()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_runs_are_found_by_axis_by_key_and_by_its_last_part(self):
        everything = [run.run for run in self.sweep]
        self.assertEqual([line["run"] for line in self.sweep.table], everything)
        self.assertEqual(self.sweep.axes, {"f": [400e3, 550e3], "pings": [2, 3], "bottom": ["soft", "<b>hard</b>"]})
        for conditions, chosen in [({"f": 550e3}, [4, 5, 6, 7]), ({"frequency_hz": 550000}, [4, 5, 6, 7]),
                                   ({"sonar.frequency_hz": [400e3]}, [0, 1, 2, 3]),
                                   ({"frequency_hz": [400e3, 550e3], "range_max_m": 2}, [0, 1, 4, 5]),
                                   ({"material": "rock", "pings": 3}, [3, 7]), ({"bottom": {"soft"}}, [0, 2, 4, 6]),
                                   ({"position_m": [1, 0, 0], "f": 4e5}, [1, 3]), ({"radius_m": 0.2, "f": 4e5}, [1, 3]),
                                   ({"f": lambda f: f > 5e5, "status": "done"}, [4, 5, 6, 7])]:
            selected = self.sweep.select(**conditions)
            self.assertEqual([run.run for run in selected], [everything[k] for k in chosen], conditions)
            self.assertEqual(len(selected), len(chosen))

    def test_a_run_is_a_data_set_with_its_values(self):
        run = self.sweep.run(5)
        self.assertEqual(run.values, {"f": 550e3, "pings": 2, "bottom": "<b>hard</b>"})
        self.assertEqual(run.settings["objects.bed.material"], "rock")
        told = json.loads((run.folder / "sequences/000000/sequence.json").read_text())
        self.assertEqual((told["sonar"]["frequency_hz"], run.sequence(0).info), (550e3, told))
        loudest = run[0].polar.level_db.max()
        self.assertAlmostEqual(run.row["max_level_db"], loudest, delta=0.1)
        self.assertEqual((run.row["pings"], run.row["axis_pings"], len(run)), (1, 2, 1))
        self.assertEqual([self.sweep.run(which).run for which in (run.run, run.run[:9], run.row["name"])], [run.run] * 3)

    def test_wrong_names_and_values_are_told_with_what_there_is(self):
        for words, conditions in [(("frequency_hz", "did you mean"), {"frequncy_hz": 4e5}),
                                  (("did you mean rock", "sand, rock"), {"material": "rok"}),
                                  (("frequency_hz = 410000", "400000.0, 550000.0"), {"frequency_hz": 410000}),
                                  (("expected an axis (f, pings, bottom) or a key (", "objects.bed.material"), {"x": 1})]:
            self.refused(*words, call=lambda: self.sweep.select(**conditions))
        self.refused("no run is 'f=4'", call=lambda: self.sweep.run("f=4"))
        self.refused("open it as SonarSweep", call=lambda: SonarDataset(self.folder / "out"))
        self.refused("not the folder of a sweep", call=lambda: SonarSweep(self.sweep.run(0).folder))

    def test_what_is_not_done_is_named(self):
        folder = shutil.copytree(self.folder, self.folder / "grown")
        (folder / "bad.obj").write_text("# no faces\n")
        grown = AXES.replace("  - name: bottom", "  - {key: sonar.beams.count, values: [8, 12]}\n  - name: bottom")
        grown = grown.replace("</b>]", "</b>, bad]")
        make(folder, grown + "      - objects.ball.shape: {mesh: {file: bad.obj}}\n", expected=3)
        lost = self.sweep.table[0]["run"]
        shutil.rmtree(folder / "out/runs" / lost)
        sweep = SonarSweep(folder / "out")
        self.assertEqual(len(sweep), 24)
        self.assertEqual([row["status"] for row in sweep.unfinished].count("failed"), 8)
        self.refused("9 of 24 runs are not done", f"{lost} f=400e3,", "missing", "bad.obj", "and 4 more",
                     call=lambda: iter(sweep))
        self.refused("missing", call=lambda: sweep.run(lost))
        self.assertEqual(len(list(sweep.select(status="done"))), 15)
        self.refused("did you mean done", call=lambda: sweep.select(status="dne"))
        self.assertEqual([row["max_level_db"] for row in sweep.select(count=8, status="done").table], [None] * 7)

    def test_a_part_that_two_keys_share_is_ambiguous(self):
        self.sweep.settings[self.sweep.table[0]["run"]]["objects.ball.material"] = "rock"
        self.refused("objects.ball.material", "objects.bed.material", "select(**{",
                     call=lambda: self.sweep.select(material="rock"))


if __name__ == "__main__":
    unittest.main()
