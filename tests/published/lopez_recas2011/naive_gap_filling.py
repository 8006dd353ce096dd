"""Random sampling and gap filling, slow and obvious: every place, every border pixel.

Written from Lopez Recas 2011, whose sections are named.
"""

from __future__ import annotations

import math

import numpy as np

from intarsia.foundation.run import below, draw

STAGE = 20110


def px(value: int) -> int:
    return math.floor(value / 256 + 0.5)


def lattice_places(first, v1, v2, low, high):
    """All points first + a v1 + b v2, in 1/256 px, whose px lie in a box, by a, then b."""
    found = set()
    for a in range(-60, 61):
        for b in range(-60, 61):
            y, x = first[0] + a * v1[0] + b * v2[0], first[1] + a * v1[1] + b * v2[1]
            if low[0] <= px(y) <= high[0] and low[1] <= px(x) <= high[1]:
                found.add((px(y), px(x), a, b))
    return sorted(found, key=lambda f: (f[2], f[3]))


def side_of(y, x, block, border):
    """The neighbour whose wedge holds a pixel (from the outer corner); None inside."""
    depths = [y, block + border - 1 - y, x, block + border - 1 - x]
    side = depths.index(min(depths))
    return side if depths[side] < border else None


def difference(f, g):
    return sum(int((int(a) - int(b)) ** 2) for p, q in zip(f, g, strict=True) for a, b in zip(p, q, strict=True))


def correlation(f, g):
    """GNCC of two lists of pixels, in 1e-9."""
    f, g = np.array(f, np.float64), np.array(g, np.float64)
    f, g = f - f.mean(axis=0), g - g.mean(axis=0)
    below_ = np.sqrt((f * f).sum(axis=0) * (g * g).sum(axis=0)).sum()
    return 0 if below_ < 1e-9 else round(1e9 * (f * g).sum() / below_)


def synthesized(picture, v1, v2, block, border, slack, size, seed, by="difference"):
    """The map of an unwrapped canvas, as the source makes it; vectors in 1/256 px."""
    height, width = picture.shape[:2]
    half = border // 2
    room = height - block - border, width - block - border
    rows, columns = -(-size[0] // block) + 1, -(-size[1] // block) + 1
    shown = {}
    for i in range(-2, rows + 1):  # 4.2.1; the blocks around the output are neighbours, too
        for j in range(-2, columns + 1):
            if (i + j) % 2 == 0:
                start = (i * block - half) * 256, (j * block - half) * 256
                places = lattice_places(start, v1, v2, (0, 0), room)
                shown[i, j] = places, draw(seed, STAGE, 0, i, j)
    for at, (places, bits) in shown.items():
        shown[at] = places[below(len(places), bits)][:2]
    patches = dict(shown)
    ring = [
        (y, x, side_of(y, x, block, border))
        for y in range(block + border)
        for x in range(block + border)
        if side_of(y, x, block, border) is not None
    ]
    for i in range(-1, rows):
        for j in range(-1, columns):
            if (i + j) % 2 == 0:
                continue
            border_px = []
            for y, x, side in ring:  # 4.2.2: read from where the neighbours were taken
                di, dj = ((-1, 0), (1, 0), (0, -1), (0, 1))[side]
                py, pxx = shown[i + di, j + dj]
                border_px.append(picture[py + y - di * block, pxx + x - dj * block])
            start = (i * block - half) * 256, (j * block - half) * 256
            near = lattice_places(start, v1, v2, (-slack, -slack), (room[0] + slack, room[1] + slack))
            candidates = sorted(
                {
                    (y + dy, x + dx)
                    for y, x, _, _ in near
                    for dy in range(-slack, slack + 1)
                    for dx in range(-slack, slack + 1)
                    if 0 <= y + dy <= room[0] and 0 <= x + dx <= room[1]
                }
            )
            fits = []
            for y, x in candidates:
                there = [picture[y + r, x + s] for r, s, _ in ring]
                fits.append(difference(there, border_px) if by == "difference" else -correlation(there, border_px))
            patches[i, j] = candidates[int(np.argmin(fits))]
    out = np.zeros((*size, 2), np.int32)
    for y in range(size[0]):  # cropped at the end
        for x in range(size[1]):
            py, pxx = patches[y // block, x // block]
            out[y, x] = py + half + y % block, pxx + half + x % block
    return out
