"""Speckle over many pings of a diffuse slope: contrast, distribution, correlations, means."""
import math

import numpy as np

import measure
import physics
from bench import Row, case, diffuse, statistical
from noise import SEABED

# 108,000 draws: a fan with many places that share no speckle costs less than many pings of a few.
PINGS = 1125
BEAMS = range(2, 40, 5)
SAMPLES = range(68, 116, 4)
SLOPE = {
    **SEABED,
    "sonar": {
        **SEABED["sonar"],
        "beams": {"count": 40, "spacing_deg": 1, "receive_width_deg": 2},
        "rays": {"elevation": 96},
    },
}
# Kolmogorov's distribution leaves 0.27 percent (three standard errors) above this.
KS_CRITICAL = math.sqrt(math.log(2.0 / 0.0027) / 2.0)


class Slope:
    """Series of all pings, and the scatterers of ping 0, which are placed alike in every ping."""

    def __init__(self, bench, coherent=None):
        scenario = {**SLOPE, "trajectory": {"ping_rate_hz": 1, "pings": PINGS}}
        if coherent:
            scenario["materials"] = {"m": {"reflectivity": 1e-3, "coherent": coherent}}
        sequence = bench.run(scenario)
        first = bench.run(scenario, scatterers=True, arguments=("--pings", "0:1"))
        self.sonar, self.scatterers = sequence.sonar, first.scatterers(0)
        self.series = measure.all_series(sequence)
        self.heard = {}  # sample -> what it hears of each echo
        self.clean = physics.expected_power(self.scatterers, self.sonar)

    def pixels(self):
        """Indices of pixels so far apart that their speckle is independent."""
        beams, samples = np.meshgrid(BEAMS, SAMPLES, indexing="ij")
        return beams.reshape(-1), samples.reshape(-1)

    def intensity(self):
        """[pings, pixels] over the clean power of each pixel."""
        beams, samples = self.pixels()
        return np.abs(self.series[:, beams, samples]) ** 2 / self.clean[beams, samples]

    def covariance(self, beams, samples, other_beams, other_samples):
        """E[p p'*] of pairs of pixels from the scatterers' variances and the pulse, written out."""
        sonar, echo = self.sonar, self.scatterers
        order = (np.arange(len(sonar.spectrum)) - len(sonar.spectrum) // 2) / len(sonar.spectrum)
        strength = (
            sonar.source_pressure_pa_m**2
            * echo["variance"].astype(float)
            * echo["gain"].astype(float) ** 2
        )

        def response(beam, sample):
            if sample not in self.heard:
                offset = sample - echo["delay_s"] * sonar.bandwidth_hz
                self.heard[sample] = np.exp(2j * np.pi * np.outer(offset, order)) @ sonar.spectrum
            return sonar.weights[beam, echo["beam"]] * self.heard[sample]

        return np.array(
            [
                np.sum(strength * response(j, n) * np.conj(response(k, m)))
                for j, n, k, m in zip(beams, samples, other_beams, other_samples)
            ]
        )


def contrast(intensity):
    """Standard deviation over mean of independent intensities, with its standard error."""
    x = intensity.reshape(-1)
    mean, spread = x.mean(), x.std(ddof=1)
    # The first-order change of spread / mean with each draw.
    influence = ((x - mean) ** 2 - spread**2) / (2 * spread * mean) - spread * (
        x - mean
    ) / mean**2
    return spread / mean, float(influence.std(ddof=1) / math.sqrt(len(x)))


def exponential_distance(intensity):
    """Kolmogorov-Smirnov distance of intensities of unit mean to the exponential."""
    x = np.sort(intensity.reshape(-1))
    wanted = 1.0 - np.exp(-x)
    steps = np.arange(len(x) + 1) / len(x)
    return float(max(np.max(steps[1:] - wanted), np.max(wanted - steps[:-1])))


def correlation_rows(slope):
    """Correlation of neighbours in range and azimuth beside the point-spread function's."""
    centres = [(beam, sample) for beam in range(4, 36, 4) for sample in range(70, 108, 6)]
    for beam_lag, sample_lag in ((0, 1), (0, 2), (1, 0), (2, 0), (1, 1), (3, 0)):
        beams, samples = (np.array(column) for column in zip(*centres))
        far_beams, far_samples = beams + beam_lag, samples + sample_lag
        scale = np.sqrt(slope.clean[beams, samples] * slope.clean[far_beams, far_samples])
        wanted = slope.covariance(beams, samples, far_beams, far_samples) / scale
        got = (
            slope.series[:, beams, samples]
            * np.conj(slope.series[:, far_beams, far_samples])
            / scale
        )
        # Turned by the phase that is expected, so that the real part is the whole of it.
        turned = (got * np.conj(wanted / np.abs(wanted))).real.mean(axis=1)
        mean, error = measure.mean_and_error(turned)
        yield statistical(
            f"V4.lag.{beam_lag}.{sample_lag}",
            f"correlation over {beam_lag} beams and {sample_lag} samples, mean of {len(centres)} places",
            float(np.abs(wanted).mean()),
            mean,
            error,
            PINGS,
            "",
        )


def ping_row(slope):
    """Speckle of a sonar at rest, drawn afresh for every ping: one knows nothing of the next."""
    beams, samples = slope.pixels()
    series = slope.series[:, beams, samples] / np.sqrt(slope.clean[beams, samples])
    product = (series[1:] * np.conj(series[:-1])).real.mean(axis=1)
    mean, error = measure.mean_and_error(product)
    return statistical("V4.pings", "correlation of a pixel with itself one ping later",
                       0.0, mean, error, product.size, "")


@case("V4")
def speckle_statistics(bench):
    """Fully developed speckle of a diffuse wall, leaning away."""
    slope = Slope(bench)
    intensity = slope.intensity()
    value, error = contrast(intensity)
    distance = exponential_distance(intensity)
    edges = np.linspace(0.0, 8.0, 41)
    share = np.histogram(intensity, edges)[0] / intensity.size / np.diff(edges)
    bench.curve(
        "speckle",
        "intensity / clean",
        0.5 * (edges[1:] + edges[:-1]),
        share,
        np.exp(-0.5 * (edges[1:] + edges[:-1])),
    )
    phase = np.exp(1j * np.angle(slope.series[:, slope.pixels()[0], slope.pixels()[1]]))
    yield statistical("V4.contrast", "diffuse wall, 30 degrees off: contrast of the intensity",
                      1.0, value, error, intensity.size, "")
    yield Row("V4.ks", "distance of its distribution to the exponential (Kolmogorov-Smirnov)",
              0.0, distance, KS_CRITICAL / math.sqrt(intensity.size), "", draws=intensity.size)
    yield Row("V4.phase", "mean of exp(i phase)",
              0.0, float(np.abs(phase.mean())), 3 / math.sqrt(phase.size), "", draws=phase.size)
    yield ping_row(slope)
    yield from correlation_rows(slope)


@case("V5")
def mean_power(bench):
    """Mean intensity over clean; clean as the program writes it."""
    slope = Slope(bench)
    intensity = slope.intensity()
    mean, error = measure.mean_and_error(intensity.mean(axis=1))
    yield statistical("V5.mean", "the same wall: mean |p|^2 over pings against clean from the scatterers",
                      0.0, float(10 * np.log10(mean)), measure.DECIBELS * error / mean, intensity.size, tolerance=0.1)
    first = bench.run({**SEABED, "output": {"polar": True}}, scatterers=True)
    clean = physics.power_level_db(physics.expected_power(first.scatterers(0), first.sonar))
    stored = first.image("polar", 0)["labels"].channels["clean_db"].T
    audible = clean > clean.max() - 100.0
    step = np.spacing(np.abs(clean).astype(np.float16)).astype(float)
    gap = (np.abs(stored.astype(float) - clean) / step)[audible]
    yield Row("V5.clean", "clean_db against clean from the scatterers, largest gap in steps of half precision",
              0.0, float(gap.max()), 0.52, "steps", draws=int(audible.sum()))


@case("rician")
def rician(bench):
    """A coherent part of K: contrast by kappa from the scatterers, and the mean itself."""
    for k in (0.5, 4.0):
        slope = Slope(bench, {"model": "rician", "k": k})
        beams, samples = slope.pixels()
        diffuse = slope.scatterers.copy()
        diffuse["mean_re"], diffuse["mean_im"] = 0.0, 0.0
        variance = physics.expected_power(diffuse, slope.sonar)[beams, samples]
        kappa = slope.clean[beams, samples] / variance - 1.0
        intensity = slope.intensity()
        got = intensity.var(axis=0, ddof=1) / intensity.mean(axis=0) ** 2
        gap, error = measure.mean_and_error(got - (1 + 2 * kappa) / (1 + kappa) ** 2)
        wanted = float(np.mean((1 + 2 * kappa) / (1 + kappa) ** 2))
        yield statistical(f"rician.{k:g}.contrast", f"rician wall, K = {k:g}: contrast^2, mean of {len(beams)} places",
                          wanted, wanted + gap, error, intensity.size, "")
        mean, error = measure.mean_and_error(intensity.mean(axis=1))
        yield statistical(
            f"rician.{k:g}.mean", f"rician wall, K = {k:g}: mean |p|^2 against clean",
            0.0, float(10 * np.log10(mean)), measure.DECIBELS * error / mean, intensity.size, tolerance=0.1
        )
        echo = slope.scatterers
        ratio = (echo["mean_re"].astype(float) ** 2 + echo["mean_im"].astype(float) ** 2) / echo[
            "variance"
        ]
        yield Row(f"rician.{k:g}.k", f"K = {k:g}: |mean|^2 / variance, the echo farthest off",
                  k, float(ratio[np.argmax(np.abs(ratio - k))]), 1e-5 * k, "")


@case("V24")
def textured_seabed(bench):
    """A gamma texture much larger than a resolution cell gives K-distributed amplitudes of its shape."""
    shape, worlds = 2.0, 24

    def seabed(texture):
        return {
            "sonar": {
                "range_min_m": 10,
                "range_max_m": 30,
                "beams": {"count": 46, "spacing_deg": 2, "receive_width_deg": 0.5},
                "elevation": {"width_deg": 60, "fan_deg": 40},
                "rays": {"elevation": 3000},
                "mount": {"rotation_deg": [0, 25, 0]},
            },
            "materials": {"m": {"reflectivity": 1e-2, **texture}},
            "objects": [diffuse("bed", {"plane": {}}, (0, 0, -6))],
        }

    even = bench.run(seabed({}), scatterers=True)
    mean = physics.expected_power(even.scatterers(0), even.sonar)
    range_m = np.arange(mean.shape[1]) * even.sonar.sound_speed_m_s / (2 * even.sonar.bandwidth_hz)
    inside = (range_m > 11) & (range_m < 28)
    moments = []
    texture = {"texture": {"model": "gamma", "shape": shape, "correlation_m": 2.5}}
    for world in bench.run_worlds(seabed(texture), worlds):
        normal = (np.abs(world.series(0)) ** 2 / mean)[:, inside]
        moments.append((normal.mean(), (normal**2).mean()))
    found, error = measure.jackknifed(np.array(moments), measure.k_distribution_shape)
    first = np.array(moments)[:, 0]
    level_error = 10 / math.log(10) * first.std(ddof=1) / math.sqrt(worlds)
    yield statistical("V24.shape", "gamma texture of shape 2 on a seabed: shape of the K distribution by its moments",
                      shape, found, error, worlds, "")
    yield statistical("V24.mean", "the same: mean power over that without texture",
                      0.0, 10 * math.log10(first.mean()), level_error, worlds)
