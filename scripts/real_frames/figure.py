"""The figure of the study: tested frames with true and answered classes, and bars of the mean overlap."""
import numpy as np
from PIL import Image, ImageDraw

from .frames import CLASSES, tested_frames
from .segmentation import class_map, resized

CELL, GAP, TITLE, MOST = (96, 192), 4, 14, 10
# Of Sasha Trubetskoy's list of distinct colors, black for the background.
COLORS = np.array([(0, 0, 0), (230, 25, 75), (60, 180, 75), (255, 225, 25), (0, 130, 200), (245, 130, 48),
                   (145, 30, 180), (70, 240, 240), (240, 50, 230), (210, 245, 60), (250, 190, 212), (110, 110, 110)], np.uint8)


def drawn(array):
    mode = array if array.ndim == 3 else np.repeat(array[:, :, None], 3, 2)
    return Image.fromarray(np.ascontiguousarray(mode)).resize(CELL, Image.NEAREST)


def rows_of(trainings, found):
    """[(title, [images])]: frames, true classes, and the answers of each arm for them."""
    arms = list(dict.fromkeys(one["arm"] for one in found if "examples" in one))
    size, frames = trainings.effort.size, []
    for fold in trainings.folds:
        tested = tested_frames(trainings.real, fold)
        frames += [tested[place] for place in trainings.example_places(len(tested))]
    rows = [("real frame", [np.clip(resized(frame.gray, size), 0, 255).astype(np.uint8) for frame in frames]),
            ("mask", [COLORS[class_map(frame.mask, size)] for frame in frames])]
    for arm in arms:
        some = sorted((one for one in found if one["arm"] == arm and "examples" in one), key=lambda one: one["fold"])
        rows.append((f"answer: {arm}", [COLORS[answer] for one in some for answer in one["examples"]]))
    return [(title, images[:MOST]) for title, images in rows]


def write_figure(path, trainings, found, miou):
    """`miou` is that of trainings.estimates."""
    rows = rows_of(trainings, found)
    height, width = CELL[1] + GAP + TITLE, MOST * (CELL[0] + GAP)
    bars = 20 * len(miou) + 2 * TITLE
    page = Image.new("RGB", (width, len(rows) * height + 20 + bars), (60, 60, 60))
    draw = ImageDraw.Draw(page)
    for row, (title, images) in enumerate(rows):
        draw.text((4, row * height + 1), title, fill=(255, 255, 255))
        for column, image in enumerate(images):
            page.paste(drawn(image), (column * (CELL[0] + GAP), row * height + TITLE))
    top = len(rows) * height
    for k, name in enumerate(CLASSES[1:]):
        x, y = k % 6 * 160 + 4, top + k // 6 * TITLE
        draw.rectangle((x, y + 2, x + 8, y + 10), fill=tuple(map(int, COLORS[k + 1])))
        draw.text((x + 11, y), name, fill=(255, 255, 255))
    for k, (arm, one) in enumerate(miou.items()):
        y = top + 20 * k + 2 * TITLE + 6
        draw.text((4, y + 3), f"{arm}: {one['value']:.3f}", fill=(255, 255, 255))
        draw.rectangle((200, y + 2, 200 + one["value"] * (width - 210), y + 14), fill=(180, 180, 180))
        ends = [200 + max(0.0, one["value"] + sign * one["standard_error"]) * (width - 210) for sign in (-1, 1)]
        draw.line((ends[0], y + 8, ends[1], y + 8), fill=(230, 25, 75), width=2)
    page.save(path)
