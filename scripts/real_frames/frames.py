"""Real frames with masks, and the roles of their blocks.

    real_frames(folder, block_size, folds)      (settings, frames); a ValueError says what is wrong where
    training_frames(frames, fold)               all but the tested block
    run_of(frames, share, fold)                 a run of consecutive frames

A block is `block_size` consecutive numbers of files, of all settings together. Of the blocks in order, every other one
from the first on is for fitting and training only (FITTING); the rest are the tested blocks of the folds.
"""
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from real_crops.crops import block_of

CLASSES = ("background", "bottle", "can", "chain", "drink carton", "hook", "propeller", "shampoo bottle",
           "standing bottle", "tire", "valve", "wall")      # their ids in masks are their places
FITTING = -1    # `block` of a frame that is never tested


@dataclass(frozen=True)
class Setting:
    """A folder of frames that share a range."""
    name: str
    rows: int
    beams: int
    range_m: tuple          # of the first and the last row
    limits_db: tuple        # of gray 0 and 255
    fan_deg: float          # of all beams together, which are equally wide


@dataclass
class Frame:
    name: str
    setting: int            # its place in the list of settings
    number: int
    block: int              # the fold that tests it, or FITTING
    half: int               # 0 or 1 in turn for runs of a quarter block, for comparing real frames with real ones
    gray: np.ndarray        # uint8 [rows, beams], near first and port first
    mask: np.ndarray        # uint8 [rows, beams], places in CLASSES
    jpeg_tables: dict = None


def numbers_of(text, key, form, path):
    """The numbers of a key, one for each word of its form, such as `[first, last]`."""
    pattern = re.sub("[a-z]+", lambda _: r"([-+.\deE]+)", re.escape(form)).replace(r"\ ", " *")
    found = re.search(rf"\b{key}: *{pattern}", text)
    if not found:
        raise ValueError(f"{path}: has no `{key}: {form}`; expected what `ensonify import` reads of a recording")
    return tuple(map(float, found.groups()))


def files_of(folder):
    """{number: file} of the frames of a folder."""
    found = {}
    for file in sorted(Path(folder).glob("*")):
        if file.suffix.lower() in (".png", ".jpg", ".jpeg"):
            digits = re.findall(r"\d+", file.stem)
            if not digits:
                raise ValueError(f"{file}: its name has no number; consecutive numbers are frames of one recording")
            found[int(digits[-1])] = file
    return found


def image_of(file):
    try:
        with Image.open(file) as image:
            return np.array(image.convert("L")), getattr(image, "quantization", None)
    except OSError as error:
        raise ValueError(f"{file}: cannot be read as an image ({error})") from error


def mask_of(file, shape):
    """The mask of a frame; files of masks have the ids of classes as gray levels."""
    if not file.exists():
        raise ValueError(f"{file}: is not there; expected a mask for each frame, a PNG file of the same name")
    mask, _ = image_of(file)
    if mask.shape != shape:
        raise ValueError(f"{file}: has {mask.shape[0]} x {mask.shape[1]} pixels, and its frame {shape[0]} x {shape[1]}")
    if mask.max() >= len(CLASSES):
        raise ValueError(f"{file}: has the unknown class {mask.max()}; expected 0 to {len(CLASSES) - 1} "
                         f"({', '.join(CLASSES)})")
    return mask


def frames_of_setting(folder, place):
    """(setting, frames) of a folder with frames/ and masks/; blocks are not yet known."""
    recording = folder / "frames" / "recording.yaml"
    if not recording.exists():
        raise ValueError(f"{recording}: is not there; expected the ranges of the frames as `range_m: [first, last]`")
    text = recording.read_text()
    frames = []
    for number, file in files_of(folder / "frames").items():
        gray, tables = image_of(file)
        if frames and gray.shape != frames[0].gray.shape:
            raise ValueError(f"{file}: has {gray.shape[0]} rows and {gray.shape[1]} beams; expected "
                             f"{frames[0].gray.shape[0]} and {frames[0].gray.shape[1]}, as in {frames[0].name}")
        mask = mask_of(folder / "masks" / f"{file.stem}.png", gray.shape)
        frames.append(Frame(f"{folder.name}/{file.name}", place, number, FITTING, 0, gray, mask, tables))
    if not frames:
        raise ValueError(f"{folder / 'frames'}: has no PNG or JPEG files")
    range_m, limits_db = (numbers_of(text, key, "[first, last]", recording) for key in ("range_m", "db"))
    fan_deg, = numbers_of(text, "fan_deg", "degrees", recording)
    return Setting(folder.name, *frames[0].gray.shape, range_m, limits_db, fan_deg), frames


def real_frames(folder, block_size, folds):
    """(settings, frames in the order of their numbers) of all folders in `folder` that have frames/ and masks/."""
    folders = sorted(path.parent for path in Path(folder).glob("*/frames") if path.is_dir())
    if not folders:
        raise ValueError(f"{folder}: has no folder with frames/; expected e.g. {folder}/near/frames/00001.png with "
                         f"the mask {folder}/near/masks/00001.png")
    found = [frames_of_setting(path, place) for place, path in enumerate(folders)]
    settings = [setting for setting, _ in found]
    for setting in settings[1:]:
        if setting.beams != settings[0].beams:
            raise ValueError(f"{folder}/{setting.name}: has {setting.beams} beams, and {settings[0].name} "
                             f"{settings[0].beams}; expected one sonar")
    frames = sorted((frame for _, some in found for frame in some), key=lambda frame: (frame.number, frame.setting))
    give_roles(frames, block_size, folds, folder)
    return settings, frames


def give_roles(frames, block_size, folds, folder):
    """Sets `block` and `half` of frames."""
    blocks = sorted({frame.number // block_size for frame in frames})
    tested = blocks[1::2]
    if len(tested) < folds:
        raise ValueError(f"{folder}: has {len(blocks)} blocks of {block_size} numbers, of which {len(tested)} can be "
                         f"tested; {folds} folds need {2 * folds} blocks: give fewer --folds or a smaller --block")
    fold_of = {block: block_of(place, len(tested), folds) for place, block in enumerate(tested)}
    for frame in frames:
        block, place = divmod(frame.number, block_size)
        frame.block, frame.half = fold_of.get(block, FITTING), place * 4 // block_size % 2


def training_frames(frames, fold):
    return [frame for frame in frames if frame.block != fold]


def run_of(frames, share, fold):
    """A run of that share of the frames, which are in order, at a place that follows from the fold."""
    count = max(1, round(share * len(frames)))
    start = int(np.random.default_rng([fold, count]).integers(0, len(frames) - count + 1))
    return frames[start:start + count]
