"""a2fnet: lists and files, read as the loader of the network reads them, against the data set's own arrays."""
import unittest

import numpy as np

import exported
from ensonify_dataset import SonarDataset, read_png


class A2fnet(exported.Case):
    format_name = "a2fnet"
    front = ("--set", "output.front=true")

    def setUp(self):
        self.source = exported.dataset(*self.front)
        self.out = exported.export("a2fnet", source=self.source)

    def test_the_same_data_set_gives_the_same_bytes(self):
        self.assertEqual(exported.hashes(self.out), exported.hashes(exported.export("a2fnet", source=self.source)))

    def test_every_ping(self):
        data = SonarDataset(self.source)
        for split in ("train", "val", "test"):
            lines = (self.out / f"label_{split}.txt").read_text().splitlines()
            pings = data.split(split)
            self.assertEqual(len(lines), len(pings))
            for line, ping in zip(lines, pings):
                image, front, front_hd, elevation = (self.out / name for name in line.split(" "))
                self.check_ping(ping, read_png(image), read_png(front), np.loadtxt(front_hd), read_png(elevation))

    def check_ping(self, ping, image, front, front_hd, elevation):
        np.testing.assert_array_equal(image, ping.polar.grey)
        r, sonar = ping.front.range_m, ping.sequence.info["sonar"]
        met = np.isfinite(r)
        self.assertTrue(met.any())
        np.testing.assert_allclose(front_hd[met], 1 / r[met], rtol=1e-5)
        self.assertFalse(front_hd[~met].any())
        near, far = 1 / max(sonar["range_min_m"], ping.sequence.info["record"]["range_step_m"]), 1 / sonar["range_max_m"]
        np.testing.assert_allclose(front, 255 * (np.where(met, 1 / r, far) - far) / (near - far), atol=0.51)
        phi = ping.polar.elevation_rad
        heard = np.isfinite(phi)
        np.testing.assert_array_equal(elevation > 0, heard)
        fan = sonar["elevation"]["fan_rad"]
        np.testing.assert_allclose(((elevation[heard] - 1.0) / 254 - 0.5) * fan, phi[heard], atol=0.51 * fan / 254)

    def test_a_data_set_without_front_views_is_an_error(self):
        result = exported.run("export", exported.dataset(), "--format", "a2fnet", "-o", exported.scratch() / "out")
        self.assertEqual(result.returncode, 2)
        self.assertIn("output.front", result.stderr)


if __name__ == "__main__":
    unittest.main()
