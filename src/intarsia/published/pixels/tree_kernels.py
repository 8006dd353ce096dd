"""Neighbourhoods as points of a tree: they are projected, and the most similar ones of each are listed."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.jit import kernel
from ...kernels.kd_tree import ask, asking_room
from .neighbourhood_kernels import CLOSED, SIZE, START, STRIDE


@kernel
def project_vector(values: Any, mean: Any, axes: Any, out: Any) -> None:
    """Turn a long vector (n,) into a point (D,): the rounded sums of (value - mean) * axis / 16384."""
    for d in range(len(axes)):
        total = np.int64(8192)
        for m in range(len(mean)):
            total += (values[m] - mean[m]) * axes[d, m]
        out[d] = total >> 14


@kernel
def gather_neighbourhoods(ground: Any, places: Any, components: Any, out: Any) -> None:
    """Read the neighbourhoods at (variant, position) `places` (N, 2) into `out` (N, n).

    `components` (n, 3) are plane, row and column of each value.
    """
    for i in range(len(places)):
        row = ground.table[places[i, 0]]
        for m in range(len(components)):
            step = components[m, 0] * row[SIZE] + components[m, 1] * row[STRIDE] + components[m, 2]
            out[i, m] = ground.values[row[START] + places[i, 1] + step]


@kernel
def project_all(ground: Any, places: Any, components: Any, mean: Any, axes: Any, out: Any) -> None:
    """Turn the neighbourhoods at all places into points (N, D)."""
    values = np.empty((1, len(components)), np.int32)
    for i in range(len(places)):
        gather_neighbourhoods(ground, places[i : i + 1], components, values)
        project_vector(values[0], mean, axes, out[i])


@kernel
def similar(ground: Any, places: Any, components: Any, tree: Any, leaves: int, near: Any, apart: int, out: Any) -> None:
    """Write the most similar places of each place into `out` (positions, k, 2), -1 where there are no more.

    They lie further than `apart` px from it, in rows or columns. `near` (2, m) is room for m found ones.
    """
    values = np.empty((1, len(components)), np.int32)
    point, room = np.empty(tree.points.shape[1], np.int64), asking_room(tree.points.shape[1])
    for i in range(len(places)):
        gather_neighbourhoods(ground, places[i : i + 1], components, values)
        project_vector(values[0], tree.mean, tree.axes, point)
        v, at = places[i, 0], places[i, 1]
        row = ground.table[v]
        count = 0
        for k in range(ask(tree, point, leaves, near[0], near[1], room)):
            w, to = places[near[1, k], 0], places[near[1, k], 1]
            if count == out.shape[1]:
                break
            high, wide = abs(at // row[STRIDE] - to // row[STRIDE]), abs(at % row[STRIDE] - to % row[STRIDE])
            if w != v or max(high, wide) > apart:
                out[row[CLOSED] + at, count, 0], out[row[CLOSED] + at, count, 1] = w, to
                count += 1
