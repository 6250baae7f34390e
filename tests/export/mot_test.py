"""mot: images, boxes and tracks against the data set as the Python reader shows it."""
import configparser
import csv
import unittest

import exported
from ensonify_dataset import SonarDataset


class Mot(exported.Case):
    format_name = "mot"

    split_of = {}

    @classmethod
    def setUpClass(cls):
        cls.split_of = {sequence.number: sequence.split for sequence in exported.sequences()}

    def tracks(self, out, ping):
        folder = out / self.split_of[ping.sequence.number] / f"{ping.sequence.number:06}"
        with open(folder / "gt/gt.txt", newline="") as file:
            return [row for row in csv.reader(file) if int(row[0]) == ping.number + 1]

    def check(self, out, view, class_ids):
        found = 0
        for ping in SonarDataset(exported.dataset()):
            images = getattr(ping, view)
            rows = self.tracks(out, ping)
            wanted = [a for a in images.annotations if a.class_id in class_ids]
            self.assertEqual([int(row[1]) for row in rows], [a.instance for a in wanted])
            for row, a in zip(rows, wanted):
                x, y, width, height = a.bbox
                self.assertEqual([int(cell) for cell in row[2:8]], [x + 1, y + 1, width, height, 1, 1])
                amodal = a.amodal_mask.sum()
                self.assertAlmostEqual(float(row[8]), a.area / amodal, places=3)
            found += len(rows)
            folder = out / self.split_of[ping.sequence.number] / f"{ping.sequence.number:06}"
            own = ping.sequence.folder / f"png/{ping.number:06}_{view}.png"
            self.assertEqual((folder / f"img1/{ping.number + 1:06}.png").read_bytes(), own.read_bytes())
        self.assertGreater(found, 0)

    def test_things(self):
        self.check(exported.export("mot"), "cartesian", {2, 3})
        self.check(exported.export("mot", "--view", "polar"), "polar", {2, 3})

    def test_chosen_objects(self):
        self.check(exported.export("mot", "--classes", "pole"), "cartesian", {3})

    def test_classes_of_tracks(self):
        out = exported.export("mot")
        for number, split in self.split_of.items():
            with open(out / split / f"{number:06}/gt/tracks.csv", newline="") as file:
                rows = list(csv.reader(file))
            self.assertEqual(rows, [["track", "class_id", "class", "name"], ["2", "2", "ball & net", "ball/1"],
                                    ["3", "3", "pole", "pole"]])

    def test_sequences(self):
        out = exported.export("mot")
        for sequence in exported.sequences():
            ini = configparser.ConfigParser()
            ini.read(out / sequence.split / f"{sequence.number:06}/seqinfo.ini")
            own = dict(ini["Sequence"])
            image = sequence.png("png", 0, "_cartesian")
            # 3 pings at 4 Hz.
            self.assertEqual(own, {"name": f"{sequence.number:06}", "imdir": "img1", "framerate": "4",
                                   "seqlength": "3", "imwidth": str(image.shape[1]),
                                   "imheight": str(image.shape[0]), "imext": ".png"})
            self.assertIn(own["name"], (out / f"seqmaps/{sequence.split}.txt").read_text().splitlines()[1:])
        self.assertEqual(sorted(path.name for path in (out / "seqmaps").iterdir()),
                         ["test.txt", "train.txt", "val.txt"])


if __name__ == "__main__":
    unittest.main()
