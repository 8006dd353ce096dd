"""The lattice by the rule of the source: the pair of correlation peaks with the best goodness.

For comparison. It is good at printed patterns, but answers on every texture, also on those without a lattice, and
prefers large cells of which few points are seen.

Source: Lopez Recas 2011, section 3.3 and 3.3.1, eq. 3.22. Departures: a negative sum has goodness 0 instead of
an undefined power; flat pairs are left out; the tile is counted in closed form, not px by px; of all peaks the
100 highest are paired.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from intarsia.analysis.correlation import autocorrelation
from intarsia.analysis.reduction import factor_for, reduced
from intarsia.lattice.correlation_map import MILLION

Int64 = NDArray[np.int64]

ALPHA = 1.12  # above 1: of equal means the one of more points, the smaller tile, wins
PAIRED = 100


@njit
def hermite(v1y: int, v1x: int, v2y: int, v2x: int) -> tuple[int, int, int]:
    """Return (a, b, c): the lattice is also spanned by (dx, dy) = (a, 0) and (b, c), 0 <= b < a, 0 < c."""
    y, x, r, s = v1y, v1x, v2y, v2x
    while r != 0:
        t = y // r
        y, x, r, s = r, s, y - t * r, x - t * s
    if y < 0:
        y, x = -y, -x
    a = abs(s)
    return a, x % a, y


@njit
def union_length(a: int, b: int, width: int, count: int) -> int:
    """Length of the union of the circular intervals [-b i, -b i + width) mod a, i < count."""
    if count <= 0:
        return 0
    if width >= a:
        return a
    at = np.empty(min(count, a), np.int64)
    for i in range(len(at)):
        at[i] = (-b * i) % a
    at.sort()
    total = min(width, a - at[-1] + at[0])
    for i in range(len(at) - 1):
        total += min(width, at[i + 1] - at[i])
    return int(total)


@njit
def tile_pixels(a: int, b: int, c: int, height: int, width: int) -> int:
    """Count the different pixels of the tile of the lattice (a, 0), (b, c) that a rectangle shows.

    Rows c apart show the same row of the tile, shifted by b.
    """
    full, rest = height // c, height % c
    total = (c - rest) * union_length(a, b, width, full)
    if rest > 0:
        total += rest * union_length(a, b, width, full + 1)
    return total


@njit
def significant_sums(
    values: NDArray[np.int32],
    lattices: NDArray[np.int64],
    height: int,
    width: int,
    total: NDArray[np.int64],
    count: NDArray[np.int64],
) -> None:
    """Add up the map at the significant points of the right half plane of every lattice, in whole px.

    Significant: the overlap of the picture (height x width) with itself shows 85 % of the tile or more.
    """
    high, wide = values.shape[0] >> 1, values.shape[1] >> 1
    for k in range(len(lattices)):
        a, b, c = hermite(lattices[k, 0, 0], lattices[k, 0, 1], lattices[k, 1, 0], lattices[k, 1, 1])
        total[k], count[k] = 0, 0
        for m in range(-(high // c), high // c + 1):
            y = m * c
            least = 0 if y > 0 else 1
            x = (m * b - least) % a + least
            while x <= wide:
                h, w = height - abs(y), width - x
                if 100 * h * w >= 85 * a * c and 100 * tile_pixels(a, b, c, h, w) >= 85 * a * c:
                    total[k] += values[y + high, x + wide]
                    count[k] += 1
                x += a


def tile_coverage(v1: tuple[int, int], v2: tuple[int, int], height: int, width: int) -> tuple[int, int]:
    """Count how many different pixels of a lattice's tile a rectangle shows, and how many the tile has.

    Vectors (dy, dx) in whole px, not parallel. Where the rectangle lies does not matter.
    """
    a, b, c = hermite(*v1, *v2)
    return tile_pixels(a, b, c, height, width), a * c


def plain_lattice(features: NDArray[np.int16]) -> NDArray[np.float64] | None:
    """The lattice of best goodness, rows (dy, dx) in px; of equals the shortest. None without peaks."""
    factor = factor_for(features.shape)
    picture, _ = reduced(features, None, factor)
    correlation, _ = autocorrelation(picture)
    values = np.rint(MILLION * correlation).astype(np.int32)
    lattices = _pairs(_peaks(values))
    if not len(lattices):
        return None
    total, points = np.empty(len(lattices), np.int64), np.empty(len(lattices), np.int64)
    significant_sums(values, lattices, *picture.shape[:2], total, points)
    sums = np.maximum(total, 0) / MILLION
    goodness = np.rint(MILLION * sums**ALPHA / np.maximum(points, 1)).astype(np.int64)
    best = int(np.argmax(goodness))
    return lattices[best].astype(np.float64) * factor if goodness[best] > 0 else None


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
