"""Every scene has an entry in docs/gallery.md: an image that is small, a text and its command."""

import re
import tempfile
import unittest
from pathlib import Path

from pages import ROOT

PAGE = "docs/gallery.md"
IMAGES = "docs/figures/gallery"
LARGEST_BYTES = 25_000


def entries(text):
    """{heading: what stands below it} of the third level."""
    parts = re.split(r"^### (.*)$", text, flags=re.M)
    return {name: re.split(r"^## ", body, flags=re.M)[0] for name, body in zip(parts[1::2], parts[2::2])}


def faults(root=ROOT):
    """["SCENE: what is wrong"] of all scenes, entries and images."""
    found, shown = [], entries((root / PAGE).read_text(encoding="utf-8"))
    scenes = {path.stem: path.relative_to(root) for path in (root / "scenes").rglob("*.yaml")}
    images = {path.stem: path for path in (root / IMAGES).iterdir()}
    for name in sorted(scenes):
        body = shown.get(name)
        if body is None:
            found.append(f"{name}: no entry")
            continue
        if not re.search(rf"^!\[[^\]]+\]\(figures/gallery/{name}\.webp\)$", body, re.M):
            found.append(f"{name}: image not shown")
        if f"`ensonify generate {scenes[name]} -o out/{name}`" not in body:
            found.append(f"{name}: command not shown")
        if name not in images:
            found.append(f"{name}: no image")
        elif images[name].read_bytes()[8:12] != b"WEBP":
            found.append(f"{name}: not a WebP image")
        elif images[name].stat().st_size > LARGEST_BYTES:
            found.append(f"{name}: image larger than {LARGEST_BYTES} bytes")
    found += [f"{name}: entry without a scene" for name in sorted(set(shown) - set(scenes))]
    return found + [f"{name}: image without a scene" for name in sorted(set(images) - set(scenes))]


class Gallery(unittest.TestCase):
    def test_every_scene_has_an_entry(self):
        self.assertEqual(faults(), [])
        self.assertTrue(entries((ROOT / PAGE).read_text(encoding="utf-8")))

    def test_that_faults_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "scenes").mkdir()
            (root / IMAGES).mkdir(parents=True)
            for name in ("good", "bare", "large", "new", "png"):
                (root / f"scenes/{name}.yaml").touch()
            webp = b"RIFF\0\0\0\0WEBP"
            images = {"good": webp, "large": webp + bytes(LARGEST_BYTES), "png": b"\x89PNG", "old": webp}
            for name, data in images.items():
                (root / f"{IMAGES}/{name}.webp").write_bytes(data)
            entry = "### {0}\n\n![What it shows](figures/gallery/{0}.webp)\n\nText.\n" \
                    "`ensonify generate scenes/{0}.yaml -o out/{0}`\n\n"
            text = "# Gallery\n\n## A\n\n" + "".join(entry.format(name) for name in ("good", "large", "png", "gone"))
            # What belongs to the next group is not taken for a part of this entry.
            (root / PAGE).write_text(text + "### bare\n\nText.\n\n## B\n\n![x](figures/gallery/bare.webp)\n",
                                     encoding="utf-8")
            self.assertEqual(faults(root), [
                "bare: image not shown", "bare: command not shown", "bare: no image",
                f"large: image larger than {LARGEST_BYTES} bytes", "new: no entry", "png: not a WebP image",
                "gone: entry without a scene", "old: image without a scene"])


if __name__ == "__main__":
    unittest.main()
