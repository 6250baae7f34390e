"""Simulated frames on the rows and beams of real ones.

    simulated_sets(...)             makes the missing data sets of a scene
    simulated_frames(...)           [SimulatedFrame, ...]
    fitted_viewer(...)              what happens after the recorder, fitted to the frames for fitting
    shown(...)                      8-bit images

The images of ours and painted differ in speckle alone: both go through the same viewer, each with its own gain.
"""
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ensonify_dataset import Display, SonarDataset, Viewer, redrawn
from real_crops.crops import block_of
from real_crops.data_sets import command_of, folder_of, make, painted_level_db

from .frames import CLASSES

KINDS = ("ours", "painted")
SEEDS = (41, 42)        # of two data sets, which are made at once
PAINTED, VIEWED = 1, 2  # streams of random numbers
# How people draw the masks of real frames, counted in those for fitting: walls reach to the end of the record in 86 % of
# the beams; a standing bottle has its shadow in the mask, and of a shampoo bottle it is the shadow alone; and gaps within
# a body are not left out, but for thin classes.
TO_THE_END = ("wall",)
WITH_SHADOW, SHADOW_ALONE = ("standing bottle",), ("shampoo bottle",)
WITH_GAPS = ("background", "chain", "hook", "valve", "wall")
CLOSEST = 0.1           # of its range, by which a simulated record may miss the ends of a real one


@dataclass
class SimulatedFrame:
    name: str
    key: tuple              # of random numbers: seed, sequence, ping
    setting: int
    block: int              # the fold whose network does not see it
    level_db: dict          # {"ours": ..., "painted": ...} float32 [rows, beams] of the setting
    mask: np.ndarray        # uint8 [rows, beams], places in CLASSES
    display: Display        # of the recorder
    absorption_db_m: float


def simulated_sets(program, scene, root, sequences, settings, report):
    """The folders of the data sets of a scene with the settings KEY=VALUE."""
    scene, commands, folders = Path(scene), {}, []
    for seed in SEEDS:
        count = sequences // len(SEEDS) + (seed < SEEDS[0] + sequences % len(SEEDS))
        own = [*settings, f"seed={seed}", f"sequences={count}"]
        folder = folder_of(root, f"{scene.stem}_{seed}", "\n".join([scene.read_text(), *own]))
        commands[folder.name] = command_of(program, scene, folder, own)
        folders.append(folder)
    make(program, commands, len(SEEDS), report)
    return folders


def class_ids(data):
    """For each class of a data set its place in CLASSES; 0 for those that real masks do not name."""
    names = [name.replace("_", " ").replace("tyre", "tire") for name in data.classes]
    found = [0, *(CLASSES.index(name) if name in CLASSES else 0 for name in names)]
    if not any(found):
        raise ValueError(f"{data.folder}: has the classes {', '.join(data.classes)}; expected some of "
                         f"{', '.join(CLASSES[1:])}")
    return np.array(found, np.uint8)


def setting_of(range_m, beams, settings, place):
    """The setting whose ranges a record has."""
    if beams != settings[0].beams:
        raise ValueError(f"{place}: has {beams} beams, and the real frames {settings[0].beams}; set sonar.beams.count")
    misses = [abs(range_m[-1] - setting.range_m[1]) + max(0, range_m[0] - setting.range_m[0]) for setting in settings]
    nearest = int(np.argmin(misses))
    first, last = settings[nearest].range_m
    if misses[nearest] > CLOSEST * (last - first):
        raise ValueError(f"{place}: has samples from {range_m[0]:.2f} to {range_m[-1]:.2f} m; expected those of "
                         + " or ".join("%s, %.2f to %.2f m" % (s.name, *s.range_m) for s in settings))
    return nearest


def on_rows(setting, sequence, image):
    """An image [samples, beams] on the rows and beams of a setting, port first, as they come from display images."""
    azimuth_rad = np.radians(setting.fan_deg * (0.5 - (np.arange(setting.beams) + 0.5) / setting.beams))
    return redrawn(image, sequence.range_m, sequence.azimuth_rad, np.linspace(*setting.range_m, setting.rows), azimuth_rad)


def filled(body):
    """True between the first and the last true sample of each beam."""
    return np.maximum.accumulate(body, 0) & np.maximum.accumulate(body[::-1], 0)[::-1]


def mask_as_drawn(polar, ids):
    """uint8 [samples, beams]: the classes of a simulated image, as people draw them in real ones."""
    instance, class_of = polar.instance, ids[np.minimum(polar.semantic, len(ids) - 1)]
    shadow = polar.shadow if polar.has("shadow") else np.zeros_like(instance)
    mask = np.zeros(instance.shape, np.uint8)
    wall = np.isin(class_of, [CLASSES.index(name) for name in TO_THE_END])
    mask[np.maximum.accumulate(wall, 0)] = CLASSES.index(TO_THE_END[0])
    for number in np.unique(instance[(class_of > 0) & ~wall]):
        body = instance == number
        k = class_of[body][0]
        if CLASSES[k] in WITH_SHADOW:
            body = body | (shadow == number)
        elif CLASSES[k] in SHADOW_ALONE:
            body = shadow == number
        mask[body if CLASSES[k] in WITH_GAPS else filled(body)] = k
    return mask


def frame_of_ping(ping, seed, settings, ids):
    sequence, range_m = ping.sequence, ping.sequence.range_m
    key = (seed, sequence.number, ping.number)
    place = f"{sequence.folder}, ping {ping.number}"
    number = setting_of(range_m, ping.polar.level_db.shape[1], settings, place)
    setting = settings[number]
    levels = {"ours": ping.polar.level_db.astype(np.float64),
              "painted": painted_level_db(ping, np.random.default_rng([PAINTED, *key]))}
    recorder = sequence.info.get("recorder")
    display = Display.of(recorder) if recorder else Display(setting.limits_db)
    return SimulatedFrame(place, key, number, 0,
                          {kind: on_rows(setting, sequence, level).astype(np.float32)
                           for kind, level in levels.items()},
                          on_rows(setting, sequence, mask_as_drawn(ping.polar, ids)), display,
                          float(sequence.info["water"].get("absorption_db_m", 0)))


def simulated_frames(folders, settings, folds):
    frames = []
    for seed, folder in zip(SEEDS, folders):
        data = SonarDataset(folder)
        ids = class_ids(data)
        found = [frame_of_ping(ping, seed, settings, ids) for ping in data]
        for place, frame in enumerate(found):
            frame.block = block_of(place, len(found), folds)
        frames += found
    return frames


def shown(frame, kind, viewer, settings):
    """The 8-bit image of a simulated frame."""
    first_m, last_m = settings[frame.setting].range_m
    step_m = (last_m - first_m) / (settings[frame.setting].rows - 1)
    return viewer.image(frame.level_db[kind], (VIEWED, *frame.key), step_m, frame.absorption_db_m, first_m)


def middle(images):
    """The median of the medians of images."""
    return float(np.median([np.median(image) for image in images]))


def fitted_viewer(real, simulated, kind, settings):
    """The viewer that gives simulated frames the middle gray level of the real frames for fitting, with their share of
    black beams and the compression of their files."""
    fitting = [frame for frame in real if frame.fitting]
    display = simulated[0].display
    lost = float(np.mean([(frame.gray.max(0) == 0).mean() for frame in fitting]))
    tables = next((frame.jpeg_tables for frame in fitting if frame.jpeg_tables), None)
    wanted = middle([frame.gray for frame in fitting])
    low, high = -200.0, 200.0
    for _ in range(20):  # the gray level grows with the gain
        gain_db = (low + high) / 2
        viewer = Viewer(display, (gain_db, gain_db))
        if middle([shown(frame, kind, viewer, settings) for frame in simulated[:40]]) < wanted:
            low = gain_db
        else:
            high = gain_db
    return Viewer(display, (gain_db, gain_db), lost, jpeg_tables=tables)
