#!/usr/bin/python3
"""./scripts/real_study.py --real DIR --json OUT [--quick] [--keep DIR] [--without PART]...

Compares simulated crops of sonar images with a folder of real ones, which has a folder of JPEG or PNG files for each of
big_propeller, cylinder, small_propeller and soft_pipeline. Consecutive numbers of files are frames of one recording. It
simulates the same targets as an Oculus M750d records them, shows the crops by a power law fitted to a part of the real
ones, and writes measures, the AUC of a network that tells real from simulated crops, and the macro-F1 of a network
trained on simulated crops and tested on real ones. docs/real_study.md explains the members.

Needs ensonify, NumPy, Pillow and PyTorch (Debian: python3-numpy python3-pil python3-torch).
"""
import argparse
import importlib.util
import json
import os
import sys
import tempfile
import time
from pathlib import Path

PACKAGES = {"numpy": "python3-numpy", "PIL": "python3-pil", "torch": "python3-torch"}
SEQUENCES, QUICK_SEQUENCES = 90, 25


def need_packages(script="real_study"):
    missing = [package for module, package in PACKAGES.items() if importlib.util.find_spec(module) is None]
    if missing:
        sys.exit(f"{script}: needs {', '.join(missing)}; install with `apt install {' '.join(missing)}`, "
                 "and run the script with that Python")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--real", required=True, metavar="DIR", help="folder of class folders of real crops")
    parser.add_argument("--json", required=True, metavar="OUT", help="file to write")
    parser.add_argument("--program", default=os.environ.get("ENSONIFY", "ensonify"),
                        help="the program ($ENSONIFY, or ensonify)")
    parser.add_argument("--keep", metavar="DIR", help="keep the data sets here, and reuse those that are there")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_SEQUENCES} sequences and fewer epochs")
    parser.add_argument("--sequences", type=int, metavar="N",
                        help=f"worlds for each class and frequency ({SEQUENCES})")
    parser.add_argument("--parts", metavar="LIST", help="use only these parts of the physics, with commas between")
    parser.add_argument("--without", action="append", default=[], metavar="PART", help="leave out a part; repeatable")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change the scenarios")
    parser.add_argument("--sheet", metavar="PNG", help="write a contact sheet of real and simulated crops")
    parser.add_argument("--measures-only", action="store_true", help="train no networks")
    parser.add_argument("--folds", type=int, default=5, help="blocks of real crops, and seeds of the networks (5)")
    parser.add_argument("--window-epochs", type=int, help="passes of the network that tells real from simulated (14)")
    parser.add_argument("--class-epochs", type=int, help="passes of the network that tells classes (35)")
    parser.add_argument("--see", choices=("crops", "smoothed", "grain"), default="crops",
                        help="what networks see: the crops, without grain, or grain alone (crops)")
    parser.add_argument("--pixels", type=int, default=36, help="longer side of the crops whose class is learnt (36)")
    parser.add_argument("--threads", type=int, default=2, help="data sets and trainings at once (2)")
    options = parser.parse_args()
    if options.folds < 2:
        parser.error("--folds: expected at least 2")
    if options.pixels < 8:
        parser.error("--pixels: expected at least 8")
    for path in (options.json, options.sheet):
        if path and not Path(path).absolute().parent.is_dir():
            parser.error(f"{path}: its folder does not exist")
    options.sequences = options.sequences or (QUICK_SEQUENCES if options.quick else SEQUENCES)
    options.window_epochs = options.window_epochs or (10 if options.quick else 14)
    options.class_epochs = options.class_epochs or (25 if options.quick else 35)
    return options


def study(options, parts, report):
    """The content of the JSON file."""
    from real_crops.comparison import Comparison
    from real_crops.crops import real_crops, simulated_crops
    from real_crops.sheet import contact_sheet
    from real_crops.targets import CLASSES, simulated_sets
    real = real_crops(options.real, options.folds)
    sets = simulated_sets(options, parts, report)
    simulated = simulated_crops(sets, options.folds, parts)
    report(f"{len(real)} real crops, {len(simulated)} simulated ones")
    comparison = Comparison(real, simulated, options, report)
    result = {"parts": parts, "classes": CLASSES, "sequences": options.sequences, "set": options.set,
              "see": options.see, "pixels": options.pixels,
              "crops": {kind: {"real": sum(crop.class_id == k for crop in real),
                               "simulated": sum(crop.class_id == k for crop in simulated)}
                        for k, kind in enumerate(CLASSES)},
              "display": comparison.displays(), **comparison.measures()}
    if options.sheet:
        contact_sheet(options.sheet, comparison)
    if not options.measures_only:
        estimates, predictions = comparison.trainings()
        result.update(estimates, predictions=predictions)
    return result


def print_summary(result):
    def words(found):
        value, error = found["value"], found["standard_error"]
        return "none" if value is None else f"{value:.3f}" + ("" if error is None else f" ± {error:.3f}")

    for name, found in result.items():
        if name.startswith(("auc_", "macro_")):
            print(f"{name}: {words(found)}")
        elif isinstance(found, dict) and "real" in found and "ours" in found:
            print(f"{name}: " + ", ".join(f"{source} {words(value)}" for source, value in found.items()))
    for kind, found in result["two_echo_share_by_class"].items():
        print(f"two echoes, {kind}: " + ", ".join(f"{source} {words(value)}" for source, value in found.items()))


def main():
    need_packages()
    options = arguments()
    sys.path.insert(0, str(Path(__file__).resolve().parent))
    from real_crops.parts import chosen_parts
    try:
        parts = chosen_parts(options.parts.split(",") if options.parts is not None else None, options.without)
    except ValueError as error:
        sys.exit(f"real_study: {error}")
    start = time.monotonic()

    def report(text):
        print(f"{time.monotonic() - start:6.0f} s  {text}", file=sys.stderr, flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        options.keep = options.keep or temporary
        try:
            result = study(options, parts, report)
        except (RuntimeError, ValueError) as error:
            sys.exit(f"real_study: {error}")
    result["seconds"] = round(time.monotonic() - start)
    Path(options.json).write_text(json.dumps(result, indent=1) + "\n")
    print_summary(result)


if __name__ == "__main__":
    main()
