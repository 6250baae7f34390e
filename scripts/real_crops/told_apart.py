"""A network that tells two sources of images apart, trained on all blocks but one and tested on that one.

A source is a list of (item, 8-bit image); items have a `block` and a `name`. Both sides have equal numbers of images of
each stratum, which is what `stratum_of` gives for an item.

    Task(stratum_of, fold, epochs, most)        .auc(first, second)
"""
from dataclasses import dataclass
from typing import Any, Callable

import numpy as np

from . import networks

WINDOWS = 3     # of each image


def rounded(values):
    return [round(float(value), 4) for value in values]


def windows_of(sides, rng):
    """Windows of two lists of images with the labels 0 and 1, and the name of the image of each window."""
    images, labels, names = [], [], []
    for label, side in enumerate(sides):
        for item, image in side:
            found = networks.windows(image, WINDOWS, rng)
            images += list(found)
            labels += [label] * len(found)
            names += [item.name] * len(found)
    return networks.normalized(images), labels, names


@dataclass(frozen=True)
class Task:
    stratum_of: Callable[[Any], Any]
    fold: int                   # the tested block, and the seed
    epochs: int
    most: int = 1_000_000       # images of a side and stratum

    def _chosen(self, first, second, testing, rng):
        """Equal numbers of images of each stratum, of the tested block or of all others."""
        pools = [[pair for pair in source if (pair[0].block == self.fold) == testing] for source in (first, second)]
        sides = [[], []]
        for stratum in sorted({self.stratum_of(item) for item, _ in first}):
            parts = [[pair for pair in pool if self.stratum_of(pair[0]) == stratum] for pool in pools]
            count = min(self.most, *map(len, parts))
            for side, part in zip(sides, parts):
                side += [part[place] for place in rng.permutation(len(part))[:count]]
        if not sides[0]:
            raise ValueError(f"fold {self.fold} has no images to tell apart: no class or setting has both sources")
        return sides

    def auc(self, first, second):
        """{seed, auc, crops, labels, scores}: of the windows of the tested block, for label 1, the second source."""
        rng = np.random.default_rng([self.fold, 1])
        images, labels, _ = windows_of(self._chosen(first, second, False, rng), rng)
        network = networks.trained(images, labels, 2, self.fold, self.epochs)
        images, labels, names = windows_of(self._chosen(first, second, True, rng), rng)
        found = networks.scores(network, images)[:, 1]
        return {"seed": self.fold, "auc": networks.area_under_curve(labels, found), "crops": names, "labels": labels,
                "scores": rounded(found)}
