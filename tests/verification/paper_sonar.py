"""Table 1 of the paper, and what our deliberate differences change in its tank."""
import numpy as np

from bench import Row
from paper_claims import EQUATION, MODEL, SET_UP, Claim
from paper_tank import arrivals_m

TABLE_1 = ("sonar.bandwidth_hz=2950",)
# What Table 1 says, as far as our sources repeat it, and how a sequence.json states the same.
PARAMETERS = (
    ("frequency", "900 kHz", lambda sonar: f"{sonar['frequency_hz'] / 1e3:g} kHz"),
    ("bandwidth", "2.95 kHz", lambda sonar: f"{sonar['bandwidth_hz'] / 1e3:g} kHz"),
    ("source level", "220 dB", lambda sonar: f"{sonar['source_level_db']:g} dB re 1 µPa·m"),
    (
        "field of view",
        "90° × 20°",
        lambda sonar: f"{np.degrees(sonar['beams']['spacing_rad']) * sonar['beams']['count']:.6g}°"
        f" × {np.degrees(sonar['elevation']['fan_rad']):.6g}°",
    ),
    ("beams", "512", lambda sonar: f"{sonar['beams']['count']}"),
    ("rays per beam", "114", lambda sonar: f"{sonar['rays']['elevation']}"),
    (
        "beam width",
        "not known to us (maker's sheet: 1°)",
        lambda sonar: f"{np.degrees(sonar['beams']['width_rad']):.6g}°",
    ),
)


def parameters(tanks):
    """Rows of Table 1: what, the paper, its preset, our scene, whether that is as the paper says."""
    printed = tanks.get("sonar_tank", TABLE_1, pings=1).first.info["sonar"]
    ours = tanks.get("sonar_tank").first.info["sonar"]
    rows = []
    for what, paper, say in PARAMETERS:
        agrees = "yes" if say(ours).startswith(paper) else "no, on purpose"
        if paper.startswith("not known"):
            agrees = "-"
        rows.append((what, paper, say(printed), say(ours), agrees))
    return rows


def table_1(tanks):
    """What its bandwidth means for the tank."""
    scene = tanks.get("sonar_tank", TABLE_1, pings=1)
    step = scene.sonar.range_step_m
    centre = scene.sonar.beams // 2
    yield Claim("Table 1", "2.95 kHz: range bins of 25 cm, c/2b", SET_UP,
                Row("Table1.bin", "range step of the record", 1500 / 5900, step, 1e-6, "m"))
    yield Claim("Table 1", "with such bins the cylinder's echo begins within a bin of 3.8 m", MODEL,
                Row("Table1.cylinder", "arrival on the center beam",
                    3.8, float(arrivals_m(scene.clean(), step)[centre]), step, "m"))


def change_db(scene, other, mask, powers):
    """Change of a window's energy from one run to the other."""
    before, after = (power(tank)[mask].sum() for power, tank in zip(powers, (scene, other)))
    return float(10 * np.log10(after / before))


def differences(tanks):
    """What the paper's or its code's choice would change, had we made it (or the other way)."""
    scene = tanks.get("sonar_tank")
    wall = scene.window((-10, -5), (5.4, 6.0)) | scene.window((5, 10), (5.4, 6.0))
    oblique = scene.window((35, 40), (6.4, 7.6))
    centre = scene.window((-0.1, 0.0), (3.7, 4.05))
    cases = (
        (
            "elevation",
            "the published code leaves out the elevation pattern (Eq 18 to 22); we apply it once",
            "a nearly flat pattern, 170 degrees over the fan of 20: change of the wall's echo",
            ("sonar.elevation={width_deg: 170, fan_deg: 20}",),
            2,
            wall,
        ),
        (
            "absorption",
            "the published code uses 0.0354 dB/m at every frequency; we use "
            "Francois and Garrison's value at 900 kHz",
            "with 0.0354 dB/m: change of the wall's echo",
            ("water.absorption={fixed_db_m: 0.0354}",),
            2,
            wall,
        ),
        (
            "normalization",
            "the scenes use Eq 16 as `mean_square`; by default we calibrate, so that the sonar "
            "equation holds",
            "calibrated: change of the center beam, cylinder",
            ("scattering.normalization=calibrated",),
            2,
            centre,
        ),
        (
            "exponent",
            "Eq 14 and the scenes have cos² of the incidence; Eq 7 and our default have cos",
            "with cos: change of the wall at 35 to 40 degrees",
            ("scattering.lambert_exponent=1",),
            1,
            oblique,
        ),
    )
    for name, words, measured, settings, exponent, mask in cases:
        other = tanks.get("sonar_tank", settings, pings=1)
        obtained = change_db(scene, other, mask, (lambda t: t.clean(),) * 2)
        wanted = change_db(
            scene, other, mask, (lambda t: t.expected(), lambda t, n=exponent: t.expected(n))
        )
        row = Row(f"differ.{name}", measured, wanted, obtained, 0.02)
        yield Claim("differences", words, EQUATION, row)
