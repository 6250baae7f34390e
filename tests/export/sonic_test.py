"""sonic: images and poses against the data set, and which pings are pairs."""
import unittest

import numpy as np

import exported
import matrices

# 25 degrees from ping to ping, of which 30 to each side are seen.
TURNING = ("--set", "trajectory.poses=[{time_s: 0, position_m: [0, 0, 0]}, "
                    "{time_s: 1, position_m: [0, 0, 0], rotation_deg: [0, 0, 100]}]",
           "--set", "trajectory.pings=5")


def lines(path):
    return [line.split(" ") for line in path.read_text().splitlines()]


def sees(head, pose, point):
    """Whether a point of the world lies in the fan, by the inverse matrix."""
    x, y, z, _ = np.linalg.inv(pose) @ np.append(point, 1)
    sonar = head["sonar"]
    r = np.sqrt(x * x + y * y + z * z)
    half_fan = 0.5 * sonar["elevation"]["fan_rad"]
    half_fov = 0.5 * sonar["beams"]["count"] * sonar["beams"]["spacing_rad"]
    return (sonar["range_min_m"] <= r <= sonar["range_max_m"] and abs(np.arctan2(y, x)) <= half_fov and
            abs(np.arcsin(z / r)) <= half_fan)


class Sonic(exported.Case):
    format_name = "sonic"

    def test_images_lie_as_the_reader_turns_them(self):
        """SONIC flips both axes; then rows go from far to near, columns from port to starboard."""
        out = exported.export("sonic", "--full-scale-db", "120")
        for sequence in exported.sequences():
            for ping in sequence.pings:
                turned = np.flip(np.load(out / f"images/{sequence.number:06}/{ping:06}.npy"))
                self.assertEqual(turned.dtype, np.float32)
                level = matrices.level_db(sequence, ping)[::-1, ::-1]
                np.testing.assert_allclose(turned, np.minimum(1, 10 ** ((level - 120) / 20)), rtol=1e-6)
                pose = np.load(out / f"poses/{sequence.number:06}/{ping:06}.npy")
                np.testing.assert_allclose(pose, matrices.of_pose(sequence.pose(ping)), atol=1e-12)

    def pairs(self, out, split):
        end = "" if split == "train" else f"_{split}"
        images, poses = lines(out / f"logs/pairs{end}.txt"), lines(out / f"logs/pairs_pos{end}.txt")
        self.assertEqual([[name.replace("images/", "poses/") for name in line] for line in images], poses)
        for name in sum(images + poses, []):
            self.assertTrue((out / name).is_file(), name)
        return images

    def test_pairs_see_the_middle_of_each_other(self):
        source = exported.dataset(*TURNING)
        out = exported.export("sonic", source=source)
        found = {True: 0, False: 0}
        for sequence in exported.sequences(source):
            pairs = self.pairs(out, sequence.split)
            poses = {p: matrices.of_pose(sequence.pose(p)) for p in sequence.pings}
            sonar = sequence.head["sonar"]
            middle = [0.5 * (sonar["range_min_m"] + sonar["range_max_m"]), 0, 0, 1]
            for a in sequence.pings:
                for b in range(a + 1, sequence.pings.stop):
                    both = (sees(sequence.head, poses[a], (poses[b] @ middle)[:3]) and
                            sees(sequence.head, poses[b], (poses[a] @ middle)[:3]))
                    names = [f"images/{sequence.number:06}/{p:06}.npy" for p in (a, b)]
                    self.assertEqual(names in pairs, bool(both), names)
                    found[bool(both)] += 1
        self.assertTrue(found[True] and found[False], found)

    def test_splits_without_a_sequence_have_no_list(self):
        out = exported.export("sonic")
        splits = {sequence.split for sequence in exported.sequences()}
        names = {"train": "pairs.txt", "val": "pairs_val.txt"}
        expected = sorted(name for split in splits for name in (names[split], names[split].replace("pairs", "pairs_pos")))
        self.assertEqual(sorted(path.name for path in (out / "logs").iterdir()), expected)


if __name__ == "__main__":
    unittest.main()
