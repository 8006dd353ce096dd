"""The lattice by the rule of the source: the pair of correlation peaks with the best goodness.

Kept for comparison and for what it is good at, printed patterns. It answers on every texture, also on those
without a lattice, and prefers large cells of which few points are seen.

Source: Lopez Recas 2011, section 3.3 and 3.3.1, eq. 3.22. Departures: a negative sum has goodness 0 instead of
an undefined power; flat pairs are left out; the tile is counted in closed form, not px by px; of all peaks the
100 highest are paired; several candidates are returned.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.correlation import autocorrelation
from .candidates import UNIT
from .correlation_map import MILLION
from .published_kernels import hermite, significant_sums, tile_pixels

Int64 = NDArray[np.int64]

ALPHA = 1.12  # above 1: of equal means the one of more points, the smaller tile, wins
PAIRED = 100


@dataclass(frozen=True)
class Plain:
    """Two vectors in 1/256 px, rows (dy, dx), their goodness and mean correlation in millionths, and points."""

    vectors: tuple[tuple[int, int], ...]
    goodness: int
    mean: int
    points: int


def tile_coverage(v1: tuple[int, int], v2: tuple[int, int], height: int, width: int) -> tuple[int, int]:
    """Count how many different pixels of a lattice's tile a rectangle shows, and how many the tile has.

    Vectors (dy, dx) in whole px, not parallel. Where the rectangle lies does not matter.
    """
    a, b, c = hermite(*v1, *v2)
    return tile_pixels(a, b, c, height, width), a * c


def plain(features: NDArray[Any], usable: NDArray[np.bool_] | None, most: int) -> list[Plain]:
    """Rank pairs of correlation peaks by goodness; the `most` best, ties in order of length."""
    height, width = features.shape[:2]
    correlation, _ = autocorrelation(features, usable)
    values = np.rint(MILLION * correlation).astype(np.int32)
    lattices = _pairs(_peaks(values))
    if not len(lattices):
        return []
    total, points = np.empty(len(lattices), np.int64), np.empty(len(lattices), np.int64)
    significant_sums(values, lattices, height, width, total, points)
    sums = np.maximum(total, 0) / MILLION
    goodness = np.rint(MILLION * sums**ALPHA / np.maximum(points, 1)).astype(np.int64)
    order = np.argsort(-goodness, kind="stable")[:most]
    return [
        Plain(
            tuple((int(y) * UNIT, int(x) * UNIT) for y, x in lattices[k]),
            int(goodness[k]),
            int(total[k] // max(points[k], 1)),
            int(points[k]),
        )
        for k in order
        if goodness[k] > 0
    ]


def _peaks(values: NDArray[np.int32]) -> Int64:
    """The highest local maxima of the right half plane (n, 2), shortest first."""
    height, width = values.shape
    middle = height // 2, width // 2
    padded = np.pad(values, 1, constant_values=-MILLION)
    top = np.ones(values.shape, bool)
    for k, (i, j) in enumerate((i, j) for i in (0, 1, 2) for j in (0, 1, 2) if (i, j) != (1, 1)):
        other = padded[i : i + height, j : j + width]
        top &= values >= other if k < 4 else values > other
    at = np.argwhere(top) - middle
    at = at[(at[:, 1] > 0) | ((at[:, 1] == 0) & (at[:, 0] > 0))]
    square = (at * at).sum(axis=1)
    height_of = values[at[:, 0] + middle[0], at[:, 1] + middle[1]]
    chosen = np.lexsort((at[:, 1], at[:, 0], square, -height_of.astype(np.int64)))[:PAIRED]
    at, square = at[chosen], square[chosen]
    result: Int64 = at[np.lexsort((at[:, 1], at[:, 0], square))].astype(np.int64)
    return result


def _pairs(peaks: Int64) -> Int64:
    """Pair every peak with every longer one, reduced by it; each pair once, flat ones left out."""
    i, j = np.triu_indices(len(peaks), 1)
    v, w = peaks[i], peaks[j]
    square = (v * v).sum(axis=1)
    w = w - ((2 * (v * w).sum(axis=1) + square) // (2 * square))[:, None] * v  # halves are rounded up
    w[(w[:, 1] < 0) | ((w[:, 1] == 0) & (w[:, 0] < 0))] *= -1
    flat = v[:, 0] * w[:, 1] == v[:, 1] * w[:, 0]
    keep = ~flat & ((w * w).sum(axis=1) >= square)
    pairs = np.stack([v[keep], w[keep]], axis=1)
    _, first = np.unique(pairs.reshape(-1, 4), axis=0, return_index=True)
    return pairs[np.sort(first)]
