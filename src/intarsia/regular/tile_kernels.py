"""Kernel of best tiles: the tile repeated over a window, in whole numbers."""

from __future__ import annotations

from ..foundation.arrays import Int32, Int64
from ..kernels.jit import kernel


@kernel
def lay_tile(
    out: Int32, begin: Int64, rates: Int64, whole: int, vectors: Int64,
    anchor: Int64,
) -> None:  # fmt: skip
    """Write for every px of `out` (H, W, 2) the exemplar px of the tile at `anchor` (Lopez Recas 2011, eq. 3.29).

    The position along both vectors (1/256 px), in units of 1 / whole periods, grows by rates[0] with every row and by
    rates[1] with every column; `begin` is that of the first px; all lie in 0 to whole - 1. All is in whole numbers:
    rounded floats would give a wrong px at lattice points.
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
