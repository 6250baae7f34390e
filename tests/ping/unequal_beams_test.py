"""Data sets of beams of unequal spacing and width: axes, manifest, place and level of a point target in polar and
Cartesian images, the series worked out again from scatterers, and what the reader and verify say."""
import json
import unittest

import numpy as np

from program import made, settings
from ensonify_dataset import SonarDataset

AZIMUTHS_DEG = np.array([-24, -21, -19, -16, -10, -6, -4, -1, 2, 8, 11, 15, 22])
WIDTHS_DEG = 2 + 0.01 * AZIMUTHS_DEG**2

SCENARIO = f"""ensonify: 1
seed: 3
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams:
    count: {len(AZIMUTHS_DEG)}
    azimuths_deg: {AZIMUTHS_DEG.tolist()}
    receive_widths_deg: {WIDTHS_DEG.round(6).tolist()}
  rays: {{elevation: 4}}
water: {{sound_speed_m_s: 1480}}
materials: {{m: {{reflectivity: 1e-3}}}}
objects:
  - {{name: room, material: m, shape: {{box: {{size_m: [5, 5, 1], inward_facing: true}}}}}}
trajectory: {{ping_rate_hz: 5, pings: 1}}
output: {{cartesian: {{height_px: 300}}, png: true, scatterers: true}}
"""
# At 2 m and 14 degrees, in the cell of the beam at 15 degrees.
TARGET = ("point_targets=[{name: tip, target_strength_db: 10, position_m: ["
          f"{2 * np.cos(np.radians(14))}, {2 * np.sin(np.radians(14))}, 0]}}]")


class UnequalBeams(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.out = made(SCENARIO, *settings(TARGET))
        cls.sequence = cls.out / "sequences/000000"
        cls.about = json.loads((cls.sequence / "sequence.json").read_text())
        cls.series = np.load(cls.sequence / "timeseries/000000.npy")

    def test_axes_and_manifest_have_each_beam(self):
        azimuths = np.load(self.sequence / "azimuth_rad.npy")
        np.testing.assert_allclose(np.degrees(azimuths), AZIMUTHS_DEG, atol=1e-12)
        beams = self.about["sonar"]["beams"]
        np.testing.assert_allclose(beams["azimuth_rad"], azimuths, atol=1e-15)
        np.testing.assert_allclose(np.degrees(beams["widths_rad"]), WIDTHS_DEG, atol=1e-6)
        self.assertAlmostEqual(np.degrees(beams["spacing_rad"]), (46 + 1.5 + 3.5) / 13)
        self.assertAlmostEqual(np.degrees(beams["width_rad"]), WIDTHS_DEG.mean(), places=5)

    def test_the_reader_makes_the_images_of_the_data_set(self):
        data = SonarDataset(self.out)
        for view in (data[0].polar, data[0].cartesian):
            np.testing.assert_array_equal(view.displayed(data.display()), view.grey)

    def test_the_series_follow_from_the_scatterers_by_the_stated_model(self):
        sonar, record, model = self.about["sonar"], self.about["record"], self.about["model"]
        self.assertIn("B(phi_beam(i) - theta_j)", model["series"])
        self.assertIn("halfway between", model["symbols"]["phi_i"])
        self.assertIn("widths_rad[j]", model["symbols"]["u"])
        f_c, b, bins = sonar["frequency_hz"], sonar["bandwidth_hz"], record["transform"]
        theta = np.array(sonar["beams"]["azimuth_rad"])
        inner = (theta[1:] + theta[:-1]) / 2
        borders = np.concatenate([[2 * theta[0] - inner[0]], inner, [2 * theta[-1] - inner[-1]]])
        phi = (borders[1:] + borders[:-1]) / 2
        x = (np.arange(bins) - bins // 2) / bins
        taper = np.where(abs(x) <= 0.4, 1, (1 + np.cos(np.pi * (abs(x) - 0.4) / 0.1)) / 2)
        pulse = np.exp(-(np.pi * x) ** 2) * taper
        pulse *= sonar["source_pressure_pa_m"] / pulse.sum()
        echoes = np.load(self.sequence / "scatterers/000000.npy")
        cells = np.zeros((len(theta), bins), complex)
        for beam in range(len(theta)):
            e = echoes[echoes["beam"] == beam]
            self.assertTrue(np.all((e["azimuth_rad"] > borders[beam] - 1e-6)
                                   & (e["azimuth_rad"] < borders[beam + 1] + 1e-6)))
            turns = np.outer(f_c + b * x, e["delay_s"])
            cells[beam] = pulse * (np.exp(-2j * np.pi * (turns % 1)) @ ((e["amp_re"] + 1j * e["amp_im"]) * e["gain"]))
        aperture = (sonar["beams"]["shading"]["aperture_wavelengths"] * sonar["beams"]["width_rad"]
                    / np.array(sonar["beams"]["widths_rad"]))
        weights = np.sinc(aperture[:, None] * np.sin(phi[None, :] - theta[:, None]))
        again = bins * np.fft.ifft(np.fft.ifftshift(weights @ cells, axes=1), axis=1)[:, :self.series.shape[1]]
        self.assertLess(abs(again - self.series).max(), 1e-5 * abs(self.series).max())

    def test_a_point_target_is_where_it_is_in_the_images(self):
        ping = SonarDataset(self.out)[0]
        polar = np.asarray(ping.polar.clean_db)
        sample, beam = np.unravel_index(polar.argmax(), polar.shape)
        self.assertEqual(beam, 11)
        self.assertLess(abs(ping.sequence.range_m[sample] - 2), 0.03)
        image, grid = np.asarray(ping.cartesian.clean_db), self.about["cartesian"]
        rows, columns = np.nonzero(image == image.max())
        x = grid["x_top_m"] - (rows + 0.5) * grid["metres_per_pixel"]
        y = grid["y_left_m"] - (columns + 0.5) * grid["metres_per_pixel"]
        azimuth = np.degrees(np.arctan2(y, x))
        # All pixels of the cell from 13 to 18.5 degrees, and no others.
        self.assertLess(abs(azimuth.min() - 13), 0.3)
        self.assertLess(abs(azimuth.max() - 18.5), 0.3)
        self.assertLess(abs(np.hypot(x, y) - 2).max(), 0.04)

    def test_every_backend_and_array_accept_the_azimuths(self):
        reference = made(SCENARIO, "--backend", "reference", *settings(TARGET))
        series = np.load(reference / "sequences/000000/timeseries/000000.npy")
        self.assertLess(abs(series - self.series).max(), 1e-6 * abs(series).max())
        array = made(SCENARIO, *settings(TARGET, "sonar.beams.receive_width_deg=3", "sonar.receiver={mode: array}"))
        about = json.loads((array / "sequences/000000/sequence.json").read_text())
        self.assertEqual(about["sonar"]["beams"]["azimuth_rad"], self.about["sonar"]["beams"]["azimuth_rad"])
        self.assertNotIn("widths_rad", about["sonar"]["beams"])
        levels = abs(np.load(array / "sequences/000000/timeseries/000000.npy")).max(axis=1)
        self.assertEqual(levels.argmax(), 11)


if __name__ == "__main__":
    unittest.main()
