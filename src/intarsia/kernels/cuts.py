"""Seam costs, and the minimum cut between an old and a new patch by shortest paths in the dual grid.

Most overlaps of quilting (strips, an L, a U, two opposite strips) are solved as shortest paths along the
corners of the pixels, which is exact and much faster than a flow: the gaps are the places on the window's border
where the forced pixels change from old to new or back. In the plane a minimum cut is a shortest path
between the two gaps if there are two of them and every forced piece touches the border. If there are
more, and the new (or the old) pixels are one piece, that piece separates the stretches of the others: each
stretch is then cut off by a path of its own between the gaps at its ends, independently of the others.
Every other shape (a ring, islands) is left to the maximum flow.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int16, Int32, Int64, UInt8
from .jit import kernel
from .maxflow import FREE, NEW, OLD, grid_min_cut


@kernel
def find_root(parent: Int32, v: int) -> int:
    """Return the representative of the set of `v`, with path halving (union-find)."""
    while parent[v] != v:
        parent[v] = parent[parent[v]]
        v = parent[v]
    return v


@kernel
def join(parent: Int32, v: int, w: int) -> None:
    """Unite the sets of two members; the smallest is the representative, so these are in the order of first members."""
    a, b = find_root(parent, v), find_root(parent, w)
    parent[max(a, b)] = min(a, b)


_WALL = -1  # an edge between corners that no path may take
_CUT = -2  # an edge that a path has taken
_FAR = 1 << 62
_IDLE = 0  # a corner is not queued,
_NEAR = 1  # queued for this round,
_LATER = 2  # or for a later one


@kernel
def lay_edges(
    state: UInt8, right: Int32, down: Int32, edge: Int32
) -> int:
    """Write the edges between corners, with walls inside forced regions; return their total cost.

    The edge to the right of corner `v` is at `v`, the one below it half the array further.
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
def typical(edge: Int32) -> int:
    """Return about the geometric mean of the costs above zero, from every fifth edge.

    A few large costs would raise the arithmetic mean far above the costs that a seam crosses. Whole bit lengths
    suffice, and are equal on every machine.
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
def _border(i: int, height: int, width: int) -> tuple[int, int, int]:
    """Return row and column of border pixel `i` of a window, clockwise from the upper left, and the corner after it."""
    stride = width + 1
    i %= 2 * (height + width) - 4
    if i < width - 1:
        return 0, i, stride + i + 1
    i -= width - 1
    if i < height - 1:
        return i, width - 1, (i + 2) * stride + width
    i -= height - 1
    if i < width - 1:
        return height - 1, width - 1 - i, (height + 2) * stride - 2 - i
    i -= width - 1
    return height - 1 - i, 0, (height - i) * stride


@kernel
def find_path(
    edge: Int32, height: int, width: int, start: Int32, goal: Int32, shift: int, step: int, far: Int64, came: UInt8
) -> int:
    """Find a shortest path from one gap to another; return the corner where it ends.

    Corners nearer than a limit are relaxed first in, first out until nothing changes; then the limit moves
    `step` beyond the nearest queued corner. Any step gives the optimum; no heap is needed.
    """
    size = far.size
    half, stride = edge.size // 2, width + 1
    steps, edges = (1, -1, stride, -stride), (0, -1, half, half - stride)
    waits = np.zeros(size, np.uint8)
    near = np.empty(size + 1, np.int32)
    later = np.empty(size, np.int32)
    far[:] = _FAR
    unit = 1 if shift > 0 else 0
    head, tail, kept = 0, 0, 0
    for i in range(start[0], start[1]):
        _, _, v = _border(i, height, width)
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
        _, _, end = _border(goal[0], height, width)
        for i in range(goal[0] + 1, goal[1]):
            _, _, v = _border(i, height, width)
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
def take_path(v: int, stride: int, came: UInt8, edge: Int32) -> None:
    """Mark the edges of the path that ends in corner `v` as cut."""
    half = edge.size // 2
    steps, edges = (1, -1, stride, -stride), (0, -1, half, half - stride)
    while came[v] != 4:
        d = came[v]
        v -= steps[d]
        edge[v + edges[d]] = _CUT


@kernel
def paint(state: UInt8, edge: Int32, out: UInt8) -> None:
    """Assign alternating sides across cut edges to the pixels, such that the forced ones agree."""
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
                wrong = side != (state[y, x] == NEW)  # equal for all forced pixels
    if wrong:
        for y in range(height):
            for x in range(width):
                out[y, x] = out[y, x] == 0


GRADIENT_UNIT = 256  # a gradient cost is the cost times this, divided by FLAT + gradients: so 16 times
FLAT = 16  # the cost in flat areas; in units of feature distance, avoids division by zero

STEEPEST = 4  # thresholds (knees): costs grow linearly from there on, so that no cut takes any detour around one step


class SeamPrice(NamedTuple):
    """Variant of the seam cost."""

    gradient: bool = False  # cheaper where there is detail (Kwatra et al. 2003, eq. 3)
    threshold: int = 0  # threshold of the truncated quadratic cost; 0: the cost is the distance of colours


PLAIN = SeamPrice()


@kernel
def truncated_quadratic(cost: int, knee: int) -> int:
    """Return the truncated quadratic of a cost: its square over the threshold, linear from STEEPEST thresholds on.

    So one visible step counts more than many invisible ones. The triangle inequality does not hold for it.
    """
    if cost >= STEEPEST * knee:
        return STEEPEST * cost
    return int(np.float64(cost * cost) / np.float64(knee))  # whole numbers: the rounding is exact


@kernel
def _distance(a: Int16, y: int, x: int, b: Int16, v: int, u: int) -> int:
    """Return the Euclidean distance of pixel (y, x) of `a` and (v, u) of `b` (h, w, C), rounded down."""
    total = 0  # views of single pixels would be reference counted, which takes longer than all the rest
    for c in range(a.shape[2]):
        difference = int(a[y, x, c]) - int(b[v, u, c])
        total += difference * difference
    return int(np.sqrt(np.float64(total))) if total > 0 else 0


@kernel
def seam_costs(
    old: Int16, new: Int16, price: Any
) -> tuple[Int32, Int32]:
    """Return the costs of a seam between each pixel and its right, and its lower neighbour.

    The cost is the distance of old and new at both pixels, summed, in the features' own units (Kwatra et
    al. 2003, eq. 1). With a `gradient` price a seam is cheaper where there is detail to hide it: the sum times
    GRADIENT_UNIT, divided by FLAT plus how much both images change between the two pixels (their eq. 3),
    rounded down; with a `knee` it is :func:`truncated_quadratic`.
    """
    height, width = old.shape[0], old.shape[1]
    apart = np.empty((height, width), np.int32)
    right = np.empty((height, max(width - 1, 0)), np.int32)
    down = np.empty((max(height - 1, 0), width), np.int32)
    for y in range(height):
        for x in range(width):
            apart[y, x] = _distance(old, y, x, new, y, x)
    for y in range(height):
        for x in range(width - 1):
            cost = apart[y, x] + apart[y, x + 1]
            if price.threshold > 0:
                cost = truncated_quadratic(cost, price.threshold)
            elif price.gradient:
                change = _distance(old, y, x, old, y, x + 1) + _distance(new, y, x, new, y, x + 1)
                cost = cost * GRADIENT_UNIT // (FLAT + change)
            right[y, x] = cost
    for y in range(height - 1):
        for x in range(width):
            cost = apart[y, x] + apart[y + 1, x]
            if price.threshold > 0:
                cost = truncated_quadratic(cost, price.threshold)
            elif price.gradient:
                change = _distance(old, y, x, old, y + 1, x) + _distance(new, y, x, new, y + 1, x)
                cost = cost * GRADIENT_UNIT // (FLAT + change)
            down[y, x] = cost
    return right, down


@kernel
def _pieces(state: UInt8) -> tuple[int, int, int]:
    """Count the 4-connected old pieces, the new ones, and those of them that do not touch the border."""
    height, width = state.shape
    most = height * width
    up = np.empty(most, np.int32)
    begin = np.empty(most, np.int32)
    end = np.empty(most, np.int32)
    coast = np.empty(most, np.uint8)
    label = np.empty(most, np.uint8)
    above, here, runs = 0, 0, 0  # the first run of the row above and of this row; all runs so far
    for y in range(height):
        above, here = here, runs
        x = 0
        while x < width:
            s = state[y, x]
            first = x
            x += 1
            while x < width and state[y, x] == s:
                x += 1
            if s == FREE:
                continue
            begin[runs] = first
            end[runs] = x
            label[runs] = s
            up[runs] = runs
            coast[runs] = 1 if y == 0 or y == height - 1 or first == 0 or x == width else 0
            touching = above
            while touching < here and begin[touching] < x:
                if end[touching] <= first:
                    above = touching + 1  # it also ends before every later run of this row
                elif label[touching] == s:
                    join(up, touching, runs)
                touching += 1
            runs += 1
    for run in range(runs):
        if coast[run] == 1:
            coast[find_root(up, run)] = 1
    old, new, inland = 0, 0, 0
    for run in range(runs):
        if up[run] == run:
            old += label[run] == OLD
            new += label[run] == NEW
            inland += coast[run] == 0
    return old, new, inland


@kernel
def _walk_border(state: UInt8, gaps: Int32, edge: Int32) -> int:
    """Write the gaps of the border, clockwise; return how many there are.

    Gap `g` consists of the corners after the pixels `gaps[g, 0]` up to, not including, `gaps[g, 1]`; both
    may lie beyond the border's length, once round. Free pixels of the border between, say, two old ones may be on
    either side, so a seam may end there and continue at another of them: edges along their outer side cost nothing.
    """
    height, width = state.shape
    stride, half = width + 1, edge.size // 2
    found, first, last, kind = 0, -1, 0, FREE
    i = 0
    while first < 0 or i <= first + 2 * (height + width) - 4:
        y, x, _ = _border(i, height, width)
        if state[y, x] != FREE:
            if first < 0:
                first = i
            elif state[y, x] != kind:
                gaps[found, 0] = last
                gaps[found, 1] = i
                found += 1
            else:
                for j in range(last + 1, i):
                    v, u, _ = _border(j, height, width)
                    corner = (v + 1) * stride + u
                    if v == 0:
                        edge[corner] = 0
                    if u == width - 1:
                        edge[half + corner + 1] = 0
                    if v == height - 1:
                        edge[corner + stride] = 0
                    if u == 0:
                        edge[half + corner] = 0
            last, kind = i, state[y, x]
        i += 1
    return found


@kernel
def min_cut(state: UInt8, right: Int32, down: Int32, out: UInt8) -> None:
    """Split a window between old and new by a minimum cut.

    `state`: 0 where a pixel must stay old, 2 where it must become new, 1 where it is free; costs are
    non-negative and below 2**30. `out` becomes 1 where the new patch is taken. The total of the costs between
    neighbours on different sides is the exact minimum, with the cost between touching forced pixels. Of
    several minimum cuts, the one with the shortest seam is taken, and among those the first in a fixed order;
    the shapes left to the maximum flow get the cut with the fewest old pixels. If nothing is forced old
    all becomes new, and if nothing is forced new all stays old.
    """
    height, width = state.shape
    olds, news, inland = _pieces(state)
    if olds == 0 or news == 0:
        out[:] = 1 if olds == 0 else 0
        return
    if inland > 0 or height < 2 or width < 2:
        grid_min_cut(state, right, down, out)
        return
    size = (height + 2) * (width + 1)
    edge = np.empty(2 * size, np.int32)
    total = lay_edges(state, right, down, edge)
    gaps = np.empty((2 * (height + width), 2), np.int32)
    found = _walk_border(state, gaps, edge)
    # With more than two gaps, the stretches to cut off are those of the label that is in several pieces:
    # the one that begins after the first gap, or the other one, which begins after the second.
    offset = 0
    if found > 2:
        y, x, _ = _border(gaps[0, 1], height, width)
        if (olds if state[y, x] == NEW else news) != 1:
            offset = 1
            if (olds if state[y, x] == OLD else news) != 1:
                grid_min_cut(state, right, down, out)
                return
    far = np.empty(size, np.int64)
    came = np.empty(size, np.uint8)
    # The length of a seam counts below its cost, where both fit together.
    shift = 1
    while (1 << shift) <= size:
        shift += 1
    if total >= 1 << (61 - shift):
        shift = 0
    step = typical(edge) << (shift + 3)
    for g in range(offset, found + offset, 2):
        end = find_path(edge, height, width, gaps[g], gaps[(g + 1) % found], shift, step, far, came)
        take_path(end, width + 1, came, edge)
    paint(state, edge, out)
