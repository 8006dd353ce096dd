"""Isometries under which a texture keeps its statistics: which mirrored and rotated patches may be used.

Light from one side, grass that grows upwards or wood grain exclude some or all of the isometries; gravel allows all.
The exemplar is divided into two halves, the light and the dark squares of a checkerboard. An isometry is allowed if the
distance between the statistics of one transformed half and those of the other half is hardly larger than the distance
of the two halves as they are. All decisions are in whole numbers, and the same for the mirrored exemplar: the exemplar
is first oriented with its darker sides at the top and at the left.

Source: Multrus 2003 leaves the choice of isometries to the user (4.1); the measurement is this project's own.
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from ..foundation.arrays import Array, Int64
from ..foundation.geometry import ISOMETRIES
from ..foundation.run import below, draw
from ..model import Exemplar, Exemplars, sampled
from . import block_sums, blocks, valid_windows
from .features import Features, features, in_isometry, transformed

STAGE = 93  # keeps these random numbers apart from others
# After each value: on how many of 29 textures without a lattice other isometries are allowed with other values.
SIDE = 5  # cells: side of the patches compared; 3: four, 9: eight
SCALES = (1, 2, 4)  # px: sides of a cell; without 4 three textures allow more, with 8 in addition none differs
BLOCKS = (3, 4, 5)  # squares along an axis of each checkerboard; 3 alone: four, 3 to 8: three, 6 to 10: eight
STATISTICS = 1 + len(SCALES)  # numbers compared: gradients, and patches of each scale
SAMPLES = 3000  # patches of each half at most; halved: one, doubled: five
LOTS = 4  # disjoint samples whose gradient distances are added; with 1 two of four crops of granite may be rotated
LEAST_SAMPLES = 50  # patches of each half at least; 1 to 400: the same, as it matters for small exemplars only
DIRECTIONS = 28  # random projections, in addition to four ramps; halved: three, doubled: one
TOLERANCE = (4, 3)  # largest ratio of distances, 4 / 3; 7 / 6: 13, 5 / 3: seven; 1.2 excludes isometries of noise
SUBGROUPS: tuple[tuple[int, ...], ...] = (
    (0, 1, 2, 3, 4, 5, 6, 7), (0, 1, 2, 6), (0, 3, 4, 6), (0, 5, 6, 7), (0, 1), (0, 2), (0, 3), (0, 4), (0, 6), (0,),
)  # fmt: skip
"""The subgroups of the eight isometries."""
MIRRORED = (0, 1, 2, 4, 3, 7, 6, 5)
"""For each isometry p the one that acts on the mirrored picture as p does on the picture."""


def allowed_isometries(exemplars: Exemplars, square: bool = True) -> tuple[int, ...]:
    """Return the largest subgroup of isometries that keep the statistics of all exemplars; it contains the identity, 0.

    Of equally large ones that of the least sum of distances. `square` False excludes isometries that exchange rows and
    columns, for patches that are not square.
    """
    far = np.stack([e.memo("symmetry", partial(pose_distances, e)) for e in sampled(exemplars)])
    groups = [
        g for g in SUBGROUPS
        if (far[..., g] * TOLERANCE[1] <= far[..., :1] * TOLERANCE[0]).all()
        and (square or not any(ISOMETRIES[p].swaps for p in g))
    ]  # fmt: skip
    return min(groups, key=lambda g: (-len(g), int(far[..., g].sum())))


def pose_distances(exemplar: Exemplar) -> Int64:
    """Return the distances between the two halves of an exemplar with one of them in each isometry: (STATISTICS, 8).

    Row 0: of histograms of gradients; the other rows: of patches at each of SCALES. Summed over the checkerboards.
    """
    feats, out = features([exemplar]), np.zeros((STATISTICS, 8), np.int64)
    vectors = {k + i for k in feats.normals for i in (0, 1)}
    level = [c for c in range(feats.base) if c not in vectors]  # the channels that do not change with the isometry
    pose = _upright(feats.pictures[0][:, :, level].sum(axis=2, dtype=np.int64))
    for number, scale in enumerate(SCALES[:1] + SCALES):
        picture = block_sums(in_isometry(feats.pictures[0], pose, feats.normals), scale)
        whole = np.asarray(blocks(transformed(exemplar.free, pose), scale).all(axis=(1, 3)))
        for squares in BLOCKS:
            halves = _halves(whole, squares)
            if min(map(len, halves)) < LEAST_SAMPLES:
                continue
            if number == 0:
                tone = picture[:, :, level].sum(axis=2)
                out[0] += sum(_of_gradients([_gradients(tone, at) for at in _subset(halves, k)]) for k in range(LOTS))
            else:
                out[number] += _of_patches([_patches(picture, at) for at in _subset(halves, 0)], feats)
    return out[:, list(MIRRORED)] if pose in (1, 2) else out


def _upright(bright: Array) -> int:
    """Return the isometry, of 0, 1, 2 and 6, that brings the darker sides of a picture to the top and to the left."""
    right, down = (int((np.arange(1 - n, n, 2) * bright.sum(axis=axis)).sum()) < 0
                   for axis, n in enumerate(bright.shape[::-1]))  # fmt: skip
    return (0, 1, 2, 6)[right + 2 * down]


def _halves(usable: Array, squares: int) -> tuple[Array, Array]:
    """Return the first cells (n, 2) of usable patches that lie wholly in light, and in dark squares of a checkerboard.

    `usable`: which cells are; `squares`: along each axis.
    """
    h, w = usable.shape
    free = valid_windows(usable.shape, usable, False, (SIDE, SIDE))
    y, x = (np.arange(n) for n in free.shape)
    row, column = squares * y // h, squares * x // w
    whole = (row == squares * (y + SIDE - 1) // h)[:, None] & (column == squares * (x + SIDE - 1) // w)
    light = (row[:, None] + column) % 2 == 0
    return np.argwhere(free & whole & light), np.argwhere(free & whole & ~light)


def _subset(halves: tuple[Array, Array], number: int) -> list[Array]:
    """Return equally many evenly spaced patches of both halves, at most SAMPLES; other numbers give others."""
    count = min(*(len(half) for half in halves), SAMPLES)
    return [half[(LOTS * np.arange(count) + number) * len(half) // max(LOTS * count, 1)] for half in halves]


def _patches(picture: Array, at: Array) -> Array:
    """Return the patches that begin at `at`: (SIDE, SIDE, n, C)."""
    i = np.arange(SIDE)
    return np.asarray(picture[at[:, 0] + i[:, None, None], at[:, 1] + i[None, :, None]])


def _of_patches(patches: list[Array], feats: Features) -> Array:
    """Return the sliced Wasserstein distance of two sets of patches, with one of them in each isometry: (8,).

    Symmetrised: the sum of transforming the one and of transforming the other.
    """
    axes = _directions(patches[0].shape[3], feats.normals)
    # Whole numbers below 2**53: exact in any order of summation.
    flat = [p.transpose(0, 1, 3, 2).reshape(-1, p.shape[2]).astype(np.float64) for p in patches]
    a, b = ((axes @ f).reshape(8, -1, f.shape[1]) for f in flat)
    a.sort(axis=2)
    b.sort(axis=2)
    apart, other = a - b[0], b - a[0]
    np.add(np.abs(apart, out=apart), np.abs(other, out=other), out=apart)
    return np.asarray(apart.sum(axis=2).astype(np.int64).sum(axis=1))


@cache
def _directions(channels: int, normals: tuple[int, ...]) -> Array:
    """Return the weights of projections of patches, of sum 0: four ramps and DIRECTIONS random ones.

    (8 * n, SIDE * SIDE * channels): all n in isometry 0, then in 1 and so on. As projecting a transformed patch equals
    projecting the patch with inversely transformed weights, the weights are transformed.
    """
    i = np.arange(SIDE) - SIDE // 2
    ramps = [np.add.outer(a * i, b * i) * 4 for a, b in ((1, 0), (0, 1), (1, 1), (1, -1))]
    out = [np.repeat(r[:, :, None], channels, axis=2).astype(np.int64) for r in ramps]
    for n in range(DIRECTIONS):
        drawn = [
            below(17, draw(0, STAGE, n, y, SIDE * c + x)) - 8
            for y in range(SIDE) for x in range(SIDE) for c in range(channels)
        ]  # fmt: skip
        out.append(np.array(drawn, np.int64).reshape(SIDE, SIDE, channels))
    level = [d * d.size - d.sum() for d in out]
    back = [0, 1, 2, 3, 4, 7, 6, 5]
    turned = [in_isometry(d, back[pose], normals).ravel() for pose in range(8) for d in level]
    return np.array(turned, np.float64)


def _gradients(tone: Array, at: Array) -> tuple[Array, Array]:
    """Return the gradients of the tone in the middle of the patches that begin at `at`: down, and to the right."""
    y, x = (at + SIDE // 2).T
    return tone[y + 1, x] - tone[y - 1, x], tone[y, x + 1] - tone[y, x - 1]


def _of_gradients(grads: list[tuple[Array, Array]]) -> Array:
    """Return the L1 distance of two histograms of gradients, with one of them in each isometry, symmetrised: (8,)."""
    strength = np.sort(np.concatenate([d * d + r * r for d, r in grads]))
    steps = strength[[len(strength) // 3, 2 * len(strength) // 3]]
    other = [_histogram(d, r, steps) for d, r in grads[::-1]]
    out = []
    for pose in range(8):
        (a, b), (c, d) = ISOMETRIES[pose].j  # the gradient turns with the transpose
        turned = [(a * down + c * right, b * down + d * right) for down, right in grads]
        pairs = zip(turned, other, strict=True)
        out.append(sum(int(np.abs(_histogram(*g, steps) - its).sum()) for g, its in pairs))
    return np.array(out, np.int64)


def _histogram(down: Array, right: Array, steps: Array) -> Array:
    """Return the histogram of gradients by signs, larger component, slope, and strength (limits `steps`, squared)."""
    v, h = np.abs(down), np.abs(right)
    small, large = np.minimum(v, h), np.maximum(v, h)
    cells = (np.sign(down) + 1) * 3 + np.sign(right) + 1
    cells = (cells * 3 + np.sign(v - h) + 1) * 2 + (12 * small > 5 * large)  # 5 / 12: 22.6 degrees
    cells = cells * 3 + np.searchsorted(steps, down * down + right * right)
    return np.bincount(cells, minlength=9 * 3 * 2 * 3).astype(np.int64)
