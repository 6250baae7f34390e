"""The figures of docs/verification.md, from the curves that the cases kept. Needs matplotlib."""
import os

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

plt.rcParams.update({"font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.0})
MOST_POINTS = 240


def thinned(x, y):
    """At most MOST_POINTS of a curve."""
    step = max(1, -(-len(x) // MOST_POINTS))
    return x[::step], y[::step]


def grid_of(curves, columns, low_db, x_label):
    """One small panel for each curve: obtained as points on the line of theory."""
    rows = -(-len(curves) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(2.6 * columns, 1.7 * rows), sharex=True, sharey=True, squeeze=False
    )
    for axis in axes.flat[len(curves) :]:
        axis.set_visible(False)
    for axis, (label, x, obtained, expected) in zip(axes.flat, curves):
        axis.plot(*thinned(x, expected), color="0.4")
        axis.plot(*thinned(x, obtained), ".", markersize=1.6, color="C0")
        axis.set_title(label, fontsize=8)
        axis.set_ylim(low_db, 3)
    for axis in axes[-1]:
        axis.set_xlabel(x_label)
    for axis in axes[:, 0]:
        axis.set_ylabel("dB")
    return figure


def single(x_label, y_label):
    figure, axis = plt.subplots(figsize=(4.6, 3.0))
    axis.set_xlabel(x_label)
    axis.set_ylabel(y_label)
    return figure, axis


def azimuth(curves):
    return grid_of(curves, 3, -60, "azimuth, degrees")


def pulses(curves):
    return grid_of(curves, 4, -80, "samples off the delay")


def speckle(curves):
    figure, axis = single("intensity / clean", "probability density")
    for label, x, obtained, expected in curves:
        axis.semilogy(x, expected, color="0.4", label="exponential")
        axis.semilogy(x, np.maximum(obtained, 1e-6), ".", label=label)
    axis.legend()
    return figure


def sphere(curves):
    figure, axis = single("radius, m", "mean level at 2r/c, dB re 1 µPa")
    for label, x, obtained, expected in curves:
        if expected is not None:
            axis.plot(x, expected, color="0.4", label=label)
        else:
            axis.plot(x, obtained, "o", label=label)
    axis.legend()
    return figure


def kirchhoff(curves):
    figure, axis = single("side of a cell, mm", "TS less closed form, dB")
    for label, x, obtained, _ in curves:
        axis.semilogx(x, obtained, ".-", label=label)
    axis.axhline(0.0, color="0.4")
    axis.set_ylim(-1.0, 1.0)
    axis.legend()
    return figure


def facets(curves):
    figure, axis = single("yaw, degrees", "target strength, dB")
    for label, x, obtained, expected in curves:
        axis.plot(x, obtained, ".-", label=label)
    axis.plot(x, expected, color="0.4", label="cylinder (V20)")
    axis.legend()
    return figure


def laws(curves):
    figure, axis = single("grazing angle, degrees", "backscatter strength, dB")
    colours = {}
    for label, x, obtained, expected in curves:
        colour = colours.setdefault(label, f"C{len(colours)}")
        if expected is not None:
            axis.plot(x, expected, color=colour, label=label)
        else:
            axis.plot(x, obtained, "o", markersize=3, color=colour)
    axis.set_ylim(-65, -8)
    axis.legend()
    return figure


def spheres(curves):
    figure, axis = single("frequency, kHz", "target strength, dB")
    for i, (label, x, obtained, expected) in enumerate(curves):
        axis.plot(x, expected, color="0.4")
        axis.plot(x, obtained, ".", markersize=2, color=f"C{i}", label=label)
    axis.legend()
    return figure


FIGURES = {
    "azimuth": azimuth,
    "pulses": pulses,
    "speckle": speckle,
    "sphere": sphere,
    "kirchhoff": kirchhoff,
    "facets": facets,
    "laws": laws,
    "spheres": spheres,
}


def draw_all(curves, folder):
    """Every figure whose case gave curves."""
    os.makedirs(folder, exist_ok=True)
    for name, draw in FIGURES.items():
        if name in curves:
            figure = draw(curves[name])
            figure.tight_layout()
            figure.savefig(
                os.path.join(folder, f"{name}.png"), dpi=110, metadata={"Software": None}
            )
            plt.close(figure)
