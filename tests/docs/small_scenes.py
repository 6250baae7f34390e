"""The scenes of scenes/ with 64 beams and small Cartesian images, for pages that say `small`."""
import re

BEAMS, HEIGHT_PX = 64, 120


def _with_beams(text):
    """The first `beams` has this count; where there are none, they stand behind the preset."""
    if re.search(r"\bbeams: \{", text):
        text = re.sub(r"\bbeams: \{count: \d+", f"beams: {{count: {BEAMS}", text, count=1)
        return re.sub(r"\bbeams: \{(?!count)", f"beams: {{count: {BEAMS}, ", text, count=1)
    in_flow = re.search(r"^sonar: \{", text, re.M) is not None
    between = ", " if in_flow else "\n  "
    return re.sub(r"\bpreset: \w+", lambda preset: f"{preset[0]}{between}beams: {{count: {BEAMS}}}", text, count=1)


def _with_images(text):
    """Cartesian images of this height; a scene that writes none keeps its `output`."""
    if re.search(r"^output:", text, re.M):
        return re.sub(r"\bheight_px: \d+", f"height_px: {HEIGHT_PX}", text)
    return text.rstrip("\n") + f"\noutput: {{cartesian: {{height_px: {HEIGHT_PX}}}}}\n"


def small(text):
    return _with_images(_with_beams(text))


def make_small(folder):
    """Rewrites every scene of a folder, which is a copy."""
    for path in folder.glob("*.yaml"):
        path.write_text(small(path.read_text(encoding="utf-8")), encoding="utf-8")
