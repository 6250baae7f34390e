"""Scenes with drawn worlds, from outside: valid, countable, and each sequence made again alone.

ENSONIFY is the program, SCENES the folder of scenes.
"""
import csv
import json
import math
import pathlib
import tempfile
import unittest

import program
from program import SCENES

SMALL = ["--set", "sonar.beams.count=96", "--set", "sonar.rays.elevation=40", "--set", "trajectory.pings=1",
         "--set", "output={cartesian: false}"]


def run(*arguments):
    result = program.run(*arguments)
    assert result.returncode == 0, result.stderr


def rotated(quaternion, v):
    """v turned by a unit quaternion w, x, y, z."""
    w, (x, y, z) = quaternion[0], quaternion[1:]
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]]


def in_sonar_frame(sonar, position):
    """(azimuth in degrees, elevation in degrees, range) of a point of the world."""
    pose = [float(sonar[k]) for k in ("x", "y", "z", "qw", "qx", "qy", "qz")]
    difference = [p - s for p, s in zip(position, pose[:3])]
    x, y, z = rotated([pose[3], -pose[4], -pose[5], -pose[6]], difference)
    r = math.sqrt(x * x + y * y + z * z)
    return math.degrees(math.atan2(y, x)), math.degrees(math.asin(z / r)), r


class Debris(unittest.TestCase):
    """20 sequences of random_debris, drawn anew each."""

    COUNT = 20

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name) / "debris"
        run("generate", SCENES / "random_debris.yaml", "-o", cls.folder, "--quiet", "--set",
            f"sequences={cls.COUNT}", *SMALL)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def sequence(self, number):
        return self.folder / f"sequences/{number:06}"

    def test_every_sequence_is_whole(self):
        run("verify", self.folder)
        self.assertEqual(len(list((self.folder / "sequences").iterdir())), self.COUNT)

    def test_worlds_differ_and_class_ids_do_not(self):
        heads = [json.loads((self.sequence(s) / "sequence.json").read_text()) for s in range(self.COUNT)]
        self.assertEqual(len({json.dumps(head["draws"]) for head in heads}), self.COUNT)
        self.assertEqual(len({json.dumps(head["classes"]) for head in heads}), 1)
        numbers = {len(head["instances"]) for head in heads}
        self.assertGreater(len(numbers), 5)

    def test_things_rest_on_the_seabed_apart_from_each_other(self):
        """Seen from above the origins of two things of one sequence are never in the same place."""
        for s in range(self.COUNT):
            with open(self.sequence(s) / "objects.csv", newline="") as file:
                places = [(float(row["x"]), float(row["y"])) for row in csv.DictReader(file)
                          if row["instance"] != "1"]
            for i, a in enumerate(places):
                for b in places[:i]:
                    self.assertGreater(math.dist(a, b), 0.05)

    def test_the_masks_hold_the_things_in_the_fan(self):
        """Whatever lies well inside the fan has a mask, but for what others hide or speckle-free sand
        outshines; what is outside has none."""
        coco = json.loads((self.folder / "coco.json").read_text())
        images = {image["id"]: image["sequence"] for image in coco["images"] if image["view"] == "polar"}
        masked = {(images[a["image_id"]], a["instance_id"]) for a in coco["annotations"]
                  if a["image_id"] in images}
        inside = found = 0
        for s in range(self.COUNT):
            with open(self.sequence(s) / "poses.csv", newline="") as file:
                sonar = next(csv.DictReader(file))
            with open(self.sequence(s) / "objects.csv", newline="") as file:
                for row in csv.DictReader(file):
                    if row["instance"] == "1":
                        continue
                    place = [float(row[k]) for k in "xyz"]
                    azimuth, elevation, r = in_sonar_frame(sonar, place)
                    seen = (s, int(row["instance"])) in masked
                    if abs(azimuth) > 60 or r > 9.5:
                        self.assertFalse(seen, (s, row))
                    if abs(azimuth) < 35 and -12 < elevation < 12 and r < 7:
                        inside += 1
                        found += seen
        self.assertGreater(inside, 40)
        self.assertGreater(found / inside, 0.9, f"{found} of {inside}")


class Wreck(unittest.TestCase):
    """wreck_survey: the mask of the wreck against the corners of its mesh."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name) / "wreck"
        run("generate", SCENES / "wreck_survey.yaml", "-o", cls.folder, "--quiet",
            "--pings", "0:10", "--set", "sonar.beams.count=96", "--set", "sonar.rays.elevation=96",
            "--set", "output={cartesian: false}")
        cls.sequence = cls.folder / "sequences/000000"
        cls.head = json.loads((cls.sequence / "sequence.json").read_text())

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def rows(self, name):
        with open(self.sequence / name, newline="") as file:
            return list(csv.DictReader(file))

    def corners(self, wreck):
        pose = [float(wreck[k]) for k in ("x", "y", "z", "qw", "qx", "qy", "qz")]
        lines = (SCENES / "meshes/wreck.obj").read_text().splitlines()
        points = [[float(v) for v in line.split()[1:]] for line in lines if line.startswith("v ")]
        return [[p + r for p, r in zip(pose[:3], rotated(pose[3:], point))] for point in points]

    def test_the_mask_lies_where_the_mesh_is(self):
        ids = {instance["name"]: instance["id"] for instance in self.head["instances"]}
        wreck = next(row for row in self.rows("objects.csv") if int(row["instance"]) == ids["wreck"])
        corners = self.corners(wreck)
        step = self.head["record"]["range_step_m"]
        sonars = {int(row["ping"]): row for row in self.rows("poses.csv")}
        coco = json.loads((self.folder / "coco.json").read_text())
        images = {image["id"]: image for image in coco["images"] if image["view"] == "polar"}
        boxes = 0
        for annotation in coco["annotations"]:
            if annotation["instance_id"] != ids["wreck"] or annotation["area"] < 50:
                continue
            image = images[annotation["image_id"]]
            seen = [in_sonar_frame(sonars[image["ping"]], corner) for corner in corners]
            _, top, _, height = annotation["bbox"]
            near, far = min(r for _, _, r in seen), max(r for _, _, r in seen)
            # A pixel hears echoes within a sample of it.
            self.assertGreaterEqual((top + 1) * step, near - step)
            self.assertLessEqual((top + height - 1) * step, far + 2 * step)
            boxes += 1
        self.assertGreaterEqual(boxes, 3)

    def test_all_that_was_counted_is_there(self):
        names = [instance["name"] for instance in self.head["instances"]]
        self.assertEqual(names, ["seabed", "wreck", "propeller"] + [f"block_{i}" for i in range(6)])


if __name__ == "__main__":
    unittest.main()
