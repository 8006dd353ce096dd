"""Where else in the exemplar it looks the same: the jump sets of the corrections.

On coarse levels they are found for every (h / 2)-th pixel only; the pixels between take those of a neighbour.

Source: Lefebvre and Hoppe 2005, where they are called candidates by k-coherence; the memorandum of 2008 on the
correction operation (docs/sources-004.md) calls them jump sets.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.axes import principal_axes
from ..kernels import kd_tree
from .appearance import whole_products
from .similar_kernels import jump_sets

AXES = 8
SAMPLE = 8192
APART = 0.05  # of the exemplar's longer side: nearer ones are no jumps
LEAVES = 8  # of the tree, looked into for one pixel
ASKED = 16  # pixels that the tree names for each jump, to be ranked exactly

Array = NDArray[Any]


def similar_places(
    table: Array, size: tuple[int, int, bool], border: int, h: int, closed: Array, count: int
) -> Array:
    """Return the `count` most similar pixels of every (h / 2)-th one: (rows, columns, count, 2) int32 (y, x), or -1.

    ``table`` (positions, n): neighbourhoods, those of `border` px on all sides included; ``size``: height, width,
    toroidal; ``closed`` (H, W): where no pixel may be jumped to. They lie at least 5 % of the exemplar, or h, from the
    pixel itself and from one another.
    """
    height, width, toroidal = size
    step = max(1, h // 2)
    ys, xs = np.arange(0, height, step), np.arange(0, width, step)
    out = np.full((len(ys) * len(xs), count, 2), -1, np.int32)
    places = np.stack(np.meshgrid(ys, xs, indexing="ij"), axis=2).reshape(-1, 2).astype(np.int64)
    free = ~closed[places[:, 0], places[:, 1]]
    if count and free.any():
        stride = width + 2 * border
        vectors = table[(places[:, 0] + border) * stride + places[:, 1] + border]
        points = _points(vectors)
        order = np.arange(int(free.sum()))
        own, nodes = points[free], 4 * (len(order) // kd_tree.LEAF + 1)
        axis, cut = np.zeros(nodes, np.int64), np.zeros(nodes, np.int64)
        kd_tree.build(own, order, axis, cut)
        none = np.zeros((1, 1), np.int64)
        tree = kd_tree.Tree(own, order, axis, cut, none[0], none)
        apart = max(2, round(APART * max(height, width)), h)
        limits = np.array([height, width, toroidal, apart, LEAVES], np.int64)
        queries = np.concatenate([places, points], axis=1)
        jump_sets(tree, queries, vectors, np.flatnonzero(free), limits, ASKED * count, out)
    return out.reshape(len(ys), len(xs), count, 2)


def _points(vectors: Array) -> Array:
    """Project neighbourhoods (N, n) on their main axes: (N, D) int32."""
    some = vectors[:: max(1, len(vectors) // SAMPLE)].astype(np.float64)
    axes = principal_axes(whole_products(some) / len(some), min(AXES, some.shape[1]))[1]
    whole = np.rint(axes * 4096)  # the products are whole numbers below 2**53: exact
    return np.asarray(np.floor(vectors.astype(np.float64) @ whole.T / 4096), np.int32)
