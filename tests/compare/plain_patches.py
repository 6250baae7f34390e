"""Log-level statistics of plain patches, one rule for recordings and simulations; compare/measure_plain.cpp has the same.

A patch is 32 samples by 24 beams. It is plain if, after a plane in dB is taken away, the means of its 12 blocks of 8 x 8
pixels spread by less than 1.5 dB, the plane rises by less than 6 dB across it, and its mean lies between the 60 and 97 %
quantiles of such means of the frame. Medians over the plain patches: standard deviation in dB, skewness, correlation of
the amplitude (over the plane) at lag 1 of beams and of samples.

The comb of beams that fire in groups, every G-th at once: rows whose mean level is among the highest tenth of the
frame's are averaged, a Gaussian mean over the beams (sigma 6) is taken away, 4 beams at each end are cut; the contrast of
a frame is the autocorrelation over beams at lag G less the mean of those at G - 1 and G + 1. Measured are the share of
frames with a contrast over 0.5, and the range of the level by beam modulo G, averaged over all rows and frames."""
import numpy as np

ROWS, COLUMNS, BLOCK = 32, 24, 8
Y, X = np.mgrid[0:ROWS, 0:COLUMNS]
PLANE = np.stack([np.ones(ROWS * COLUMNS), Y.ravel() / ROWS, X.ravel() / COLUMNS], 1)
SOLVE = np.linalg.pinv(PLANE)
NAMES = ("std", "skew", "beams", "samples")


def patches(levels):
    """(mean dB, deviations from the plane [32, 24], whether it is plain) of the patches of a frame [samples, beams]."""
    for i in range(0, levels.shape[0] - ROWS + 1, ROWS // 2):
        for j in range(0, levels.shape[1] - COLUMNS + 1, COLUMNS // 2):
            p = levels[i:i + ROWS, j:j + COLUMNS]
            if not np.isfinite(p).all() or np.ptp(p) == 0:
                continue
            fit = SOLVE @ p.ravel()
            x = p - (PLANE @ fit).reshape(p.shape)
            means = x.reshape(ROWS // BLOCK, BLOCK, COLUMNS // BLOCK, BLOCK).mean((1, 3))
            yield p.mean(), x, means.std() < 1.5 and abs(fit[1]) < 6 and abs(fit[2]) < 6


def medians(frames):
    """(number of plain patches, {name of NAMES: median}) of frames of levels in dB."""
    rows = []
    for levels in frames:
        found = list(patches(levels))
        low, high = np.quantile([mean for mean, _, _ in found], [0.6, 0.97])
        for mean, x, plain in found:
            if plain and low <= mean <= high:
                a = 10 ** (x / 20)
                a -= a.mean()
                near = lambda u, v: float((u * v).mean() / a.var())  # noqa: E731
                rows.append((x.std(), (x ** 3).mean() / x.std() ** 3, near(a[:, :-1], a[:, 1:]), near(a[:-1], a[1:])))
    return len(rows), dict(zip(NAMES, np.median(np.array(rows).reshape(-1, 4), 0)))


def comb(frames, period):
    """(share of frames that show it, range of the level by beam modulo the period in dB)."""
    kernel = np.exp(-0.5 * (np.arange(-24, 25) / 6) ** 2)
    kernel /= kernel.sum()
    flat = lambda line: (line - np.convolve(np.pad(line, 24, "reflect"), kernel, "valid"))[4:-4]  # noqa: E731
    contrast, profile = [], []
    for levels in frames:
        mean = levels.mean(1)
        e = flat(levels[mean >= np.quantile(mean, 0.9)].mean(0))
        before, at, after = ((e[:-k] * e[k:]).mean() / (e * e).mean() for k in (period - 1, period, period + 1))
        contrast.append(at - (before + after) / 2)
        profile.append(flat(levels.mean(0)))
    by_group = [np.mean(profile, 0)[k::period].mean() for k in range(period)]
    return float(np.mean(np.array(contrast) > 0.5)), float(np.ptp(by_group))
