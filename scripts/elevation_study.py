#!/usr/bin/python3
"""Trains networks on elevation: ./scripts/elevation_study.py --json OUT [--quick] [--shuffle-labels] [--help]

Trains small networks to estimate the elevation of the surface in each pixel of one polar image, on worlds that are made
while they train and never come twice (scripts/elevation_study.yaml). The arms differ only in the speckle of the images
that they train on; all see the same worlds and labels in the same order:

    ensonify     the level images of ensonify
    independent  independent speckle on its expected level: point spread, but no correlation of the speckle
    painted      independent speckle on the power in each pixel before beams and pulse spread it

All are tested on the images of ensonify of unseen worlds, with the kinds of objects that they know and with others, and
compared with the best constants. docs/elevation_study.md explains the members of OUT.

Needs the Python package of ensonify, NumPy and PyTorch (Debian: python3-numpy python3-torch).
"""
import argparse
import importlib.util
import itertools
import json
import sys
import time
from pathlib import Path

PACKAGES = {"numpy": "python3-numpy", "torch": "python3-torch", "ensonify": "python3-ensonify"}


def need_packages():
    missing = [package for module, package in PACKAGES.items() if importlib.util.find_spec(module) is None]
    if missing:
        sys.exit(f"elevation_study: needs {', '.join(missing)}; docs/python.md shows how to install "
                 "ensonify, the others are Debian packages")


need_packages()
import ensonify  # noqa: E402
import numpy as np  # noqa: E402
import torch  # noqa: E402
from ensonify.dataset import normalise  # noqa: E402
from torch import nn  # noqa: E402
from torch.nn import functional  # noqa: E402

ARMS = ("ensonify", "independent", "painted")
SCENE = Path(__file__).resolve().with_suffix(".yaml")
WANT = ["level_db", "clean_db", "surface_elevation_rad", "instance", "elevation", "front.range_m"]
TRAIN_SEED, TEST_SEED = 1, 2
BED = 1                        # its instance id
HALF_FAN_RAD = np.radians(13)  # the networks' unit of elevation
PRESENCE_WEIGHT = 0.1          # of the loss that finds pixels with a surface
FIRST_BIN = 4                  # samples of range to a class of first echoes
FILL_DEG = 1.0                 # a direction of the front view takes the range of a pixel at most this far away
OTHER_KINDS = {"choice": [{"model": {"kind": kind, "size_m": {"uniform": [0.3, 1.0]}}}
                          for kind in ("tyre", "valve", "propeller", "crab_pot", "chain", "wall")]}


def painted_power(ping):
    """[samples, beams], Pa^2: the expected echo in the pixel of each surface, before beams and pulse spread it, scaled
    to the total power of the image. The worlds have no echoes with fixed amplitudes."""
    echoes, shape = ping.elevation, ping.polar.clean_db.shape
    inside = (echoes.sample >= 0) & (echoes.sample < shape[0])
    pixel = echoes.sample[inside].astype(int) * shape[1] + echoes.beam[inside]
    power = np.bincount(pixel, echoes.diffuse_pa2[inside], shape[0] * shape[1]).reshape(shape)
    return power * expected_power(ping).sum() / max(power.sum(), 1e-30)


def expected_power(ping):
    return 10 ** ((ping.polar.clean_db.astype(float) - 120) / 10)


class Example:
    """Makes of a ping images of the arms, the true elevations, and what the tests need."""

    def __init__(self, arms, seed):
        self.arms, self.seed = arms, seed

    def __call__(self, ping):
        rng = np.random.default_rng([self.seed, ping.sequence.number])
        noise = ping.sequence.info["noise"]["power_pa2"]
        # The noise is as random as the speckle, so that their sum is one exponential intensity.
        powers = {"independent": expected_power(ping) + noise, "painted": painted_power(ping) + noise}
        images = {"ensonify": ping.polar.level_db}
        for name, power in powers.items():
            images[name] = 10 * np.log10(rng.exponential(power) + 1e-22) + 120
        return {"images": np.stack([normalise(images[arm].astype(np.float32)) for arm in self.arms]),
                "elevation": ping.polar.surface_elevation_rad, "instance": ping.polar.instance.astype(np.int32),
                "front": ping.front.range_m, "front_elevation": ping.front.elevation_rad,
                "range": ping.sequence.range_m}


def stream(example, batch, changes):
    """Batches of NumPy arrays without end, each world once. `changes` of the scenario by key."""
    scenario = ensonify.Scenario.load(SCENE, set={**changes, "seed": example.seed})
    pings = map(example, scenario.stream(range(2 ** 32), threads=1, want=WANT))
    while True:
        chosen = list(itertools.islice(pings, batch))
        yield {name: np.stack([one[name] for one in chosen]) for name in chosen[0]}


def block(inputs, outputs):
    layers = []
    for channels in (inputs, outputs):
        layers += [nn.Conv2d(channels, outputs, 3, padding=1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU()]
    return nn.Sequential(*layers)


class ElevationNet(nn.Module):
    """A U-Net of four scales, the finest half the image's. In: [n, rows, columns] levels; to these it adds the places
    in range and azimuth, which a sonar knows. Out: elevation in half fans, and the logit of a surface."""

    def __init__(self, width=16):
        super().__init__()
        widths = [width, 2 * width, 3 * width, 4 * width]
        self.down = nn.ModuleList(block(a, b) for a, b in zip([12, *widths], widths))
        self.up = nn.ModuleList(block(a + b, a) for a, b in zip(widths, widths[1:]))
        self.answer = nn.Conv2d(width, 8, 1)

    def forward(self, image):
        count, rows, columns = image.shape
        along = torch.linspace(-1, 1, rows)[:, None].expand(count, rows, columns)
        across = torch.linspace(-1, 1, columns).expand(count, rows, columns)
        x = functional.pixel_unshuffle(torch.stack([image, along, across], 1), 2)
        passed = []
        for scale, convolve in enumerate(self.down):
            x = convolve(x if scale == 0 else functional.max_pool2d(x, 2))
            passed.append(x)
        for scale in (2, 1, 0):
            x = self.up[scale](torch.cat([passed[scale], functional.interpolate(x, scale_factor=2.0)], 1))
        return functional.pixel_shuffle(self.answer(x), 2).unbind(1)


class Constants:
    """The best constants for the mean absolute error, medians over the training pixels: of all of them, of those at the
    range, and of those at the range in beams whose first echo is as far away. None looks at levels or neighbors."""

    NAMES = ("constant", "by_range", "by_range_and_first_echo")

    def __init__(self, samples, bins=104):
        self.count = np.zeros((samples // FIRST_BIN + 1, samples, bins))

    def places(self, elevation):
        """Class of the first echo, and sample, of each pixel [n, samples, beams]."""
        first = np.isfinite(elevation).argmax(1)[:, None] // FIRST_BIN
        first, sample = np.broadcast_arrays(first, np.arange(elevation.shape[1])[:, None])
        return first, sample

    def learn(self, elevation):
        first, sample = self.places(elevation)
        seen = np.isfinite(elevation)
        bins = self.count.shape[-1]
        step = ((elevation[seen] / HALF_FAN_RAD + 1) / 2 * bins).clip(0, bins - 1).astype(int)
        np.add.at(self.count, (first[seen], sample[seen], step), 1)

    def answers(self, elevation):
        """By name, radians, for images of which only the first echoes are looked at."""
        first, sample = self.places(elevation)
        by_range = self.count.sum(0)
        # Where training had no pixel the coarser median stands in, with a weight that is too small to matter elsewhere.
        by_range = by_range + 1e-6 * by_range.sum(0)
        tables = (by_range.sum(0), by_range[sample], (self.count + 1e-6 * by_range)[first, sample])
        return {name: np.broadcast_to(self.median(table), elevation.shape) for name, table in zip(self.NAMES, tables)}

    @staticmethod
    def median(count):
        bins = count.shape[-1]
        total = np.cumsum(count, axis=-1)
        return (2 * ((total < total[..., -1:] / 2).sum(-1) + 0.5) / bins - 1) * HALF_FAN_RAD


def loss_of(answer, elevation):
    """Huber loss of the elevation where there is a surface, and cross entropy of its presence."""
    seen = torch.isfinite(elevation)
    error = functional.smooth_l1_loss(answer[0][seen], elevation[seen] / HALF_FAN_RAD, beta=0.1, reduction="sum")
    presence = functional.binary_cross_entropy_with_logits(answer[1], seen.float())
    return error / max(int(seen.sum()), 1) + PRESENCE_WEIGHT * presence


def train(options, report):
    """Networks by arm and seed, and the constants. All learn from the same batches."""
    networks, optimizers, constants = {}, {}, None
    for seed, arm in itertools.product(range(options.seeds), options.arms):
        torch.manual_seed(seed)  # arms start from the same weights
        networks[arm, seed] = ElevationNet().to(memory_format=torch.channels_last).train()
        optimizer = torch.optim.Adam(networks[arm, seed].parameters())
        optimizers[arm, seed] = optimizer, torch.optim.lr_scheduler.OneCycleLR(
            optimizer, max_lr=0.005, total_steps=options.steps)
    total = dict.fromkeys(networks, 0.0)
    batches = stream(Example(options.arms, TRAIN_SEED), options.batch, options.set)
    for step, batch in zip(range(1, options.steps + 1), batches):
        constants = constants or Constants(batch["elevation"].shape[1])
        constants.learn(batch["elevation"])
        images, elevation = torch.from_numpy(batch["images"]), torch.from_numpy(batch["elevation"])
        elevation = elevation.roll(int(options.shuffle_labels), 0)
        for (arm, seed), network in networks.items():
            optimizer, schedule = optimizers[arm, seed]
            loss = loss_of(network(images[:, options.arms.index(arm)]), elevation)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total[arm, seed] += loss.item()
        if step % 50 == 0:
            report(f"step {step}: " + ", ".join(f"{arm} {seed} {sum_ / 50:.3f}" for (arm, seed), sum_ in total.items()))
            total = dict.fromkeys(networks, 0.0)
    return networks, constants


def front_of(elevation, seen, range_m, rows_rad):
    """[rows, beams], meters: the nearest of the pixels in each direction of a front view; infinite without any."""
    step = rows_rad[1] - rows_rad[0]
    sample, beam = np.nonzero(seen)
    row = np.round((elevation[sample, beam] - rows_rad[0]) / step).astype(int).clip(0, len(rows_rad) - 1)
    front = np.full((len(rows_rad), elevation.shape[1]), np.inf)
    np.minimum.at(front, (row, beam), range_m[sample])
    placed, reach = front, round(np.radians(FILL_DEG) / step)
    for away in itertools.chain.from_iterable((k, -k) for k in range(1, reach + 1)):
        moved = np.full_like(placed, np.inf)
        moved[max(away, 0):len(placed) + min(away, 0)] = placed[max(-away, 0):len(placed) + min(-away, 0)]
        front = np.where(np.isinf(front), moved, front)
    return front


def errors_of(elevation, found, world):
    """Of the answer for one world. `found`: where it says that there is a surface, for the front view."""
    truth = world["elevation"]
    seen = np.isfinite(truth)
    error = np.degrees(np.abs(elevation - truth))
    bed = world["instance"] == BED
    chosen = {"mean_deg": seen, "bed_deg": seen & bed, "solids_deg": seen & ~bed}
    result = {name: error[pixels].mean() if pixels.any() else np.nan for name, pixels in chosen.items()}
    result["median_deg"] = np.median(error[seen]) if seen.any() else np.nan
    result["wrong_presence"] = (found != seen).mean()
    there = np.isfinite(world["front"])
    front = front_of(elevation, found, world["range"], world["front_elevation"])
    apart = np.abs(front[there] - world["front"][there])
    placed = apart[np.isfinite(apart)]
    result["front_mean_m"] = placed.mean() if placed.size else np.nan
    result["front_median_m"] = np.median(placed) if placed.size else np.nan
    result["front_covered"] = np.isfinite(apart).mean() if apart.size else np.nan
    result["front_within_0.1_m"] = (apart < 0.1).mean() if apart.size else np.nan
    return result


def tested(networks, constants, options, changes):
    """Errors by method: lists over the worlds. The method of a network is (arm, seed, images that it gets)."""
    found = {}
    worlds = stream(Example(options.arms, TEST_SEED), 1, {**options.set, **changes})
    for batch in itertools.islice(worlds, options.worlds):
        world = {name: array[0] for name, array in batch.items()}
        seen = np.isfinite(world["elevation"])
        answers = {name: (answer[0], seen) for name, answer in constants.answers(batch["elevation"]).items()}
        answers["truth"] = np.where(seen, world["elevation"], 0), seen
        with torch.no_grad():
            for (arm, seed), network in networks.items():
                elevation, presence = network.eval()(torch.from_numpy(world["images"]))
                for images, one, logit in zip(options.arms, elevation.numpy() * HALF_FAN_RAD, presence.numpy()):
                    answers[arm, seed, images] = one, logit > 0
        for method, answer in answers.items():
            found.setdefault(method, []).append(errors_of(*answer, world))
    return found


def estimate(values):
    """Of [seeds, worlds]: the mean, and its standard error from the spreads of both."""
    values = np.asarray(values, float)
    values = values[:, np.isfinite(values).all(0)]
    if not values.size:
        return {"value": None, "standard_error": None, "by_seed": []}
    variance = sum(one.var(ddof=1) / len(one) for one in (values.mean(0), values.mean(1)) if len(one) > 1)
    return {"value": float(values.mean()), "standard_error": float(np.sqrt(variance)),
            "by_seed": values.mean(1).tolist()}


def summary(found, options):
    """Estimates of each error by method, and those of differences from the first arm in the same worlds."""
    def values(name, method, images="ensonify"):
        keys = [(method, seed, images) for seed in range(options.seeds)] if method in ARMS else [method]
        return np.array([[world[name] for world in found[key]] for key in keys])

    result = {}
    for name in found["truth"][0]:
        result[name] = {method: estimate(values(name, method)) for method in (*options.arms, *Constants.NAMES, "truth")}
        result[name]["minus_ensonify"] = {method: estimate(values(name, method) - values(name, "ensonify"))
                                          for method in (*options.arms[1:], *Constants.NAMES)}
        result[name]["on_own_images"] = {arm: estimate(values(name, arm, arm)) for arm in options.arms}
    return result


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", required=True, metavar="OUT", help="file to write")
    parser.add_argument("--quick", action="store_true", help="two arms, one seed, 100 steps, 24 worlds in each test")
    parser.add_argument("--steps", type=int, help="batches of training (500)")
    parser.add_argument("--batch", type=int, default=8, help="worlds in a batch (8)")
    parser.add_argument("--seeds", type=int, help="networks in each arm, with other first weights (3)")
    parser.add_argument("--worlds", type=int, help="worlds in each test (100)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="change the scenario; VALUE is JSON; repeatable")
    parser.add_argument("--shuffle-labels", action="store_true",
                        help="control: each training image gets the elevations of another world")
    parser.add_argument("--threads", type=int, default=1, help="of PyTorch (1)")
    options = parser.parse_args()
    try:
        options.set = {key: json.loads(value) for key, value in (setting.split("=", 1) for setting in options.set)}
    except ValueError as error:
        parser.error(f"--set: expected KEY=VALUE with VALUE in JSON ({error})")
    options.arms = ("ensonify", "painted") if options.quick else ARMS
    options.steps = options.steps or (100 if options.quick else 500)
    options.seeds = options.seeds or (1 if options.quick else 3)
    options.worlds = options.worlds or (24 if options.quick else 100)
    if not Path(options.json).absolute().parent.is_dir():
        parser.error(f"{options.json}: its folder does not exist")
    return options


def print_tables(result):
    for kinds, errors in result["tests"].items():
        for name in ("mean_deg", "front_within_0.1_m"):
            print(f"{kinds} kinds of objects, {name}:")
            for method, found in errors[name].items():
                if "value" in found:
                    print(f"  {method:24} {found['value']:.3f} ± {found['standard_error']:.3f}")


def main():
    options = arguments()
    torch.set_num_threads(options.threads)
    start = time.monotonic()

    def report(text):
        print(f"{time.monotonic() - start:6.0f} s  {text}", file=sys.stderr, flush=True)

    networks, constants = train(options, report)
    result = {"steps": options.steps, "batch": options.batch, "seeds": options.seeds, "worlds": options.worlds,
              "set": options.set, "shuffled_labels": options.shuffle_labels, "tests": {},
              "parameters": sum(weights.numel() for weights in ElevationNet().parameters())}
    other = {f"objects.{name}.shape": OTHER_KINDS for name in ("solid", "floating")}
    for kinds, changes in (("known", {}), ("other", other)):
        report(f"test with {kinds} kinds of objects")
        result["tests"][kinds] = summary(tested(networks, constants, options, changes), options)
    result["seconds"] = round(time.monotonic() - start)
    Path(options.json).write_text(json.dumps(result, indent=1) + "\n")
    print_tables(result)


if __name__ == "__main__":
    main()
