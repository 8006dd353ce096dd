"""The points of a lattice that lie in a box."""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel

UNIT = 256  # parts of a px


@kernel
def lattice_points(first: Any, v1: Any, v2: Any, low: Any, high: Any) -> Any:
    """List the points first + a v1 + b v2 that lie, rounded to px, in a box: (n, 2) in 1/256 px.

    `first`, `v1`, `v2`: (y, x) in 1/256 px; `low`, `high`: first and last px of the box, (y, x).
    """
    y0, y1 = low[0] * UNIT - UNIT // 2, high[0] * UNIT + UNIT // 2 - 1
    x0, x1 = low[1] * UNIT - UNIT // 2, high[1] * UNIT + UNIT // 2 - 1
    determinant = v1[0] * v2[1] - v1[1] * v2[0]
    least, most = np.int64(1) << 60, -(np.int64(1) << 60)
    for y in (y0, y1):
        for x in (x0, x1):
            a = ((y - first[0]) * v2[1] - (x - first[1]) * v2[0]) // determinant
            least, most = min(least, a), max(most, a + 1)
    expected = max(0, y1 - y0) * max(0, x1 - x0) // abs(determinant)
    found = np.empty((64 + expected + expected // 8, 2), np.int64)
    count = 0
    for a in range(least, most + 1):
        if y1 < y0 or x1 < x0:
            break
        py, px = first[0] + a * v1[0], first[1] + a * v1[1]
        begin, end = -(np.int64(1) << 60), np.int64(1) << 60
        for p, v, s, t in ((py, v2[0], y0, y1), (px, v2[1], x0, x1)):
            if v > 0:
                begin, end = max(begin, -((p - s) // v)), min(end, (t - p) // v)
            elif v < 0:
                begin, end = max(begin, -((t - p) // -v)), min(end, (p - s) // -v)
            elif p < s or p > t:
                end = begin - 1
        for b in range(begin, end + 1):
            if count == len(found):
                larger = np.empty((2 * count, 2), np.int64)
                larger[:count] = found
                found = larger
            found[count, 0], found[count, 1] = py + b * v2[0], px + b * v2[1]
            count += 1
    return found[:count]
