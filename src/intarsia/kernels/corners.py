"""Shortest paths along the corners of a window's pixels, and the two sides that they part.

Corner (y, x) is the upper left one of pixel (y, x). It has the index (y + 1) * (width + 1) + x; a row of
corners above the window that no edge leads to spares every test for its ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .jit import kernel
from .maxflow import FREE, NEW

_WALL = -1  # an edge between corners that no path may take
_CUT = -2  # an edge that a path has taken
_FAR = 1 << 62
_IDLE = 0  # a corner waits for nothing,
_NEAR = 1  # for this round
_LATER = 2  # or for a later one


@kernel
def lay_edges(
    state: NDArray[np.uint8], right: NDArray[np.int32], down: NDArray[np.int32], edge: NDArray[np.int32]
) -> int:
    """Lay out the edges between corners, with walls inside what is forced; returns their total cost.

    The edge to its right comes first, then, half the array on, the one below it.
    """
    height, width = state.shape
    stride = width + 1
    half = edge.size // 2
    edge[:] = _WALL
    total = 0
    for y in range(height):
        if y > 0:
            base = (y + 1) * stride
            here, above, costs = state[y], state[y - 1], down[y - 1]
            line = edge[base : base + width]
            for x in range(np.uint64(width)):
                line[x] = costs[x] if here[x] != above[x] or here[x] == FREE else _WALL
        base = half + (y + 1) * stride + 1
        here, costs = state[y], right[y]
        line = edge[base : base + width - 1]
        after = here[1:]
        for x in range(np.uint64(width - 1)):
            line[x] = costs[x] if after[x] != here[x] or here[x] == FREE else _WALL
    for e in range(np.uint64(edge.size)):
        total += max(edge[e], 0)
    return total


@kernel
def typical(edge: NDArray[np.int32]) -> int:
    """Return about the geometric mean of the costs above zero, from every fifth edge.

    Few large costs would drive the plain mean far above what a seam ever crosses. Whole bit lengths suffice,
    and are the same on every machine.
    """
    bits, count = 0, 0
    for e in range(0, edge.size, 5):
        cost = edge[e]
        if cost > 0:
            count += 1
            while cost > 0:
                cost >>= 4
                bits += 4
    return 1 << (bits // count - 2) if count > 0 else 1


@kernel
def find_path(
    edge: NDArray[np.int32],
    corner: NDArray[np.int32],
    start: NDArray[np.int32],
    goal: NDArray[np.int32],
    stride: int,
    shift: int,
    step: int,
    far: NDArray[np.int64],
    came: NDArray[np.uint8],
) -> int:
    """Find a shortest path from one gap to another; returns the corner where it ends.

    Corners nearer than a limit are relaxed first in, first out until nothing changes; then the limit moves
    `step` beyond the nearest corner that waits. Any step gives the optimum, a good one saves a heap.
    """
    size = far.size
    half = edge.size // 2
    steps, edges = (1, -1, stride, -stride), (0, -1, half, half - stride)
    n = corner.size
    waits = np.zeros(size, np.uint8)
    near = np.empty(size + 1, np.int32)
    later = np.empty(size, np.int32)
    far[:] = _FAR
    unit = 1 if shift > 0 else 0
    head, tail, kept = 0, 0, 0
    for i in range(start[0], start[1]):
        v = corner[i if i < n else i - n]
        far[v] = 0
        came[v] = 4
        waits[v] = _NEAR
        near[tail] = v
        tail += 1
    limit = step
    while True:
        while head != tail:
            v = near[head]
            head = head + 1 if head < size else 0
            waits[v] = _IDLE
            here = far[v]
            for d in range(4):
                e, u = v + edges[d], v + steps[d]
                cost = edge[e]
                if cost < 0:
                    continue
                there = here + (np.int64(cost) << shift) + unit
                if there >= far[u]:
                    continue
                far[u] = there
                came[u] = d
                if there < limit:
                    if waits[u] != _NEAR:
                        waits[u] = _NEAR
                        near[tail] = u
                        tail = tail + 1 if tail < size else 0
                elif waits[u] == _IDLE:
                    waits[u] = _LATER
                    later[kept] = u
                    kept += 1
        end = corner[goal[0] if goal[0] < n else goal[0] - n]
        for i in range(goal[0] + 1, goal[1]):
            v = corner[i if i < n else i - n]
            if far[v] < far[end]:
                end = v
        if far[end] < limit or kept == 0:
            return int(end)
        limit = _FAR
        for i in range(kept):
            if waits[later[i]] == _LATER:
                limit = min(limit, int(far[later[i]]))
        limit += step
        waiting, kept = kept, 0
        for i in range(waiting):
            v = later[i]
            if waits[v] == _LATER:
                if far[v] < limit:
                    waits[v] = _NEAR
                    near[tail] = v
                    tail = tail + 1 if tail < size else 0
                else:
                    later[kept] = v
                    kept += 1


@kernel
def take_path(v: int, stride: int, came: NDArray[np.uint8], edge: NDArray[np.int32]) -> int:
    """Mark the edges of the path that ends in corner `v` as cut; returns what they cost."""
    half = edge.size // 2
    steps, edges = (1, -1, stride, -stride), (0, -1, half, half - stride)
    cost = 0
    while came[v] != 4:
        d = came[v]
        v -= steps[d]
        e = v + edges[d]
        cost += edge[e]
        edge[e] = _CUT
    return cost


@kernel
def paint(state: NDArray[np.uint8], edge: NDArray[np.int32], out: NDArray[np.uint8]) -> None:
    """Give the pixels alternating sides across the edges that are cut, such that the forced ones agree."""
    height, width = state.shape
    stride = width + 1
    half = edge.size // 2
    left = False
    wrong = False
    for y in range(height):
        base = (y + 1) * stride
        left ^= edge[base] == _CUT
        side = left
        for x in range(width):
            if x > 0:
                side ^= edge[half + base + x] == _CUT
            out[y, x] = side
            if state[y, x] != FREE:
                wrong = side != (state[y, x] == NEW)  # all forced pixels say the same
    if wrong:
        for y in range(height):
            for x in range(width):
                out[y, x] = out[y, x] == 0
