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

    def test_clean_cartesian_images_are_means_of_clean_polar_ones(self):
        """Beyond 1.5 m a footprint is less than 9 samples and 5 beams: its mean lies between their extremes."""
        polar_out, out = exported.export("pairs", "--view", "polar"), exported.export("pairs")
        outside = {"clean": [], "noisy": []}
        for sequence in exported.sequences():
            pixel = sequence.npy("cartesian_map.npy")
            rows, columns = np.divmod(pixel, len(sequence.npy("azimuth_rad.npy")))
            name = f"{sequence.number:06}_000001.png"
            polar = read_png(polar_out / sequence.split / "clean" / name)
            padded = np.pad(polar, ((4, 4), (2, 2)), mode="edge")
            window = np.lib.stride_tricks.sliding_window_view(padded, (9, 5))
            low, high = window.min(axis=(2, 3)), window.max(axis=(2, 3))
            far = (pixel >= 0) & (sequence.npy("range_m.npy")[rows] > 1.5)
            for folder, shares in outside.items():
                gray = read_png(out / sequence.split / folder / name)[far].astype(int)
                at = rows[far], columns[far]
                shares.append(np.mean((gray < low[at].astype(int) - 1) | (gray > high[at].astype(int) + 1)))
        self.assertEqual(max(outside["clean"]), 0)
        self.assertGreater(max(outside["noisy"]), 0.001, "the noisy image would pass, too")

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
