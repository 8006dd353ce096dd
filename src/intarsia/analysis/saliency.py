"""Saliency of exemplar pixels and rarity of patches: nearest-neighbour distance of local statistics, at several scales.

A brown leaf on a lawn is salient, and so is each repetition of it. Local statistics of spots (mean features and
deviation in a neighbourhood) are whitened, and compared with those of spots elsewhere: the saliency is the distance to
one of the nearest neighbours in this space. Rosenholtz ("A simple saliency model predicts a number of motion popout
phenomena", Vision Research 1999) likewise measures the distance of a feature to the distribution of features.

The rarity of whole patches is measured by their mean colours on a coarse grid: a patch with a brown leaf, a knot or a
door is rare if nothing else in the exemplar is similar. It replaces the repetition control of Multrus 2003 (patch-based
sampling, prevention of repetitions), which fails on exemplars with one salient element: in its measure the variation of
the blades of grass hides the leaf.

The distance to the k-th nearest neighbour as a measure of being an outlier: Ramaswamy, Rastogi and Shim, "Efficient
algorithms for mining outliers from large data sets", SIGMOD 2000.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..foundation.arrays import Array, Int16, Int32, Int64, Mask, Pair
from ..foundation.filters import Mode, highest, lowest, moving_sums
from ..foundation.run import Run, draw_many, run_of
from . import FINE, block_sums, enlarged, factor_for, reduced, running_sums

MEDIAN = 256  # saliency of the median spot
FAR = 1 << 12  # beyond all features
MOST = 16 * MEDIAN  # largest saliency
WORK_SIDE = 192  # px: larger exemplars are measured on reduced copies
RADII = 2, 5, 9  # px r of the scales: three averages over 2 r + 1 px, about a Gaussian of sigma r
ROOM = 8  # a scale is used if the shorter side is at least this many radii
ROWS = 1024  # spots that are compared at a time, which limits memory
REFERENCES = 500  # randomly chosen spots with which all spots are compared, at most
NEIGHBOUR_RANK = 3, 200  # rank, from 0, of the neighbour whose distance counts: 3/200 of the references,
LEAST_RANK = 3  # at least this
FLAT, SEEN = 3, 16  # side, px, of the squares that are uniform if every channel varies by less than SEEN units
APART = 3  # radii: least distance in the picture of spots that are compared; nearer ones overlap
LEAST_VARIANCE = 50  # 1/50 of the total variance is added to each variance before whitening, against noise
FIXED = 64  # whitened statistics are kept in 1/64 of a standard deviation
NOWHERE = 1 << 30  # distance of spots that are not compared
STAGE = 1999  # of the random numbers that choose the references


def saliency_map(
    picture: Int16, usable: Mask | None = None, toroidal: bool = False, run: Run | None = None
) -> Int32:
    """Return the saliency of every pixel of an exemplar: how far its local statistics are from those elsewhere.

    Parameters
    ----------
    picture : int16 array, shape (H, W, C)
        Features of the exemplar.
    usable : bool array, shape (H, W), optional
        Which pixels count.
    toroidal : bool
        Whether the exemplar continues in itself.
    run : Run, optional
        Threads, which share the scales.

    Returns
    -------
    int32 array, shape (H, W)
        In 1/256: 256 is the distance of the median spot, 512 twice as far, at most 4096. The maximum over all
        scales, so at least 256; and 256 where nothing can be compared. 0 in uniform areas.
    """
    factor = factor_for(picture.shape, WORK_SIDE)
    small, mask = reduced(picture, usable, factor)
    out = np.full(small.shape[:2], MEDIAN, np.int32)
    with run_of(run).pool() as each:
        scales = [radius for radius in RADII if ROOM * radius <= min(out.shape)]
        out = np.maximum.reduce([out, *each(lambda radius: _at_scale(small, mask, radius, toroidal), scales)])
    out[_uniform(small, mask, toroidal)] = 0
    return enlarged(out, picture.shape, factor)


SALIENT = 2.0  # least saliency, relative to the median, of salient pixels
RARE = 0.9  # share of all pixels that must be less salient; with 0, of 48 judged pairs 1 better, 6 worse (passes.md)
MAX_WEIGHT = 64  # greatest weight (docs/design/passes.md)


def saliency_weights(strikes: Sequence[Array], plain: float) -> Array:
    """Return the weights of all pixels of exemplars, end to end, from their :func:`saliency_map`.

    With e the relative excess of the saliency over the threshold (the greater of SALIENT and the quantile RARE), the
    weight is 1 + (4 e)**2, at most MAX_WEIGHT, for e >= 0, and `plain` for e < 0; 0 in uniform areas.
    """
    far = np.concatenate([s.ravel() for s in strikes]) / MEDIAN
    bar = max(np.quantile(far, RARE, method="lower"), SALIENT)
    out: Array = np.minimum(1 + (4 * np.maximum(far / bar - 1, 0)) ** 2, MAX_WEIGHT)
    out[far < bar] = plain
    out[far < 0.5] = 0
    return out


def _uniform(picture: Array, usable: Mask | None, toroidal: bool) -> Mask:
    """Return which pixels lie in uniform areas."""
    counts = np.ones(picture.shape[:2], bool) if usable is None else usable
    mode: Mode = "wrap" if toroidal else "edge"
    high = highest(np.where(counts[..., None], picture, -FAR), FLAT, mode)
    low = lowest(np.where(counts[..., None], picture, FAR), FLAT, mode)
    return np.asarray((high - low < SEEN).all(axis=2))


def local_statistics(picture: Array, usable: Mask | None, radius: int, toroidal: bool) -> tuple[Array, Array]:
    """Return mean features and deviation around every pixel, (H, W, C + 1), and the usable share in 1/4096, (H, W).

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
    """Return pictures (C, H, W) averaged three times over squares of 2 radius + 1 px, rounded down each time.

    All sums are whole numbers below 2**53, so they and the rounded means are exact.
    """
    for _ in range(3):
        for axis in (1, 2):
            sums = moving_sums(values, axis, radius, "wrap" if toroidal else "symmetric")
            values = np.floor(sums / (2 * radius + 1))
    return values


def _at_scale(picture: Array, usable: Mask | None, radius: int, toroidal: bool) -> Int32:
    """Return the saliency at one scale, measured on a grid; every pixel has that of the nearest spot."""
    step, begin = max(2, radius * 4 // 5), radius // 2
    height, width = picture.shape[:2]
    every, share = local_statistics(picture, usable, radius, toroidal)
    y, x = np.arange(begin, height - begin, step), np.arange(begin, width - begin, step)
    at = np.stack(np.meshgrid(y, x, indexing="ij"), axis=2).reshape(-1, 2)
    counts = share[at[:, 0], at[:, 1]] >= 2048
    spots = np.full(len(at), MEDIAN, np.int64)
    if counts.sum() > LEAST_RANK:
        size = (height, width) if toroidal else (0, 0)
        at = at[counts]
        chosen = np.argsort(np.array(draw_many(0, STAGE, 0, at), np.uint64), kind="stable")[:REFERENCES]
        rank = max(LEAST_RANK, len(chosen) * NEIGHBOUR_RANK[0] // NEIGHBOUR_RANK[1])
        wide = _whitened(every[at[:, 0], at[:, 1]].astype(np.int64))
        spots[counts] = _relative_distance(wide, at, chosen, APART * radius, size, rank, FIXED // 8)
    rows, columns = (np.clip((2 * (np.arange(n) - begin) + step) // (2 * step), 0, m - 1)
                     for n, m in ((height, len(y)), (width, len(x))))  # fmt: skip
    return spots.reshape(len(y), len(x))[rows[:, None], columns].astype(np.int32)


def _whitened(spots: Array) -> Array:
    """Return the statistics of spots (n, C) whitened, in 1/FIXED standard deviations, rounded.

    By the Cholesky factor of their covariance plus a constant diagonal, computed in an order that is equal on every
    machine.
    """
    n, count = len(spots), spots.shape[1]
    around = spots - spots.sum(axis=0) // n
    total = [[int((around[:, a] * around[:, b]).sum()) / n for b in range(count)] for a in range(count)]
    least = sum(total[a][a] for a in range(count)) / LEAST_VARIANCE + FINE * FINE
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


def _relative_distance(
    spots: Array, at: Array, others: Array, apart: int, size: Pair, rank: int, least: int, few: int = 1
) -> Array:
    """Return the distance of every spot (n, C) to its neighbour of a rank, from 0, among `others`, 256 = the median.

    `at` (n, 2): places of spots in the picture, px. Neighbours lie at least `apart` px away in it along an axis, modulo
    `size` if it is not 0. Distances are raised to `least`; all are 256 if fewer than `few` spots have a neighbour.
    """
    far = neighbour_distance(spots, at, others, apart, size, rank)
    known = far >= 0
    if known.sum() < few:
        return np.full(len(spots), MEDIAN, np.int64)
    far = np.maximum(far, least)
    usual = int(np.sort(far[known])[known.sum() // 2])
    return np.where(known, np.minimum((MEDIAN * far + usual // 2) // usual, MOST), MEDIAN)


def neighbour_distance(spots: Array, at: Array, others: Array, apart: int, size: Pair, rank: int) -> Int64:
    """Return the distance of every spot (n, C) to its neighbour of this rank, from 0, rounded down; -1 where none.

    All numbers are whole and below 2**53, so that products of float64 are exact.
    """
    out, theirs = np.full(len(spots), -1, np.int64), spots[others].astype(np.float64)
    square, places = (theirs * theirs).sum(axis=1), at.astype(np.int32)
    for begin in range(0, len(spots) if rank < len(others) else 0, ROWS):
        part = np.s_[begin : begin + ROWS]
        mine = spots[part].astype(np.float64)
        far = mine @ theirs.T
        far *= -2
        far += (mine * mine).sum(axis=1)[:, None]
        far += square
        beside = np.ones(far.shape, np.bool_)
        for axis in range(2):
            away = np.abs(places[part, axis][:, None] - places[others, axis])
            beside &= (np.minimum(away, size[axis] - away) if size[axis] else away) < apart
        if far.max() < NOWHERE:  # partitioning is five times as fast in 32-bit integers
            far = far.astype(np.int32)
        far[beside] = none = np.inf if far.dtype.kind == "f" else NOWHERE
        best = np.partition(far, rank, axis=1)[:, rank]
        there = best < none
        out[part][there] = np.sqrt(best[there])
    return out


MOST_RARE = 4 * MEDIAN  # greatest rarity: patches at 4 times the median distance are unique
NEIGHBOURS = 3  # k of the k-th nearest neighbour: a salient element that occurs two or three times is still rare
CELLS = 4  # a patch is described by 4 x 4 mean colours
PATCH_SIDE = 512  # px: patches of larger exemplars are measured on reduced copies
SAMPLES = 1000  # patches compared: n * n distances take time
FEW = 16  # patches, at least, for a meaningful median
VISIBLE = 1  # feature units, a thousandth of the range: smaller differences of mean colours count as this


def rarity(features: Int16, patch: int) -> tuple[Int32, int]:
    """Return the rarity of the patches of an exemplar.

    Parameters
    ----------
    features : int16 array, shape (H, W, C)
        Any size; at most 64 channels.
    patch : int
        Side of a patch, px. Cut to the short side of the exemplar.

    Returns
    -------
    grid : int32 array, shape (ceil((H - patch + 1) / step), ceil((W - patch + 1) / step))
        ``grid[i, j]`` is the rarity of the patch whose upper left px is (i * step, j * step), in 1/256: 256
        is the median, 512 twice as far from similar patches, 1024 the most. All are 256 if
        fewer than 16 patches exist, or all are equal; so is a patch with
        fewer than 3 others at least half a patch away.
    step : int
        The step of the grid, px: the smallest that gives at most 1000 patches.
    """
    height, width = features.shape[:2]
    patch = min(patch, height, width)
    room = height - patch + 1, width - patch + 1
    step = factor = max(1, min(-(-max(height, width) // PATCH_SIDE), patch // CELLS))
    while -(-room[0] // step) * -(-room[1] // step) > SAMPLES:
        step += factor
    shape = -(-room[0] // step), -(-room[1] // step)
    if shape[0] * shape[1] < FEW:
        return np.full(shape, MEDIAN, np.int32), step
    side, count = patch // factor, min(CELLS, patch // factor)
    edges = np.arange(count + 1) * side // count
    rows, columns = (np.arange(n)[:, None] * (step // factor) + edges for n in shape)
    corners = running_sums(block_sums(features, factor))[rows[:, :, None, None], columns]
    sums = np.diff(np.diff(corners, axis=1), axis=3).transpose(0, 2, 1, 3, 4)
    area = factor * factor * np.multiply.outer(np.diff(edges), np.diff(edges))[:, :, None]
    seen = (FINE * sums // area).reshape(shape[0] * shape[1], -1)  # the mean colours of their cells, in 1/FINE
    # Others, half a patch away or more along an axis: nearer ones overlap.
    found = _relative_distance(
        seen, 2 * step * np.argwhere(np.ones(shape)), np.arange(len(seen)), patch, (0, 0), NEIGHBOURS - 1,
        int(FINE * VISIBLE * seen.shape[1] ** 0.5), FEW,
    )  # fmt: skip
    return np.minimum(found, MOST_RARE).astype(np.int32).reshape(shape), step
