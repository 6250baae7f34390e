"""All trainings of the study, several at once, and what is estimated of them.

Fold f is the seed of its networks. A network that is trained on simulated frames alone is tested on all folds, and
counts for its own fold in what is compared with networks that have seen real ones.
"""
import multiprocessing
from dataclasses import dataclass

import numpy as np

from real_crops import networks
from real_crops.measures import estimate, jackknifed
from real_crops.told_apart import Task

from . import segmentation
from .frames import CLASSES, tested_frames, training_frames
from .scenes import copied_mask, likeness, some_of
from .segmentation import BATCH
from .simulated import KINDS, shown

SHARES = (0.01, 0.05, 0.1, 1.0)     # of the real frames, added to simulated ones
REAL_OF_BATCH = 3                   # of the frames of a batch, the others being simulated ones that show all classes
SEEN = "ours_painted_seen"          # at the size at which networks see frames
SPECKLE = ("ours_painted", SEEN)
EXAMPLES = 2                        # answers that are kept of each fold, for the figure


@dataclass(frozen=True)
class Effort:
    """What a training costs."""
    size: tuple         # (rows, columns) of the network's images
    width: int          # channels at the finest scale
    steps: int          # from new weights
    window_epochs: int  # of networks that tell real frames from simulated ones
    window_frames: int  # of each setting and side


class Trainings:
    def __init__(self, settings, real, simulated, viewers, folds, effort):
        self.settings, self.real, self.simulated, self.viewers = settings, real, simulated, viewers
        self.folds, self.effort, self.shares = range(folds), effort, SHARES
        self.images = {kind: [shown(frame, kind, viewers[kind], settings) for frame in simulated] for kind in viewers}
        self._real = segmentation.prepared([(frame.gray, frame.mask) for frame in real], effort.size)
        self._simulated = {kind: segmentation.prepared(list(zip(images, (frame.mask for frame in simulated))),
                                                       effort.size) for kind, images in self.images.items()}

    def _of(self, frames):
        """(images, masks) of some real frames."""
        names = {frame.name for frame in frames}
        chosen = np.array([frame.name in names for frame in self.real])
        return self._real[0][chosen], self._real[1][chosen]

    def _tested(self, network, arm, seed, folds):
        """One dict for each fold: the confusion, and some answers in the fold of the seed."""
        found = []
        for fold in folds:
            images, masks = self._of(tested_frames(self.real, fold))
            found.append({"arm": arm, "seed": seed, "fold": fold,
                          "confusion": segmentation.confusion(network, images, masks).tolist()})
            if fold == seed:
                found[-1]["examples"] = segmentation.answers(network, images[self.example_places(len(images))])
        return found

    @staticmethod
    def example_places(count):
        return np.linspace(0, count - 1, EXAMPLES + 2).astype(int)[1:-1]

    def from_simulated(self, kind, seed):
        """Trained on simulated frames alone; for ours then as long on shares of the real ones."""
        steps, width = self.effort.steps, self.effort.width
        source = self._simulated[kind]
        network = segmentation.trained([(*source, BATCH)], steps, seed, width)
        found = self._tested(network, kind, seed, self.folds)
        for share in self.shares if kind == "ours" else ():
            run = self._of(some_of(training_frames(self.real, seed), share, seed))
            mixed = [(*run, REAL_OF_BATCH), (*source, BATCH - REAL_OF_BATCH)] if share < 1 else [(*run, BATCH)]
            more = segmentation.trained(mixed, steps, seed, width, network)
            found += self._tested(more, f"ours_and_{share:.0%}", seed, [seed])
        return found

    def from_real(self, _, seed):
        source = self._of(training_frames(self.real, seed))
        network = segmentation.trained([(*source, BATCH)], self.effort.steps, seed, self.effort.width)
        return self._tested(network, "real", seed, [seed])

    def copied(self, _, fold):
        """The mask of the training frame of the same setting that is most alike: what remembering frames is worth."""
        table = np.zeros((len(CLASSES), len(CLASSES)), int)
        for place in range(len(self.settings)):
            tested, training = ([frame for frame in some if frame.setting == place]
                                for some in (tested_frames(self.real, fold), training_frames(self.real, fold)))
            if tested and training:
                alike, places = likeness(tested, training)
                masks, theirs = self._of(tested)[1], self._of(training)[1]
                answers = [copied_mask(theirs[k], places[row, k]) for row, k in enumerate(alike.argmax(1))]
                table = table + segmentation.confusion_of(masks, np.stack(answers))
        return [{"arm": "copied", "seed": fold, "fold": fold, "confusion": table.tolist()}]

    def _sides(self, pair):
        """What a network has to tell apart, without frames for fitting, since scene and viewer are fitted to them."""
        real = [(frame, frame.gray) for frame in self.real if not frame.fitting]
        if pair == "real_real":
            return [[item for item in real if item[0].half == half] for half in (0, 1)]
        sides = [real if kind == "real" else list(zip(self.simulated, self.images[kind]))
                 for kind in pair.split("_")[:2]]
        if pair == SEEN:
            sides = [[(frame, np.rint(segmentation.resized(image, self.effort.size)).astype(np.uint8))
                      for frame, image in side] for side in sides]
        return sides

    def told_apart(self, pair, fold):
        """The AUC of a network that tells the windows of two kinds of frames apart."""
        task = Task(lambda frame: frame.setting, fold, self.effort.window_epochs, self.effort.window_frames)
        return [{"arm": f"auc_{pair}", "seed": fold, "fold": fold, "auc": task.auc(*self._sides(pair))["auc"]}]

    def tasks(self, kinds=(*KINDS, "real"), shares=SHARES):
        """Long ones first. How the kinds of simulated frames differ is measured where there are both."""
        self.shares = shares
        runs = [("from_real" if kind == "real" else "from_simulated", kind) for kind in kinds]
        runs += [("copied", "real")] if "real" in kinds else []
        pairs = [*(f"real_{kind}" for kind in kinds), *(SPECKLE if set(KINDS) <= set(kinds) else ())]
        return [(run, kind, fold) for run, kind in (*runs, *(("told_apart", pair) for pair in pairs))
                for fold in self.folds]

    def run(self, tasks, processes, report):
        """What all tasks found, in their order."""
        found = []
        # Steps are too short to share between threads. The processes begin as copies of this one, frames included.
        with multiprocessing.get_context("fork").Pool(processes, _begin, (self,)) as pool:
            for some in pool.imap(_train, tasks):
                found += some
                for one in some:
                    value = one["auc"] if "auc" in one else segmentation.mean_iou(one["confusion"])
                    report(f"{one['arm']}, seed {one['seed']}, fold {one['fold']}: {value:.3f}")
        return found


def _begin(trainings):
    global _trainings
    _trainings = trainings
    networks.use_one_thread()


def _train(task):
    run, kind, fold = task
    return getattr(_trainings, run)(kind, fold)


def own_fold(found, arm):
    """The confusions of an arm by fold, each by the network of the fold's own seed."""
    return {one["fold"]: np.array(one["confusion"]) for one in found
            if one["arm"] == arm and one["seed"] == one["fold"]}


def by_seed(found, arm):
    """The mean overlap of each seed's network on the tested frames of all folds."""
    seeds = sorted({one["seed"] for one in found if one["arm"] == arm})
    return {seed: round(segmentation.mean_iou(sum(np.array(one["confusion"]) for one in found
                                                  if one["arm"] == arm and one["seed"] == seed)), 4) for seed in seeds}


def estimates(found):
    """The members of the JSON file: AUC, mIoU of each arm, and what is compared by fold. Confusions are summed over
    folds, each fold being tested by its own network; standard errors are those of the jackknife over folds."""
    arms = list(dict.fromkeys(one["arm"] for one in found))
    result = {arm: estimate([one["auc"] for one in found if one["arm"] == arm])
              for arm in arms if arm.startswith("auc_")}
    tables = {arm: own_fold(found, arm) for arm in arms if not arm.startswith("auc_")}

    def miou(arm, folds, background=False):
        return segmentation.mean_iou(sum(tables[arm][fold] for fold in folds), background)

    result["miou"] = {arm: jackknifed(lambda folds: miou(arm, folds), table) for arm, table in tables.items()}
    result["miou_with_background"] = {arm: jackknifed(lambda folds: miou(arm, folds, True), table)
                                      for arm, table in tables.items()}
    result["iou_by_class"] = {arm: dict(zip(CLASSES, rounded(segmentation.class_ious(sum(table.values())))))
                              for arm, table in tables.items()}
    result["miou_by_seed"] = {arm: by_seed(found, arm) for arm in tables if arm in KINDS}
    if "real" in tables:
        folds = list(tables["real"])
        result["miou_over_real"] = {arm: jackknifed(lambda some: miou(arm, some) / max(miou("real", some), 1e-9), folds)
                                    for arm in tables if arm != "real"}
        result["miou_minus_real"] = {arm: jackknifed(lambda some: miou(arm, some) - miou("real", some), folds)
                                     for arm in tables if arm != "real"}
    result["runs"] = [{key: value for key, value in one.items() if key != "examples"} for one in found]
    return result


def gains(whole, without):
    """By how much a part changes the AUC and the mIoU of ours, fold by fold: with it minus without it."""
    def by_fold(found, arm, value):
        return {one["fold"]: value(one) for one in found if one["arm"] == arm and one["seed"] == one["fold"]}

    members = {"auc": ("auc_real_ours", lambda one: one["auc"]),
               "miou": ("ours", lambda one: segmentation.mean_iou(one["confusion"]))}
    values = {name: [by_fold(found, *of) for found in (whole, without)] for name, of in members.items()}
    return {name: estimate([before[fold] - after[fold] for fold in before]) for name, (before, after) in values.items()}


def rounded(values):
    return [None if np.isnan(value) else round(float(value), 4) for value in values]
