"""Jump sets: for every pixel the few most similar ones elsewhere in the exemplar, by a kd-tree, ranked exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel
from .trees import DEEP, LEAF, _insert


@kernel
def apart(ay: Any, ax: Any, by: Any, bx: Any, size: Any) -> Any:
    """Return how far two pixels lie apart, along rows or columns; `size`: height, width, 1 if toroidal."""
    high, wide = abs(ay - by), abs(ax - bx)
    if size[2]:
        high, wide = min(high, size[0] - high), min(wide, size[1] - wide)
    return max(high, wide)


@kernel
def ask_apart(tree: Any, point: Any, place: Any, y: int, x: int, limits: Any, near: Any, number: Any) -> int:
    """Find the nearest points of a tree that lie far enough from (y, x); return how many.

    As trees.ask; ``place`` (N, 2): pixel of each point; ``limits``: height, width, 1 if toroidal, px apart at least,
    leaves looked into at most.
    """
    dims, k, leaves = tree.points.shape[1], len(near), limits[4]
    stack, gaps = np.empty((DEEP, 4), np.int64), np.zeros((DEEP, dims), np.int64)
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
                at = place[tree.order[i]]
                if apart(y, x, at[0], at[1], limits) < limits[3]:
                    refused = True
                    continue
                taken = True
                count = min(count + 1, k)
                _insert(near, number, count, total, tree.order[i])
        leaves -= 0 if refused and not taken else 1
    return count


@kernel
def jump_sets(tree: Any, queries: Any, vectors: Any, free: Any, limits: Any, asked: int, out: Any) -> None:
    """Write for each query its most similar targets, apart from it and from one another, (N, k - 1, 2).

    ``queries`` (N, 2 + D): pixel and point; ``vectors`` (N, n): the same as whole neighbourhoods, by which those that
    the tree names are ranked, equal ones by their number; ``free`` (M,): which queries are the tree's points.
    -1 where there are no more.
    """
    near, number = np.empty(asked, np.int64), np.empty(asked, np.int64)
    exact, ranked = np.empty(asked, np.int64), np.empty(asked, np.int64)
    targets = queries[free, :2]
    for q in range(len(queries)):
        count = ask_apart(tree, queries[q, 2:], targets, queries[q, 0], queries[q, 1], limits, near, number)
        for c in range(count):
            total, other = np.int64(0), free[number[c]]
            for i in range(vectors.shape[1]):
                gap = np.int64(vectors[q, i]) - vectors[other, i]
                total += gap * gap
            _insert(exact, ranked, c + 1, total, number[c])
        kept = 0
        for c in range(count):
            at = targets[ranked[c]]
            clear = kept < out.shape[1]
            for m in range(kept):
                clear = clear and apart(at[0], at[1], out[q, m, 0], out[q, m, 1], limits) >= limits[3]
            if clear:
                out[q, kept, 0], out[q, kept, 1] = at[0], at[1]
                kept += 1
