"""Real frames with masks, and their roles.

    real_frames(folder, block_size)     (settings, frames); a ValueError says what is wrong where
    training_frames(frames, fold)       all but those of the tested scenes
    tested_frames(frames, fold)         those of the tested scenes that are not for fitting

A block is `block_size` consecutive numbers of files, of all settings together. Of the blocks in order, every other one
from the first on is for fitting and training only. scenes.py shares scenes between folds.
"""
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

CLASSES = ("background", "bottle", "can", "chain", "drink carton", "hook", "propeller", "shampoo bottle",
           "standing bottle", "tire", "valve", "wall")      # their ids in masks are their places


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
    gray: np.ndarray        # uint8 [rows, beams], near first and port first
    mask: np.ndarray        # uint8 [rows, beams], places in CLASSES
    jpeg_tables: dict = None
    fitting: bool = False   # presets, scene and viewer may use it, and it is never tested
    half: int = 0           # 0 or 1 in turn for runs of a quarter block, for comparing real frames with real ones
    scene: int = 0
    block: int = 0          # the fold that tests its scene


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
                raise ValueError(f"{file}: its name has no number, which decides between fitting and tests")
            if int(digits[-1]) in found:
                raise ValueError(f"{file}: has the number of {found[int(digits[-1])].name}; expected a number for each")
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
    """(setting, frames) of a folder with frames/ and masks/, without roles."""
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
        frames.append(Frame(f"{folder.name}/{file.name}", place, number, gray, mask, tables))
    if not frames:
        raise ValueError(f"{folder / 'frames'}: has no PNG or JPEG files")
    range_m, limits_db = (numbers_of(text, key, "[first, last]", recording) for key in ("range_m", "db"))
    fan_deg, = numbers_of(text, "fan_deg", "degrees", recording)
    return Setting(folder.name, *frames[0].gray.shape, range_m, limits_db, fan_deg), frames


def real_frames(folder, block_size):
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
    blocks = sorted({frame.number // block_size for frame in frames})
    if len(blocks) < 2:
        raise ValueError(f"{folder}: has 1 block of {block_size} numbers; expected one for fitting and one for tests: "
                         "give a smaller --block")
    for frame in frames:
        block, place = divmod(frame.number, block_size)
        frame.fitting, frame.half = blocks.index(block) % 2 == 0, place * 4 // block_size % 2
    return settings, frames


def training_frames(frames, fold):
    return [frame for frame in frames if frame.block != fold]


def tested_frames(frames, fold):
    return [frame for frame in frames if frame.block == fold and not frame.fitting]
