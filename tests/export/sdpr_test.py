"""sdpr: images against the 8-bit polar images, poses against poses.csv."""
import csv
import unittest

import numpy as np
from PIL import Image

import exported


class Sdpr(exported.Case):
    format_name = "sdpr"

    def test_images_and_poses(self):
        out = exported.export("sdpr")
        sequences = {sequence.number: sequence for sequence in exported.sequences()}
        seen = 0
        for split in {sequence.split for sequence in sequences.values()}:
            with open(out / split / "pings.csv", newline="") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual([int(row["number"]) for row in rows], list(range(len(rows))))
            for row in rows:
                sequence, ping = sequences[int(row["sequence"])], int(row["ping"])
                self.assertEqual(sequence.split, split)
                image = np.asarray(Image.open(out / split / f"imgs/{row['number']}.jpeg")).astype(int)
                # Port on the left. JPEG changes the pixels a little, a flip changes most of them.
                own = sequence.png("png", ping, "_polar").astype(int)
                self.assertLess(np.mean(np.abs(image - own[:, ::-1])), 3)
                self.assertGreater(np.mean(np.abs(image - own)), 6)
                position, rotation = (out / split / f"poses/{row['number']}.txt").read_text().splitlines()
                x, y, z, qw, qx, qy, qz = sequence.pose(ping)
                self.assertEqual([float(n) for n in position.split(" ")], [x, y, z])
                self.assertEqual([float(n) for n in rotation.split(" ")], [qx, qy, qz, qw])
                seen += 1
        self.assertEqual(seen, sum(len(sequence.pings) for sequence in sequences.values()))


if __name__ == "__main__":
    unittest.main()
