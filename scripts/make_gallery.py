#!/usr/bin/env python3
"""Makes docs/figures/gallery/NAME.webp, the images of docs/gallery.md: one ping of each scene.

    scripts/make_gallery.py [--program PROGRAM] [NAME...]

Each is the 8-bit Cartesian image of the ping at the scene's own settings, without empty borders
behind and at the sides, reduced to 320 pixels. Without a NAME all scenes are made. Needs NumPy and cwebp.
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

WIDEST_PX = 320
LARGEST_BYTES = 25_000
QUALITIES = (80, 65, 50, 35, 20)

# The ping of scenes whose first ping does not show what the scene is about.
PING = {"pile_inspection": 30, "wreck_survey": 8}
# Settings of scenes that keep no pings, or that have worlds that the image does not need.
SETTINGS = {
    "random_debris": ["sequences=1"],
    "watertank": ["sequences=1", "output.cartesian={height_px: 1000}", "output.png=true"],
    "speckle_wall": ["output.statistics=false", "output.pings=true"],
}


def generate(program, scene, folder):
    """Generates one ping; returns it, as the reader opens it, and its Cartesian image file."""
    ping = PING.get(scene.stem, 0)
    settings = ["output.timeseries=none", *SETTINGS.get(scene.stem, [])]
    options = [word for setting in settings for word in ("--set", setting)]
    subprocess.run([program, "generate", scene, "-o", folder, "--pings", f"{ping}:{ping + 1}", "--quiet", *options],
                   check=True)
    return SonarDataset(folder)[0, ping], folder / f"sequences/000000/png/{ping:06}_cartesian.png"


def bounds(image):
    """(left, top, width, height) of the pixels that are not black, down to the sonar in the last row."""
    rows, columns = np.flatnonzero(image.any(axis=1)), np.flatnonzero(image.any(axis=0))
    return columns[0], rows[0], columns[-1] - columns[0] + 1, image.shape[0] - rows[0]


def encode(png, crop, file):
    """The part of the image as WebP, in the best quality that is small enough."""
    wide = crop[2] >= crop[3]
    size = (min(crop[2], WIDEST_PX), 0) if wide else (0, min(crop[3], WIDEST_PX))
    for quality in QUALITIES:
        subprocess.run(["cwebp", "-quiet", "-mt", "-m", "6", "-q", str(quality), "-crop", *map(str, crop),
                        "-resize", *map(str, size), str(png), "-o", str(file)], check=True)
        if file.stat().st_size <= LARGEST_BYTES:
            return
    raise SystemExit(f"{file}: {file.stat().st_size} bytes at quality {quality}; expected at most {LARGEST_BYTES}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "build/release/ensonify", help="the built ensonify")
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes, without .yaml")
    arguments = parser.parse_args()
    images = ROOT / "docs/figures/gallery"
    images.mkdir(exist_ok=True)
    for name in arguments.names or sorted(path.stem for path in (ROOT / "scenes").glob("*.yaml")):
        with tempfile.TemporaryDirectory() as folder:
            ping, png = generate(arguments.program, ROOT / f"scenes/{name}.yaml", pathlib.Path(folder) / name)
            encode(png, bounds(ping.cartesian.grey), images / f"{name}.webp")


if __name__ == "__main__":
    main()
