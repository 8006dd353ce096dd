"""Pieces of a map whose pieces are scaled, turned or bent: where one goes on to within a pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .jit import kernel
from .unions import find_root

HOLE = 255
NEAR = 1.0
"""Px by which a neighbour may miss where the exemplar goes on, along each axis; rounding alone misses by as much."""


@kernel
def goes_on(
    at: NDArray[np.float64],
    j: NDArray[np.float64],
    which: NDArray[np.uint8],
    pose: NDArray[np.uint8],
    y: int,
    x: int,
    axis: int,
) -> bool:
    """Say whether a pixel goes on in the next along an axis: it lies where the mean of both frames leads."""
    v, u = (y + 1, x) if axis == 0 else (y, x + 1)
    if which[y, x] != which[v, u]:
        return False
    if which[y, x] == HOLE:
        return True
    if pose[y, x] != pose[v, u]:
        return False
    for k in range(2):
        step = (j[y, x, k, axis] + j[v, u, k, axis]) / 2
        if abs(at[v, u, k] - at[y, x, k] - step) > NEAR:
            return False
    return True


@kernel
def label_flowing(
    at: NDArray[np.float64], j: NDArray[np.float64], which: NDArray[np.uint8], pose: NDArray[np.uint8]
) -> NDArray[np.int32]:
    """Number the connected pieces (H, W) in the order of their first pixels; holes are a class of their own.

    `at` (H, W, 2) is where pixels lie in the exemplar, `j` (H, W, 2, 2) how the exemplar goes on around them.
    """
    height, width = which.shape
    labels = np.empty((height, width), np.int32)
    parent = np.arange(height * width).astype(np.int32)
    for y in range(height):
        for x in range(width):
            own = y * width + x
            labels[y, x] = own
            for axis in range(2):
                before = own - width if axis == 0 else own - 1
                v, u = (y - 1, x) if axis == 0 else (y, x - 1)
                if v < 0 or u < 0 or not goes_on(at, j, which, pose, v, u, axis):
                    continue
                a, b = find_root(parent, own), find_root(parent, before)
                if a != b:  # the smaller number stays the root, so roots come first in the raster
                    parent[max(a, b)] = min(a, b)
    number = np.empty(height * width, np.int32)
    pieces = 0
    for own in range(height * width):
        if parent[own] == own:
            number[own] = pieces
            pieces += 1
        labels[own // width, own % width] = number[find_root(parent, own)]
    return labels
