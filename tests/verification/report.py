"""The table of docs/verification.md: written, read again, compared by its numbers."""
import math
import re

HEAD = "| id | experiment | expected | obtained | tolerance | standard error | draws | |"
RULE = "|---|---|---|---|---|---|---|---|"
FIGURES = (
    ("azimuth", "Azimuth pattern of the receiver, one-way, against theory (V2, shading)."),
    ("pulses", "Range cuts of every pulse and window against theory (V3, pulse)."),
    ("speckle", "Intensity of the diffuse wall against the exponential (V4)."),
    ("sphere", "Level from the inside of a diffuse sphere against range (V6)."),
    ("kirchhoff", "Target strength of rigid bodies against the size of the cells (V18, V19, V20)."),
    ("facets", "Target strength of a coarse cylinder with a specular echo against its yaw (V20.mesh)."),
    ("laws", "Backscatter against grazing angle for every law (law)."),
    ("spheres", "Target strength of elastic spheres against frequency (sphere)."),
)
INTRODUCTION = """# Verification

What the program computes beside what it should compute. `tests/verification` writes small
scenarios, runs the program on them and works out the expected value from closed forms or
quadratures that share no code with it. The numbers V1 to V20 are those of
[closed_forms.md](physics/closed_forms.md). A row passes where obtained and expected differ
by no more than the tolerance.

Conditions unless said: 900 kHz, 29.9 kHz, 1500 m/s, beams of 1 by 20 degrees, 220 dB, no
absorption, calibrated. Seeds are fixed. "Draws" is the number of independent intensities that
gives the standard error.

Made by `./scripts/verify_physics.sh`, which needs a few minutes. `tests/verification/README.md`
says how to run a part of it and how the rows themselves are tested.
"""


def decimals(tolerance):
    """Digits after the point that show a hundredth of the tolerance."""
    if not tolerance > 0 or math.isnan(tolerance):
        return 6
    return max(0, 1 - math.floor(math.log10(tolerance)))


def number(value, tolerance):
    """A number rounded to what its tolerance makes meaningful."""
    if math.isnan(value):
        return "-"
    if tolerance == 0:
        return f"{value:g}"
    digits = decimals(tolerance)
    text = f"{value:.{digits}f}"
    if float(text) == 0.0 and value != 0.0 and tolerance < 2e-3:
        text = f"{value:.0e}"
    return re.sub(r"^-(0(\.0*)?)$", r"\1", text)


def short(value):
    """Tolerances and errors: two digits."""
    return "-" if value is None or math.isnan(value) else f"{value:.2g}"


def cells(row):
    """One row of the table as text."""
    verdict = "ok" if row.passed else "FAIL"
    trouble = f": {row.trouble}" if row.trouble else ""
    unit = f" {row.unit}" if row.unit else ""
    return [
        row.identity,
        row.experiment + trouble,
        number(row.expected, row.tolerance) + unit,
        number(row.obtained, row.tolerance) + unit,
        short(row.tolerance),
        short(row.standard_error),
        "-" if row.draws is None else str(row.draws),
        verdict,
    ]


def console_line(row):
    mark = "ok  " if row.passed else "FAIL"
    text = cells(row)
    error = f", s.e. {text[5]} from {text[6]}" if row.standard_error is not None else ""
    return f"{mark} {text[0]}: {text[1]}: {text[3]}, expected {text[2]} +- {text[4]}{error}"


def line(parts):
    """Of a table."""
    return "| " + " | ".join(part.replace("|", "\\|") for part in parts) + " |"


def write(path, rows):
    """The whole page."""
    lines = [INTRODUCTION, "## Table\n", HEAD, RULE, *(line(cells(row)) for row in rows)]
    lines.append("\n## Figures\n")
    for name, words in FIGURES:
        lines += [f"{words}\n", f"![{words}](figures/{name}.png)\n"]
    with open(path, "w", encoding="utf-8") as stream:
        stream.write("\n".join(lines).rstrip() + "\n")


def first_number(text):
    found = re.match(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", text.strip())
    return float(found.group(0)) if found else math.nan


def read(path, expected_at={8: 2}):
    """Rows of written tables by id: (expected, obtained, verdict). expected_at: number of cells to that of `expected`."""
    found = {}
    with open(path, encoding="utf-8") as stream:
        for text in stream:
            parts = [part.strip() for part in text.strip().strip("|").split(" | ")]
            if not text.startswith("| ") or len(parts) not in expected_at or parts[0] == "id":
                continue
            if parts[0] in found:
                raise ValueError(f"{path}: {parts[0]} stands twice")
            at = expected_at[len(parts)]
            found[parts[0]] = (first_number(parts[at]), first_number(parts[at + 1]), parts[-1].strip("| "))
    return found


def differences(path, rows):
    """What a written table says otherwise than today's rows."""
    written, faults = read(path), []
    fresh = {row.identity: row for row in rows}
    faults += [f"{name}: stands in {path}, was not made" for name in written if name not in fresh]
    for name, row in fresh.items():
        if name not in written:
            faults.append(f"{name}: not in {path}")
            continue
        expected, obtained, verdict = written[name]
        # Rounding of the text: a hundredth of the tolerance.
        allowed = row.tolerance * 1.01 if row.tolerance > 0 else 1e-9
        for what, old, new in (
            ("expected", expected, row.expected),
            ("obtained", obtained, row.obtained),
        ):
            if not abs(old - new) <= allowed:
                faults.append(f"{name}: {what} {old:g} in {path}, now {new:g}")
        if verdict != "ok":
            faults.append(f"{name}: {verdict} in {path}")
    return faults
