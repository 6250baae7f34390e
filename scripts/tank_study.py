#!/usr/bin/python3
"""./scripts/tank_study.py --real DIR --json OUT [--quick] [--keep DIR] [--ablate LIST] [--figure PNG]

Trains small networks on simulated frames of a water tank and tests them on real frames with masks. DIR has folders with
frames/ and masks/ each, and frames/recording.yaml. Networks are trained on simulated frames alone, on the same frames
with independent speckle, on real frames, and on simulated frames and shares of the real ones. Tested frames show scenes
that no network of their fold has seen. Presets and display were fitted to other frames of the same scenes.
docs/real_study.md explains the members of OUT.

Needs ensonify, NumPy, Pillow and PyTorch (Debian: python3-numpy python3-pil python3-torch).
"""
import argparse
import json
import os
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

import real_study

SCENE = Path(__file__).resolve().parents[1] / "scenes/watertank.yaml"
# One ping of each world: the next ones show nearly the same.
SETTINGS = ["trajectory.pings=1"]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--real", required=True, metavar="DIR", help="folder of folders with frames/ and masks/")
    parser.add_argument("--json", required=True, metavar="OUT", help="file to write")
    parser.add_argument("--figure", metavar="PNG", help="write a figure of answers and overlaps")
    parser.add_argument("--program", default=os.environ.get("ENSONIFY", "ensonify"),
                        help="the program ($ENSONIFY, or ensonify)")
    parser.add_argument("--scene", default=str(SCENE), metavar="YAML", help="the scenario (scenes/watertank.yaml)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change the scenario")
    parser.add_argument("--keep", metavar="DIR", help="keep the data sets here, and reuse those that are there")
    parser.add_argument("--quick", action="store_true", help="fewer worlds, steps and windows")
    parser.add_argument("--ablate", metavar="LIST",
                        help="parts to switch off, one at a time, with commas between; or all")
    parser.add_argument("--sequences", type=int, metavar="N", help="worlds (600; 200 with --quick)")
    parser.add_argument("--steps", type=int, metavar="N", help="steps of a training (4000; 900 with --quick)")
    parser.add_argument("--folds", type=int, default=5, help="groups of scenes, and seeds of the networks (5)")
    parser.add_argument("--alike", type=float, metavar="R",
                        help="correlation above which two frames show one scene (0.5; 1: each frame is a scene)")
    parser.add_argument("--block", type=int, default=93, metavar="N",
                        help="consecutive numbers in a block; every other block is for fitting and training (93)")
    parser.add_argument("--processes", type=int, default=2, help="trainings at once (2)")
    options = parser.parse_args()
    if options.folds < 2:
        parser.error("--folds: expected at least 2")
    for name in ("sequences", "steps", "block", "processes"):
        value = getattr(options, name)
        if value is not None and value < 1:
            parser.error(f"--{name}: {value} is too small; expected at least 1")
    if options.alike is not None and not 0 < options.alike <= 1:
        parser.error(f"--alike: {options.alike} is out of range; expected more than 0 and at most 1")
    for path in (options.json, options.figure):
        if path and not Path(path).absolute().parent.is_dir():
            parser.error(f"{path}: its folder does not exist")
    if not Path(options.scene).is_file():
        parser.error(f"--scene: there is no file {options.scene}")
    options.sequences = options.sequences or (200 if options.quick else 600)
    options.steps = options.steps or (900 if options.quick else 4000)
    return options


def effort_of(options):
    from real_frames.trainings import Effort
    from real_frames.scenes import CELLS
    return Effort(CELLS, 16, options.steps, *((4, 60) if options.quick else (10, 150)))


def trainings_of(options, real, more, report):
    """The trainings with the data sets of the scene and the settings `more`."""
    from real_frames.simulated import KINDS, fitted_viewer, simulated_frames, simulated_sets
    from real_frames.trainings import Trainings
    settings, frames = real
    folders = simulated_sets(options.program, options.scene, options.keep, options.sequences,
                             [*SETTINGS, *options.set, *more], report)
    simulated = simulated_frames(folders, settings, options.folds)
    viewers = {kind: fitted_viewer(frames, simulated, kind, settings) for kind in KINDS}
    report(f"{len(frames)} real frames, {len(simulated)} simulated ones")
    return Trainings(settings, frames, simulated, viewers, options.folds, effort_of(options))


def without(part, options, real, whole, report):
    """AUC and mIoU of ours without a part, and what the part adds, by fold: whole minus without."""
    from real_frames.parts import PARTS
    from real_frames.trainings import estimates, gains
    report(f"without {part}: {PARTS[part].meaning}")
    trainings = trainings_of(options, real, PARTS[part].off, report)
    found = trainings.run(trainings.tasks(("ours",), shares=()), options.processes, report)
    result = estimates(found)
    return {"auc_real_ours": result["auc_real_ours"], "miou": result["miou"]["ours"], "gain": gains(whole, found)}


def study(options, parts, report):
    """The content of the JSON file."""
    from real_frames.figure import write_figure
    from real_frames.frames import CLASSES, real_frames
    from real_frames.scenes import ALIKE, give_scenes
    from real_frames.trainings import estimates
    real = real_frames(options.real, options.block)
    alike = ALIKE if options.alike is None else options.alike
    give_scenes(*real, alike, options.folds, options.real)
    trainings = trainings_of(options, real, (), report)
    found = trainings.run(trainings.tasks(), options.processes, report)
    result = {"scene": Path(options.scene).name, "set": options.set, "sequences": options.sequences,
              "folds": options.folds, "block": options.block, "alike": alike,
              "effort": asdict(trainings.effort), "classes": CLASSES,
              "frames": {"real": len(real[1]), "fitting": sum(frame.fitting for frame in real[1]),
                         "scenes": len({frame.scene for frame in real[1]}), "simulated": len(trainings.simulated)},
              "viewer": {kind: {"gain_db": viewer.gain_db[0], "lost_beams": viewer.lost_beams,
                                "jpeg": viewer.jpeg_tables is not None} for kind, viewer in trainings.viewers.items()},
              **estimates(found)}
    if options.figure:
        write_figure(options.figure, trainings, found, result["miou"])
    result["ablations"] = {part: without(part, options, real, found, report) for part in parts}
    return result


def print_summary(result):
    def words(found):
        if found["value"] is None:
            return "none"
        error = found["standard_error"]
        return f"{found['value']:.3f}" + ("" if error is None else f" ± {error:.3f}")

    for name in (name for name in result if name.startswith("auc_")):
        print(f"{name}: {words(result[name])}")
    for arm, miou in result["miou"].items():
        over = result["miou_over_real"].get(arm)
        print(f"mIoU, {arm}: {words(miou)}, with background {words(result['miou_with_background'][arm])}"
              + (f"; {words(over)} of real, difference {words(result['miou_minus_real'][arm])}" if over else ""))
        print("    " + ", ".join(f"{name} {value:.2f}" for name, value in result["iou_by_class"][arm].items()
                                 if value is not None))
    for arm, seeds in result["miou_by_seed"].items():
        print(f"mIoU, {arm}, each seed on all folds: " + ", ".join(f"{value:.3f}" for value in seeds.values()))
    for part, one in result["ablations"].items():
        print(f"without {part}: AUC {words(one['auc_real_ours'])}, mIoU {words(one['miou'])}; "
              + ", ".join(f"{name} {words(value)}" for name, value in one["gain"].items()))


def main():
    real_study.need_packages("tank_study")
    options = arguments()
    from real_frames.parts import chosen_parts
    start = time.monotonic()

    def report(text):
        print(f"{time.monotonic() - start:6.0f} s  {text}", file=sys.stderr, flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        options.keep = options.keep or temporary
        try:
            result = study(options, chosen_parts(options.ablate), report)
        except (RuntimeError, ValueError) as error:
            sys.exit(f"tank_study: {error}")
    result["seconds"] = round(time.monotonic() - start)
    Path(options.json).write_text(json.dumps(result, indent=1) + "\n")
    print_summary(result)


if __name__ == "__main__":
    main()
