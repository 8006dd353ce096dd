"""A balanced kd-tree over integer points for approximate nearest neighbours, equal on every machine.

Node k has the children 2k + 1 and 2k + 2. A node's points are cut in halves along the axis on which they spread
most, until few are left; so the shape of the tree follows from the number of points alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int32, Int64
from .jit import kernel

FAR = np.int64(1) << 62
LEAF = 12
DEEP = 64
NOWHERE: Int64 = np.zeros((0, 2), np.int64)


class Tree(NamedTuple):
    """Points in the order of the leaves, and the splits of the nodes."""

    points: Int32  # (N, D)
    order: Int64  # (N,): number of each point as it was given
    axis: Int64  # (nodes,)
    cut: Int64  # (nodes,): points after the split are not smaller, those before it not larger
    mean: Int64  # (n,): mean of the vectors that are projected on D axes, in 1 / 16384, to give points
    axes: Int64  # (D, n)


@kernel
def build(points: Any, order: Any, axis: Any, cut: Any) -> None:
    """Sort points (N, D) into leaves in place; `order` (N,) begins as 0 .. N-1. Equal ones keep their order."""
    dims, before, numbers = points.shape[1], np.empty_like(points), np.empty_like(order)
    least, most = np.empty(dims, np.int64), np.empty(dims, np.int64)
    keys = np.empty(len(points), np.int64)
    stack = np.empty((DEEP, 3), np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, 0, len(points)
    top = 1
    while top:
        top -= 1
        node, low, high = stack[top, 0], stack[top, 1], stack[top, 2]
        if high - low <= LEAF:
            continue
        for d in range(dims):
            least[d] = most[d] = points[low, d]
        for i in range(low + 1, high):
            for d in range(dims):
                least[d], most[d] = min(least[d], points[i, d]), max(most[d], points[i, d])
        widest = 0
        for d in range(1, dims):
            widest = d if most[d] - least[d] > most[widest] - least[widest] else widest
        for i in range(high - low):
            keys[i] = ((points[low + i, widest] - least[widest]) << 32) + i
            numbers[i] = order[low + i]
            for d in range(dims):
                before[i, d] = points[low + i, d]
        keys[: high - low].sort()
        for i in range(high - low):
            at = keys[i] & 0xFFFFFFFF
            order[low + i] = numbers[at]
            for d in range(dims):
                points[low + i, d] = before[at, d]
        middle = (low + high) // 2
        axis[node], cut[node] = widest, points[middle, widest]
        stack[top, 0], stack[top, 1], stack[top, 2] = 2 * node + 1, low, middle
        stack[top + 1, 0], stack[top + 1, 1], stack[top + 1, 2] = 2 * node + 2, middle, high
        top += 2


@kernel
def pixels_apart(ay: Any, ax: Any, by: Any, bx: Any, size: Any) -> Any:
    """Return the chessboard distance of two pixels; `size`: height, width, 1 if toroidal."""
    high, wide = abs(ay - by), abs(ax - bx)
    if size[2]:
        high, wide = min(high, size[0] - high), min(wide, size[1] - wide)
    return max(high, wide)


@kernel
def asking_room(dims: int) -> Any:
    """Return the scratch arrays of :func:`query_apart`."""
    return np.empty((DEEP, 4), np.int64), np.empty((DEEP, dims), np.int64), np.empty(dims, np.int64)


@kernel
def ask(tree: Any, point: Any, leaves: int, near: Any, number: Any, room: Any) -> int:
    """Find the nearest points in at most `leaves` leaves; return how many were found.

    `near` (k,) int64 squared distances, rising; `number` (k,) the points' numbers. Equal ones: the lower number.
    """
    return query_apart(tree, point, NOWHERE, (0, 0), (0, 0, 0, 0, leaves), near, number, room)


@kernel
def query_apart(
    tree: Any, point: Any, place: Any, own: Any, limits: Any, near: Any, number: Any, room: Any
) -> int:
    """Find the nearest points of a tree, as :func:`ask`, at a least distance from the pixel `own`; return how many.

    ``place`` (N, 2): pixel of each point, or empty: no least distance. ``limits``: height, width, 1 if toroidal,
    least distance in px, most leaves to visit. ``room``: stack of nodes (node, first point, one past the last, lower
    bound of the distance); their offsets from the point along each axis; and those of the current node.
    """
    points, order, axes, cuts = tree.points, tree.order, tree.axis, tree.cut
    dims, k, leaves, anywhere = points.shape[1], len(near), limits[4], len(place) == 0
    stack, gaps, here = room
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0, 0, len(points), 0
    for d in range(dims):
        gaps[0, d] = 0
    top, count, worst = 1, 0, FAR  # no bound until enough are found
    while top and leaves > 0:
        top -= 1
        node, low, high, least = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        if least > worst:
            continue
        for d in range(dims):
            here[d] = gaps[top, d]
        while high - low > LEAF:
            axis, middle = axes[node], (low + high) // 2
            gap = point[axis] - cuts[node]
            stack[top, 3] = least - here[axis] * here[axis] + gap * gap
            for d in range(dims):
                gaps[top, d] = here[d]
            gaps[top, axis] = gap
            if gap < 0:
                stack[top, 0], stack[top, 1], stack[top, 2] = 2 * node + 2, middle, high
                node, high = 2 * node + 1, middle
            else:
                stack[top, 0], stack[top, 1], stack[top, 2] = 2 * node + 1, low, middle
                node, low = 2 * node + 2, middle
            top += 1
        refused, taken = False, False  # a leaf of nothing but too near pixels does not count
        for i in range(low, high):
            total, d = np.int64(0), 0
            while d < dims and total <= worst:
                gap = np.int64(points[i, d]) - point[d]
                total += gap * gap
                d += 1
            if total < worst or (total == worst and (count < k or order[i] < number[k - 1])):
                if not anywhere:
                    at = order[i]
                    if pixels_apart(own[0], own[1], place[at, 0], place[at, 1], limits) < limits[3]:
                        refused = True
                        continue
                taken = True
                count = min(count + 1, k)
                _insert(near, number, count, total, order[i])
                worst = near[k - 1] if count == k else worst
        leaves -= 0 if refused and not taken else 1
    return count


@kernel
def _insert(near: Any, number: Any, count: int, distance: Any, index: Any) -> None:
    """Insert an entry in order among the first `count`, the last of which is dropped."""
    at = count - 1
    while at > 0 and (near[at - 1] > distance or (near[at - 1] == distance and number[at - 1] > index)):
        near[at], number[at] = near[at - 1], number[at - 1]
        at -= 1
    near[at], number[at] = distance, index
