"""Data sets that the studies make with the program.

    folder_of(root, name, identity)     a folder whose name follows from all that shapes the sequences
    make(program, jobs, threads, ...)   makes the missing ones
    painted_level_db(ping, rng)         the control: independent speckle on the expected levels
"""
import hashlib
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np


def folder_of(root, name, identity):
    """Another text `identity` has another folder, and the same one finds its sequences again."""
    return Path(root) / f"{name}_{hashlib.sha256(identity.encode()).hexdigest()[:8]}"


def command_of(program, scene, folder, settings, more=()):
    """One thread for each data set: a world of one ping has little to share out."""
    command = [program, "generate", scene, "-o", folder, "--quiet", "--threads", 1, *more]
    for setting in settings:
        command += ["--set", setting]
    return [*map(str, command)]


def generate(command):
    """Runs the program, which leaves finished sequences alone; a RuntimeError holds what it printed."""
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode not in (0, 3):  # 3: some worlds cannot be made
        raise RuntimeError(f"{' '.join(command)}\n{result.stderr}")


def make(program, commands, threads, report):
    """Runs {name: command}, `threads` at once. A RuntimeError says what failed."""
    if not shutil.which(program):
        raise RuntimeError(f"there is no program {program}; give its path with --program")
    with ThreadPoolExecutor(threads) as pool:
        for name, outcome in [(name, pool.submit(generate, command)) for name, command in commands.items()]:
            if outcome.exception():
                pool.shutdown(cancel_futures=True)
                raise outcome.exception()
            report(f"{name}: is made")


def painted_level_db(ping, rng=None):
    """The control: independent Rayleigh speckle on the expected power, noise included, for each polar pixel; without
    `rng` the expected level itself."""
    expected = ping.polar.clean_db.astype(np.float64)
    noise = ping.sequence.info.get("noise")
    noise_power = noise["power_pa2"] * 1e12 if noise else 0.0
    power = np.where(expected > -90, 10 ** (expected / 10), 0) + noise_power
    speckle = rng.exponential(size=power.shape) if rng else 1.0
    return 10 * np.log10(np.maximum(power * speckle, 1e-9))
