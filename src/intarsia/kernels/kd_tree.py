"""A balanced kd-tree over points of whole numbers: built once, asked for the nearest few, the same everywhere.

Node k has the children 2k + 1 and 2k + 2. A node's points are cut in halves along the axis on which they spread
most, until few are left; so the shape of the tree follows from the number of points alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .jit import kernel
from .neighbourhoods import CLOSED, SIZE, START, STRIDE

LEAF = 12
DEEP = 64
NOWHERE: NDArray[np.int64] = np.zeros((0, 2), np.int64)


class Tree(NamedTuple):
    """Points in the order of the leaves, and where they are cut."""

    points: NDArray[np.int32]  # (N, D)
    order: NDArray[np.int64]  # (N,): number of each point as it was given
    axis: NDArray[np.int64]  # (nodes,)
    cut: NDArray[np.int64]  # (nodes,): points beyond the cut are not smaller, those before it not larger
    mean: NDArray[np.int64]  # (n,): how long vectors become points: less the mean, along D axes in 1 / 16384
    axes: NDArray[np.int64]  # (D, n)


@kernel
def project_vector(values: Any, mean: Any, axes: Any, out: Any) -> None:
    """Turn a long vector (n,) into a point (D,): the rounded sums of (value - mean) * axis / 16384."""
    for d in range(len(axes)):
        total = np.int64(8192)
        for m in range(len(mean)):
            total += (values[m] - mean[m]) * axes[d, m]
        out[d] = total >> 14


@kernel
def build(points: Any, order: Any, axis: Any, cut: Any) -> None:
    """Sort points (N, D) into leaves in place; `order` (N,) begins as 0 .. N-1."""
    stack = np.empty((DEEP, 3), np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, len(points)
    top = 1
    while top:
        top -= 1
        node, low, high = stack[top, 0], stack[top, 1], stack[top, 2]
        if high - low <= LEAF:
            continue
        widest, span = 0, np.int64(-1)
        for d in range(points.shape[1]):
            column = points[low:high, d]
            spread = np.int64(column.max()) - column.min()
            if spread > span:
                widest, span = d, spread
        sorting = np.argsort(points[low:high, widest], kind="mergesort")
        points[low:high] = points[low:high][sorting]
        order[low:high] = order[low:high][sorting]
        middle = (low + high) // 2
        axis[node], cut[node] = widest, points[middle, widest]
        stack[top, 0], stack[top, 1], stack[top, 2] = 2 * node + 1, low, middle
        stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2] = 2 * node + 2, middle, high
        top += 2


@kernel
def pixels_apart(ay: Any, ax: Any, by: Any, bx: Any, size: Any) -> Any:
    """Return how far two pixels lie apart, along rows or columns; `size`: height, width, 1 if toroidal."""
    high, wide = abs(ay - by), abs(ax - bx)
    if size[2]:
        high, wide = min(high, size[0] - high), min(wide, size[1] - wide)
    return max(high, wide)


@kernel
def ask(tree: Any, point: Any, leaves: int, near: Any, number: Any) -> int:
    """Find the nearest points, looking into at most so many leaves; return how many of them were found.

    `near` (k,) int64 squared distances, rising; `number` (k,) the points' numbers. Equal ones: the lower number.
    """
    return ask_apart(tree, point, NOWHERE, (0, 0), (0, 0, 0, 0, leaves), near, number)


@kernel
def ask_apart(tree: Any, point: Any, place: Any, own: Any, limits: Any, near: Any, number: Any) -> int:
    """Find the nearest points of a tree, as :func:`ask`, that lie far enough from the pixel `own`; return how many.

    ``place`` (N, 2): pixel of each point, or none: then all are far enough. ``limits``: height, width, 1 if toroidal,
    px apart at least, leaves looked into at most.
    """
    dims, k, leaves, anywhere = tree.points.shape[1], len(near), limits[4], len(place) == 0
    stack = np.empty((DEEP, 4), np.int64)  # node, first point, one past the last, distance at least
    gaps = np.zeros((DEEP, dims), np.int64)  # how far the node lies from the point along each axis
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0, 0, len(tree.points), 0
    top, count = 1, 0
    here = np.empty(dims, np.int64)
    while top and leaves > 0:
        top -= 1
        node, low, high, least = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        if count == k and least > near[k - 1]:
            continue
        here[:] = gaps[top]
        while high - low > LEAF:
            axis, middle = tree.axis[node], (low + high) // 2
            gap = point[axis] - tree.cut[node]
            stack[top, 3] = least - here[axis] * here[axis] + gap * gap
            gaps[top] = here
            gaps[top, axis] = gap
            if gap < 0:
                stack[top, 0], stack[top, 1], stack[top, 2] = 2 * node + 2, middle, high
                node, high = 2 * node + 1, middle
            else:
                stack[top, 0], stack[top, 1], stack[top, 2] = 2 * node + 1, low, middle
                node, low = 2 * node + 2, middle
            top += 1
        refused, taken = False, False  # a leaf of nothing but neighbours does not count
        for i in range(low, high):
            total = np.int64(0)
            for d in range(dims):
                gap = np.int64(tree.points[i, d]) - point[d]
                total += gap * gap
            if count < k or total < near[k - 1] or (total == near[k - 1] and tree.order[i] < number[k - 1]):
                if not anywhere:
                    at = place[tree.order[i]]
                    if pixels_apart(own[0], own[1], at[0], at[1], limits) < limits[3]:
                        refused = True
                        continue
                taken = True
                count = min(count + 1, k)
                _insert(near, number, count, total, tree.order[i])
        leaves -= 0 if refused and not taken else 1
    return count


@kernel
def _insert(near: Any, number: Any, count: int, distance: Any, index: Any) -> None:
    """Put an entry into its place among the first `count`, the last of which is lost."""
    at = count - 1
    while at > 0 and (near[at - 1] > distance or (near[at - 1] == distance and number[at - 1] > index)):
        near[at], number[at] = near[at - 1], number[at - 1]
        at -= 1
    near[at], number[at] = distance, index


@kernel
def gather_neighbourhoods(ground: Any, places: Any, components: Any, out: Any) -> None:
    """Read the neighbourhoods at (variant, position) `places` (N, 2) into `out` (N, n).

    `components` (n, 3) are plane, row and column of each value.
    """
    for i in range(len(places)):
        row = ground.table[places[i, 0]]
        for m in range(len(components)):
            step = components[m, 0] * row[SIZE] + components[m, 1] * row[STRIDE] + components[m, 2]
            out[i, m] = ground.values[row[START] + places[i, 1] + step]


@kernel
def project_all(ground: Any, places: Any, components: Any, mean: Any, axes: Any, out: Any) -> None:
    """Turn the neighbourhoods at all places into points (N, D)."""
    values = np.empty((1, len(components)), np.int32)
    for i in range(len(places)):
        gather_neighbourhoods(ground, places[i : i + 1], components, values)
        project_vector(values[0], mean, axes, out[i])


@kernel
def similar(ground: Any, places: Any, components: Any, tree: Any, leaves: int, near: Any, apart: int, out: Any) -> None:
    """Write the most similar places of each place into `out` (positions, k, 2), -1 where there are no more.

    They lie further than `apart` px from it, in rows or columns. `near` (2, m) is room for m found ones.
    """
    values = np.empty((1, len(components)), np.int32)
    point = np.empty(tree.points.shape[1], np.int64)
    for i in range(len(places)):
        gather_neighbourhoods(ground, places[i : i + 1], components, values)
        project_vector(values[0], tree.mean, tree.axes, point)
        v, at = places[i, 0], places[i, 1]
        row = ground.table[v]
        count = 0
        for k in range(ask(tree, point, leaves, near[0], near[1])):
            w, to = places[near[1, k], 0], places[near[1, k], 1]
            if count == out.shape[1]:
                break
            high, wide = abs(at // row[STRIDE] - to // row[STRIDE]), abs(at % row[STRIDE] - to % row[STRIDE])
            if w != v or max(high, wide) > apart:
                out[row[CLOSED] + at, count, 0], out[row[CLOSED] + at, count, 1] = w, to
                count += 1
