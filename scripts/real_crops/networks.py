"""The small network of the comparison, its training, and the scores of its answers.

    trained(images, labels, classes, seed, epochs)      a network
    scores(network, images)                             [n, classes]
    area_under_curve(labels, scores), macro_f1(labels, answers, classes)
"""
import numpy as np
import torch
from PIL import Image
from torch import nn
from torch.nn import functional

WINDOW_PX = 32      # of windows at native resolution
SMALLEST_PX = 20    # crops with a shorter side have no windows
BATCH = 32


def use_one_thread():
    torch.set_num_threads(1)


def normalized(images):
    """float32 [n, rows, columns] of mean 0 and standard deviation 1 each."""
    images = np.asarray(images, np.float32)
    mean, spread = images.mean((1, 2), keepdims=True), images.std((1, 2), keepdims=True)
    return (images - mean) / (spread + 1)


def fitted(gray, side_px):
    """A whole crop in a square: its longer side is scaled to it, and the rest filled with its background."""
    height, width = gray.shape
    scale = side_px / max(height, width)
    size = max(1, round(width * scale)), max(1, round(height * scale))
    small = np.asarray(Image.fromarray(gray).resize(size, Image.BOX), np.float32)
    square = np.full((side_px, side_px), np.percentile(gray, 40), np.float32)
    top, left = (side_px - small.shape[0]) // 2, (side_px - small.shape[1]) // 2
    square[top:top + small.shape[0], left:left + small.shape[1]] = small
    return square


def windows(gray, count, rng):
    """[count, 32, 32]: windows of a crop at random places; crops that are too short are continued by reflection."""
    if min(gray.shape) < SMALLEST_PX:
        return np.empty((0, WINDOW_PX, WINDOW_PX), np.uint8)
    missing = [max(0, WINDOW_PX - side) for side in gray.shape]
    padded = np.pad(gray, [(0, missing[0]), (0, missing[1])], mode="reflect")
    places = [(rng.integers(0, padded.shape[0] - WINDOW_PX + 1), rng.integers(0, padded.shape[1] - WINDOW_PX + 1))
              for _ in range(count)]
    return np.stack([padded[row:row + WINDOW_PX, column:column + WINDOW_PX] for row, column in places])


def network_of(classes, channels=(16, 32, 64)):
    """Three convolutions, each with normalization and halving, and a mean over places."""
    layers, inputs = [], 1
    for outputs in channels:
        layers += [nn.Conv2d(inputs, outputs, 3, padding=1), nn.BatchNorm2d(outputs), nn.ReLU(), nn.MaxPool2d(2)]
        inputs = outputs
    return nn.Sequential(*layers, nn.AdaptiveAvgPool2d(1), nn.Flatten(), nn.Dropout(0.3), nn.Linear(inputs, classes))


def varied(images, rng):
    """A batch mirrored along the arc at random, moved by up to 3 pixels, with other contrast, level and some noise."""
    count = len(images)

    def random(low, high):
        return torch.from_numpy(rng.uniform(low, high, (count, 1, 1, 1)).astype(np.float32))

    if rng.random() < 0.5:
        images = torch.flip(images, [3])
    images = images * random(0.7, 1.3) + random(-0.3, 0.3)
    images = images + torch.randn_like(images) * random(0, 0.15)
    down, right = rng.integers(-3, 4, 2)
    return torch.roll(images, (int(down), int(right)), (2, 3))


def trained(images, labels, classes, seed, epochs, batch=BATCH):
    """A network trained on normalized images; rare classes weigh more."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    network = network_of(classes)
    images, labels = torch.from_numpy(images)[:, None], torch.from_numpy(np.asarray(labels, np.int64))
    weights = len(labels) / (classes * torch.bincount(labels, minlength=classes).clamp(min=1).float())
    optimizer = torch.optim.Adam(network.parameters(), 2e-3, weight_decay=1e-4)
    steps = epochs * -(-len(labels) // batch)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 4e-3, total_steps=steps + 1)
    network.train()
    for _ in range(epochs):
        for chosen in torch.from_numpy(rng.permutation(len(labels))).split(batch):
            if len(chosen) < 4:  # too few for the normalization
                continue
            loss = functional.cross_entropy(network(varied(images[chosen], rng)), labels[chosen], weight=weights)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
    return network.eval()


def scores(network, images):
    with torch.no_grad():
        parts = [network(part) for part in torch.from_numpy(images)[:, None].split(128)]
    return torch.cat(parts).softmax(1).numpy()


def area_under_curve(labels, values):
    """The probability that an item of label 1 has a larger value than one of label 0; ties count half."""
    labels, values = np.asarray(labels), np.asarray(values, np.float64)
    ordered = np.sort(values)
    ranks = (np.searchsorted(ordered, values, "left") + np.searchsorted(ordered, values, "right") + 1) / 2
    ones = int((labels == 1).sum())
    zeros = len(labels) - ones
    if not ones or not zeros:
        return float("nan")
    return float((ranks[labels == 1].sum() - ones * (ones + 1) / 2) / (ones * zeros))


def macro_f1(labels, answers, classes):
    """The mean of the F1 of all classes."""
    labels, answers = np.asarray(labels), np.asarray(answers)
    found = [2 * ((answers == k) & (labels == k)).sum() / max((answers == k).sum() + (labels == k).sum(), 1)
             for k in range(classes)]
    return float(np.mean(found))
