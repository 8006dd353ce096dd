"""How striking every part of an exemplar is: a knot in wood, the one red leaf.

Smooth and common parts may return in a result as often as they like, nobody sees it; a striking part that
returns twice is seen at once. A part is striking if nothing else in the exemplar looks like it: if the k-th
nearest of all other patches is far away, compared with what is usual in this exemplar.

Source: our remedy for the failing repetition control of Multrus 2003 on exemplars with one striking element
(patch-based sampling, prevention of repetitions). The distance to the k-th nearest neighbour as a measure of
being an outlier: Ramaswamy, Rastogi and Shim, "Efficient algorithms for mining outliers from large data
sets", SIGMOD 2000.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Floats, Int16, Int32, Int64, Mask, Pair
from .sums import FINE, WORK_SIDE, block_sums, running_sums

COMMON = 256  # the rarity of what is as common as the median
MOST = 1024  # rarities end here: 4 times the median is simply unique
NEIGHBOURS = 3  # k: the copy beside a repeat, or a pair of knots, must not make either common
CELLS = 4  # a patch is described by 4 x 4 mean colours: what is seen of it at a glance
SAMPLES = 1000  # patches compared: n * n distances take time
FEW = 16  # fewer patches have no meaningful median
VISIBLE = 1  # mean colours that differ less, in feature units, look equal: a thousandth of the range


def rarity(features: Int16, patch: int) -> tuple[Int32, int]:
    """Measure how striking the patches of an exemplar are.

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
        is as common as the median patch, 512 twice as far from its like, 1024 the most. All are 256 where
        fewer than 16 patches exist, or all look alike; so is a patch that overlaps too many others.
    step : int
        The step of the grid, px: the smallest that gives at most 1000 patches.
    """
    height, width = features.shape[:2]
    patch = min(patch, height, width)
    room = height - patch + 1, width - patch + 1
    step = factor = max(1, min(-(-max(height, width) // WORK_SIDE), patch // CELLS))
    while -(-room[0] // step) * -(-room[1] // step) > SAMPLES:
        step += factor
    shape = -(-room[0] // step), -(-room[1] // step)
    if shape[0] * shape[1] < FEW:
        return np.full(shape, COMMON, np.int32), step
    looks = _looks(features, patch // factor, step // factor, shape, factor)
    return _relative(_distances(looks), _apart(shape, step, patch), looks.shape[1]).reshape(shape), step


def _looks(
    features: Int16, patch: int, step: int, shape: Pair, factor: int
) -> Int64:
    """Describe every patch by the mean colours of its cells: an array (patches, cells * channels), in 1/FINE.

    `patch` and `step` count blocks of factor x factor px.
    """
    cells = min(CELLS, patch)
    edges = np.arange(cells + 1) * patch // cells
    rows, columns = (np.arange(n)[:, None] * step + edges for n in shape)
    corners = running_sums(block_sums(features, factor))[rows[:, :, None, None], columns]
    sums = np.diff(np.diff(corners, axis=1), axis=3).transpose(0, 2, 1, 3, 4)
    area = np.diff(edges)
    means: Int64 = FINE * sums // (factor * factor * np.multiply.outer(area, area)[:, :, None])
    return means.reshape(shape[0] * shape[1], -1)


def _distances(looks: Int64) -> Floats:
    """Square distances between all patches.

    Colours of 16 + 4 bit, at most 16 x 64 of them: all sums stay below 2**51, so that float64 holds every
    partial result exactly and the order in which a BLAS adds does not matter. Plain form: ((a - b)**2).sum().
    """
    x = looks.astype(np.float64)
    own = np.einsum("ij,ij->i", x, x)
    result: Floats = x @ x.T
    result *= -2.0
    result += own[:, None]
    result += own
    return result


def _apart(shape: Pair, step: int, patch: int) -> Mask:
    """Say which pairs of patches lie half a patch or more apart in some axis: others share what they show."""
    y, x = (2 * step * np.abs(np.subtract.outer(np.arange(n), np.arange(n))) >= patch for n in shape)
    count = shape[0] * shape[1]
    return (y[:, None, :, None] | x[None, :, None, :]).reshape(count, count)


def _relative(squares: Floats, apart: Mask, colours: int) -> Int32:
    """Compare every patch's distance to its k-th nearest with the median of all."""
    squares[~apart] = np.inf
    rows = np.arange(len(squares))
    for _ in range(NEIGHBOURS - 1):  # faster than np.partition for so small a k
        squares[rows, np.argmin(squares, axis=1)] = np.inf
    near = squares.min(axis=1)
    known = np.isfinite(near)
    result = np.full(len(near), COMMON, np.int32)
    if known.sum() < FEW:
        return result
    # Square roots of whole numbers are rounded the same everywhere (IEEE 754).
    distance = np.sqrt(near[known]).astype(np.int64)
    distance = np.maximum(distance, int(FINE * VISIBLE * colours**0.5))
    usual = int(np.sort(distance)[len(distance) // 2])
    result[known] = np.minimum((COMMON * distance + usual // 2) // usual, MOST)
    return result
