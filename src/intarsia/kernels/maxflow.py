"""Exact minimum cuts on the 4-neighbour grid of a window, whatever the shape of what is forced.

The maximum flow is found by push and relabel in first-in, first-out order with breadth-first relabelling
from time to time (Goldberg and Tarjan, J. ACM 1988; Cherkassky and Goldberg, Algorithmica 1997). On window
grids this measured three to ten times faster than a plain version of Boykov and Kolmogorov's two search
trees, whose paths become long where much lies between the forced pixels. Only the first phase is run: flow
that cannot reach the end is left where it is stuck, for the cut is already known by then.

The graph is implicit: the arcs of pixel `v` are the four residual capacities `room[4 * v + d]`, d = right,
left, down, up, and `d ^ 1` is the arc back. A margin of one pixel without arcs spares every test for the
window's edge. Costs are non-negative and below 2**30, for a residual may become the sum of both directions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..foundation.arrays import Int32, Int64, UInt8
from .jit import kernel

OLD = 0
FREE = 1
NEW = 2
MOST = (1 << 63) - 1  # no flow is more


@kernel
def cut_cost(mask: UInt8, right: Int32, down: Int32) -> int:
    """Add up the costs between all neighbouring pixels that lie on different sides of `mask`."""
    height, width = mask.shape
    total = 0
    for y in range(height):
        for x in range(width):
            if x + 1 < width and mask[y, x] != mask[y, x + 1]:
                total += right[y, x]
            if y + 1 < height and mask[y, x] != mask[y + 1, x]:
                total += down[y, x]
    return total


@kernel
def _fill_room(
    state: UInt8,
    right: Int32,
    down: Int32,
    kind: UInt8,
    room: Int32,
) -> None:
    """Lay out each pixel's kind and the capacities of its four arcs, inside a margin without arcs."""
    height, width = state.shape
    stride = width + 2
    kind[:] = FREE
    room[:] = 0
    for y in range(height):
        for x in range(width):
            v = (y + 1) * stride + x + 1
            s = state[y, x]
            kind[v] = s
            # Arcs between forced pixels carry nothing: their cost is paid either never or always.
            if x + 1 < width and (s == FREE or state[y, x + 1] == FREE):
                room[4 * v] = right[y, x]
                room[4 * (v + 1) + 1] = right[y, x]
            if y + 1 < height and (s == FREE or state[y + 1, x] == FREE):
                room[4 * v + 2] = down[y, x]
                room[4 * (v + stride) + 3] = down[y, x]


@kernel
def _measure_heights(kind: Any, room: Any, sink: Any, step: Any, level: Any, reached: Any) -> None:
    """Count each pixel's arcs on the shortest way with room to an old one, or out of the grid; the size: no way."""
    size = kind.size
    head, tail = np.uint64(0), np.uint64(0)  # what is unsigned needs no test for the last but so many
    for k in range(size):
        v = np.uint64(k)
        level[v] = size if kind[v] != NEW else size + 1
        if kind[v] == OLD:
            level[v] = 0
            reached[tail] = v
            tail += np.uint64(1)
    for k in range(sink.size):
        v = np.uint64(k)
        if kind[v] == FREE and sink[v] > 0:
            level[v] = 1
            reached[tail] = v
            tail += np.uint64(1)
    while head < tail:
        v = np.uint64(reached[head])
        head += np.uint64(1)
        following = level[v] + 1
        for d in range(np.uint64(4)):
            u = v + step[d]
            if level[u] == size and room[np.uint64(4) * u + (d ^ np.uint64(1))] > 0:
                level[u] = following
                reached[tail] = u
                tail += np.uint64(1)


@kernel
def _drain(
    room: Any, sink: Any, step: Any, level: Any, excess: Any, queue: Any, ends: Any, most: Any
) -> tuple[Any, Any, Any]:
    """Push waiting flow downhill, raising pixels as needed, until none waits, heights are due anew or `most` came.

    A pixel waits in the queue, which lasts from the first to the second of `ends`, while it has more than came to it
    than left it. Returns both ends, and how much came to old pixels.
    """
    (head, tail), size, one, came = ends, level.size, np.uint64(1), np.int64(0)
    end, raised = np.uint64(size), 0
    while head != tail and 4 * raised <= size and came < most:  # of 1/20, 1/4 and 1 of the size this measured best
        v = np.uint64(queue[head])
        head = head + one if head < end else np.uint64(0)
        here, mine, begin = excess[v], level[v], np.uint64(4) * v
        if sink.size:
            moved = min(sink[v], here)
            sink[v] -= moved
            here -= moved
            came += moved
        while here > 0 and mine < size:
            lowest = size
            for d in range(np.uint64(4)):
                fits = room[begin + d]
                if fits > 0:
                    u = v + step[d]
                    other = level[u]
                    if other < mine:
                        moved = min(fits, here)
                        room[begin + d] = fits - moved
                        room[np.uint64(4) * u + (d ^ one)] += moved
                        here -= moved
                        if other == 0:
                            came += moved
                        else:
                            had = excess[u]
                            excess[u] = had + moved
                            if had == 0:
                                queue[tail] = u
                                tail = tail + one if tail < end else np.uint64(0)
                        if here == 0:
                            break
                    elif other + 1 < lowest:
                        lowest = other + 1
            if here > 0:
                mine = lowest
                raised += 1
        level[v] = mine
        excess[v] = here
    return head, tail, came


@kernel
def push_flow(
    kind: UInt8, room: Int32, excess: Int64, sink: Int64, stride: int, most: Any
) -> tuple[Any, Any]:
    """Send all that can flow from the new pixels, and what waits in `excess`, to the old ones; or until `most` came.

    Returns each pixel's distance to an old one along arcs with room left; the size, or more, where there is no way:
    it is known if less than `most` came. That comes next. `room` and `excess` are used up.
    """
    size, four, one = kind.size, np.uint64(4), np.uint64(1)
    level, reached = np.empty(size, np.int32), np.empty(size, np.int32)
    queue = np.empty(size + 1, np.int32)
    step = np.array([1, -1, stride, -stride]).astype(np.uint64)
    for k in range(size):
        v = np.uint64(k)
        if kind[v] == NEW:
            for d in range(four):
                u, moved = v + step[d], room[four * v + d]
                if moved > 0:
                    room[four * u + (d ^ one)] += moved
                    room[four * v + d] = 0
                    excess[u] += moved
    _measure_heights(kind, room, sink, step, level, reached)
    head, tail, total = np.uint64(0), np.uint64(0), np.int64(0)
    for k in range(size):
        v = np.uint64(k)
        if kind[v] == OLD:
            total += excess[v]
        elif kind[v] == FREE and excess[v] > 0:
            queue[tail] = v
            tail += one
    while head != tail and total < most:
        head, tail, came = _drain(room, sink, step, level, excess, queue, (head, tail), most - total)
        total += came
        _measure_heights(kind, room, sink, step, level, reached)
    return level, total


@kernel
def grid_min_cut(
    state: UInt8, right: Int32, down: Int32, out: UInt8
) -> int:
    """Split a window of any shape between old and new at the least cost; returns that cost.

    `state` says 0 where a pixel must stay old, 2 where it must become new and 1 where it is free. `out`
    becomes 1 where the new one is taken. Of several least cuts this is the one with the fewest old pixels:
    those which an arc with room left still connects to an old one (that set is unique). Where nothing is
    forced old all becomes new, and where nothing is forced new all stays old.
    """
    height, width = state.shape
    any_old = np.any(state == OLD)
    if not any_old or not np.any(state == NEW):
        out[:] = 0 if any_old else 1
        return 0
    stride = width + 2
    size = (height + 2) * stride
    kind = np.empty(size, np.uint8)
    room = np.empty(4 * size, np.int32)
    excess = np.zeros(size, np.int64)
    _fill_room(state, right, down, kind, room)
    level, _ = push_flow(kind, room, excess, np.zeros(0, np.int64), stride, MOST)
    for y in range(height):
        for x in range(width):
            out[y, x] = 0 if level[(y + 1) * stride + x + 1] < size else 1
    return cut_cost(out, right, down)
