"""Data sets of an array of elements: the series worked out again from scatterers and sequence.json
by the formulas that it holds, the channels, the packing, the reader, and what verify finds."""
import json
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np

from program import made, run, settings
from ensonify_dataset import SonarDataset

SCENARIO = """ensonify: 1
seed: 3
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 1.5
  beams: {count: 8, fov_deg: 60, receive_width_deg: 8}
  rays: {elevation: 4}
  receiver: {mode: array, spacing_m: 1.2e-3, element_width_m: 6e-4, shading: taylor, gain_error_db: 1,
             phase_error_deg: 10, dead: [2]}
water: {sound_speed_m_s: 1480}
materials: {m: {reflectivity: 1e-3, coherent: {model: rician, k: 1}}}
objects:
  - {name: room, material: m, shape: {box: {size_m: [2.4, 2.4, 1], inward_facing: true}}}
point_targets: [{name: tip, target_strength_db: -30, position_m: [0.7, 0.2, 0.05]}]
trajectory: {ping_rate_hz: 5, pings: 2}
output: {cartesian: false, png: false, channels: true, scatterers: true}
"""


def generated(*pairs, text=SCENARIO):
    return made(text, "--backend", "reference", *settings(*pairs))


def element_records(about, echoes, sonar_position, times_s):
    """p_n(t) [elements, times], times_s [times] or [elements, times]."""
    sonar, record = about["sonar"], about["record"]
    receiver, c = sonar["receiver"], about["water"]["sound_speed_m_s"]
    f_c, b, bins = sonar["frequency_hz"], sonar["bandwidth_hz"], record["transform"]
    d = (np.arange(bins) - bins // 2) * b / bins
    x = np.abs(d) / b
    taper = np.where(x <= 0.4, 1.0, 0.5 * (1 + np.cos(np.pi * (x - 0.4) / 0.1)))
    spectrum = np.exp(-((np.pi * d / b) ** 2)) * taper
    spectrum = spectrum / spectrum.sum()
    y = np.array(receiver["y_m"])
    position = np.stack([echoes["x"], echoes["y"], echoes["z"]], -1)
    q = np.linalg.norm(position - sonar_position, axis=1)
    azimuth, elevation = (echoes[k].astype(float) for k in ("azimuth_rad", "elevation_rad"))
    direction = np.stack([np.cos(elevation) * np.cos(azimuth),
                          np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], -1)
    apparent = q[:, None] * direction
    u = direction[:, 1]
    heard = np.sinc(receiver["element_width_m"] * u * f_c / c)
    amplitude = (echoes["amp_re"] + 1j * echoes["amp_im"]).astype(complex) * echoes["gain"] * heard
    response = np.array(receiver["response_re"]) + 1j * np.array(receiver["response_im"])
    times_s = np.broadcast_to(times_s, (len(y), np.shape(times_s)[-1]))
    records = np.zeros(times_s.shape, complex)
    for n, y_n in enumerate(y):
        delta = (np.linalg.norm(apparent - [0, y_n, 0], axis=1) - q) / c
        delay = echoes["delay_s"] + delta
        # S_m sum_i a_i e^(-i 2 pi f_m delay_i), then to the times.
        sums = spectrum * (amplitude @ np.exp(-2j * np.pi * np.outer(delay, f_c + d)))
        records[n] = response[n] * sonar["source_pressure_pa_m"] * (
            np.exp(2j * np.pi * np.outer(times_s[n], d)) @ sums)
    return records


def beams(about, echoes, sonar_position, azimuths):
    """p_j(t_k) [beams, samples]."""
    receiver, c = about["sonar"]["receiver"], about["water"]["sound_speed_m_s"]
    f_c, b = about["sonar"]["frequency_hz"], about["sonar"]["bandwidth_hz"]
    k = np.arange(about["record"]["samples"])
    y = np.array(receiver["y_m"])[:, None]
    r = np.maximum(k, 1) * c / (2 * b)
    series = []
    for theta in azimuths:
        steer = -y * np.sin(theta) / c
        focus = (np.sqrt(r**2 - 2 * r * y * np.sin(theta) + y**2) - r) / c
        records = element_records(about, echoes, sonar_position, k / b + steer)
        weight = np.array(receiver["weight"])[:, None]
        series.append(np.sum(weight * np.exp(2j * np.pi * f_c * focus) * records, axis=0))
    return np.array(series)


class Arrays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.data = generated()

    def test_series_and_channels_are_the_formulas_of_sequence_json(self):
        data = SonarDataset(self.data)
        about = data.sequence(0).info
        self.assertEqual(about["sonar"]["receiver"]["elements"], 12)
        ping = data[0, 1]
        echoes = np.load(self.data / "sequences/000000/scatterers/000001.npy")
        place = ping.pose.position_m
        b = about["sonar"]["bandwidth_hz"]
        times = np.arange(about["record"]["samples"]) / b
        for expected, obtained in (
                (beams(about, echoes, place, ping.sequence.azimuth_rad), ping.series),
                (element_records(about, echoes, place, times), ping.channels)):
            self.assertEqual(expected.shape, obtained.shape)
            error = np.linalg.norm(expected - obtained) / np.linalg.norm(expected)
            self.assertLess(error, 1e-5)
        self.assertTrue(np.all(ping.channels[2] == 0))

    def test_verify_knows_channels(self):
        with tempfile.TemporaryDirectory() as folder:
            spoilt = shutil.copytree(self.data, Path(folder, "spoilt"))
            file = spoilt / "sequences/000000/channels/000001.npy"
            np.save(file, np.load(file)[:-1])
            result = run("verify", spoilt)
        self.assertEqual(result.returncode, 1)
        self.assertIn("channels/000001.npy", result.stdout + result.stderr)

    def test_packed_channels_are_those_of_the_pings(self):
        packed = generated("output.one_file_per=sequence")
        about = json.loads((packed / "sequences/000000/sequence.json").read_text())
        elements, samples = 12, about["record"]["samples"]
        self.assertEqual(about["arrays"]["channels.npy"]["shape"], [2, elements, samples])
        for ping in range(2):
            np.testing.assert_array_equal(SonarDataset(packed)[0, ping].channels,
                                          SonarDataset(self.data)[0, ping].channels)
        self.assertIn("channels", (packed / "README.md").read_text())

    def test_the_resolved_scenario_gives_the_same_bytes(self):
        again = generated(text=(self.data / "scenario.yaml").read_text())
        manifest = [(folder / "dataset.sha256").read_text() for folder in (self.data, again)]
        self.assertEqual(*manifest)

    def test_no_channels_no_folder(self):
        plain = generated("output.channels=false")
        self.assertFalse((plain / "sequences/000000/channels").exists())
        with self.assertRaises(Exception):
            SonarDataset(plain)[0, 0].channels  # pylint: disable=expression-not-assigned


if __name__ == "__main__":
    unittest.main()
