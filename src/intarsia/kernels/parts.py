"""Parts of a picture that hang together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .jit import kernel
from .union_find import find_root
from .windows import canvas_place


@kernel
def parts(values: NDArray[np.int32], wrap: tuple[bool, bool], out: NDArray[np.int32]) -> int:
    """Number the parts of a picture from 1, as they come in rows, into `out` (H, W); 0: no part. Returns how many.

    Pixels of the same value other than 0 that touch, corners included, are of one part; `wrap` says along which axes
    the picture goes on in itself.
    """
    height, width = values.shape
    parent = out.reshape(height * width)  # of each pixel one before it in its part, until all are numbered
    for at in range(height * width):
        parent[at] = at
    for y in range(height):
        for x in range(width):
            if values[y, x] == 0:
                continue
            for k in range(4):  # right, and the three below
                b = canvas_place(y + (1 if k else 0), height, wrap[0])
                a = canvas_place(x + (k - 2 if k else 1), width, wrap[1])
                if b < 0 or a < 0 or values[b, a] != values[y, x]:
                    continue
                one, other = find_root(parent, y * width + x), find_root(parent, b * width + a)
                parent[max(one, other)] = min(one, other)
    count = 0
    for y in range(height):
        for x in range(width):
            at = y * width + x
            if values[y, x] == 0:
                parent[at] = 0
            elif parent[at] == at:  # the first of its part in rows
                count += 1
                parent[at] = -count
            else:
                parent[at] = parent[parent[at]]  # that is numbered already
    for at in range(height * width):
        parent[at] = -parent[at]
    return count


@kernel
def boxes_of_parts(part: NDArray[np.int32], wrap: tuple[bool, bool], out: NDArray[np.int64]) -> None:
    """Say where the parts of :func:`parts` lie: `out` (n, 5) first row and column, rows and columns, and their pixels.

    A box may reach over a border that wraps; of a part longer than half of the picture it may be too small there.
    """
    size, count = part.shape, len(out)
    first = np.full((count, 2), -1, np.int64)
    out[:] = 0
    for y in range(size[0]):
        for x in range(size[1]):
            k = part[y, x] - 1
            if k < 0:
                continue
            if first[k, 0] < 0:
                first[k, 0], first[k, 1] = y, x
            for axis in range(2):
                away = (y if axis == 0 else x) - first[k, axis]
                if wrap[axis]:
                    away = (away + size[axis] // 2) % size[axis] - size[axis] // 2
                out[k, axis] = min(out[k, axis], away)
                out[k, 2 + axis] = max(out[k, 2 + axis], away)
            out[k, 4] += 1
    for k in range(count):
        for axis in range(2):
            out[k, 2 + axis] += 1 - out[k, axis]
            out[k, axis] = (out[k, axis] + first[k, axis]) % size[axis]
