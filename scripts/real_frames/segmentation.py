"""The network that finds classes in frames, its training, and the overlap that it reaches.

    prepared(pairs, size)               (images, masks) at the size of the network
    flattened(images)                   without level and contrast of the surroundings
    trained(sources, ...)               a network
    confusion(network, images, ...)   pixels by true and answered class
    mean_iou(confusions)
"""
import numpy as np
import torch
from PIL import Image
from torch.nn import functional

from real_crops import networks
from train_example import SmallUNet

from .frames import CLASSES

BATCH = 4
LABELED_SHARE = 0.3     # of a cell of the network, from which on it has the class of the most labeled pixels
RATE, FURTHER_RATE = 1e-2, 3e-3     # highest ones: from new weights, and from those of another network
DECAY = 0.03            # of the weights, as a share of the rate
SURROUNDINGS = 31       # rows and columns of the window about a cell
ZOOM, STRETCH, SHIFT = 0.15, 0.1, 0.15  # most of both axes and of each, as logarithms; most shift over half the size


def resized(array, size):
    """float32: means over the cells of a grid of (rows, columns)."""
    return np.asarray(Image.fromarray(array.astype(np.float32)).resize((size[1], size[0]), Image.BOX))


def class_map(mask, size):
    """uint8 of (rows, columns): the class with most labeled pixels where enough are labeled, else 0. Simulated labels
    have gaps between echoes, which this fills."""
    present = [k for k in np.unique(mask) if k]
    if not present:
        return np.zeros(size, np.uint8)
    shares = np.stack([resized(mask == k, size) for k in present])
    return np.where(shares.sum(0) > LABELED_SHARE, np.array(present, np.uint8)[shares.argmax(0)], 0).astype(np.uint8)


def flattened(images):
    """Images with mean 0 and standard deviation 1, minus the mean of the surroundings of each cell and over their
    standard deviation: the level of the floor along range depends on height and tilt, which nobody knows."""
    images = torch.from_numpy(networks.normalized(images))[:, None]

    def mean_of(values):
        padded = functional.pad(values, [SURROUNDINGS // 2] * 4, mode="reflect")
        return functional.avg_pool2d(padded, SURROUNDINGS, 1)

    mean = mean_of(images)
    spread = (mean_of(images ** 2) - mean ** 2).clamp(min=0.05).sqrt()
    return ((images - mean) / spread)[:, 0].numpy()


def prepared(pairs, size):
    """(float32 [n, rows, columns], uint8 of the same shape) of [(8-bit image, mask), ...]."""
    return (flattened([resized(gray, size) for gray, _ in pairs]),
            np.stack([class_map(mask, size) for _, mask in pairs]))


def loss_of(answer, mask, weights):
    """Cross entropy, and Dice of the classes that are there."""
    logarithm = answer.log_softmax(1)
    share = logarithm.exp()
    count = torch.bincount(mask.reshape(-1), minlength=len(CLASSES))
    hit = torch.zeros(len(CLASSES)).index_add(0, mask.reshape(-1), share.gather(1, mask[:, None]).reshape(-1))
    dice = 1 - 2 * hit / (share.sum((0, 2, 3)) + count)
    return functional.nll_loss(logarithm, mask, weight=weights) + dice[count > 0].mean()


def class_weights(masks):
    """By the inverse root of the share of a class, at most 10; 0 of those that are not there."""
    share = np.mean([np.bincount(mask.ravel(), minlength=len(CLASSES)) / mask.size for mask in masks], 0)
    weights = np.where(share > 0, np.minimum((share.max() / np.maximum(share, 1e-9)) ** 0.5, 10), 0)
    return torch.from_numpy(weights.astype(np.float32))


def batches_of(sources, rng):
    """Batches without end: of each source (images, masks, count) so many, in a new order each time round."""
    orders = [[] for _ in sources]
    while True:
        images, masks = [], []
        for order, (some, their_masks, count) in zip(orders, sources):
            while len(order) < count:
                order += list(rng.permutation(len(some)))
            chosen, order[:] = order[:count], order[count:]
            images.append(some[chosen])
            masks.append(their_masks[chosen])
        yield np.concatenate(images), np.concatenate(masks)


def zoomed(images, masks, rng):
    """Each frame stretched along both axes and moved, both at random; what is missing at an edge is mirrored there."""
    count = len(images)
    ways = np.zeros((count, 2, 3), np.float32)
    stretch = rng.uniform(-ZOOM, ZOOM, (count, 1)) + rng.uniform(-STRETCH, STRETCH, (count, 2))
    ways[:, 0, 0], ways[:, 1, 1] = np.exp(stretch).T
    ways[:, :, 2] = rng.uniform(-SHIFT, SHIFT, (count, 2))
    both = torch.from_numpy(np.stack([images, masks.astype(np.float32)], 1))
    grid = functional.affine_grid(torch.from_numpy(ways), both.shape, align_corners=False)
    moved = functional.grid_sample(both, grid, mode="nearest", padding_mode="reflection", align_corners=False).numpy()
    return moved[:, 0], np.rint(moved[:, 1]).astype(np.uint8)


def varied(images, masks, rng):
    """Mirrored along the arc, stretched and moved at random, with other contrast and level."""
    if rng.random() < 0.5:
        images, masks = images[:, :, ::-1], masks[:, :, ::-1]
    images, masks = zoomed(images.astype(np.float32), masks, rng)
    shape = (len(images), 1, 1)
    return images * rng.uniform(0.7, 1.3, shape) + rng.uniform(-0.3, 0.3, shape), masks


def trained(sources, steps, seed, width, begin=None):
    """A network trained on sources (images, masks, how many of each batch), from new weights or from those of
    `begin`."""
    torch.manual_seed(seed)
    rng = np.random.default_rng([seed, 2])
    network, rate = SmallUNet(width, len(CLASSES), scales=4).to(memory_format=torch.channels_last), RATE
    if begin is not None:
        network.load_state_dict(begin.state_dict())
        rate = FURTHER_RATE
    weights = class_weights(np.concatenate([masks for _, masks, _ in sources]))
    optimizer = torch.optim.AdamW(network.parameters(), weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, rate, total_steps=steps + 1)
    network.train()
    for _, (images, masks) in zip(range(steps), batches_of(sources, rng)):
        images, masks = varied(images, masks, rng)
        answer = network(torch.from_numpy(images.astype(np.float32))[:, None])
        loss = loss_of(answer, torch.from_numpy(masks.astype(np.int64)), weights)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
    return network.eval()


def answers(network, images):
    """uint8 [n, rows, columns]: the class of each pixel."""
    with torch.no_grad():
        parts = [network(part[:, None]).argmax(1) for part in torch.from_numpy(images).split(BATCH)]
    return torch.cat(parts).numpy().astype(np.uint8)


def confusion_of(masks, answered):
    """[classes, classes]: pixels by true and answered class."""
    count = len(CLASSES)
    pairs = masks.astype(np.int64) * count + answered
    return np.bincount(pairs.ravel(), minlength=count * count).reshape(count, count)


def confusion(network, images, masks):
    return confusion_of(masks, answers(network, images))


def class_ious(table):
    """Intersection over union of each class; NaN of those that are not there."""
    table = np.asarray(table, np.float64)
    hit = np.diag(table)
    with np.errstate(invalid="ignore"):
        return np.where(table.sum(1) > 0, hit / (table.sum(0) + table.sum(1) - hit), np.nan)


def mean_iou(table, background=False):
    """The mean over the classes that are there."""
    return float(np.nanmean(class_ious(table)[0 if background else 1:]))
