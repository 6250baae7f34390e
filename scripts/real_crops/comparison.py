"""The comparison by folds. Fold f tests on block f of the real crops and of the simulated sequences, fits the display
to block f + 1 of the real ones, and trains on all blocks but f. So no image is tested by what it had a part in.

    Comparison(real, simulated, options)
        .displays()             the fitted displays, and their test on the real crops of block f
        .measures()             levels, contrasts and shares of real, ours and painted
        .trainings()            AUC of networks that tell two sources apart, macro-F1 of networks that tell classes
"""
import multiprocessing

import numpy as np

from . import networks
from .display import fit_power_law, median_contrast, shown_crops
from .measures import MEASURES, estimate, jackknifed, measures_of, smoothed
from .targets import CLASSES
from .told_apart import Task, rounded

KINDS = ("ours", "painted")
TRAINED_ON = (*KINDS, "clean", "real")
# What networks see of each crop: all, what is left without grain, or grain alone.
SEEN = {"crops": lambda gray: gray, "smoothed": lambda gray: smoothed(gray.astype(np.float32), 2, 2),
        "grain": lambda gray: 64 * (gray + 1.0) / (smoothed(gray.astype(np.float32), 3, 3) + 1)}
CLASS_BATCH = 16        # more steps than with larger batches, at the same price: there are few simulated crops
SHARES = ("two_echoes", "saturated_share")


class Comparison:
    def __init__(self, real, simulated, options, report):
        self.real, self.simulated, self.options, self.report = real, simulated, options, report
        self.folds = range(options.folds)
        self._images = {}       # (kind, fold): 8-bit images of the simulated crops
        self._laws = {}

    def law(self, kind, fold):
        """The display of a kind of simulated crops, fitted to block `fold` + 1 of the real ones; `clean` has no contrast
        to fit, and the display of ours."""
        if kind == "clean":
            return self.law("ours", fold)
        if (kind, fold) not in self._laws:
            block = (fold + 1) % len(self.folds)
            fitting = [crop for crop in self.real if crop.block == block]
            self._laws[kind, fold] = fit_power_law(fitting, self.simulated, kind, fold)
        return self._laws[kind, fold]

    def crops(self, kind, fold):
        """[(crop, 8-bit image), ...] of one kind with the display of a fold; `real` has its own."""
        if kind == "real":
            return [(crop, crop.gray) for crop in self.real]
        if (kind, fold) not in self._images:
            self._images[kind, fold] = shown_crops(self.simulated, kind, self.law(kind, fold), fold)
        return list(zip(self.simulated, self._images[kind, fold]))

    def displays(self):
        """For each kind the exponent, and the contrast of backgrounds in block f over that of real ones, minus 1."""
        found = {}
        for kind in KINDS:
            real = [median_contrast([crop.gray for crop in self.real if crop.block == fold]) for fold in self.folds]
            reached = [median_contrast([image for crop, image in self.crops(kind, fold) if crop.block == fold])
                       for fold in self.folds]
            found[kind] = {"exponent": estimate([self.law(kind, fold).exponent for fold in self.folds]),
                           "contrast_error": estimate([ours / true - 1 for ours, true in zip(reached, real)])}
        return found

    def measures(self):
        """{measure: {source: estimate}}, and the share of crops with two or more echoes by class and source."""
        sources = ("real", *KINDS)
        by_fold = {(source, fold): [(crop.class_id, measures_of(image)) for crop, image in self.crops(source, fold)
                                    if crop.block == fold] for source in sources for fold in self.folds}

        def mean_of(source, fold, name, classes):
            """The mean over classes of the medians over crops (of shares: of the means), so that all classes count."""
            middles, middle = [], np.mean if name in SHARES else np.median
            for k in classes:
                values = [found[name] for class_id, found in by_fold[source, fold] if class_id == k]
                values = [value for value in values if np.isfinite(value)]
                middles += [middle(values)] if values else []
            return float(np.mean(middles)) if middles else float("nan")

        def of_sources(name, classes):
            return {source: estimate([mean_of(source, fold, name, classes) for fold in self.folds])
                    for source in sources}

        everything = range(len(CLASSES))
        result = {name: of_sources(name, everything) for name in MEASURES}
        result["two_echo_share_by_class"] = {kind: of_sources("two_echoes", [k]) for k, kind in enumerate(CLASSES)}
        return result

    def seen(self, kind, fold):
        """[(crop, what networks see of it), ...]"""
        return [(crop, SEEN[self.options.see](image)) for crop, image in self.crops(kind, fold)]

    def _pair(self, kind, fold):
        """Two lists of crops that a network shall tell apart."""
        if kind == "real":
            return [[pair for pair in self.seen("real", fold) if pair[0].half == half] for half in (0, 1)]
        return [self.seen("real", fold), self.seen(kind, fold)]

    def told_apart(self, kind, fold):
        """The scores of windows of real crops and of a kind by a network that has seen both; `real`: the other half."""
        return Task(lambda crop: crop.class_id, fold, self.options.window_epochs).auc(*self._pair(kind, fold))

    def classified(self, kind, fold):
        """The scores of the real crops of a fold by a network that was trained on a kind; `real`: on other blocks."""
        def images_of(pairs):
            return networks.normalized([networks.fitted(image, self.options.pixels) for _, image in pairs])

        source = [pair for pair in self.seen(kind, fold) if kind != "real" or pair[0].block != fold]
        network = networks.trained(images_of(source), [crop.class_id for crop, _ in source], len(CLASSES), fold,
                                   self.options.class_epochs, CLASS_BATCH)
        tested = [pair for pair in self.seen("real", fold) if pair[0].block == fold]
        return {"seed": fold, "crops": [crop.name for crop, _ in tested],
                "labels": [crop.class_id for crop, _ in tested],
                "scores": [rounded(row) for row in networks.scores(network, images_of(tested))]}

    def trainings(self):
        """({member: estimate}, {member: predictions by fold}) of all networks, several trainings at once."""
        tasks = [(f"auc_real_{kind}", "told_apart", kind, fold) for kind in (*KINDS, "real") for fold in self.folds]
        tasks += [(f"macro_f1_{kind}_to_real", "classified", kind, fold) for kind in TRAINED_ON for fold in self.folds]
        predictions = {}
        # Steps are too short to share between threads. The processes begin as copies of this one, images included.
        with multiprocessing.get_context("fork").Pool(self.options.threads, _begin, (self,)) as pool:
            for (member, run, kind, fold), found in zip(tasks, pool.imap(_train, [task[1:] for task in tasks])):
                predictions.setdefault(member, []).append(found)
                self.report(f"{member}, fold {fold}" + (f": {found['auc']:.3f}" if "auc" in found else ""))
        estimates = {member: estimate([fold["auc"] for fold in folds]) if "auc" in folds[0] else jackknifed_f1(folds)
                     for member, folds in predictions.items()}
        ours = predictions["macro_f1_ours_to_real"]
        estimates.update({f"macro_f1_ours_minus_{kind}": jackknifed_f1(ours, predictions[f"macro_f1_{kind}_to_real"])
                          for kind in TRAINED_ON[1:]})
        return estimates, predictions


def _begin(comparison):
    global _comparison
    _comparison = comparison
    networks.use_one_thread()


def _train(task):
    run, kind, fold = task
    return getattr(_comparison, run)(kind, fold)


def jackknifed_f1(predictions, others=None):
    """Macro-F1 over the real crops of all folds, each tested once, with the standard error of the jackknife and the
    recall; or what it is above that of other predictions of the same crops."""
    labels = np.concatenate([fold["labels"] for fold in predictions])
    folds = np.concatenate([[place] * len(fold["labels"]) for place, fold in enumerate(predictions)])

    def answers_of(found):
        return np.concatenate([np.argmax(fold["scores"], 1) for fold in found])

    def score(answers, used):
        return networks.macro_f1(labels[np.isin(folds, used)], answers[np.isin(folds, used)], len(CLASSES))

    answers, places = answers_of(predictions), range(len(predictions))
    if others:
        theirs = answers_of(others)
        return jackknifed(lambda used: score(answers, used) - score(theirs, used), places)
    recall = {kind: float((answers[labels == k] == k).mean()) for k, kind in enumerate(CLASSES)}
    return {**jackknifed(lambda used: score(answers, used), places), "recall_by_class": recall}
