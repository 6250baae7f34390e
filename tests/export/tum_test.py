"""tum: each trajectory against poses.csv and objects.csv, number by number."""
import unittest

import exported


def rows(path):
    return [[float(word) for word in line.split(" ")] for line in path.read_text().splitlines()]


class Tum(exported.Case):
    format_name = "tum"

    def test_the_sonar_is_poses_tum(self):
        out = exported.export("tum")
        for sequence in exported.sequences():
            self.assertEqual((out / f"{sequence.number:06}/sonar.txt").read_text(),
                             (sequence.folder / "poses.tum").read_text())

    def test_every_object_at_every_ping(self):
        out = exported.export("tum")
        names = {1: "00001_room", 2: "00002_ball_1", 3: "00003_pole"}
        moved = False
        for sequence in exported.sequences():
            folder = out / f"{sequence.number:06}/objects"
            self.assertEqual(sorted(p.name for p in folder.iterdir()), [n + ".txt" for n in names.values()])
            for instance, name in names.items():
                table = [row for row in sequence.objects if int(row["instance"]) == instance]
                expected = [[float(sequence.poses[int(row["ping"])]["time_s"])] +
                            [float(row[key]) for key in ("x", "y", "z", "qx", "qy", "qz", "qw")]
                            for row in table]
                self.assertEqual(rows(folder / f"{name}.txt"), expected)
                moved = moved or expected[0][1:] != expected[-1][1:]
        self.assertTrue(moved, "nothing moved: the times would not be tested")


if __name__ == "__main__":
    unittest.main()
