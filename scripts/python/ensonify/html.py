"""How scenarios and pings show themselves in a notebook."""
from __future__ import annotations

import struct
import warnings
import zlib
from base64 import b64encode
from html import escape
from typing import TYPE_CHECKING, Dict, Iterable, List, Tuple

import numpy as np
from ensonify_dataset import NO_ENERGY_DB, Pose, View

if TYPE_CHECKING:
    from .live import LivePing
    from .scenario import Scenario

Color = Tuple[int, int, int]
# Okabe and Ito's colors, which people with any color vision tell apart.
_COLORS: List[Color] = [(230, 159, 0), (86, 180, 233), (0, 158, 115), (240, 228, 66), (0, 114, 178), (213, 94, 0),
                        (204, 121, 167)]


def color_of(class_id: int) -> Color:
    return _COLORS[class_id % len(_COLORS)]


def png_of(image: np.ndarray) -> bytes:
    """A PNG file of uint8 [rows, columns, 3]."""
    rows, columns, _ = image.shape
    lines = b"".join(b"\0" + row.tobytes() for row in np.ascontiguousarray(image))
    head = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(lines)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks)


def _picture(image: np.ndarray, caption: str) -> str:
    data = b64encode(png_of(image)).decode()
    return (f'<figure style="display:inline-block;margin:4px"><img style="max-height:360px" '
            f'src="data:image/png;base64,{data}"><figcaption>{escape(caption)}</figcaption></figure>')


def _gray(view: View) -> np.ndarray:
    """The level between its median and its 99.9th percentile plus 3 dB, as uint8."""
    level = view.level_db
    heard = level[level > NO_ENERGY_DB]
    if heard.size == 0:
        return np.zeros(level.shape, np.uint8)
    black, white = np.percentile(heard, 50), np.percentile(heard, 99.9) + 3
    return np.clip(255 * (level - black) / max(white - black, 1), 0, 255).astype(np.uint8)


def _kinds(view: View) -> Dict[int, str]:
    return {i["class_id"]: i["class"] for i in view.ping.sequence.info["instances"]}


def view_html(view: View) -> str:
    """The image, and the image with its classes in colors."""
    if not view.has("level_db"):
        return f"<p>{escape(view.kind)}: no level was asked for</p>"
    gray = _gray(view)
    shown = np.repeat(gray[..., None], 3, axis=2)
    parts = [_picture(shown, f"{view.kind}, level")]
    if view.has("semantic"):
        marked = shown.astype(np.float64)
        names = _kinds(view)
        found = [int(k) for k in np.unique(view.semantic) if k]
        for k in found:
            mask = view.semantic == k
            marked[mask] = 0.5 * marked[mask] + 0.5 * np.array(color_of(k))
        parts.append(_picture(marked.astype(np.uint8), "classes: " + ", ".join(names[k] for k in found)))
        parts.append(_legend((color_of(k), names[k]) for k in found))
    return "".join(parts)


def _legend(entries: Iterable[Tuple[Color, str]]) -> str:
    return " ".join(f'<span style="color:rgb{color}">&#9632;</span> {escape(name)}' for color, name in entries)


def ping_html(ping: "LivePing") -> str:
    view = ping.cartesian if ping.cartesian.has("level_db") else ping.polar
    return f"<p>{escape(repr(ping))}, {ping.time_s:g} s</p>{view_html(view)}"


def _outline(pose: Pose, centre_m: np.ndarray, size_m: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """[4, 2] corners of a box's base, seen from above."""
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * size_m / 2
    return (pose.position_m + (centre_m + corners @ turn.T) @ pose.rotation.T)[:, :2]


def _boxes(ping: "LivePing") -> List[Tuple[str, int, np.ndarray]]:
    poses, boxes = ping.object_poses, []
    for instance in ping.sequence.info["instances"]:
        box = instance.get("box")
        if not box or instance["id"] not in poses:
            continue
        turn = Pose(np.zeros(3), np.array(box["quaternion_wxyz"])).rotation
        corners = _outline(poses[instance["id"]], np.array(box["centre_m"]), np.array(box["size_m"]), turn)
        boxes.append((instance["name"], instance["class_id"], corners))
    return boxes


def _fan(ping: "LivePing") -> np.ndarray:
    """[points, 2]: the sonar and the far end of its fan, seen from above."""
    azimuth = np.linspace(ping.sequence.azimuth_rad[0], ping.sequence.azimuth_rad[-1], 24)
    range_m = ping.sequence.info["sonar"]["range_max_m"]
    ends = range_m * np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1)
    return (ping.pose.position_m + np.vstack([np.zeros(3), ends]) @ ping.pose.rotation.T)[:, :2]


def _polygon(points: np.ndarray, style: str, title: str) -> str:
    # North up: x, ahead at yaw 0, points up and y to the left.
    text = " ".join(f"{-y:.3f},{-x:.3f}" for x, y in points)
    return f'<polygon points="{text}" style="{style}"><title>{escape(title)}</title></polygon>'


def scenario_html(scenario: "Scenario") -> str:
    """The first ping's world from above, of the first sequence that can be made: objects as their boxes, and the fan."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        stream = scenario.stream(range(max(scenario.sequences, 64)), threads=1, want=[], pings=(0, 1))
        ping = next(stream)
        stream.close()
    fan, boxes = _fan(ping), _boxes(ping)
    points = np.vstack([fan] + [corners for _, _, corners in boxes])
    (x0, y0), (x1, y1) = points.min(0), points.max(0)
    wide = max(x1 - x0, y1 - y0, 1e-3)
    line = f"stroke-width:{wide / 300:.4f}"
    shapes = [_polygon(fan, f"fill:#6883;stroke:#446;{line}", "fan of the sonar")]
    for name, class_id, corners in boxes:
        color = color_of(class_id)
        fill = "none" if np.ptp(corners, axis=0).max() > 0.8 * wide else f"rgb{color}"
        shapes.append(_polygon(corners, f"fill:{fill};fill-opacity:0.5;stroke:rgb{color};{line}", name))
    named = {i["class_id"]: i["class"] for i in ping.sequence.info["instances"]}
    return (f'<p>{escape(repr(scenario))}; sequence {ping.sequence.number} from above, {x1 - x0:.1f} m by {y1 - y0:.1f} m</p>'
            f'<svg width="360" height="360" viewBox="{-y1:.3f} {-x1:.3f} {y1 - y0:.3f} {x1 - x0:.3f}">'
            f'{"".join(shapes)}</svg><br>{_legend((color_of(k), name) for k, name in named.items())}')
