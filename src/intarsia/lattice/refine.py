"""Large exemplars: the lattice is searched in a reduced copy, then made exact at full resolution.

At full resolution only a few lattice points are looked at: the exemplar, moved by about that vector, is
compared with itself in whole numbers, a few px to every side. Where it differs least lies the exact vector.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .candidates import UNIT, canonical
from .shift_kernels import best_shift

Mask = NDArray[np.bool_]
Int64 = NDArray[np.int64]

WINDOW = 512  # px: side of what is compared; as much as a search sees that reduces nothing
POINTS = 12  # lattice points looked at: two of each direction
ANGLES = 6  # directions of a half circle, 30 degrees each, over which they are spread
FARTHEST = 0.5  # of each side: the other half is left to compare
SPARE = 2  # px besides those that one px of the reduced copy stands for: the peak may lie beside its px
SPANNED = 0.5  # the determinant of whole numbers is 0 where all points lie in a row, 1 or more else


def refined(features: NDArray[np.int16], usable: Mask | None, vectors: Int64, factor: int) -> Int64 | None:
    """Make the vectors (1/256 px) exact at full resolution; None where the exemplar does not allow it.

    Weighted least squares over the points that lie furthest out: their error is shared by many cells.
    """
    height, width = features.shape[:2]
    mask = np.ones((1, 1), np.bool_) if usable is None else usable
    rows, right = [], []
    found = np.empty(2)
    radius = factor + SPARE
    for index in _furthest(vectors, height, width):
        at = (np.array(index) @ vectors) / UNIT
        if best_shift(features, mask, np.rint(at).astype(np.int64), radius, WINDOW, found):
            rows.append(index)
            right.append((float(found[0]), float(found[1])))
    return _least_squares(rows, right, vectors, factor)


def _furthest(vectors: Int64, height: int, width: int) -> list[tuple[int, ...]]:
    """Lattice points that leave half of each side to compare, the furthest first, spread over directions."""
    n = len(vectors)
    most = [max(1, int(FARTHEST * max(height, width) * UNIT / math.hypot(*v))) for v in vectors]
    found = []
    for a in range(most[0] + 1):
        for b in range(-most[1], most[1] + 1) if n == 2 else (0,):
            index = (a, b)[:n]
            if index <= (0, 0)[:n]:
                continue
            y, x = (np.array(index) @ vectors) / UNIT
            if abs(y) <= FARTHEST * height and abs(x) <= FARTHEST * width:
                angle = math.floor(ANGLES * (math.atan2(y, x) % math.pi) / math.pi)
                found.append((round(math.hypot(y, x)), angle, index))
    found.sort(key=lambda f: (-f[0], f[2]))
    seen: dict[int, int] = {}
    ranked = []
    for far, angle, index in found:
        seen[angle] = seen.get(angle, 0) + 1
        ranked.append((seen[angle], -far, index))
    return [index for _, _, index in sorted(ranked)[:POINTS]]


def _least_squares(
    rows: list[tuple[int, ...]], right: list[tuple[float, float]], vectors: Int64, factor: int
) -> Int64 | None:
    if not rows:
        return None
    a, p = np.array(rows, np.float64), np.array(right)
    n = len(vectors)
    if n == 1:
        across = vectors[0] / math.hypot(*vectors[0])
        exact = ((a[:, 0] * (p @ across)).sum() / (a[:, 0] ** 2).sum()) * across[None]
    else:
        aa, ab, bb = (a[:, 0] ** 2).sum(), (a[:, 0] * a[:, 1]).sum(), (a[:, 1] ** 2).sum()
        determinant = aa * bb - ab * ab
        if determinant < SPANNED:
            return None
        t0, t1 = (a[:, 0, None] * p).sum(axis=0), (a[:, 1, None] * p).sum(axis=0)
        exact = np.array([bb * t0 - ab * t1, aa * t1 - ab * t0]) / determinant
    whole: Int64 = np.rint(UNIT * exact).astype(np.int64)
    if np.abs(whole - vectors).max() > UNIT * factor:
        return None
    if n == 2:
        whole = canonical(whole[None])[0]
    return whole
