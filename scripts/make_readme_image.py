#!/usr/bin/env python3
"""Makes docs/figures/readme.webp, the image at the top of README.md: one ping and three of its labels.

    scripts/make_readme_image.py [--program PROGRAM]

It is the first ping of scenes/stony_seabed.yaml, seen from above. This script colors the panels from the polar
arrays; the texts are titles that `ensonify figure` draws. Needs NumPy, cwebp and dwebp.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from ensonify_dataset import SonarDataset  # noqa: E402

SCENE = ROOT / "scenes/stony_seabed.yaml"
IMAGE = ROOT / "docs/figures/readme.webp"
LARGEST_BYTES = 300_000
NEAREST_M = 2.3           # nearer samples hold no echo
PIXELS_PER_M = 66
OVERSAMPLING = 3
MARGIN_PX, TITLE_PX = 12, 50
TITLE_FIGURE_PX, LEGEND_FIGURE_PX = 1100, 800   # widths of the figures, whose titles grow with them
LIMITS_DB = 70, 121
BACKGROUND, WHITE = np.array([16, 22, 34.0]), np.array([240, 243, 248.0])
SEABED, TYRE, CRAB_POT = np.array([[150, 118, 74], [86, 190, 245], [255, 92, 138.0]])
# Colors of the levels from low to high, at equal steps.
LEVELS = np.array([(4, 4, 20), (40, 11, 84), (101, 21, 110), (159, 42, 99), (212, 72, 66), (245, 125, 21),
                   (250, 193, 39), (252, 255, 190)], float)


def run(*words, data=None):
    return subprocess.run(list(map(str, words)), input=data, stdout=subprocess.PIPE, check=True).stdout


def share(level_db):
    """0 to 1 between the limits."""
    return np.clip((level_db - LIMITS_DB[0]) / (LIMITS_DB[1] - LIMITS_DB[0]), 0, 1)


def colored(level_db):
    place = share(level_db) * (len(LEVELS) - 1)
    return np.stack([np.interp(place, range(len(LEVELS)), LEVELS[:, channel]) for channel in range(3)], axis=-1)


def painted(ping, ids, colors, opacity):
    """The expected level in dark gray, with the color of each id over it."""
    image = (20 + 150 * share(ping.polar.clean_db))[..., None].repeat(3, axis=2)
    for number, color in colors.items():
        inside = ids == number
        image[inside] = (1 - opacity[number]) * image[inside] + opacity[number] * color
    return image


def fan(ping, image):
    """An image [samples, beams, 3] as seen from above: ahead is up, port is left."""
    azimuth, range_m = np.asarray(ping.sequence.azimuth_rad), np.asarray(ping.sequence.range_m)
    edge, fine = azimuth[-1] + (azimuth[1] - azimuth[0]) / 2, PIXELS_PER_M * OVERSAMPLING
    half = round(range_m[-1] * np.sin(edge) * PIXELS_PER_M)
    rows = round((range_m[-1] - NEAREST_M * np.cos(edge)) * PIXELS_PER_M)
    x = range_m[-1] - (np.arange(rows * OVERSAMPLING) + 0.5)[:, None] / fine
    y = (half * OVERSAMPLING - np.arange(2 * half * OVERSAMPLING) - 0.5)[None, :] / fine
    r, theta = np.hypot(x, y), np.arctan2(y, x)
    sample = np.clip(np.rint(r / (range_m[1] - range_m[0])), 0, len(range_m) - 1).astype(int)
    beam = np.clip(np.rint(np.interp(theta, azimuth, np.arange(len(azimuth)))), 0, len(azimuth) - 1).astype(int)
    inside = (abs(theta) < edge) & (r > NEAREST_M) & (r < range_m[-1])
    out = np.where(inside[..., None], image[sample, beam], BACKGROUND)
    return out.reshape(rows, OVERSAMPLING, 2 * half, OVERSAMPLING, 3).mean(axis=(1, 3))


def text(program, folder, words, width_px):
    """The ink of a text, 0 to 1, cut from the title of a figure of that width."""
    run(program, "figure", folder / "data", "-o", folder / "text.png", "--title", words, "--width-px", width_px,
        "--overwrite", "--quiet")
    webp = run("cwebp", "-quiet", "-lossless", folder / "text.png", "-o", "-")
    _, size, _, pixels = run("dwebp", "-quiet", "-ppm", "-o", "-", "--", "-", data=webp).split(b"\n", 3)
    width, height = map(int, size.split())
    title = np.frombuffer(pixels, np.uint8).reshape(height, width, 3)[:round(0.05 * width)].mean(axis=2)
    ink = 1 - (title - title.min()) / (255 - title.min())
    columns = np.flatnonzero(ink.max(axis=0) > 0.05)
    return ink[:, columns[0]:columns[-1] + 1]


def write(canvas, ink, left, top, color):
    part = canvas[top:top + ink.shape[0], left:left + ink.shape[1]]
    part += ink[..., None] * (color - part)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "build/release/ensonify", help="the built ensonify")
    program = parser.parse_args().program
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(program, "generate", SCENE, "-o", folder / "data", "--pings", "0:1", "--quiet")
        ping = SonarDataset(folder / "data")[0]
        things = {2: TYRE, 3: CRAB_POT}
        panels = {
            "Sonar image": colored(ping.polar.level_db),
            "Expected level": colored(ping.polar.clean_db),
            "Instances": painted(ping, ping.polar.instance, {1: SEABED, **things}, {1: 0.45, 2: 0.9, 3: 0.9}),
            "Shadows": painted(ping, ping.polar.shadow, things, {2: 0.9, 3: 0.9}),
        }
        fans = [fan(ping, image) for image in panels.values()]
        height, width, _ = fans[0].shape
        canvas = np.tile(BACKGROUND, (TITLE_PX + height + MARGIN_PX, 4 * (width + MARGIN_PX) + MARGIN_PX, 1))
        for column, (title, image) in enumerate(zip(panels, fans)):
            left = MARGIN_PX + column * (width + MARGIN_PX)
            canvas[TITLE_PX:TITLE_PX + height, left:left + width] = image
            ink = text(program, folder, title, TITLE_FIGURE_PX)
            write(canvas, ink, left + (width - ink.shape[1]) // 2, 0, WHITE)
        beams = np.degrees(ping.sequence.azimuth_rad)
        fov_deg = round(beams[-1] - beams[0] + beams[1] - beams[0])
        legends = {2: (("seabed", SEABED + 60), ("tyre", TYRE), ("crab pot", CRAB_POT)),
                   3: (("tyre", TYRE), ("crab pot", CRAB_POT)),
                   0: ((f"{ping.sequence.range_m[-1]:.0f} m, {fov_deg}\N{DEGREE SIGN}", WHITE),)}
        for column, legend in legends.items():
            for row, (words, color) in enumerate(reversed(legend)):
                ink = text(program, folder, words, LEGEND_FIGURE_PX)
                write(canvas, ink, MARGIN_PX + column * (width + MARGIN_PX), canvas.shape[0] - 46 - 30 * row, color)
        ppm = b"P6\n%d %d\n255\n" % canvas.shape[1::-1] + np.rint(canvas).clip(0, 255).astype(np.uint8).tobytes()
        (folder / "image.ppm").write_bytes(ppm)
        run("cwebp", "-quiet", "-m", "6", "-q", "82", "-sharp_yuv", folder / "image.ppm", "-o", IMAGE)
    if IMAGE.stat().st_size > LARGEST_BYTES:
        raise SystemExit(f"{IMAGE}: {IMAGE.stat().st_size} bytes; expected at most {LARGEST_BYTES}")


if __name__ == "__main__":
    main()
