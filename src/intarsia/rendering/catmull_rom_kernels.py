"""Read an exemplar between its pixels: which pixels a place is read from, and with what weights.

A *reading* of the exemplar at a place u is a short list of pixels and weights: 4 x 4 by Catmull-Rom (Catmull and Rom
1974; Keys 1981, a = -1/2), 2 x 2 where one of these must not be read, without those that must not. Where a step of
one px in the output leads further than one px in the exemplar, several readings spread over the pixel's footprint are
averaged.
"""

from __future__ import annotations

from math import ceil, floor, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel

Array = NDArray[Any]

MOST = 4
"""Readings along each axis of a footprint, at most."""

SLACK = 1 / 64
"""Steps that are longer than one px by no more are taken for one px, such as those of a turn."""


class Reach(NamedTuple):
    """Which pixels may be read."""

    table: NDArray[np.int64]  # (n, 4): number of the first pixel, height, width, 1 if toroidal
    free: NDArray[np.bool_]  # (N,): those that may be; empty where all may
    near: NDArray[np.uint16]  # (N,): distance to what must not be read, capped; empty without a feather


@kernel
def exemplar_of(table: NDArray[np.int64], which: int) -> tuple[int, int, int, int]:
    """Return the number of an exemplar's first pixel, its height, its width, and 1 if it is toroidal.

    Plain numbers: a view of the table would count references wherever it is made.
    """
    return table[which, 0], table[which, 1], table[which, 2], table[which, 3]


@kernel
def _pixel(row: tuple[int, int, int, int], y: int, x: int) -> int:
    """Return the number of a pixel; beyond the border there is the nearest one, or the other side of a torus."""
    height, width = row[1], row[2]
    if not (0 <= y < height and 0 <= x < width):
        if row[3] != 0:
            y, x = y % height, x % width
        else:
            y, x = min(max(y, 0), height - 1), min(max(x, 0), width - 1)
    number: int = row[0] + y * width + x
    return number


@kernel
def nearest_pixel(row: tuple[int, int, int, int], free: NDArray[np.bool_], uy: float, ux: float, own: int) -> int:
    """Return the pixel nearest to a place, or `own` where that one must not be read."""
    k = _pixel(row, floor(uy + 0.5), floor(ux + 0.5))
    return own if free.size > 0 and not free[k] else k


@kernel
def share_of(row: tuple[int, int, int, int], near: NDArray[np.uint16], uy: float, ux: float) -> int:
    """Return how much the pixel nearest to a place counts in a vote: nothing outside of the exemplar."""
    y, x = floor(uy + 0.5), floor(ux + 0.5)
    if row[3] == 0 and not (0 <= y < row[1] and 0 <= x < row[2]):
        return 0
    return int(near[_pixel(row, y, x)])


@kernel
def _cubic(f: float, w: Array, begin: int) -> None:
    w[2, begin] = ((1.0 - 0.5 * f) * f - 0.5) * f
    w[2, begin + 1] = (1.5 * f - 2.5) * f * f + 1.0
    w[2, begin + 2] = ((2.0 - 1.5 * f) * f + 0.5) * f
    w[2, begin + 3] = (0.5 * f - 0.5) * f * f


@kernel
def taps(
    row: tuple[int, int, int, int], free: NDArray[np.bool_], uy: float, ux: float, at: NDArray[np.int64], w: Array
) -> int:
    """List the pixels of a reading, at most 16, and their weights in w[0]; in w[1] those of the 2 x 2 around it alone.

    Returns how many; 0 where none of the four around may be read. `free` as in :class:`Reach`; w[2] is room to work.
    """
    y, x = floor(uy), floor(ux)
    fy, fx = uy - y, ux - x
    _cubic(fy, w, 0)
    _cubic(fx, w, 4)
    n, smooth, total = 0, True, 0.0
    for i in range(4):
        for k in range(4):
            weight = w[2, i] * w[2, 4 + k]
            if w[2, i] == 0.0 or w[2, 4 + k] == 0.0:
                continue
            at[n] = _pixel(row, y + i - 1, x + k - 1)
            if free.size > 0 and not free[at[n]]:
                smooth = False
                continue
            w[0, n], w[1, n] = weight, 0.0
            if 1 <= i <= 2 and 1 <= k <= 2:
                w[1, n] = (fy if i == 2 else 1.0 - fy) * (fx if k == 2 else 1.0 - fx)
                total += w[1, n]
            n += 1
    if smooth:
        return n
    kept = 0
    for k in range(n):
        if w[1, k] > 0.0:
            at[kept] = at[k]
            w[0, kept] = w[1, kept] = w[1, k] / total
            kept += 1
    return kept


@kernel
def footprint(down: float, across: float) -> tuple[int, float]:
    """Return how many readings a pixel needs along an axis, and over how much of its step (down, across) they spread.

    One where a step of the output is no longer than a pixel of the exemplar; from there on they spread, over all of the
    step where it is two, so that sharpness never jumps.
    """
    length = sqrt(down * down + across * across)
    if length <= 1.0 + SLACK:
        return 1, 0.0
    return min(ceil(length - SLACK), MOST), min(1.0, 2.0 - 2.0 / length)
