"""Which real frames show the same scene, and the folds of the scenes.

    give_scenes(settings, frames, alike, folds, folder)     sets `scene` and `block` of frames
    likeness(first, second)                                 how alike frames are, and by which shift
    copied_mask(mask, place)                                a mask after the shift SHIFTS[place]
    some_of(frames, share, seed)                            that share of the frames, scene by scene

Numbers of files cannot tell scenes: those of the marine debris set do not follow time (docs/real_study.md).
"""
import numpy as np

from .frames import CLASSES
from .segmentation import flattened, resized

# Frames that are more alike show one scene. Of the pairs of frames of different settings, whose cells do not
# correspond, 4 in 10,000 are more alike.
ALIKE = 0.5
CELLS, POOL = (144, 64), 2
SHIFTS = [(rows, columns) for rows in range(-18, 19, 2) for columns in range(-8, 9, 2)]     # of pooled cells
ASSIGNMENTS = 3000      # of scenes to folds, of which the most even one is taken


def looks(frames):
    """float32 [frames, rows, columns]: what networks see, averaged over 2 x 2 cells."""
    images = flattened([resized(frame.gray, CELLS) for frame in frames])
    return images.reshape(len(images), CELLS[0] // POOL, POOL, CELLS[1] // POOL, POOL).mean((2, 4))


def part_of(images, shift):
    """The part of images that remains in view after a shift, with mean 0 and length 1: float32 [images, cells]."""
    rows, columns = shift
    height, width = images.shape[1:]
    part = images[:, max(0, rows):height + min(0, rows), max(0, columns):width + min(0, columns)]
    part = part.reshape(len(images), -1)
    part = part - part.mean(1, keepdims=True)
    return part / np.maximum(np.linalg.norm(part, axis=1, keepdims=True), 1e-9)


def likeness(first, second):
    """([first, second] the highest correlation of any shift, [first, second] the place of this shift in SHIFTS). A
    frame of `second` that is moved by the shift resembles that of `first`."""
    first, second = looks(first), looks(second)
    best, place = np.full((len(first), len(second)), -1, np.float32), np.zeros((len(first), len(second)), int)
    for k, (rows, columns) in enumerate(SHIFTS):
        found = np.minimum(part_of(first, (rows, columns)) @ part_of(second, (-rows, -columns)).T, 1)
        place[found > best] = k
        best = np.maximum(best, found)
    return best, place


def copied_mask(mask, place):
    """A mask [rows, columns] of CELLS moved by a shift; the background comes in at the edges."""
    rows, columns = (POOL * shift for shift in SHIFTS[place])
    moved = np.zeros_like(mask)
    height, width = mask.shape
    moved[max(0, rows):height + min(0, rows), max(0, columns):width + min(0, columns)] = \
        mask[max(0, -rows):height + min(0, -rows), max(0, -columns):width + min(0, -columns)]
    return moved


def groups_of(linked):
    """A number for each row of a symmetric matrix of truth: rows that are linked, directly or over others, share it."""
    group, count = np.full(len(linked), -1), 0
    for first in range(len(linked)):
        if group[first] >= 0:
            continue
        reached = np.arange(len(linked)) == first
        while (more := linked[reached].any(0) & ~reached).any():
            reached |= more
        group[reached] = count
        count += 1
    return group


def folds_of(counts, folds):
    """The fold of each scene: of many random assignments the one that shares the columns of `counts` [scenes, kinds]
    most evenly."""
    rng = np.random.default_rng(5)
    shares = counts / np.maximum(counts.sum(0), 1)
    found = rng.permuted(np.tile(np.arange(len(counts)) % folds, (ASSIGNMENTS, 1)), axis=1)
    uneven = [sum(((shares[one == fold].sum(0) - 1 / folds) ** 2).sum() for fold in range(folds)) for one in found]
    return found[int(np.argmin(uneven))]


def give_scenes(settings, frames, alike, folds, folder):
    """Sets `scene` and `block` of frames; the shares of settings and classes in folds are as equal as whole scenes
    allow. A ValueError says when a fold would have nothing to test."""
    count = 0
    for place in range(len(settings)):
        some = [frame for frame in frames if frame.setting == place]
        scenes = groups_of(likeness(some, some)[0] > alike)
        for frame, scene in zip(some, scenes):
            frame.scene = count + int(scene)
        count += scenes.max() + 1
    shown = np.zeros((count, len(settings) + len(CLASSES)))
    for frame in frames:
        shown[frame.scene, [frame.setting, *(len(settings) + np.unique(frame.mask))]] += 1
    fold_of = folds_of(shown, folds)
    for frame in frames:
        frame.block = int(fold_of[frame.scene])
    tested = {frame.block for frame in frames if not frame.fitting}
    if len(tested) < folds:
        raise ValueError(f"{folder}: only {len(tested)} of {folds} folds have frames to test ({count} scenes): give "
                         "fewer --folds or a higher --alike")


def some_of(frames, share, seed):
    """That share of the frames: those of one scene, in a random order of scenes, before those of the next."""
    count = max(1, round(share * len(frames)))
    order = np.random.default_rng([seed, 3]).permutation(1 + max(frame.scene for frame in frames))
    return sorted(frames, key=lambda frame: order[frame.scene])[:count]
