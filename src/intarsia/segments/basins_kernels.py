"""Basins of a relief, and the tree in which they merge, the weakest border first.

Segments of a picture: neighbouring pixels grow together while no edge between them stands out.

Felzenszwalb and Huttenlocher, "Efficient Graph-Based Image Segmentation", IJCV 2004. Weights are whole numbers
and the order of the edges is given, so ties are settled by the caller's stable sort and nothing else.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Int32, Int64
from ..kernels.cuts import find_root
from ..kernels.jit import kernel


@kernel
def smooth(colours: Int32, passes: int) -> None:
    """Blur (H, W, C) by (1, 2, 1) / 4 along both axes, so many times, rounded to the nearest; in place."""
    h, w, n = colours.shape
    rows, above, line = colours.reshape(h, w * n), np.empty(w * n, np.int32), np.empty((w + 2) * n, np.int32)
    for _ in range(passes):
        for k in range(w * n):
            above[k] = rows[0, k]
        for i in range(h):
            here, below = rows[i], rows[min(i + 1, h - 1)]
            for k in range(w * n):
                middle = here[k]
                twice = np.int32(np.int32(middle + middle) + np.int32(2))
                here[k] = np.int32(np.int32(above[k] + below[k]) + twice) >> np.int32(2)
                above[k] = middle
        for i in range(h):
            here = rows[i]
            for k in range(w * n):
                line[n + k] = here[k]
            for k in range(n):
                line[k], line[n + w * n + k] = here[k], here[w * n - n + k]
            for k in range(w * n):
                twice = np.int32(np.int32(line[k + n] + line[k + n]) + np.int32(2))
                here[k] = np.int32(np.int32(line[k] + line[k + 2 * n]) + twice) >> np.int32(2)


@kernel
def join_edges(
    first: Int32,
    second: Int32,
    weight: NDArray[np.uint16],
    order: Int64,
    slack: int,
    least: int,
    parent: Int32,
) -> None:
    """Join pixels along edges, lightest first; `parent` (one entry for each pixel) becomes the segments.

    Two segments join over an edge no heavier than ``largest edge inside + slack / pixels`` of both. Those of
    fewer than `least` px then join a neighbour over the lightest edge. A segment is named by its first pixel.
    """
    size = np.ones(parent.size, np.int64)
    inner = np.zeros(parent.size, np.int64)
    for v in range(parent.size):
        parent[v] = v
    for e in order:
        a = find_root(parent, first[e])
        b = find_root(parent, second[e])
        w = np.int64(weight[e])
        # w <= inner + slack / size, in whole numbers
        if a != b and (w - inner[a]) * size[a] <= slack and (w - inner[b]) * size[b] <= slack:
            if b < a:
                a, b = b, a
            parent[b] = a
            size[a] += size[b]
            inner[a] = w
    for e in order:
        a = find_root(parent, first[e])
        b = find_root(parent, second[e])
        if a != b and (size[a] < least or size[b] < least):
            if b < a:
                a, b = b, a
            parent[b] = a
            size[a] += size[b]
    for v in range(parent.size):
        parent[v] = find_root(parent, v)


# What is known of a node, in this order.
AREA, ROWS, COLUMNS, HIGH, WIDE, SLANT, RIM = range(7)
FACTS = 7  # as many as are named above
HUE = 90.0  # what a colour one spread away adds to a border that may be 330 strong; at most twice that


class Nodes(NamedTuple):
    """What is known of basins, and what they merge to: 2 n - 1 rows, of which the first n are the basins."""

    facts: Int64  # (., FACTS): sums over their pixels
    colours: Floats  # (., channels): sums of whole numbers
    kids: Int64  # (., 2): what merged; -1 in basins
    outline: Int64  # (., 3): strength, length, length where strong
    inner: Floats  # (.,): the strongest border inside


@kernel
def _weight(one: int, two: int, value: Any, facts: Any, colours: Any, spread: float, unit: float) -> float:
    """What merging two nodes costs: how strong their border is, how far their colours; little ones are cheap."""
    far = 0.0
    a, b = facts[one, AREA], facts[two, AREA]
    for c in range(colours.shape[1]):
        d = colours[one, c] / a - colours[two, c] / b
        far += d * d
    least = min(a, b)
    price: float = (value[0] / value[1] + HUE * min(np.sqrt(far) / spread, 2.0)) * np.sqrt(least / (least + unit))
    return price


@kernel
def _add_up(rows: Any, one: int, two: int, into: int) -> None:
    """Write the sum of two rows into a third."""
    for c in range(rows.shape[1]):
        rows[into, c] = rows[one, c] + rows[two, c]


@kernel
def merge(pairs: Any, values: Any, nodes_: Any, spread: float, unit: float) -> int:
    """Merge all basins, the cheapest pair first; returns how many nodes there are.

    `pairs` and `values` are those of :func:`.wholes.borders`, and used up; `spread`: of the colours; `unit` px: basins
    much smaller merge early. In `nodes_` are sums of the basins, no kids (-1), else 0; others are written.
    """
    facts, colours, kids, outline, inner = nodes_
    n, m = kids.shape[0] // 2 + 1, pairs.shape[0]
    nodes: int = n
    # pairs are named by slots: a slot is where a node lives, so that a merge renames only one of two
    node_of = np.arange(n)
    weight = np.empty(m, np.float64)
    seen = np.full(n, -1, np.int64)
    for k in range(m):
        weight[k] = _weight(pairs[k, 0], pairs[k, 1], values[k], facts, colours, spread, unit)
        for side in range(2):
            for c in range(3):
                outline[pairs[k, side], c] += values[k, c]
    while m > 0:
        best = 0
        for k in range(1, m):
            if weight[k] < weight[best]:
                best = k
        p, q = pairs[best, 0], pairs[best, 1]
        one, two = node_of[p], node_of[q]
        kids[nodes, 0], kids[nodes, 1] = one, two
        _add_up(facts, one, two, nodes)
        _add_up(colours, one, two, nodes)
        _add_up(outline, one, two, nodes)
        for c in range(3):
            outline[nodes, c] -= 2 * values[best, c]
        short = 0.45 * np.sqrt(float(min(facts[one, AREA], facts[two, AREA])))
        strength = values[best, 0] / values[best, 1] * min(1.0, values[best, 1] / short)
        inner[nodes] = max(inner[one], inner[two], strength)
        node_of[p] = nodes
        kept = 0
        for k in range(m):
            if k == best:
                continue
            a, b = pairs[k, 0], pairs[k, 1]
            if a == q:
                a = p
            if b == q:
                b = p
            v0, v1, v2 = values[k, 0], values[k, 1], values[k, 2]
            to = kept
            touched = a == p or b == p
            if touched:
                other = b if a == p else a
                if seen[other] >= 0:
                    to = seen[other]
                    v0, v1, v2 = v0 + values[to, 0], v1 + values[to, 1], v2 + values[to, 2]
                else:
                    seen[other] = kept
            if to == kept:
                kept += 1
            pairs[to, 0], pairs[to, 1] = a, b
            values[to, 0], values[to, 1], values[to, 2] = v0, v1, v2
            if touched:
                weight[to] = _weight(node_of[a], node_of[b], values[to], facts, colours, spread, unit)
            else:
                weight[to] = weight[k]
        m = kept
        for k in range(m):
            seen[pairs[k, 0]] = -1
            seen[pairs[k, 1]] = -1
        nodes += 1
    return nodes


@kernel
def choose(kids: Any, area: Any, score: Any, least: float, name: Any, scores: Any) -> tuple[float, int]:
    """Of all sets of nodes that share no pixel take that with most score by area; returns that, and how many.

    Those of it that score more than `least` are named from 1, the last nodes first: `name` (nodes,) says what each
    node is a part of, 0 or -1: of none; `scores` (nodes + 1,) what they score.
    """
    n = len(score)
    best, keep = np.zeros(n), np.zeros(n, np.bool_)
    for k in range(n):
        own, parts = area[k] * score[k], 0.0
        if kids[k, 0] >= 0:
            parts = best[kids[k, 0]] + best[kids[k, 1]]
        keep[k] = own >= parts and own > 0
        best[k] = max(own, parts)
    name[:] = 0
    scores[0] = 0.0
    count = 1
    for k in range(n - 1, -1, -1):
        if name[k] == 0 and keep[k]:
            name[k] = -1
            if score[k] > least:
                name[k], scores[count] = count, score[k]
                count += 1
        if name[k] != 0 and kids[k, 0] >= 0:
            name[kids[k, 0]] = name[kids[k, 1]] = name[k]
    return best[n - 1], count
