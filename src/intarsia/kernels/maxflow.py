"""Exact minimum cuts on the 4-neighbour grid of a window, for forced regions of any shape, by push and relabel.

The maximum flow is found by push and relabel in first-in, first-out order, the farthest first, with breadth-first
(global) relabelling (Goldberg and Tarjan, J. ACM 1988; Cherkassky and Goldberg, Algorithmica 1997). On window
grids this measured three to ten times faster than a plain version of Boykov and Kolmogorov's two search
trees, whose paths become long if the forced pixels are far from one another. Only the first phase is run: flow
that cannot reach the sink is left where it is, as the cut is already known.

The graph is implicit: the arcs of pixel `v` are the four residual capacities `room[4 * v + d]`, d = right,
left, down, up, and `d ^ 1` is the reverse arc. A margin of one pixel without arcs makes tests for the
window's edge unnecessary. Costs are non-negative and below 2**30, for a residual may become the sum of both directions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..foundation.arrays import Int32, Int64, UInt8
from .jit import kernel

OLD, FREE, NEW = 0, 1, 2  # a pixel must stay, is free, must become new,
ABSENT = 3  # or is no part of the window
MOST = (1 << 63) - 1  # no flow is more


@kernel
def _measure_heights(kind: Any, room: Any, sink: Any, step: Any, level: Any, reached: Any) -> Any:
    """Write each pixel's residual distance to an old one, or to the sink, in arcs; the size: unreachable.

    List the reachable ones, the nearest first; return how many.
    """
    size = kind.size
    head, tail = np.uint64(0), np.uint64(0)  # unsigned: no tests for negative indices
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
    return tail


@kernel
def _drain(
    room: Any, sink: Any, step: Any, level: Any, excess: Any, queue: Any, waiting: Any, most: Any
) -> Any:
    """Push excess to lower pixels and relabel, until none is left, global relabelling is due, or `most` arrived.

    The first `waiting` of the queue have excess. Return how much arrived at old pixels.
    """
    head, tail, size, one, came = np.uint64(0), waiting, level.size, np.uint64(1), np.int64(0)
    end, raised = np.uint64(size), 0
    while head != tail and 4 * raised <= size and came < most:  # of 1/20, 1/8, 1/4, 1/2 and 1 of the size the best
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
    return came


@kernel
def push_flow(
    kind: UInt8, room: Int32, excess: Int64, sink: Int64, stride: int, most: Any
) -> tuple[Any, Any]:
    """Send the maximum flow from the new pixels, and from `excess`, to the old ones; or stop when `most` arrived.

    Return each pixel's residual distance to an old one, the size or more if unreachable (defined if less than `most`
    arrived), and the flow. `room` and `excess` are overwritten.
    """
    size, four, one = kind.size, np.uint64(4), np.uint64(1)
    level, reached = np.empty(size, np.int32), np.empty(size, np.int32)
    queue = np.empty(size + 1, np.int32)
    step = np.array([1, -1, stride, -stride]).astype(np.uint64)
    total = np.int64(0)
    for k in range(size):
        v = np.uint64(k)
        if kind[v] == NEW:
            for d in range(four):
                u, moved = v + step[d], room[four * v + d]
                if moved > 0:
                    room[four * u + (d ^ one)] += moved
                    room[four * v + d] = 0
                    excess[u] += moved
    for k in range(size):
        if kind[k] == OLD:
            total += excess[k]
    while total < most:
        known, waiting = _measure_heights(kind, room, sink, step, level, reached), np.uint64(0)
        for k in range(known):  # the farthest first: the flow into a pixel is pushed on together
            v = np.uint64(reached[known - one - np.uint64(k)])
            if kind[v] == FREE and excess[v] > 0:
                queue[waiting] = v
                waiting += one
        if waiting == 0:
            break
        total += _drain(room, sink, step, level, excess, queue, waiting, most - total)
    return level, total


@kernel
def least_cut(state: Any, terms: Any, more: Any, out: Any, most: Any) -> Any:
    """Minimise a submodular energy of old and new pixels by a minimum cut (an expansion move).

    `state`: OLD, FREE, NEW or ABSENT. `terms` (3, 2, h, w): pairwise terms of each pixel and its right, and its lower
    neighbour: if both stay, if the second becomes new, if the first does.
    `more` (h, w): unary term of each pixel if it becomes new, or, below 0, if it stays; or of no size.
    Of several minima `out` (1 = new) is the one with the fewest old pixels. If nothing must stay, all
    becomes new. Return whether `out` is a minimum: not if all choices cost `most` or more.
    """
    h, w = state.shape
    kept = 0
    for i in range(h):
        for j in range(w):
            kept += state[i, j] == OLD
            out[i, j] = state[i, j] != ABSENT
    if kept == 0:
        return True
    stride = w + 2
    size = (h + 2) * stride
    kind = np.full(size, FREE, np.uint8)
    room = np.zeros(4 * size, np.int32)
    excess, sink = np.zeros(size, np.int64), np.zeros(size if more.size else 0, np.int64)
    for i in range(h):
        begin = np.uint64((i + 1) * stride + 1)
        for j in range(np.uint64(w)):
            p = begin + j
            if state[i, j] != ABSENT:
                kind[p] = state[i, j]
            if more.size and state[i, j] == FREE:
                if more[i, j] > 0:
                    sink[p] = more[i, j]
                else:
                    excess[p] -= more[i, j]
        for k in range(2):
            a, b, c, on, d = terms[0, k, i], terms[1, k, i], terms[2, k, i], 1 if k == 0 else stride, np.uint64(2 * k)
            for j in range(np.uint64(w)):
                p = begin + j
                q = p + np.uint64(on)
                if a[j] == 0:
                    if c[j]:
                        room[np.uint64(4) * p + d] = c[j]
                    if b[j]:
                        room[np.uint64(4) * q + d + np.uint64(1)] = b[j]
                    continue
                mine = min(a[j], b[j])
                rest = min(a[j] - mine, c[j])
                excess[p] += mine
                excess[q] += rest
                room[np.uint64(4) * p + d] = c[j] - rest
                room[np.uint64(4) * q + d + np.uint64(1)] = b[j] - mine
    level, came = push_flow(kind, room, excess, sink, stride, most)
    for i in range(h):
        for j in range(w):
            out[i, j] = 1 if level[(i + 1) * stride + j + 1] >= size and state[i, j] != ABSENT else 0
    return came < most


@kernel
def grid_min_cut(state: UInt8, right: Int32, down: Int32, out: UInt8) -> None:
    """Split a window of any shape between old and new by a minimum cut.

    `state`: 0 where a pixel must stay old, 2 where it must become new, 1 where it is free. `out`
    becomes 1 where the new one is taken. Of several minimum cuts this is the one with the fewest old pixels:
    those with a residual path to an old one (that set is unique). If nothing is
    forced old all becomes new, and if nothing is forced new all stays old.
    """
    height, width = state.shape
    any_old = np.any(state == OLD)
    if not any_old or not np.any(state == NEW):
        out[:] = 0 if any_old else 1
        return
    terms = np.zeros((3, 2, height, width), np.int32)
    for k in range(1, 3):
        terms[k, 0, :, :-1], terms[k, 1, :-1] = right, down
    least_cut(state, terms, np.zeros((0, 0), np.int64), out, MOST)
