"""pairs: noisy images are those of the data set; clean ones show clean_db by the formula of docs/dataset.md."""
import unittest

import numpy as np

import exported
import matrices
from sonar_dataset import read_png


def shown(sequence, level_db):
    """The display of the scenario's default: linear in dB between two limits."""
    black, white = sequence.head["png"]["db"]
    gray = 255 * (level_db - black) / (white - black)
    return np.where(level_db <= -99, 0, np.clip(gray, 0, 255))


class Pairs(exported.Case):
    format_name = "pairs"

    def files(self, out, folder):
        return {path.name: path for path in out.glob(f"*/{folder}/*.png")}

    def test_names_are_equal(self):
        out = exported.export("pairs")
        noisy, clean = self.files(out, "noisy"), self.files(out, "clean")
        self.assertEqual(sorted(noisy), sorted(clean))
        names = [f"{s.number:06}_{ping:06}.png" for s in exported.sequences() for ping in s.pings]
        self.assertEqual(sorted(noisy), names)
        for sequence in exported.sequences():
            for ping in sequence.pings:
                name = f"{sequence.split}/noisy/{sequence.number:06}_{ping:06}.png"
                self.assertEqual((out / name).read_bytes(),
                                 (sequence.folder / f"png/{ping:06}_cartesian.png").read_bytes())

    def test_clean_polar_images(self):
        out = exported.export("pairs", "--view", "polar")
        for sequence in exported.sequences():
            for ping in sequence.pings:
                clean = read_png(out / f"{sequence.split}/clean/{sequence.number:06}_{ping:06}.png")
                level = np.asarray(matrices.ping_of(sequence, ping).polar.clean_db, dtype=np.float64)
                self.assertGreater(clean.std(), 10)
                self.assertLessEqual(np.abs(clean - shown(sequence, level)).max(), 0.5 + 1e-3)

    def test_clean_cartesian_images_of_nearest_pixels(self):
        source = exported.dataset("--set", "output.png={resampling: nearest}", "--set", "trajectory.pings=2")
        polar = exported.export("pairs", "--view", "polar", source=source)
        cartesian = exported.export("pairs", source=source)
        for sequence in exported.sequences(source):
            pixel = sequence.npy("cartesian_map.npy")
            name = f"{sequence.split}/clean/{sequence.number:06}_000001.png"
            expected = np.where(pixel < 0, 0, read_png(polar / name).ravel()[pixel])
            np.testing.assert_array_equal(read_png(cartesian / name), expected)

    def test_clean_cartesian_images_have_no_speckle(self):
        """Smooth against azimuth: the median step between neighbors is far below that of the noisy image."""
        out = exported.export("pairs")
        steps = {"noisy": [], "clean": []}
        for folder, all_steps in steps.items():
            for path in self.files(out, folder).values():
                gray = read_png(path).astype(float)
                both = (gray[:, 1:] > 0) & (gray[:, :-1] > 0)
                all_steps.append(np.mean(np.abs(np.diff(gray, axis=1))[both]))
        self.assertLess(np.mean(steps["clean"]), 0.7 * np.mean(steps["noisy"]))

    def test_an_automatic_gain_is_that_of_the_noisy_image(self):
        source = exported.dataset("--set", "output.png={automatic_gain: true}", "--set", "trajectory.pings=1")
        out = exported.export("pairs", "--view", "polar", source=source)
        for sequence in exported.sequences(source):
            polar = matrices.ping_of(sequence, 0).polar
            level = np.asarray(polar.level_db, dtype=np.float64)
            heard = np.sort(level[level > -99])
            gain = sequence.head["png"]["db"][1] - heard[int(0.995 * (heard.size - 1))]
            clean = read_png(out / f"{sequence.split}/clean/{sequence.number:06}_000000.png")
            expected = shown(sequence, np.asarray(polar.clean_db, dtype=np.float64) + gain)
            expected[np.asarray(polar.clean_db) <= -99] = 0
            self.assertLessEqual(np.abs(clean - expected).max(), 0.5 + 1e-3)

    def test_without_the_levels(self):
        bare = exported.dataset("--set", "output={polar: false, timeseries: none}", "--set", "trajectory.pings=1")
        result = exported.run("export", bare, "--format", "pairs", "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 2)
        self.assertIn("output.polar", result.stderr)


if __name__ == "__main__":
    unittest.main()
