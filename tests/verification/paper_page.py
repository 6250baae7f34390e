"""The page docs/paper.md: written, and compared by its numbers."""
import textwrap

import report
from report import line
from paper_times import BEGIN, END

INTRODUCTION = """# The paper's figures

This page reproduces figures 7 to 11 and both tables of Choi et al. 2021, "Physics-Based Modelling and Simulation of
Multibeam Echosounder Perception for Autonomous Underwater Manipulation", with ensonify. `./scripts/paper_figures.sh`
writes it.

The data behind the paper's figures are not public, so nothing is compared pixel by pixel. Each row compares one
statement with the scene, over {pings} pings where it is statistical. The statements are in our own words and rest on:

| rests on | meaning |
|---|---|
| set-up | the expected number follows from sizes, places or reflectivities in the paper |
| equation | an equation of the paper gives the number |
| model | we know of no number in the paper; the expected one follows from its equations and the geometry of our scene, traced by independent code (`tests/verification/paper_tank.py`). The row agrees with the model, no more |

Expected and obtained numbers agree within the tolerance. It is three standard errors where one is given ("draws":
pings or intensities). [paper_decisions.md](physics/paper_decisions.md) lists where the paper is unclear and what was
decided. Colors are levels in dB of ping 0.
"""
HEAD = (
    "| id | the paper, or what its equations give | rests on | what is measured | expected | "
    "obtained | tolerance | standard error | draws | agrees |\n|---|---|---|---|---|---|---|---|---|---|"
)
FIGURES = {
    "7": (
        "Figure 7: one beam of the tank against range",
        "`scenes/sonar_tank.yaml`. Left: the beam through the cylinder; right: a beam on the wall. We do not "
        "know which beam the paper shows. Dotted: the bandwidth printed in Table 1, which is too coarse "
        "for the paper's own images.",
    ),
    "8": (
        "Figure 8: the fan of the tank",
        "`scenes/sonar_tank.yaml`, polar and Cartesian.",
    ),
    "9": (
        "Figure 9: one reflectivity 20 dB lower",
        "`scenes/tank_dim_wall.yaml` and `scenes/tank_dim_target.yaml`, on the scale of figure 8. The "
        "seed and the speckle are the same, so the change is exact.",
    ),
    "10": (
        "Figure 10: two cylinders",
        "`scenes/two_cylinders.yaml`. The reflectivities are the paper's; the places may not be.",
    ),
    "11": (
        "Figure 11: cylinders that lean",
        "`scenes/tilted_cylinders.yaml`: the port cylinder leans by 45° across the line of sight, the "
        "starboard one by 45° along it. Sizes and places may not be the paper's. Extents are those of "
        "the mean power within 20 dB of the object's peak, before the wall.",
    ),
}
TABLE_1 = """The column of the paper holds what we know of its table. The scenes use the preset `paper_table1` with
the bandwidth of the published code.

| | the paper | preset `paper_table1` | `scenes/sonar_tank.yaml` | agrees |
|---|---|---|---|---|"""
TABLE_1_NOTE = """
We do not use the printed bandwidth: the text gives it in another unit, the paper's images are finer
than bins of 25 cm, and the published code runs at 29.9 kHz.
"""
TABLE_2 = """We know the paper's times of its full calculation on an RTX 2080 Ti, but not the layout of the table or the
times of its reduced calculation, which our case `reduced` follows. The paper's stages below add up to
1.64 s, but 0.5 pings/s are 2 s. [performance.md](performance.md) describes the cases.
"""
TABLE_2_NOTE = """
The paper measured a graphics card, we measured processor cores, so the table compares waiting times and not
code. The CUDA backend has no times yet. `./scripts/paper_figures.sh --keep-times` keeps these times.
"""
DIFFERENCES = """[paper_decisions.md](physics/paper_decisions.md) lists all differences. These change the mean power in the tank of figure 8:

| id | choice | what is measured | expected | obtained | agrees |
|---|---|---|---|---|---|"""
DIFFERENCES_NOTE = """
The published code also takes the absolute value of the azimuth pattern (Eq 17); we keep its sign. This does
not change the mean power of diffuse echoes, but that of a target that echoes in phase over several beams.
"""


def cells(claim):
    """A claim as text, but for the verdict."""
    row = claim.row
    identity, measured, expected, obtained, tolerance, error, draws, _ = report.cells(row)
    return [
        identity,
        claim.paper,
        claim.source,
        measured,
        expected,
        obtained,
        tolerance,
        error,
        draws,
        claim.verdict,
    ]


def figure_section(number, claims):
    title, words = FIGURES[number]
    words = textwrap.fill(words, 100, break_on_hyphens=False)
    rows = [line(cells(claim)) for claim in claims if claim.figure == number]
    picture = f"![{title}.](figures/paper_fig{number}.png)"
    return "\n".join([f"## {title}\n", words + "\n", picture + "\n", HEAD, *rows, ""])


def summary(claims):
    agreeing = sum(claim.row.passed for claim in claims)
    by_model = sum(claim.verdict == "yes (model)" for claim in claims)
    return (
        f"{agreeing} of {len(claims)} rows agree, {by_model} of them with the model only.\n"
    )


def page(claims, parameters, times, pings):
    """The whole text."""
    parts = [INTRODUCTION.format(pings=pings), summary(claims)]
    parts += [figure_section(number, claims) for number in FIGURES]
    parts += ["## Table 1: the sonar\n", TABLE_1]
    parts[-1] += "".join("\n" + line(row) for row in parameters)
    parts += [TABLE_1_NOTE, HEAD]
    parts[-1] += "".join("\n" + line(cells(c)) for c in claims if c.figure == "Table 1")
    parts += ["\n## Table 2: run times\n", TABLE_2, f"{BEGIN}\n{times}\n{END}", TABLE_2_NOTE]
    parts += ["## Where we differ on purpose\n", DIFFERENCES]
    for claim in (claim for claim in claims if claim.figure == "differences"):
        identity, words, _, measured, expected, obtained, *_, verdict = cells(claim)
        parts[-1] += "\n" + line([identity, words, measured, expected, obtained, verdict])
    parts.append(DIFFERENCES_NOTE)
    return "\n".join(parts).rstrip() + "\n"


def differences(path, claims):
    """What a page says otherwise than today's claims. A row passes its tolerance on both sides."""
    there, faults = report.read(path, {10: 4, 6: 3}), []
    fresh = {claim.row.identity: claim for claim in claims}
    if there.keys() != fresh.keys():
        faults.append(f"{path}: other rows than today's: {sorted(there.keys() ^ fresh.keys())}")
    for identity in (name for name in there if name in fresh):
        expected, obtained, verdict = there[identity]
        claim = fresh[identity]
        row = claim.row
        if not abs(expected - row.expected) <= row.tolerance:
            faults.append(f"{identity}: expected {expected:g} in {path}, now {row.expected:g}")
        # A statistical row of few pings may lie three of its errors off; it has passed by itself.
        if row.standard_error is None and not abs(obtained - row.obtained) <= row.tolerance:
            faults.append(f"{identity}: obtained {obtained:g} in {path}, now {row.obtained:g}")
        if not verdict.startswith("yes"):
            faults.append(f"{identity}: {verdict} in {path}")
    return faults
