"""Costs of the borders of tiles, and the tile laid out: whole numbers, one row after the other."""

from __future__ import annotations

import numpy as np

from ..foundation.arrays import Int32, Int64
from ..kernels.jit import kernel


@kernel
def band_costs(difference: Int64, dy: int, dx: int, band: int, costs: Int64) -> None:
    """Add to every anchor's cost the differences in a band around its side (dy, dx), |dy| >= |dx|, dy not 0.

    In every row of the side the band is `band` px wide, centred on the side. -1 where a difference is missing.
    Running sums along the rows: a row of the band is one subtraction.
    """
    height, width = difference.shape
    total = np.zeros((height, width + 1), np.int64)
    missing = np.zeros((height, width + 1), np.int64)
    for y in range(height):
        for x in range(width):
            d = difference[y, x]
            total[y, x + 1] = total[y, x] + max(d, 0)
            missing[y, x + 1] = missing[y, x] + (d < 0)
    sign = 1 if dy > 0 else -1
    rows = abs(dy)
    shift = np.empty(rows, np.int64)
    for i in range(rows):
        shift[i] = (2 * i * dx + rows) // (2 * rows) - band // 2
    for y in range(height):
        last = y + sign * (rows - 1)
        for x in range(width):
            if costs[y, x] < 0:
                continue
            if last < 0 or last >= height:
                costs[y, x] = -1
                continue
            for i in range(rows):
                left = x + shift[i]
                row = y + sign * i
                if left < 0 or left + band > width or missing[row, left + band] > missing[row, left]:
                    costs[y, x] = -1
                    break
                costs[y, x] += total[row, left + band] - total[row, left]


@kernel
def lay_tile(
    out: Int32, begin: Int64, rates: Int64, whole: int, vectors: Int64,
    anchor: Int64,
) -> None:  # fmt: skip
    """Fill in, for every px, the px of the tile at `anchor` that repeats there (Lopez Recas 2011, eq. 3.29).

    How far a px lies along both vectors (1/256 px), in whole periods, grows by rates[0] / whole with every row and by
    rates[1] / whole with every column; `begin` is that of the first px; all lie in 0 to whole - 1. Only whole numbers:
    floats would miss at the lattice points themselves.
    """
    first, second = begin[0], begin[1]
    half = 128 * whole
    for y in range(out.shape[0]):
        a, b = first, second
        for x in range(out.shape[1]):
            out[y, x, 0] = anchor[0] + (a * vectors[0, 0] + b * vectors[1, 0] + half) // (256 * whole)
            out[y, x, 1] = anchor[1] + (a * vectors[0, 1] + b * vectors[1, 1] + half) // (256 * whole)
            a += rates[1, 0]
            b += rates[1, 1]
            a -= whole if a >= whole else 0
            b -= whole if b >= whole else 0
        first += rates[0, 0]
        second += rates[0, 1]
        first -= whole if first >= whole else 0
        second -= whole if second >= whole else 0
