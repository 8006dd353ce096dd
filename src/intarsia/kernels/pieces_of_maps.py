"""Connected pieces of a map, frames and fractions included: where one neighbour continues the other in the exemplar."""

from __future__ import annotations

import numpy as np

from ..arrays import Floats, Int32, Int64, UInt8
from ..geometry import ISOMETRIES
from .cuts import find_root, join
from .jit import kernel

HOLE = 255
J = np.array([isometry.j for isometry in ISOMETRIES], dtype=np.int64).reshape(8, 4)
"""The matrices of the eight isometries, (a, b, c, d) each: rows move by a y + b x, columns by c y + d x."""

# Columns of the tables of pieces and groups; TOP .. RIGHT is the box of the pixels themselves, half open.
WHICH, POSE, OY, OX, TOP, LEFT, BOTTOM, RIGHT = range(8)
NEAR = 1.0
"""Px by which a neighbour may miss where the exemplar goes on, along each axis; rounding alone misses by as much."""


@kernel
def goes_on(
    at: Floats,
    j: Floats,
    which: UInt8,
    pose: UInt8,
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
    at: Floats, j: Floats, which: UInt8, pose: UInt8
) -> Int32:
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
                join(parent, own, before)
    number = np.empty(height * width, np.int32)
    pieces = 0
    for own in range(height * width):
        if parent[own] == own:
            number[own] = pieces
            pieces += 1
        labels[own // width, own % width] = number[find_root(parent, own)]
    return labels


@kernel
def _first_pass(
    yx: Int32,
    which: UInt8,
    pose: UInt8,
    labels: Int32,
    parent: Int32,
) -> int:
    """Join every pixel to its left and upper neighbour where the exemplar continues."""
    height, width = which.shape
    count = 0
    for y in range(height):
        for x in range(width):
            w, p = which[y, x], pose[y, x]
            label = -1
            if x > 0 and which[y, x - 1] == w:
                same = pose[y, x - 1] == p
                same &= yx[y, x, 0] - yx[y, x - 1, 0] == J[p, 1] and yx[y, x, 1] - yx[y, x - 1, 1] == J[p, 3]
                if same or w == HOLE:
                    label = find_root(parent, labels[y, x - 1])
            if y > 0 and which[y - 1, x] == w:
                same = pose[y - 1, x] == p
                same &= yx[y, x, 0] - yx[y - 1, x, 0] == J[p, 0] and yx[y, x, 1] - yx[y - 1, x, 1] == J[p, 2]
                if same or w == HOLE:
                    other = find_root(parent, labels[y - 1, x])
                    if label < 0:
                        label = other
                    elif label != other:  # the smaller number stays the root, so roots come first in the raster
                        parent[max(label, other)] = min(label, other)
                        label = min(label, other)
            if label < 0:
                label = count
                parent[count] = count
                count += 1
            labels[y, x] = label
    return count


@kernel
def label_pieces(
    yx: Int32, which: UInt8, pose: UInt8
) -> tuple[Int32, Int64]:
    """Number the connected pieces of a map in the order of their first pixels.

    Four-neighbours belong together when exemplar and pose are equal and the exemplar continues from one to
    the other; holes are a class of their own. Returns the numbers (H, W) and a table (n, 8): exemplar, pose,
    offset ``S(q) - J q`` (row, column), box (top, left, bottom, right).
    """
    height, width = which.shape
    labels = np.empty((height, width), np.int32)
    parent = np.empty(height * width, np.int32)
    count = _first_pass(yx, which, pose, labels, parent)
    number = np.empty(count, np.int32)
    pieces = 0
    for k in range(count):
        if parent[k] == k:
            number[k] = pieces
            pieces += 1
        else:
            number[k] = number[find_root(parent, k)]
    table = np.empty((pieces, 8), np.int64)
    table[:, TOP] = -1
    for y in range(height):
        for x in range(width):
            n = number[labels[y, x]]
            labels[y, x] = n
            row = table[n]
            if row[TOP] < 0:
                p = pose[y, x]
                row[WHICH], row[POSE] = which[y, x], p
                row[OY] = yx[y, x, 0] - J[p, 0] * y - J[p, 1] * x
                row[OX] = yx[y, x, 1] - J[p, 2] * y - J[p, 3] * x
                row[TOP], row[LEFT], row[RIGHT] = y, x, x + 1
            row[BOTTOM] = y + 1
            row[LEFT] = min(row[LEFT], x)
            row[RIGHT] = max(row[RIGHT], x + 1)
    return labels, table
