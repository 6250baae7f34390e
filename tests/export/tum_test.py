"""tum: each trajectory against poses.csv and objects.csv, number by number."""
import unittest

import exported


def rows(path):
    return [[float(word) for word in line.split(" ")] for line in path.read_text().splitlines()]


BALL = """  - name: ball_{0}
    class: ball
    material: m
    shape: {{sphere: {{radius_m: 0.3}}}}
    trajectory:
      poses: [{{time_s: 0, position_m: [1.23456789, {0}.1, 0]}}, {{time_s: 900, position_m: [1.3, {0}.2, 0.3],
               rotation_deg: [10, 5, 20]}}]
"""
LONG = """ensonify: 1
name: long
sonar: {preset: paper_table1, bandwidth_hz: 3000, range_max_m: 2, beams: {count: 2, fov_deg: 2}, rays: {elevation: 2}}
materials: {m: {reflectivity: 1e-3}}
trajectory:
  poses: [{time_s: 0, position_m: [0, 0, 0]}, {time_s: 900, position_m: [0.3, 0.2, 0], rotation_deg: [0, 5, 20]}]
  ping_rate_hz: 3
  pings: 2500
output: {polar: false, cartesian: false, png: false}
objects:
""" + "".join(BALL.format(i) for i in range(20))


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

    def test_trajectories_larger_than_what_is_held(self):
        folder = exported.scratch()
        (folder / "long.yaml").write_text(LONG)
        for words in (["generate", folder / "long.yaml", "-o", folder / "set"],
                      ["export", folder / "set", "--format", "tum", "-o", folder / "tum"]):
            made = exported.run(*words, "--quiet")
            self.assertEqual(made.returncode, 0, made.stderr)
        files = sorted((folder / "tum").rglob("*.txt"))
        self.assertEqual(len(files), 21)
        self.assertGreater(sum(file.stat().st_size for file in files), 5e6)  # 4 MiB are held
        [sequence] = exported.sequences(folder / "set")
        self.assertEqual((folder / "tum/000000/sonar.txt").read_text(), (sequence.folder / "poses.tum").read_text())
        expected = [float(row["x"]) for row in sequence.objects if row["instance"] == "7"]
        self.assertEqual([row[1] for row in rows(folder / "tum/000000/objects/00007_ball_6.txt")], expected)


if __name__ == "__main__":
    unittest.main()
