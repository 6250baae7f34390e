"""Which real frames show the same scene, and the folds of the scenes.

    give_scenes(settings, frames, ...)          sets `scene` and `block` of frames
    looks(frames)                               what is compared
    most_alike(tested, training)                for each tested frame the place of the training frame most like it
    some_of(frames, share, seed)                that share of the frames, scene by scene

Numbers of files cannot tell: those of the marine debris set do not follow time. The correlation of frames with the next
numbers is that of any two frames (0.14), and the frame that is most like another one (0.93) is 560 numbers away.
"""
import numpy as np

from .segmentation import flattened, resized

# Of frames of one scene, at least. 2 of 10,000 pairs of frames of different settings, whose cells do not correspond, are
# more alike.
ALIKE = 0.42
CELLS, POOL = (144, 64), 2


def looks(frames):
    """float32 [frames, cells] with mean 0 and length 1, whose products are correlations."""
    images = flattened([resized(frame.gray, CELLS) for frame in frames])
    cells = images.reshape(len(images), CELLS[0] // POOL, POOL, CELLS[1] // POOL, POOL).mean((2, 4))
    cells = cells.reshape(len(images), -1)
    cells -= cells.mean(1, keepdims=True)
    return cells / np.maximum(np.linalg.norm(cells, axis=1, keepdims=True), 1e-9)


def groups_of(linked):
    """A number for each row of a symmetric matrix of truth: rows that links connect, over others too, have the same."""
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


def folds_of(sizes, folds):
    """The fold of each scene: the largest one first, each to the fold with the fewest frames so far."""
    found, filled = np.zeros(len(sizes), int), np.zeros(folds, int)
    for scene in np.argsort(-sizes, kind="stable"):
        found[scene] = filled.argmin()
        filled[found[scene]] += sizes[scene]
    return found


def give_scenes(settings, frames, alike, folds, folder):
    """Sets `scene` and `block` of frames; folds have about equal shares of each setting. A ValueError says where a fold
    would have nothing to test."""
    before = 0
    for place, setting in enumerate(settings):
        some = [frame for frame in frames if frame.setting == place]
        cells = looks(some)
        scenes = groups_of(cells @ cells.T > alike)
        fold_of = folds_of(np.bincount(scenes), folds)
        for frame, scene in zip(some, scenes):
            frame.scene, frame.block = before + int(scene), int(fold_of[scene])
        before += len(fold_of)
        tested = {frame.block for frame in some if not frame.fitting}
        if len(tested) < folds:
            raise ValueError(f"{folder}/{setting.name}: has {len(fold_of)} scenes of frames that are alike, which give "
                             f"{len(tested)} folds frames to test; expected {folds} folds with some: give fewer --folds "
                             "or a smaller --block")


def most_alike(tested, training):
    """For each tested frame the place of the frame in `training` that is most like it."""
    return (looks(tested) @ looks(training).T).argmax(1)


def some_of(frames, share, seed):
    """That share of the frames: those of one scene, in a random order of scenes, before those of the next."""
    count = max(1, round(share * len(frames)))
    order = np.random.default_rng([seed, 3]).permutation(1 + max(frame.scene for frame in frames))
    return sorted(frames, key=lambda frame: order[frame.scene])[:count]
