"""What the sonars of a rig hear of the same scatterers: equal sonars at one place the same to the bit, displaced ones by
the theorem of van Cittert and Zernike, and those of another frequency by the spectrum of the pulse.

ENSONIFY is the program.
"""
import numpy as np
from program import Case, run

C, SHELL_M, FAN_RAD = 1500, 10, np.radians(4)
FREQUENCY, BAND = 500e3, 10e3
KEPT = ["x", "y", "z", "amp_re", "amp_im"]


def sonar(name, place=(0, 0, 0), frequency=FREQUENCY, pitch=0, least=SHELL_M - 1, most=SHELL_M + 1, fan=4, more=""):
    return (f"  - {{name: {name}, sonar: {{frequency_hz: {frequency}, bandwidth_hz: {BAND}, source_level_db: 200, "
            f"range_min_m: {least}, range_max_m: {most}, beams: {{count: 48, fov_deg: 96, receive_width_deg: 0.7}}, "
            f"elevation: {{width_deg: 90, fan_deg: {fan}, shading: uniform}}, rays: {{elevation: 4}}{more}, "
            f"mount: {{position_m: {list(place)}, rotation_deg: [0, {pitch}, 0]}}}}}}\n")


def scene(instruments, shape, sequences=1, more=""):
    return (f"ensonify: 1\nname: rig\nseed: 2\nsequences: {sequences}\nrig:\n{''.join(instruments)}"
            "water: {sound_speed_m_s: 1500, absorption: {fixed_db_m: 0}}\nscattering: {speckle: surface}\n"
            f"materials: {{m: {{reflectivity: 1e-3}}}}\nobjects:\n  - {{name: patch, class: patch, material: m, {shape}}}\n"
            f"trajectory: {{pings: 1}}\n{more}output: {{polar: false, cartesian: false, png: false}}\n")


SHELL = f"shape: {{sphere: {{radius_m: {SHELL_M}, inward_facing: true}}}}"
GROUND = "shape: {plane: {}}, pose: {position_m: [0, 0, -3]}"


def coherence(a, b):
    return np.sum(a * np.conj(b)) / np.sqrt(np.sum(np.abs(a) ** 2) * np.sum(np.abs(b) ** 2))


class Coherence(Case):
    def make(self, text):
        self.scenario.write_text(text)
        done = run("generate", self.scenario, "-o", self.folder / "rig", "--quiet", "--overwrite")
        self.assertEqual(done.returncode, 0, done.stderr)
        return lambda name, sequence=0: np.load(
            self.folder / f"rig/{name}/sequences/{sequence:06d}/timeseries/000000.npy").astype(complex)

    def agrees(self, found, expected, count):
        """Within three standard errors of the modulus over `count` independent samples."""
        self.assertLess(abs(abs(found) - abs(expected)), 3 * (1 - expected**2) / np.sqrt(2 * count), (found, expected))

    def test_equal_sonars_at_one_place_hear_the_same(self):
        adc = ", receiver: {adc: {bits: 12, full_scale_db: 120}}"
        heard = self.make(scene([sonar("a", more=adc), sonar("b", more=adc)], SHELL))
        np.testing.assert_array_equal(heard("a"), heard("b"))
        self.assertGreater(np.abs(heard("a")).max(), 0)
        # Their noise is their own, and so is speckle that is not fixed on surfaces.
        noisy = self.make(scene([sonar("a"), sonar("b")], SHELL, more="noise: {snr_db: 0}\n"))
        ours, theirs = noisy("a")[:, :100], noisy("b")[:, :100]  # before the shell
        self.assertLess(abs(coherence(ours, theirs)), 5 / np.sqrt(ours.size))
        fresh = self.make(scene([sonar("a"), sonar("b")], SHELL).replace("surface", "per_ping"))
        self.assertLess(abs(coherence(fresh("a"), fresh("b"))), 0.5)

    def test_a_coarse_sonar_hears_the_scatterers_of_a_fine_one(self):
        text = scene([sonar("fine"), sonar("coarse").replace(f"bandwidth_hz: {BAND}", "bandwidth_hz: 5000.0")
                      .replace("width_deg: 0.7", "width_deg: 3")], SHELL).replace("{polar", "{scatterers: true, polar")
        self.make(text)
        fine, coarse = (np.sort(np.load(self.folder / f"rig/{name}/sequences/000000/scatterers/000000.npy")[KEPT], order=KEPT)
                        for name in ("fine", "coarse"))
        self.assertGreater(fine.size, 1000)
        np.testing.assert_array_equal(fine, coarse)

    def test_coherence_over_the_baseline(self):
        # All scatterers of the shell are at one range and fill the fan in elevation evenly, so that the coherence over
        # a vertical baseline d is the transform of a box, sin(x)/x with x = k d (fan - d/R): two ways of k d sin(phi)/2
        # on either side of the middle, less the edges that only one of both hears.
        k = 2 * np.pi * FREQUENCY / C
        baselines = [x / (k * FAN_RAD) for x in (1, 2, 3, 4.5)]
        sequences = 24
        names = [f"d{i}" for i in range(len(baselines))]
        heard = self.make(scene([sonar("zero")] + [sonar(n, (0, 0, float(d))) for n, d in zip(names, baselines)], SHELL,
                                sequences))
        zero = np.array([heard("zero", s) for s in range(sequences)])
        at = np.argmax(np.mean(np.abs(zero) ** 2, axis=(0, 1)))
        for name, d in zip(names, baselines):
            other = np.array([heard(name, s)[:, at] for s in range(sequences)])
            found = coherence(zero[:, :, at], other)
            expected = np.sin(k * d * (FAN_RAD - d / SHELL_M)) / (k * d * FAN_RAD)
            self.agrees(found, expected, other.size)

    def test_coherence_over_frequency(self):
        # Of scatterers that are even in range it is the autocorrelation of the pulse's spectrum at the difference of
        # the frequencies. Neighboring samples are as coherent as the transform of the squared spectrum says.
        shares = [0.1, 0.2, 0.3, 0.45]
        names = [f"f{i}" for i in range(len(shares))]
        look = {"pitch": 30, "least": 3, "most": 9, "fan": 50}
        heard = self.make(scene([sonar("f", **look)] + [sonar(n, frequency=FREQUENCY + s * BAND, **look)
                                                        for n, s in zip(names, shares)], GROUND))
        first = heard("f")
        window = slice(int(4.5 / (C / 2 / BAND)), int(8.5 / (C / 2 / BAND)))
        x = np.linspace(-0.5, 0.5, 10001)
        squared = spectrum(x) ** 2 / np.sum(spectrum(x) ** 2)
        lags = np.array([np.sum(squared * np.cos(2 * np.pi * lag * x)) for lag in range(-8, 9)])
        count = first[:, window].size / np.sum(lags**2)
        for name, share in zip(names, shares):
            turn = np.exp(-2j * np.pi * share * np.arange(first.shape[1]))
            found = coherence(first[:, window], (heard(name) / turn)[:, window])
            expected = np.sum(spectrum(x) * spectrum(x + share)) / np.sum(spectrum(x) ** 2)
            self.agrees(found, expected, count)


def spectrum(x):
    """Of the Gaussian pulse, over the band |x| <= 1/2, with its tapered edges (docs/physics/2_pulse_and_record.md)."""
    inside = np.clip(np.abs(x), 0.4, 0.5)
    return np.exp(-((np.pi * x) ** 2)) * (1 + np.cos(10 * np.pi * (inside - 0.4))) / 2


if __name__ == "__main__":
    import unittest

    unittest.main()
