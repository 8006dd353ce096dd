"""A tree over all neighbourhoods of the exemplars, to find similar ones quickly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...analysis.sums import principal_axes
from ...kernels import kd_tree
from ...kernels.kd_tree import LEAF, Tree
from . import tree_kernels
from .neighbourhood_kernels import Ground

DIMS = 12  # axes kept of a neighbourhood
SAMPLE = 4096  # neighbourhoods that the axes are measured on
ASKED = 12  # of similar pixels this many more are asked for than wanted: neighbours do not count
LEAVES = 32

Array = NDArray[np.int64]


def tree_of(ground: Ground, places: NDArray[np.int64], components: NDArray[np.int64]) -> Tree:
    """Build the tree over the neighbourhoods at (variant, position) `places` (N, 2).

    `components` (n, 3) are plane, row and column of what a neighbourhood consists of.
    """
    every = np.ascontiguousarray(places[:: max(1, len(places) // SAMPLE)])
    some = np.empty((len(every), len(components)), np.int32)
    tree_kernels.gather_neighbourhoods(ground, every, components, some)
    mean = some.astype(np.int64).sum(axis=0) // len(some)
    centred = (some - mean).astype(np.float64)  # sums of whole numbers below 2**53: exact in any order
    _, axes = principal_axes(centred.T @ centred / len(some), min(DIMS, len(components)))
    whole = np.rint(axes * 16384).astype(np.int64)
    points = np.empty((len(places), len(axes)), np.int32)
    tree_kernels.project_all(ground, places, components, mean, whole, points)
    order = np.arange(len(places))
    nodes = 4 * (len(places) // LEAF + 1)
    axis, cut = np.zeros(nodes, np.int64), np.zeros(nodes, np.int64)
    kd_tree.build(points, order, axis, cut)
    return Tree(points, order, axis, cut, mean, whole)


def similar_pixels(ground: Ground, places: NDArray[np.int64], components: NDArray[np.int64], count: int) -> Array:
    """Return for every position the `count` most similar places that are not its neighbours: (positions, count, 2).

    (variant, position), or -1 where there are no more.
    """
    out = np.full((ground.closed.shape[1], count, 2), -1, np.int64)
    if count:
        tree = tree_of(ground, places, components)
        near = np.empty((2, ASKED + 4 * count), np.int64)
        apart = int(np.abs(components[:, 1:]).max(initial=1))
        tree_kernels.similar(ground, places, components, tree, LEAVES, near, apart, out)
    return out
