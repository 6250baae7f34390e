"""Crops of real and of simulated images, as arrays with the sonar at the top.

    real_crops(folder, blocks)      [RealCrop, ...] of the class folders
    simulated_crops(sets, ...)      [SimulatedCrop, ...] of data sets of the program

A real crop is an 8-bit image. A simulated crop holds levels in dB, which display.py turns into 8-bit images.
"""
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from ensonify_dataset import SonarDataset

from .data_sets import painted_level_db
from .targets import CLASSES, TARGETS

SPREADING = 30          # dB of gain for each tenfold of range
MOST_BESIDE, MOST_BEFORE = 0.4, 0.35     # the largest margins of a simulated crop, of its box
VISIBLE_DB = 20         # below the strongest expected level of the target, what a person still takes for a part of it
SMALLEST_BOX_PX, SMALLEST_AREA_PX, SMALLEST_CROP_PX = 6, 25, 14
NO_ECHO_DB = -300.0
CROP_SEED = 11


@dataclass
class RealCrop:
    class_id: int
    name: str
    block: int
    half: int               # 0 or 1 in turn for runs of a quarter block, for comparing real crops with real ones
    gray: np.ndarray        # uint8
    jpeg_tables: dict       # of its compression; None without


@dataclass
class SimulatedCrop:
    class_id: int
    name: str
    block: int
    level_db: dict          # {"ours": ..., "painted": ..., "clean": ...}, with gain; NO_ECHO_DB outside the fan


def block_of(place, count, blocks):
    """The number of the block that holds an item, of `blocks` equal runs of `count` items in order."""
    return place * blocks // count


def real_crops(folder, blocks):
    """All images of the class folders; the frames of a recording have consecutive numbers, and so share a block."""
    crops = []
    for class_id, kind in enumerate(CLASSES):
        files = [file for file in Path(folder, kind).glob("*") if file.suffix.lower() in (".jpg", ".jpeg", ".png")]
        numbered = sorted((int((re.findall(r"\d+", file.stem) or ["0"])[-1]), file) for file in files)
        if len(numbered) < blocks:
            sys.exit(f"real_study: {Path(folder, kind)} has {len(numbered)} images; expected at least {blocks}")
        for place, (_, file) in enumerate(numbered):
            with Image.open(file) as image:
                gray, tables = np.array(image.convert("L")), getattr(image, "quantization", None)
            block, half = (block_of(place, len(numbered), runs) for runs in (blocks, 4 * blocks))
            crops.append(RealCrop(class_id, f"{kind}/{file.name}", block, half % 2, gray, tables))
    return crops


def mirrored_pixels(sequence):
    """The map from pixels to polar cells of a viewer that draws the sector of each beam mirrored in azimuth: within a
    beam, rows of pixels cross the samples in the wrong direction. -1 outside the fan."""
    pixels, grid = sequence.cartesian_map, sequence.info["cartesian"]
    row, column = np.nonzero(pixels >= 0)
    ahead_m = grid["x_top_m"] - (row + 0.5) * grid["metres_per_pixel"]
    port_m = grid["y_left_m"] - (column + 0.5) * grid["metres_per_pixel"]
    beams, range_m = len(sequence.azimuth_rad), sequence.range_m
    beam = pixels[row, column] % beams
    azimuth_rad = 2 * sequence.azimuth_rad[beam] - np.arctan2(port_m, ahead_m)
    sample = np.rint((ahead_m / np.cos(azimuth_rad) - range_m[0]) / (range_m[1] - range_m[0])).astype(int)
    mirrored = np.full_like(pixels, -1)
    mirrored[row, column] = np.clip(sample, 0, len(range_m) - 1) * beams + beam
    return mirrored


def with_gain(ping, polar_level_db, pixels):
    """The Cartesian image of polar levels by a map of its pixels, with time-varied gain."""
    sequence = ping.sequence
    range_m = np.maximum(sequence.range_m, 0.2)
    gain_db = SPREADING * np.log10(range_m) + 2 * sequence.info["water"]["absorption_db_m"] * range_m
    shown = polar_level_db + gain_db[:, None]
    return np.where(pixels < 0, NO_ECHO_DB, shown.ravel()[np.maximum(pixels, 0)])


def cut(box, shape, most_behind, rng):
    """Slices of rows and columns around a box [x, y, width, height], with random margins; None if too small."""
    x, y, width, height = box
    most = np.array([MOST_BESIDE, MOST_BESIDE, most_behind, MOST_BEFORE])
    left, right, top, bottom = rng.uniform(0, most) * [width, width, height, height] + 2
    rows = slice(int(max(0, y - top)), int(min(shape[0], y + height + bottom)))
    columns = slice(int(max(0, x - left)), int(min(shape[1], x + width + right)))
    if min(rows.stop - rows.start, columns.stop - columns.start) < SMALLEST_CROP_PX:
        return None
    return rows, columns


def visible_box(ping, target):
    """The box of the target with the train of echoes behind it, which a person does not tell from its outline."""
    cartesian = ping.cartesian
    clean_db = np.where(ping.polar.clean_db > -90, ping.polar.clean_db, NO_ECHO_DB).astype(float)
    expected = with_gain(ping, clean_db, ping.sequence.cartesian_map)
    body = cartesian.instance == target.instance
    seen = body | (cartesian.multipath == target.instance)
    seen &= expected > expected[body].max(initial=NO_ECHO_DB) - VISIBLE_DB
    rows, columns = np.nonzero(seen)
    x, y, width, height = target.bbox
    left, top = min(columns.min(initial=int(x)), x), min(rows.min(initial=int(y)), y)
    right, bottom = max(columns.max(initial=0) + 1, x + width), max(rows.max(initial=0) + 1, y + height)
    return left, top, right - left, bottom - top


def crop_of_ping(ping, class_id, mirrored, rng):
    """The crop of the target, or None if it is too small or outside the fan."""
    targets = [a for a in ping.cartesian.annotations if a.name == "target"]
    if not targets or min(targets[0].bbox[2:]) < SMALLEST_BOX_PX or targets[0].area < SMALLEST_AREA_PX:
        return None
    pixels = mirrored_pixels(ping.sequence) if mirrored else ping.sequence.cartesian_map
    images = {"ours": with_gain(ping, ping.polar.level_db.astype(np.float64), pixels),
              "painted": with_gain(ping, painted_level_db(ping, rng), pixels),
              "clean": with_gain(ping, painted_level_db(ping), pixels)}
    window = cut(visible_box(ping, targets[0]), images["ours"].shape, TARGETS[class_id].most_behind, rng)
    if window is None:
        return None
    # The first row of a Cartesian image is the farthest; real crops have the sonar at the top.
    levels = {kind: image[window][::-1].astype(np.float32) for kind, image in images.items()}
    return SimulatedCrop(class_id, "", 0, levels)


def simulated_crops(sets, blocks, parts):
    """The crops of all data sets [(class, folder), ...]; their sequences are split into blocks in order."""
    crops = []
    for kind, folder in sets:
        data = SonarDataset(folder)
        found = []
        for ping in data:
            rng = np.random.default_rng([CROP_SEED, ping.sequence.number])
            crop = crop_of_ping(ping, CLASSES.index(kind), "mirrored" in parts, rng)
            if crop:
                crop.name = f"{Path(folder).name}/{ping.sequence.number}"
                found.append(crop)
        for place, crop in enumerate(found):
            crop.block = block_of(place, len(found), blocks)
        crops += found
    return crops
