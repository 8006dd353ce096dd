"""The slow twin of `analysis/saliency.py`: spot by spot, in plain Python."""

from __future__ import annotations

import math

import numpy as np


def _at(n, length, toroidal):
    """The pixel that stands for one beyond the border: round it, or mirrored."""
    while not 0 <= n < length:
        n = n % length if toroidal else (-1 - n if n < 0 else 2 * length - 1 - n)
    return n


def averaged(values, radius, toroidal):
    """Average a list of lists of numbers three times over squares, rounding down along each axis."""
    height, width = len(values), len(values[0])
    around = range(-radius, radius + 1)
    for _ in range(3):
        values = [
            [sum(values[_at(y + d, height, toroidal)][x] for d in around) // len(around) for x in range(width)]
            for y in range(height)
        ]
        values = [
            [sum(values[y][_at(x + d, width, toroidal)] for d in around) // len(around) for x in range(width)]
            for y in range(height)
        ]
    return values


def looks(picture, usable, radius, toroidal):
    """What every spot looks like: means, then how far pixels are from them; and the share that counts."""
    height, width, channels = picture.shape
    share = averaged([[4096 * int(usable[y, x]) for x in range(width)] for y in range(height)], radius, toroidal)
    means = []
    for c in range(channels):
        one = [[int(picture[y, x, c]) * 64 * int(usable[y, x]) for x in range(width)] for y in range(height)]
        one = averaged(one, radius, toroidal)
        means.append([[one[y][x] * 64 // max(share[y][x], 1) for x in range(width)] for y in range(height)])
    apart = [
        [sum((int(picture[y, x, c]) - means[c][y][x]) ** 2 for c in range(channels)) * int(usable[y, x])
         for x in range(width)]
        for y in range(height)
    ]  # fmt: skip
    apart = averaged(apart, radius, toroidal)
    spread = [[math.isqrt(apart[y][x] * 4096 // max(share[y][x], 1)) for x in range(width)] for y in range(height)]
    return np.moveaxis(np.array([*means, spread], np.int64), 0, 2), np.array(share, np.int64)


def relative(spots, at, order, apart, size, rank, least):
    """How far the like of a rank is from every spot, 256 = the median of all; none is nearer than `apart`."""
    far = []
    for k, spot in enumerate(spots):
        found = []
        for r in order:
            gaps = [abs(int(at[k][a]) - int(at[r][a])) for a in (0, 1)]
            gaps = [min(g, size[a] - g) if size[a] else g for a, g in enumerate(gaps)]
            if not all(g < apart for g in gaps):
                found.append(sum((int(a) - int(b)) ** 2 for a, b in zip(spot, spots[r], strict=True)))
        far.append(math.isqrt(sorted(found)[rank]) if len(found) > rank else -1)
    known = sorted(f for f in far if f >= 0)
    usual = max(known[len(known) // 2], least) if known else 1
    return [min((256 * max(f, least) + usual // 2) // usual, 4096) if f >= 0 else 256 for f in far]
