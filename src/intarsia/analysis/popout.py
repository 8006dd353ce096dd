"""What strikes in an exemplar: spots whose colour or contrast is unlike that of all others, at several scales.

A brown leaf on a lawn is seen at once, and is seen each time it returns. The mean colour of a spot, and how much it
varies around it, are compared with those of spots elsewhere, after both were made equally wide in all directions: a
spot pops out as far as its nearest likes are away. Rosenholtz ("A simple saliency model predicts a number of motion
popout phenomena", Vision Research 1999) measures likewise how far off a distribution a feature lies. Rarity
(`rarity.py`) compares patches cell by cell; there blades of grass hide the leaf.
"""

from __future__ import annotations

import math

import numpy as np

from ..arrays import Array, Int16, Int32, Mask, Pair
from ..draws import draw_many
from . import popout_kernels
from .sums import FINE, factor_for, reduced

USUAL = 256  # what the median spot has
MOST = 16 * USUAL
WORK_SIDE = 384  # px: larger exemplars are looked at on reduced copies
RADII = 2, 5, 10, 18  # px: three times averaged over 2 r + 1 px, a Gaussian of about so many px
ROOM = 8  # a scale needs an exemplar so many times as large
REFERENCES = 500  # spots that all are compared with
LIKES = 3, 200  # the nearest three in two hundred are a spot's likes,
LEAST_LIKES = 3  # but no fewer
APART = 3  # radii: nearer spots show the same
NARROW = 50  # directions in which spots differ less than by 1 / 50 of all their variance are not widened more
FIXED = 64  # distances are kept in 1/64 of a spread
STAGE = 1999  # which spots are references hangs on this number and on their places


def popout(picture: Int16, usable: Mask | None = None, toroidal: bool = False) -> Int32:
    """Measure how far the look of every spot of an exemplar is from its likes.

    Parameters
    ----------
    picture : int16 array, shape (H, W, C)
        Features of the exemplar.
    usable : bool array, shape (H, W), optional
        Which pixels count.
    toroidal : bool
        Whether the exemplar continues in itself.

    Returns
    -------
    int32 array, shape (H, W)
        In 1/256: 256 is as common as the median spot, 512 twice as far from its likes, at most 4096. The most of all
        scales, so at least 256; and 256 where nothing can be compared.
    """
    factor = factor_for(picture.shape, WORK_SIDE)
    small, mask = reduced(picture, usable, factor)
    out = np.full(small.shape[:2], USUAL, np.int32)
    for radius in RADII:
        if ROOM * radius <= min(out.shape):
            np.maximum(out, _at_scale(small, mask, radius, toroidal), out=out)
    rows, columns = (np.minimum(np.arange(picture.shape[a]) // factor, out.shape[a] - 1) for a in (0, 1))
    return np.asarray(out[rows[:, None], columns])


def looks(picture: Array, usable: Mask | None, radius: int, toroidal: bool) -> tuple[Array, Array]:
    """Describe every spot: its mean features and how they vary (H, W, C + 1); and how much of it counts, of 4096.

    Whole numbers below 2**53, in float64.
    """
    planes = np.moveaxis(picture, 2, 0).astype(np.float64, order="C")
    mask = np.ones(planes.shape[1:]) if usable is None else usable.astype(np.float64)
    share = _averaged(mask[None] * 4096, radius, toroidal)[0]
    part = np.maximum(share, 1)
    mean = _averaged(planes * (mask * 64), radius, toroidal)
    mean *= 64
    mean /= part
    np.floor(mean, out=mean)
    planes -= mean
    planes *= planes
    apart = _averaged(planes.sum(axis=0)[None] * mask, radius, toroidal)
    spread = np.floor(np.sqrt(np.floor(apart * 4096 / part)))
    return np.moveaxis(np.concatenate([mean, spread]), 0, 2), share


def _averaged(values: Array, radius: int, toroidal: bool) -> Array:
    """Average pictures (C, H, W) three times over squares of 2 radius + 1 px, rounded down each time."""
    popout_kernels.average(values, radius, toroidal)
    return values


def _at_scale(picture: Array, usable: Mask | None, radius: int, toroidal: bool) -> Int32:
    """Measure spots of one size on a grid; every pixel has what the spot nearest to it has."""
    step, begin = max(2, radius * 4 // 5), radius // 2
    height, width = picture.shape[:2]
    every, share = looks(picture, usable, radius, toroidal)
    y, x = np.arange(begin, height - begin, step), np.arange(begin, width - begin, step)
    at = np.stack(np.meshgrid(y, x, indexing="ij"), axis=2).reshape(-1, 2)
    counts = share[at[:, 0], at[:, 1]] >= 2048
    spots = np.full(len(at), USUAL, np.int64)
    if counts.sum() > LEAST_LIKES:
        size = (height, width) if toroidal else (0, 0)
        at = at[counts]
        spots[counts] = _relative(_widened(every[at[:, 0], at[:, 1]].astype(np.int64)), at, APART * radius, size)
    rows, columns = (np.clip((2 * (np.arange(n) - begin) + step) // (2 * step), 0, m - 1)
                     for n, m in ((height, len(y)), (width, len(x))))  # fmt: skip
    return spots.reshape(len(y), len(x))[rows[:, None], columns].astype(np.int32)


def _widened(spots: Array) -> Array:
    """Give spots (n, C) the same spread in all directions; in 1/FIXED of it, rounded.

    By the Cholesky factor of their covariance, whose few steps are single IEEE operations: the same everywhere.
    """
    n, count = len(spots), spots.shape[1]
    around = spots - spots.sum(axis=0) // n
    total = [[int((around[:, a] * around[:, b]).sum()) / n for b in range(count)] for a in range(count)]
    least = sum(total[a][a] for a in range(count)) / NARROW + FINE * FINE
    out = np.zeros((n, count))
    factor = [[0.0] * count for _ in range(count)]
    for a in range(count):
        for b in range(a + 1):
            rest = total[a][b] + (least if a == b else 0.0)
            for c in range(b):
                rest -= factor[a][c] * factor[b][c]
            factor[a][b] = math.sqrt(rest) if a == b else rest / factor[b][b]
        rest_of = around[:, a].astype(np.float64)
        for c in range(a):
            rest_of -= factor[a][c] * out[:, c]
        out[:, a] = rest_of / factor[a][a]
    return np.rint(out * FIXED).astype(np.int64)


def _relative(spots: Array, at: Array, apart: int, size: Pair) -> Array:
    """How far every spot's likes are, 256 = the median; none is nearer than `apart` px (on a torus of `size`)."""
    numbers = np.array(draw_many(0, STAGE, 0, at), np.uint64)
    chosen = np.argsort(numbers, kind="stable")[:REFERENCES]
    k = max(LEAST_LIKES, len(chosen) * LIKES[0] // LIKES[1])
    theirs, far = np.ascontiguousarray(spots[chosen].T, np.float64), np.empty(len(spots), np.int64)
    popout_kernels.likes_away(spots.astype(np.float64), at, theirs, at[chosen], apart, size, k, far)
    known = far >= 0
    if not known.any():
        return np.full(len(spots), USUAL, np.int64)
    usual = max(int(np.sort(far[known])[known.sum() // 2]), FIXED // 8)
    return np.where(known, np.clip((USUAL * far + usual // 2) // usual, 0, MOST), USUAL)
