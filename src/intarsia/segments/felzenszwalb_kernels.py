"""Graph-based image segmentation: region merging along sorted edges.

Felzenszwalb and Huttenlocher, "Efficient Graph-Based Image Segmentation", IJCV 2004. Weights are whole numbers
and the order of the edges is given, so ties are settled by the caller's stable sort and nothing else.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.cuts import find_root
from ..kernels.jit import kernel


@kernel
def join_edges(first: Any, second: Any, weight: Any, slack: int, least: int, parent: Any) -> None:
    """Join pixels along edges, sorted lightest first; `parent` (one entry for each pixel) becomes the segments.

    Two segments join over an edge no heavier than ``largest edge inside + slack / pixels`` of both. Those of
    fewer than `least` px then join a neighbour over the lightest edge. A segment is named by its first pixel.
    """
    size = np.ones(parent.size, np.int64)
    inner = np.zeros(parent.size, np.int64)
    for v in range(parent.size):
        parent[v] = v
    for e in range(len(first)):
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
    for e in range(len(first)):
        a = find_root(parent, first[e])
        b = find_root(parent, second[e])
        if a != b and (size[a] < least or size[b] < least):
            if b < a:
                a, b = b, a
            parent[b] = a
            size[a] += size[b]
    for v in range(parent.size):
        parent[v] = find_root(parent, v)
