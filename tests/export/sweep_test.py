"""All runs of a sweep as one data set, with the values of their axes, or each in a folder of its own."""
import csv
import json
import shutil
import tarfile
import unittest

from exported import hashes, run, scratch
from program import swept


def export(sweep, format_name, *options, status=0):
    out = scratch() / "out"
    done = run("export", sweep, "--format", format_name, "-o", out, *options)
    assert done.returncode == status, done.stderr
    return out, done.stderr


class Sweep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sweep = swept()
        cls.plan = [json.loads(line) for line in (cls.sweep / "plan.jsonl").read_text().splitlines()]
        cls.names = [line["run"] + "_000000_000000" for line in cls.plan]

    def records(self, records):
        """Of all runs in order."""
        self.assertEqual([(one["run"], one["axes"]) for one in records],
                         [(line["run"], line["values"]) for line in self.plan])

    def test_coco_has_all_runs_with_the_values_of_their_axes(self):
        out, said = export(self.sweep, "coco", "--view", "polar")
        self.assertIn("8 pings of 8 sequences of 8 runs as coco", said)
        coco = json.loads((out / "annotations/instances_train.json").read_text())
        self.records(coco["images"])
        self.assertEqual([image["id"] for image in coco["images"]], list(range(1, 9)))
        for image, line, name in zip(coco["images"], self.plan, self.names):
            self.assertEqual(image["file_name"], name + ".png")
            made = self.sweep / "runs" / line["run"] / "sequences/000000"
            png = (out / "images/train" / image["file_name"]).read_bytes()
            self.assertEqual(png, next((made / "png").glob("*polar*")).read_bytes())
            annotated = json.loads((made / "annotations.jsonl").read_text())["images"][0]["annotations"]
            areas = [one["area"] for one in coco["annotations"] if one["image_id"] == image["id"]]
            self.assertEqual(areas, [one["area"] for one in annotated if one["instance"] == 2])
        self.assertEqual((out / "runs.csv").read_bytes(), (self.sweep / "runs.csv").read_bytes())
        self.assertEqual(hashes(export(self.sweep, "coco", "--view", "polar")[0]), hashes(out))

    def test_records_of_other_formats(self):
        panoptic, _ = export(self.sweep, "coco_panoptic", "--view", "polar")
        self.records(json.loads((panoptic / "annotations/panoptic_train.json").read_text())["images"])
        shards, _ = export(self.sweep, "webdataset", "--view", "polar")
        with tarfile.open(shards / "train-000000.tar") as tar:
            self.records([json.load(tar.extractfile(name + ".json")) for name in self.names])
        sdpr, _ = export(self.sweep, "sdpr")
        rows = list(csv.DictReader((sdpr / "train/pings.csv").read_text().splitlines()))
        self.assertEqual([(row["number"], row["run"]) for row in rows],
                         [(str(k), line["run"]) for k, line in enumerate(self.plan)])
        yolo, _ = export(self.sweep, "yolo", "--view", "polar")
        self.assertEqual(sorted(path.stem for path in (yolo / "labels/train").iterdir()), sorted(self.names))

    def test_other_formats_have_a_folder_or_file_of_each_run(self):
        tum, said = export(self.sweep, "tum")
        self.assertIn("8 pings of 8 sequences of 8 runs", said)
        hdf5, _ = export(self.sweep, "hdf5")
        for line in self.plan:
            alone, _ = export(self.sweep / "runs" / line["run"], "tum")
            self.assertEqual(hashes(tum / line["run"]), hashes(alone))
            self.assertTrue((hdf5 / (line["run"] + ".h5")).read_bytes().startswith(b"\x89HDF"))

    def test_what_is_not_done_or_does_not_fit_together(self):
        sweep = shutil.copytree(self.sweep, scratch() / "sweep")
        (sweep / "runs.csv").unlink()
        self.assertIn("--finalize --partial", export(sweep, "coco", status=2)[1])
        shutil.rmtree(sweep / "runs" / self.plan[0]["run"])
        done = run("sweep", "none.yaml", "-o", sweep, "--finalize", "--partial")
        self.assertEqual(done.returncode, 0, done.stderr)
        out, said = export(sweep, "yolo", "--view", "polar")
        self.assertIn("warning: 1 run of the sweep is not done and left out", said)
        self.assertEqual(len(list((out / "labels/train").iterdir())), 7)
        self.assertIn("missing", (out / "runs.csv").read_text())
        self.assertIn("not an option of --format coco", export(sweep, "coco", "--stack", status=2)[1])

    def test_runs_with_other_classes_are_refused(self):
        folder = scratch()
        base = self.sweep / "runs" / self.plan[0]["run"] / "scenario.yaml"
        (folder / "s.yaml").write_text(f"ensonify_sweep: 1\nbase: {base}\naxes:\n"
                                       "  - {key: objects.ball.class, values: [ball, mine]}\n")
        self.assertEqual(run("sweep", folder / "s.yaml", "-o", folder / "out", "--quiet").returncode, 0)
        said = export(folder / "out", "coco", "--view", "polar", status=2)[1]
        self.assertRegex(said, r"has the classes .*mine.*first run has .*ball.*`classes`")
        self.assertEqual(len(list(export(folder / "out", "tum")[0].iterdir())), 3)


if __name__ == "__main__":
    unittest.main()
