"""Slow, obvious versions of what `intarsia.kernels.cuts` and `maxflow` compute, to compare them with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_flow


def mask_cost(mask: NDArray[np.uint8], right: NDArray[np.int32], down: NDArray[np.int32]) -> int:
    """Add up the costs between neighbours on different sides of a mask."""
    m = mask != 0
    return int(right[m[:, 1:] != m[:, :-1]].sum(dtype=np.int64) + down[m[1:] != m[:-1]].sum(dtype=np.int64))


def exhaustive_cost(state: NDArray[np.uint8], right: NDArray[np.int32], down: NDArray[np.int32]) -> int:
    """Try every mask that respects what is forced and return the least cost."""
    free = np.argwhere(state == 1)
    if not (state == 0).any() or not (state == 2).any():
        return 0
    choices = (np.arange(1 << len(free))[:, None] >> np.arange(len(free))) & 1
    masks = np.repeat((state == 2)[None], len(choices), axis=0)
    masks[:, free[:, 0], free[:, 1]] = choices
    across = ((masks[:, :, 1:] != masks[:, :, :-1]) * right).sum(axis=(1, 2))
    upright = ((masks[:, 1:] != masks[:, :-1]) * down).sum(axis=(1, 2))
    return int((across + upright).min())


def scipy_flow_cost(state: NDArray[np.uint8], right: NDArray[np.int32], down: NDArray[np.int32]) -> int:
    """Return the value of scipy's maximum flow from all old pixels, as one source, to all new ones."""
    if not (state == 0).any() or not (state == 2).any():
        return 0
    node = np.arange(state.size).reshape(state.shape) + 2
    node[state == 0] = 0
    node[state == 2] = 1
    a = np.concatenate([node[:, :-1].ravel(), node[:-1].ravel()])
    b = np.concatenate([node[:, 1:].ravel(), node[1:].ravel()])
    c = np.concatenate([right.ravel(), down.ravel()])
    keep = a != b
    a, b, c = a[keep], b[keep], c[keep]
    size = state.size + 2
    rows, columns, costs = np.concatenate([a, b]), np.concatenate([b, a]), np.concatenate([c, c])
    graph = csr_matrix((costs, (rows, columns)), shape=(size, size), dtype=np.int32)
    return int(maximum_flow(graph, 0, 1).flow_value)


def _best_path(error: NDArray[np.int64]) -> NDArray[np.int64]:
    """Accumulate a strip's errors from its last row up: each plus the least of its three predecessors."""
    total = error.copy()
    for i in range(len(error) - 2, -1, -1):
        padded = np.pad(total[i + 1], 1, constant_values=np.iinfo(np.int64).max // 4)
        total[i] += np.minimum(np.minimum(padded[:-2], padded[1:-1]), padded[2:])
    return total


def _descend(total: NDArray[np.int64], row: int, column: int) -> list[int]:
    """Follow a strip's accumulated errors from a pixel to the last row; returns the column in each row."""
    columns = [column]
    for i in range(row + 1, len(total)):
        low = max(columns[-1] - 1, 0)
        columns.append(low + int(np.argmin(total[i, low : columns[-1] + 2])))
    return columns


def two_path_mask(error: NDArray[np.int64], overlap: int) -> NDArray[np.uint8]:
    """Cut an L-shaped overlap by the rule of Efros and Freeman, as Robinson's IPOL article writes it out.

    One monotone path runs down the left strip and one along the top strip; they meet in the pixel of the
    corner where their sum is least. What lies on them, left of the one and above the other is old.
    """
    n = len(error)
    vertical = _best_path(error[:, :overlap])
    horizontal = _best_path(error[:overlap].T.copy()).T
    corner = vertical[:overlap] + horizontal[:, :overlap] - error[:overlap, :overlap]
    turn_y, turn_x = np.unravel_index(int(np.argmin(corner)), corner.shape)
    mask = np.ones((n, n), np.uint8)
    mask[: turn_y + 1, : turn_x + 1] = 0
    for i, x in enumerate(_descend(vertical, int(turn_y), int(turn_x))):
        mask[turn_y + i, : x + 1] = 0
    for j, y in enumerate(_descend(horizontal.T, int(turn_x), int(turn_y))):
        mask[: y + 1, turn_x + j] = 0
    return mask
