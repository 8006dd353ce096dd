"""Jump sets: for every pixel the few most similar ones elsewhere in the exemplar, by a kd-tree, ranked exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from ..kernels.kd_tree import _insert, apart, ask_apart


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
        count = ask_apart(tree, queries[q, 2:], targets, (queries[q, 0], queries[q, 1]), limits, near, number)
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
