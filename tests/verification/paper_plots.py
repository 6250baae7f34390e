"""The pictures of docs/paper.md. Needs matplotlib and what it draws with, Pillow."""
import io
import os

import matplotlib
import numpy as np
from PIL import Image

from paper_sonar import TABLE_1

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

plt.rcParams.update({"font.size": 8, "lines.linewidth": 1.0, "figure.constrained_layout.use": True})
PIXEL_M, FAR_M, SIDE_M = 0.025, 6.5, 5.5
DEPTH_DB = 50


def level(power):
    return 10 * np.log10(np.maximum(power, 1e-30)) + 120


def saved(figure, folder, name):
    """A PNG without the name of what drew it, as small as it gets."""
    raw = io.BytesIO()
    figure.savefig(raw, dpi=100, metadata={"Software": None})
    plt.close(figure)
    picture = Image.open(raw).convert("RGB")
    picture.save(os.path.join(folder, f"paper_{name}.png"), optimize=True)


def cartesian(scene, power):
    """Nearest pixel of the fan on a grid of PIXEL_M; NaN outside the fan."""
    ahead = np.arange(FAR_M, 0, -PIXEL_M) - PIXEL_M / 2
    aside = np.arange(SIDE_M, -SIDE_M, -PIXEL_M) - PIXEL_M / 2
    x, y = np.meshgrid(ahead, aside, indexing="ij")
    beam = np.degrees(np.arctan2(y, x)) / np.degrees(scene.sonar.spacing_rad)
    beam = np.round(beam + (scene.sonar.beams - 1) / 2).astype(int)
    sample = np.round(np.hypot(x, y) / scene.sonar.range_step_m).astype(int)
    inside = (beam >= 0) & (beam < scene.sonar.beams) & (sample < scene.sonar.samples)
    picture = np.full(x.shape, np.nan)
    picture[inside] = level(power[beam[inside], sample[inside]])
    return picture


def draw_fan(axis, scene, power, top_db, title=""):
    """The Cartesian fan, port to the left."""
    shown = axis.imshow(
        cartesian(scene, power),
        extent=(SIDE_M, -SIDE_M, 0, FAR_M),
        cmap="viridis",
        vmin=top_db - DEPTH_DB,
        vmax=top_db,
        interpolation="nearest",
    )
    axis.set_xlabel("y (port), m")
    axis.set_ylabel("x, m")
    axis.set_title(title, fontsize=8)
    return shown


def top_of(scene):
    return float(np.ceil(level(scene.power(0)).max() / 5) * 5)


def figure_7(tanks, folder):
    scene, printed = tanks.get("sonar_tank"), tanks.get("sonar_tank", TABLE_1, pings=1)
    one, mean, expected = scene.power(0), scene.mean_power(), scene.expected()
    coarse = printed.expected()
    figure, axes = plt.subplots(1, 2, figsize=(7.4, 3.0), sharey=True)
    for axis, degrees in zip(axes, (0.0, 8.0)):
        beam = scene.beam_at(degrees)
        axis.plot(scene.range_m, level(one[beam]), color="0.75", label="one ping")
        axis.plot(scene.range_m, level(mean[beam]), color="0.2", label="mean of pings")
        axis.plot(
            scene.range_m, level(expected[beam]), "--", color="C2", label="expected, other code"
        )
        axis.plot(
            printed.range_m,
            level(coarse[beam]),
            ":.",
            markersize=4,
            color="C0",
            label="expected at 2.95 kHz",
        )
        axis.set_xlim(3, 7)
        axis.set_ylim(top_of(scene) - 70, top_of(scene))
        axis.set_title(f"beam at {scene.azimuth_deg[beam]:.1f} degrees", fontsize=8)
        axis.set_xlabel("range, m")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("level, dB re 1 µPa")
    axes[1].legend(loc="lower right", fontsize=7)
    saved(figure, folder, "fig7")


def figure_8(tanks, folder):
    scene = tanks.get("sonar_tank")
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 3.0), width_ratios=(1, 1.25))
    near = scene.range_m < 8
    axes[0].imshow(
        level(scene.power(0)[:, near]).T,
        origin="lower",
        aspect="auto",
        extent=(scene.azimuth_deg[0], scene.azimuth_deg[-1], 0, scene.range_m[near][-1]),
        cmap="viridis",
        vmin=top_of(scene) - DEPTH_DB,
        vmax=top_of(scene),
    )
    axes[0].invert_xaxis()
    axes[0].set_xlabel("azimuth (port to the left), degrees")
    axes[0].set_ylabel("range, m")
    shown = draw_fan(axes[1], scene, scene.power(0), top_of(scene))
    figure.colorbar(shown, ax=axes[1], label="dB re 1 µPa", shrink=0.8)
    saved(figure, folder, "fig8")


def figure_9(tanks, folder):
    top = top_of(tanks.get("sonar_tank"))
    figure, axes = plt.subplots(1, 2, figsize=(7.6, 2.8), sharey=True)
    pairs = (("tank_dim_wall", "wall 1e-5"), ("tank_dim_target", "cylinder 1e-5"))
    for axis, (name, title) in zip(axes, pairs):
        scene = tanks.get(name, like="sonar_tank", pings=1)
        shown = draw_fan(axis, scene, scene.power(0), top, title)
    axes[1].set_ylabel("")
    figure.colorbar(shown, ax=axes, label="dB re 1 µPa", shrink=0.8)
    saved(figure, folder, "fig9")


def single_fan(tanks, folder, name, scene_name):
    scene = tanks.get(scene_name)
    figure, axis = plt.subplots(figsize=(5.4, 3.2))
    shown = draw_fan(axis, scene, scene.power(0), top_of(scene))
    figure.colorbar(shown, ax=axis, label="dB re 1 µPa", shrink=0.9)
    saved(figure, folder, name)


def draw_all(tanks, folder):
    """Every figure of the page."""
    os.makedirs(folder, exist_ok=True)
    figure_7(tanks, folder)
    figure_8(tanks, folder)
    figure_9(tanks, folder)
    single_fan(tanks, folder, "fig10", "two_cylinders")
    single_fan(tanks, folder, "fig11", "tilted_cylinders")
