"""The synthetic tank with what its plain sequences leave out, and faults of just that."""
import synthetic_tank
from synthetic_faults import SEQUENCE, SERIES, change_array, change_json

CHECKS = ("check_files", "check_series", "check_scatterers", "check_labels", "check_coco")
STEP_PA = 10**2.5 / 2**15


def write_data_set(root):
    synthetic_tank.write_data_set(root, ("burst",))


def one_step(series):
    """The loudest sample, one step of the converter up."""
    series = series.copy()
    series.reshape(-1)[abs(series).argmax()] += STEP_PA
    return series


def described(*keys, value=None, factor=None):
    """A change of one entry of sequence.json: another value, or one times a factor."""

    def change(content):
        for key in keys[:-1]:
            content = content[key]
        content[keys[-1]] = value if factor is None else content[keys[-1]] * factor

    return change_json(f"{SEQUENCE}/sequence.json", change)


FAULTS = [
    ("a sample one step off", "check_series", change_array(SERIES, one_step)),
    ("samples between steps", "check_series", change_array(SERIES, lambda a: a * 1.0002)),
    ("another full scale", "check_series", described("sonar", "adc", "full_scale_db", value=170.1)),
    ("another step", "check_series", described("sonar", "adc", "step_pa", factor=1.001)),
    ("another ratio to the noise", "check_series", described("noise", "snr_db", value=30.1)),
    ("another window", "check_series", described("sonar", "window", value="hamming")),
    ("another burst", "check_series", described("sonar", "pulse", "duration_s", factor=1.02)),
    (
        "another shading",
        "check_series",
        described("sonar", "beams", "shading", "kind", value="chebyshev"),
    ),
    (
        "a shorter aperture",
        "check_files",
        described("sonar", "beams", "shading", "aperture_wavelengths", factor=0.999),
    ),
    (
        "another pattern in elevation",
        "check_scatterers",
        described("sonar", "elevation", "shading", "kind", value="chebyshev"),
    ),
    (
        "a lower aperture",
        "check_files",
        described("sonar", "elevation", "shading", "aperture_wavelengths", factor=0.999),
    ),
    ("a longer pulse", "check_files", described("record", "pulse_extent_s", factor=1.01)),
    ("a gain of nothing", "check_files", described("sonar", "processing_gain", value=2.0)),
    (
        "another transmit pattern",
        "check_scatterers",
        described("sonar", "beams", "transmit_width_rad", factor=1.0001),
    ),
    ("another K", "check_scatterers", described("instances", 1, "coherent", "k", value=0.501)),
    (
        "another exponent",
        "check_scatterers",
        described("instances", 0, "law", "exponent", value=1.01),
    ),
    (
        "another law",
        "check_scatterers",
        described("instances", 0, "law", "model", value="lommel_seeliger"),
    ),
]
