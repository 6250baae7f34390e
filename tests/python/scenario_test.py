"""Scenarios from Python: their sources, errors, samples, and what they say of themselves."""
import pickle
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import ensonify as en
from ensonify.dataset import SonarDataset
from small_data import SCENES, generate

DEBRIS = SCENES / "random_debris.yaml"
SMALL = {"sonar.beams.count": 24, "sonar.rays.elevation": 16, "output.cartesian": False}


class Scenarios(unittest.TestCase):
    def test_a_dict_and_a_file_are_one_scenario(self):
        scene = en.Scenario.load(SCENES / "two_cylinders.yaml", set=SMALL)
        again = en.Scenario.from_dict(scene.sample(0))
        self.assertEqual(again.sample(0), scene.sample(0))
        self.assertTrue(np.array_equal(again.ping().series, scene.ping().series))

    def test_a_sample_has_the_values_of_the_data_set(self):
        scene = en.Scenario.load(DEBRIS, set=SMALL)
        sample = scene.sample(3)
        draws = scene.ping(3, want=[]).sequence.info["draws"]
        self.assertGreater(len(draws), 10)
        self.assertEqual(sample["noise"]["spectrum_level_db"], draws["noise.spectrum_level_db"])
        sand = next(m for name, m in sample["materials"].items() if name == "sand")
        self.assertEqual(sand["reflectivity"], draws["materials.sand.reflectivity"])

    def test_all_faults_come_with_their_places(self):
        text = "ensonify: 1\nsonar: {preset: nope}\nnonsense: 1\n"
        with self.assertRaises(en.ScenarioError) as caught:
            en.Scenario.from_yaml(text)
        faults = {fault.key: fault for fault in caught.exception.faults}
        self.assertEqual((faults["sonar.preset"].line, faults["nonsense"].line), (2, 3))
        self.assertIn("oculus_m750d_hf", faults["sonar.preset"].advice)
        with self.assertRaises(en.ScenarioError) as caught:
            en.Scenario.load(DEBRIS, set={"sonar.range_max_m": -1})
        self.assertEqual([(f.file, f.key) for f in caught.exception.faults],
                         [("--set sonar.range_max_m", "sonar.range_max_m")])
        with self.assertRaises(OSError):
            en.Scenario.load("no/such/file.yaml")
        with self.assertRaises(en.ScenarioError) as caught:
            en.Scenario.load(SCENES / "two_cylinders.yaml",
                             set={"trajectory": {"file": "no_such.csv"}})
        self.assertIn("no_such.csv", str(caught.exception))

    def test_what_is_wanted_is_checked(self):
        scene = en.Scenario.load(DEBRIS, set=SMALL)
        for want, told in ((["leveldb"], "level_db"), ("level_db", "list"), (["cartesian.instance"], "output.cartesian"),
                           (["surface_range_m"], "output.surfaces"), (["channels"], "output.channels")):
            with self.assertRaisesRegex(ValueError, told):
                scene.stream(want=want)
        ping = scene.ping(want=["instance"])
        from ensonify.dataset import DatasetError
        for ask in (lambda: ping.series, lambda: ping.cartesian.instance, lambda: ping.polar.grey):
            with self.assertRaises(DatasetError):
                ask()
        with self.assertRaises(IndexError):
            scene.ping(0, 99)

    def test_generate_writes_the_programs_files(self):
        with tempfile.TemporaryDirectory() as folder:
            own, program = Path(folder) / "own", Path(folder) / "program"
            generate("random_debris", program, "--set", "sequences=2")
            settings = {"sonar.beams.count": 32, "sonar.rays.elevation": 24, "output.png": True,
                        "output.cartesian": {"height_px": 60}, "sequences": 2}
            told = []
            en.generate(en.Scenario.load(DEBRIS, set=settings), own, progress=lambda done, all: told.append((done, all)))
            self.assertEqual(told[-1], (6, 6))
            names = sorted(str(path.relative_to(program)) for path in program.rglob("*") if path.is_file())
            self.assertGreater(len(names), 20)
            self.assertEqual(names, sorted(str(p.relative_to(own)) for p in own.rglob("*") if p.is_file()))
            for name in names:
                if Path(name).name != "provenance.json":
                    self.assertEqual((own / name).read_bytes(), (program / name).read_bytes(), name)

    def test_a_run_that_its_caller_ends_goes_on(self):
        scene = en.Scenario.load(DEBRIS, set={**SMALL, "sequences": 8})

        def stop(done, _):
            if done >= 3:
                raise ZeroDivisionError

        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(ZeroDivisionError):
                en.generate(scene, Path(folder) / "set", progress=stop, threads=1)
            self.assertFalse((Path(folder) / "set/dataset.sha256").exists())
            en.generate(scene, Path(folder) / "set")
            self.assertEqual(len(SonarDataset(Path(folder) / "set")), 24)

    def test_a_scenario_can_be_pickled(self):
        scene = pickle.loads(pickle.dumps(en.Scenario.load(DEBRIS, set=SMALL)))
        self.assertEqual(scene.name, "random_debris")

    def test_the_reader_alone_loads_no_extension(self):
        code = "import sys, ensonify.dataset; print('ensonify._core' in sys.modules, 'torch' in sys.modules)"
        self.assertEqual(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout,
                         "False False\n")

    def test_notebooks_get_images_and_a_plan(self):
        scene = en.Scenario.load(DEBRIS, set=SMALL)
        ping = scene.ping(0, 0)
        page = ping._repr_html_()
        self.assertEqual(page.count("data:image/png;base64,"), 2)
        self.assertIn("seabed", page)
        plan = scene._repr_html_()
        boxes = [i for i in ping.sequence.info["instances"] if i.get("box")]
        self.assertEqual(plan.count("<polygon"), 1 + len(boxes))


if __name__ == "__main__":
    unittest.main()
