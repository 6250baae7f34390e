#!/usr/bin/env python3
"""Twin experiment: does `ensonify fit` find what it should, and are its intervals honest?

    scripts/twin_experiment.py --json twin.json [--draws 20] [--program ensonify] [--keep DIR]

Each draw hides other values of four keys in a scenario (scripts/twin/scenario.yaml), simulates it with a seed of its
own, writes the pings as an Oculus log, imports the log, and fits the keys blind, from their ranges. Counted is how often
the 95 % intervals hold the hidden values. Needs NumPy and the program; about a minute a draw on two cores."""
import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

SCENARIO = Path(__file__).resolve().parent / "twin" / "scenario.yaml"
# Path, range of the search, logarithmic. Values are hidden in the middle 80 % of the range.
KEYS = [("sonar.beams.receive_width_deg", 0.6, 2.0, True),
        ("noise.spectrum_level_db", 30.0, 60.0, False),
        ("materials.sand.texture.shape", 0.7, 8.0, True),
        ("materials.sand.law.lambert.exponent", 1.0, 3.0, False)]


def run(program, *arguments):
    result = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))}\n{result.stderr}")
    return result.stdout


def hidden_values(draw):
    shares = np.random.default_rng([20, draw]).uniform(0.1, 0.9, len(KEYS))
    return [float(low * (high / low) ** share if log else low + share * (high - low))
            for (_, low, high, log), share in zip(KEYS, shares)]


def log_of(program, folder, draw, hidden):
    """A data set imported from a log with hidden settings."""
    settings = [part for (path, *_), value in zip(KEYS, hidden) for part in ("--set", f"{path}={value}")]
    run(program, "generate", SCENARIO, "-o", folder / "hidden", "--seed", 1000 + draw, "--quiet", *settings)
    shutil.rmtree(folder / "log", ignore_errors=True)
    run(program, "export", folder / "hidden", "--format", "oculus", "-o", folder / "log", "--quiet")
    run(program, "import", folder / "log" / "000000.oculus", "-o", folder / "recording", "--quiet")
    return folder / "recording"


def fitted(program, folder, recording):
    ranges = [part for path, low, high, log in KEYS
              for part in ("--key", f"{path}={low}:{high}" + (":log" if log else ""))]
    run(program, "fit", SCENARIO, recording, "-o", folder / "fit", "--blocks", 24, "--quiet", *ranges)
    return json.loads((folder / "fit" / "fit.json").read_text())


def one_draw(program, folder, draw):
    hidden = hidden_values(draw)
    fit = fitted(program, folder, log_of(program, folder, draw, hidden))
    keys = []
    for value, key in zip(hidden, fit["keys"]):
        low, high = key["interval"]
        keys.append({"path": key["path"], "hidden": value, "value": key["value"], "interval": [low, high],
                     "identified": key["identified"], "held": low <= value <= high})
    return {"draw": draw, "simulations": fit["simulations"], "rms_misfit": fit["rms_misfit"],
            "converged": fit["converged"], "keys": keys}


def summary(draws):
    """By key: identified, held among these; and over all keys."""
    found = {}
    for path, *_ in KEYS:
        keys = [key for draw in draws for key in draw["keys"] if key["path"] == path and key["identified"]]
        found[path] = {"identified": len(keys), "held": sum(key["held"] for key in keys)}
    identified = sum(key["identified"] for key in found.values())
    held = sum(key["held"] for key in found.values())
    return {"draws": len(draws), "keys": found, "identified": identified, "held": held,
            "coverage": held / identified if identified else None}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--program", default="build/release/ensonify")
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first draw")
    parser.add_argument("--json", type=Path, required=True)
    parser.add_argument("--keep", type=Path, help="folder for the data sets and fits; fits in it are not repeated")
    options = parser.parse_args()
    draws = []
    with tempfile.TemporaryDirectory() as scratch:
        for draw in range(options.first, options.first + options.draws):
            folder = (options.keep or Path(scratch)) / f"{draw:03}"
            kept = folder / "draw.json"
            if not kept.exists():
                folder.mkdir(parents=True, exist_ok=True)
                kept.write_text(json.dumps(one_draw(options.program, folder, draw)))
            draws.append(json.loads(kept.read_text()))
            print(f"draw {draw}: " + ", ".join(f"{k['hidden']:.4g} in {k['interval'][0]:.4g} to {k['interval'][1]:.4g}"
                                               f"{'' if k['held'] else ' MISSED'}"
                                               f"{'' if k['identified'] else ' (not identified)'}"
                                               for k in draws[-1]["keys"]), flush=True)
    result = {"summary": summary(draws), "draws": draws}
    options.json.write_text(json.dumps(result, indent=1) + "\n")
    print(json.dumps(result["summary"], indent=1))


if __name__ == "__main__":
    main()
