#!/usr/bin/env python3
"""Makes docs/figures/gallery/NAME.webp, the images of docs/gallery.md: one ping of each scene.

    scripts/make_gallery.py [--program PROGRAM] [NAME...]

Each is the 8-bit Cartesian image of the ping at the scene's own settings, without empty borders
behind and at the sides, reduced to 320 pixels. Those of the sonars of a rig stand side by side, then the
image of a camera, alone and with the levels of the first sonar. Without a NAME all scenes are made. Needs
NumPy and cwebp.
"""
import argparse
import json
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
PING = {"pile_inspection": 30, "wreck_camera": 2, "wreck_survey": 8}
# Settings of scenes that keep no pings, or that have worlds that the image does not need.
SETTINGS = {
    "random_debris": ["sequences=1"],
    "watertank": ["sequences=1", "output.cartesian={height_px: 1000}", "output.png=true"],
    "stereo_pair": ["output.cartesian={height_px: 240}"],
    "wreck_camera": ["output.cartesian={height_px: 320}"],
    "speckle_wall": ["output.statistics=false", "output.pings=true"],
}


def generate(program, scene, folder):
    """Generates one ping of the scene; returns those of its sonars and cameras, as the reader opens them."""
    ping = PING.get(scene.stem, 0)
    settings = ["output.timeseries=none", *SETTINGS.get(scene.stem, [])]
    options = [word for setting in settings for word in ("--set", setting)]
    subprocess.run([program, "generate", scene, "-o", folder, "--pings", f"{ping}:{ping + 1}", "--sequences", "0:1",
                    "--quiet", *options], check=True)
    rig = folder / "rig.json"
    names = [entry["name"] for entry in json.loads(rig.read_text())["instruments"]
             if entry["kind"] != "navigation"] if rig.exists() else [""]
    return [SonarDataset(folder / name)[0] for name in names]


def cut(image):
    """The image without what is black at the sides and above, down to the sonar in the last row."""
    rows, columns = np.flatnonzero(image.any(axis=1)), np.flatnonzero(image.any(axis=0))
    return image[rows[0]:, columns[0]:columns[-1] + 1]


def with_levels(camera, ping):
    """The camera's image with the gray of the sonar's levels where its pixels are."""
    image, polar = camera.color.copy(), ping.polar
    sample, beam = np.nonzero(polar.instance)
    pixels, seen = camera.from_sonar(sample, beam, polar.elevation_rad[sample, beam], ping)
    column, row = np.rint(pixels[seen]).astype(int).T
    image[row, column] = polar.grey[sample, beam][seen][:, None]
    return image


def panels(pings):
    sonars = [ping for ping in pings if "sonar" in ping.sequence.info]
    yield from (np.repeat(cut(ping.cartesian.grey)[..., None], 3, axis=2) for ping in sonars)
    for ping in pings:
        if ping not in sonars:
            yield from (ping.camera.color, with_levels(ping.camera, sonars[0]))


def side_by_side(images):
    height = max(image.shape[0] for image in images)
    return np.hstack([np.pad(image, ((height - len(image), 0), (0, 4 * (k < len(images) - 1)), (0, 0)))
                      for k, image in enumerate(images)])


def encode(images, file):
    """The images next to each other as WebP, in the best quality that is small enough."""
    image = side_by_side(images)
    height, width = image.shape[:2]
    widest = WIDEST_PX * len(images)
    size = (min(width, widest), 0) if width >= height else (0, min(height, widest))
    for quality in QUALITIES:
        subprocess.run(["cwebp", "-quiet", "-mt", "-m", "6", "-q", str(quality), "-resize", *map(str, size), "-o", str(file),
                        "--", "-"], check=True, input=b"P6\n%d %d\n255\n" % (width, height) + image.tobytes())
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
    for scene in sorted((ROOT / "scenes").rglob("*.yaml")):
        if arguments.names and scene.stem not in arguments.names:
            continue
        with tempfile.TemporaryDirectory() as folder:
            pings = generate(arguments.program, scene, pathlib.Path(folder) / scene.stem)
            encode(list(panels(pings)), images / f"{scene.stem}.webp")


if __name__ == "__main__":
    main()
