#!/usr/bin/env python3
"""Trains a small network to find debris on the seabed, and tells how well it does on worlds it has
not seen. It shows how a data set is loaded, and whether its labels can be learnt from.

Needs Python 3.9, NumPy and PyTorch (Debian: python3-torch). Its data set, 400 worlds of one ping:

    build/release/ensonify generate scenes/random_debris.yaml -o out/debris \\
        --set sequences=400 --set trajectory.pings=1 --set sonar.beams.count=128 \\
        --set sonar.rays.elevation=512 \\
        --set 'output={timeseries: none, cartesian: false, png: false}'
    scripts/train_example.py out/debris

With --stream SCENARIO it trains for as many steps on worlds that are made meanwhile and never come twice, which needs
the package `ensonify` (docs/python.md); the folder's other splits are what it is tested on, and the scenario is the
folder's own, `out/debris/scenario.yaml`.

Input is the level of the polar picture, normalised picture by picture; the answer is a mask of the
classes of kind thing, which leaves the seabed out. Told at the end, for each split, of this one mask and over all
pixels of all pictures together: the IoU of the network; that of the best threshold on the level, chosen on the
training pictures; and that of the best constant answer. Docs: docs/training.md.
"""
import argparse
import json
import time

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from ensonify_dataset import SonarDataset, normalise, to_amplitude, to_db

TOLD = 50  # steps between two lines of progress


def by_twos(array):
    """[rows / 2, 2, columns]: two samples of range to a row."""
    rows = array.shape[0] // 2
    return array[: 2 * rows].reshape(rows, 2, -1)


def things_of(dataset):
    """Ids of the classes that have boxes: all but the seabed."""
    return [k + 1 for k, kind in enumerate(dataset.class_kinds) if kind == "thing"]


def example_of(ping, things):
    """Normalised level and debris mask of a ping, [1, rows, columns] each.

    Two samples of range make a row: their mean power, and debris where either has some.
    """
    power = to_amplitude(ping.polar.level_db).astype(np.float64) ** 2
    debris = np.isin(ping.polar.semantic, things)
    picture = normalise(to_db(np.sqrt(by_twos(power).mean(1))))
    return picture[None], by_twos(debris).any(1)[None].astype(np.float32)


def load(dataset):
    """Pictures and masks of a data set, which are small and all fit into memory."""
    things = things_of(dataset)
    pictures, masks = zip(*(example_of(ping, things) for ping in dataset))
    return torch.from_numpy(np.stack(pictures)), torch.from_numpy(np.stack(masks))


class Example:
    """The transform of the stream: a ping as picture and mask."""

    def __init__(self, things):
        self.things = things

    def __call__(self, sample, ping):
        picture, mask = example_of(ping, self.things)
        return {"picture": picture, "mask": mask}


def block(inputs, outputs):
    """Two convolutions, each with normalisation."""
    layers = []
    for channels in (inputs, outputs):
        convolution = nn.Conv2d(channels, outputs, 3, padding=1, bias=False)
        layers += [convolution, nn.BatchNorm2d(outputs), nn.ReLU()]
    return nn.Sequential(*layers)


class SmallUNet(nn.Module):
    """A U-Net of a few scales; the finest is half the picture's, four pixels to a place. [n, classes, rows, columns]."""

    def __init__(self, width=16, classes=1, scales=3):
        super().__init__()
        widths = [width * 2 ** scale for scale in range(scales)]
        self.down = nn.ModuleList([block(inputs, outputs) for inputs, outputs in zip([4, *widths], widths)])
        self.up = nn.ModuleList([block(fine + coarse, fine) for fine, coarse in zip(widths, widths[1:])])
        self.answer = nn.Conv2d(width, 4 * classes, 1)

    def forward(self, picture):
        rows, columns = picture.shape[-2:]
        least = 2 ** len(self.down)
        padded = functional.pad(picture, (0, -columns % least, 0, -rows % least), mode="replicate")
        x = functional.pixel_unshuffle(padded, 2)
        passed = []
        for scale, convolve in enumerate(self.down):
            x = convolve(x if scale == 0 else functional.max_pool2d(x, 2))
            passed.append(x)
        for convolve, finer in zip(reversed(self.up), reversed(passed[:-1])):
            wider = functional.interpolate(x, scale_factor=2.0)
            x = convolve(torch.cat([wider, finer], 1))
        return functional.pixel_shuffle(self.answer(x), 2)[..., :rows, :columns]


def loss_of(answer, mask):
    """Cross entropy, and Dice: where a class is rare the first alone is content with none of it."""
    share = torch.sigmoid(answer)
    dice = 1 - (2 * (share * mask).sum() + 1) / (share.sum() + mask.sum() + 1)
    return functional.binary_cross_entropy_with_logits(answer, mask) + dice


def stored_batches(pictures, masks, options):
    """Batches without end, in a new order each time round."""
    while True:
        for chosen in torch.randperm(len(pictures)).split(options.batch):
            yield pictures[chosen], masks[chosen]


def streamed_batches(things, options):
    """Batches of worlds that never come twice, of the sequences that the scenario gives to training."""
    import ensonify
    from ensonify.torch import SonarStream
    scenario = ensonify.Scenario.load(options.stream)
    stream = SonarStream(scenario, ["level_db", "semantic"], Example(things), "train", batch_size=options.batch)
    for batch in stream:
        yield batch["picture"], batch["mask"]


def train(network, batches, steps, options):
    """Adam with a rate that rises and falls once; pictures are mirrored at random."""
    optimizer = torch.optim.Adam(network.parameters())
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, max_lr=0.01, total_steps=steps)
    start, total = time.monotonic(), 0.0
    network.train()
    for step, (pictures, masks) in zip(range(1, steps + 1), batches):
        turned = [3] if torch.rand(()) < 0.5 else []
        loss = loss_of(network(pictures.flip(turned)), masks.flip(turned))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        total += loss.item()
        if step % TOLD == 0 and not options.quiet:
            print(f"step {step}/{steps}: loss {total / TOLD:.3f}, {time.monotonic() - start:.0f} s", flush=True)
            total = 0.0


def overlap(answer, truth):
    """Intersection over union of two boolean arrays."""
    return ((answer & truth).sum() / max((answer | truth).sum(), 1)).item()


def iou(network, pictures, masks):
    """Of the debris, over all pixels of all pictures together."""
    network.eval()
    with torch.no_grad():
        answers = [network(some) > 0 for some in pictures.split(8)]
    return overlap(torch.cat(answers), masks > 0.5)


def best_threshold(pictures, masks):
    """The level above which all is called debris, that does best on these pictures."""
    candidates = torch.linspace(0, 4, 81)
    scores = [overlap(pictures > candidate, masks > 0.5) for candidate in candidates]
    return candidates[int(np.argmax(scores))]


def constant_iou(masks):
    """The better of "all debris", which is debris' share of the pixels, and "none", which is 0."""
    return masks.mean().item()


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="data set, finished")
    parser.add_argument("--stream", metavar="SCENARIO", help="train on worlds of this scenario, none of them twice")
    parser.add_argument("--epochs", type=int, default=12, help="passes over the pictures (12)")
    parser.add_argument("--batch", type=int, default=8, help="pictures a step (8)")
    parser.add_argument("--width", type=int, default=16, help="channels at the finest scale (16)")
    parser.add_argument("--seed", type=int, default=0,
                        help="of the network and the order of pictures (0)")
    parser.add_argument("--threads", type=int, default=1, help="of PyTorch (1: steps are short)")
    parser.add_argument("--shuffle-labels", action="store_true",
                        help="control: each training picture gets the mask of another one")
    parser.add_argument("--quiet", action="store_true", help="print nothing but the result, a line of JSON")
    return parser.parse_args()


def main():
    options = arguments()
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    dataset = SonarDataset(options.folder)
    data = {name: load(dataset.split(name)) for name in ("train", "val", "test")}
    pictures, masks = data["train"]
    if options.shuffle_labels:
        masks = masks.roll(len(masks) // 2, 0)
    network = SmallUNet(options.width).to(memory_format=torch.channels_last)
    steps = options.epochs * -(-len(pictures) // options.batch)
    batches = (streamed_batches(things_of(dataset), options) if options.stream
               else stored_batches(pictures, masks, options))
    start = time.monotonic()
    train(network, batches, steps, options)
    seen = steps * options.batch if options.stream else len(pictures)
    result = {"seed": options.seed, "shuffled_labels": options.shuffle_labels, "train_pictures": seen,
              "steps": steps, "seconds": round(time.monotonic() - start)}
    threshold = best_threshold(*data["train"])
    for name, (pictures, truth) in data.items():
        result[name] = {"iou": round(iou(network, pictures, truth), 3),
                        "threshold_iou": round(overlap(pictures > threshold, truth > 0.5), 3),
                        "constant_iou": round(constant_iou(truth), 3)}
    print(json.dumps(result))


if __name__ == "__main__":
    main()
