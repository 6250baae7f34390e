"""A contact sheet: real crops in the upper row of each class, simulated ones below."""
import numpy as np
from PIL import Image, ImageDraw

from .targets import CLASSES

CELL_PX, GAP_PX, TITLE_PX, COLUMNS = 150, 4, 16, 14


def spread(items, count):
    """At most `count` items at equal distances."""
    return [items[place] for place in np.unique(np.linspace(0, len(items) - 1, min(count, len(items))).astype(int))]


def contact_sheet(path, comparison, kinds=("real", "ours", "painted")):
    rows = [(name, kind, [image for crop, image in comparison.crops(kind, 0) if crop.class_id == k])
            for k, name in enumerate(CLASSES) for kind in kinds]
    height = CELL_PX + GAP_PX + TITLE_PX
    page = Image.new("L", (COLUMNS * (CELL_PX + GAP_PX), len(rows) * height), 60)
    draw = ImageDraw.Draw(page)
    for row, (name, kind, images) in enumerate(rows):
        draw.text((4, row * height + 2), f"{name}, {kind}", fill=255)
        for column, gray in enumerate(spread(images, COLUMNS) if images else []):
            scale = CELL_PX / max(gray.shape)
            size = max(1, int(gray.shape[1] * scale)), max(1, int(gray.shape[0] * scale))
            page.paste(Image.fromarray(gray).resize(size, Image.NEAREST),
                       (column * (CELL_PX + GAP_PX), row * height + TITLE_PX))
    page.save(path)
