#!/usr/bin/python3
"""Shows that rows fail when they should, that a report is read back and its changes are found, and
that what measures curves measures known ones.

    selftest.py
"""
import math
import os
import sys
import tempfile

import numpy as np

# First, since it opens the way to tests/independent.
from bench import CASES, Bench, Row, case, default_scenario, merged, rows_of
import closed_forms
import measure
import mutations
import report
import speckle
from beam_patterns import SINC_WIDTH_FACTOR, Shading, aperture_wavelengths, line_pattern
from checklist import Checklist
from pulses import Pulse
from surface_laws import Law, backscatter_strength


def test_rows(checklist):
    sound = Row("a", "x", 1.0, 1.04, 0.05)
    for name, row, wanted in (
        ("within", sound, True),
        ("beyond", Row("a", "x", 1.0, 1.06, 0.05), False),
        ("not a number", Row("a", "x", 1.0, math.nan, 0.05), False),
        ("troubled", Row("a", "x", 1.0, 1.0, 0.05, trouble="e"), False),
    ):
        checklist.equal(f"a row {name} its tolerance", row.passed, wanted)

    @case("broken")
    def broken(bench):
        return [Row("b", "x", 1.0, float(bench.run({}).no_such_thing), 1.0)]

    with tempfile.TemporaryDirectory() as folder:
        rows = rows_of("broken", Bench("/bin/false", folder))
    del CASES["broken"]
    checklist.expect(
        len(rows) == 1 and not rows[0].passed and "exit 1" in rows[0].trouble,
        "a program that fails gives a failing row",
        rows[0].trouble,
        "exit 1: ...",
    )
    tree = merged(default_scenario(), {"sonar": {"pulse": "flat"}, "water": None})
    checklist.expect(
        tree["sonar"]["pulse"] == "flat" and tree["sonar"]["beams"] and "water" not in tree,
        "changes merged into a scenario",
        sorted(tree),
        "no water",
    )


def test_report(checklist, folder):
    path = os.path.join(folder, "report.md")
    rows = [
        Row("V1", "a | b".replace("|", "/"), 152.041, 152.05, 0.05),
        Row("V8", "small", 0.0, 3e-8, 1e-5, ""),
        Row("lag", "negative", -0.2173, -0.2170, 0.0025, "of the peak", 0.001, 3000),
    ]
    report.write(path, rows)
    checklist.equal("a report against its own rows", report.differences(path, rows), [])
    changed = {
        "obtained moved": [Row("V1", "", 152.041, 152.11, 0.05), *rows[1:]],
        "expected moved": [Row("V1", "", 152.2, 152.05, 0.05), *rows[1:]],
        "a missing row": rows[:2],
        "an extra row": [*rows, Row("new", "", 0, 0, 1)],
        "a number lost": [rows[0], Row("V8", "", 0.0, math.nan, 1e-5, ""), rows[2]],
    }
    for name, others in changed.items():
        found = report.differences(path, others)
        checklist.expect(len(found) >= 1, f"a report against {name}", found, "one fault at least")
    report.write(path, [Row("V1", "", 152.041, 153.0, 0.05), *rows[1:]])
    checklist.expect(
        len(report.differences(path, rows)) >= 1,
        "a report with a row that fails",
        report.differences(path, rows),
        "one fault at least",
    )


def test_measures(checklist):
    x = np.linspace(-6, 6, 1201)
    lobe = np.sinc(x) ** 2
    checklist.near("half-power width of sinc^2", measure.width_at(x, lobe), 0.885893, 1e-5)
    checklist.near("first side lobe of sinc^2", measure.first_side_lobe_db(lobe), -13.2614, 1e-3)
    checklist.near(
        "highest side lobe of sinc^2", measure.highest_side_lobe_db(lobe), -13.2614, 1e-3
    )
    n = np.arange(120)
    tone = np.exp(2j * np.pi * 0.11 * n)[None] * np.exp(-(((n - 60.3) / 9.0) ** 2))
    fine = np.abs(measure.interpolated(tone, 32)[0])
    checklist.near("peak between samples, place", measure.peak(fine)[0] / 32, 60.3, 1e-3)
    checklist.near("peak between samples, height", measure.peak(fine)[1], 1.0, 1e-4)
    generator = np.random.default_rng(1)
    intensity = generator.exponential(size=(300, 200))
    value, error = speckle.contrast(intensity)
    checklist.near(
        "standard error of the contrast of an exponential", error * math.sqrt(60000), 1.0, 0.1
    )
    checklist.near("contrast of an exponential", value, 1.0, 3 * error)
    limit = speckle.KS_CRITICAL / math.sqrt(intensity.size)
    distance = speckle.exponential_distance(intensity)
    checklist.expect(distance < limit, "distance of an exponential", distance, f"< {limit:.5f}")
    for name, wrong in (
        (
            "a Rician of K 0.3",
            np.abs(
                math.sqrt(0.3)
                + generator.normal(size=60000, scale=0.5**0.5)
                + 1j * generator.normal(size=60000, scale=0.5**0.5)
            )
            ** 2
            / 1.3,
        ),
        ("2 percent more", intensity * 1.02),
    ):
        distance = speckle.exponential_distance(wrong)
        checklist.expect(distance > limit, f"distance of {name}", distance, f"> {limit:.5f}")


def test_closed_forms(checklist):
    beam, fan = math.radians(1.0), math.radians(20.0)
    azimuth = closed_forms.azimuth_integral(beam, -math.pi / 2, math.pi / 2)
    elevation = closed_forms.elevation_integral(fan, -fan / 2, fan / 2)
    checklist.near(
        "diffuse sphere of V6",
        220 + 10 * math.log10(1e-3 * azimuth * elevation / 25),
        153.50,
        0.01,
        " dB",
    )
    for pulse, energy, lobe in ((Pulse(), 1.370, -32.4), (Pulse("flat"), 1.080, -13.5)):
        envelope = closed_forms.Envelope(pulse)
        checklist.near(f"b int |s|^2 dt, {pulse.shape}", envelope.energy, energy, 0.001)
        checklist.near(
            f"highest side lobe, {pulse.shape}",
            measure.highest_side_lobe_db(envelope.power),
            lobe,
            0.05,
            " dB",
        )
    dense = np.linspace(0, 6, 60001)
    for shading, wanted in (
        (Shading("hann"), -31.47),
        (Shading("chebyshev", -35.0), -35.0),
        (Shading("chebyshev", -50.0), -50.0),
        (Shading("taylor", -35.0, 5), -35.2),
    ):
        lobe = measure.first_side_lobe_db(line_pattern(shading, dense) ** 2)
        checklist.near(f"first side lobe, {shading.kind}", lobe, wanted, 0.03, " dB")
        aperture = aperture_wavelengths(shading, beam)
        checklist.near(
            f"half power of {shading.kind} at half its width",
            float(line_pattern(shading, aperture * beam / 2)),
            math.sqrt(0.5),
            1e-9,
        )
    checklist.near(
        "aperture of an unshaded degree",
        aperture_wavelengths(Shading(), beam),
        SINC_WIDTH_FACTOR / beam,
        1e-12,
    )
    rows = ((0.0, -40.0), (90.0, -10.0))
    checklist.near(
        "a table halfway",
        10 * math.log10(backscatter_strength(Law("table", rows=rows), math.cos(math.radians(45)))),
        -25.0,
        1e-9,
        " dB",
    )


def test_mutations(checklist):
    for entry in mutations.read_list(mutations.HERE / "mutations.json", None):
        text = (mutations.ROOT / entry["file"]).read_text(encoding="utf-8")
        checklist.equal(f"{entry['file']}: lines of `{entry['text'].strip()[:40]}`", text.count(entry["text"]), 1)


def main():
    checklist = Checklist("selftest")
    test_rows(checklist)
    with tempfile.TemporaryDirectory() as folder:
        test_report(checklist, folder)
    test_measures(checklist)
    test_closed_forms(checklist)
    test_mutations(checklist)
    return checklist.finish()


if __name__ == "__main__":
    sys.exit(main())
