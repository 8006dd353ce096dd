"""Kernels of healing: how well patches continue old pixels that must stay, right at the edge of a hole."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from ..kernels.windows import canvas_place

# Of ten photographs, what was healed departs in contrast from what was lost by 6 % with GRAIN, by 11 % without it.
REACH = 3  # px from the hole in which old pixels are its edge
CELL = 8  # px; a step of tone shows where the differences of a cell have one sign
GRAIN = 4  # how much a step from rough to smooth counts: of two that fit badly the sum of squares likes the smoother
TONE = 8  # how much such a step counts: grain hides it from the sum of squares, not from the eye


@kernel
def edge_of(locked: Any, y0: int, x0: int, wrap: Any, known: Any, edge: Any) -> int:
    """Mark in `edge` (h, w) the pixels of a window that must stay and lie beside unknown ones; return their number."""
    height, width = locked.shape
    h, w = known.shape
    count = 0
    for i in range(h):
        y = canvas_place(y0 + i, height, wrap[0])
        for j in range(w):
            edge[i, j] = 0
            x = canvas_place(x0 + j, width, wrap[1])
            if known[i, j] == 0 or y < 0 or x < 0 or not locked[y, x]:
                continue
            near = False
            for a in range(max(i - REACH, 0), min(i + REACH + 1, h)):
                for b in range(max(j - REACH, 0), min(j + REACH + 1, w)):
                    near = near or known[a, b] == 0
            if near:
                edge[i, j] = 1
                count += 1
    return count


@kernel
def grain(flat: Any, begin: int, stride: int, channels: int, edge: Any) -> Any:
    """Root of the sum of squared deviations from the mean of each cell, over the edge pixels of a window.

    `flat` holds the window from `begin` on, `stride` pixels a row.
    """
    h, w = edge.shape
    total = np.int64(0)
    for y in range(0, h, CELL):
        for x in range(0, w, CELL):
            for c in range(channels):
                count, values, squares = np.int64(0), np.int64(0), np.int64(0)
                for i in range(y, min(y + CELL, h)):
                    for j in range(x, min(x + CELL, w)):
                        if edge[i, j]:
                            value = np.int64(flat[begin + (i * stride + j) * channels + c])
                            count, values, squares = count + 1, values + value, squares + value * value
                if count:
                    total += squares - values * values // count
    return np.sqrt(np.float64(total))


@kernel
def weigh_edge(
    locked: Any, at: Any, wrap: Any, feats: Any, known: Any, flat: Any, table: Any, rows: Any
) -> None:  # fmt: skip
    """Add to the distances of candidates (n, 4) what they differ at the edge, which counts as much as all the rest.

    Steps of tone and of grain count besides. `feats`, `known`: the window that begins at `at`. The candidates come
    out in the order of the new distances; where nothing must stay, nothing changes.
    """
    h, w, channels = feats.shape
    edge = np.empty((h, w), np.uint8)
    count = edge_of(locked, at[0], at[1], wrap, known, edge)
    if count == 0:
        return
    total = np.int64(0)
    for i in range(h):
        for j in range(w):
            total += known[i, j]
    sums = np.zeros(((h + CELL - 1) // CELL, (w + CELL - 1) // CELL, channels + 1), np.int64)
    own = grain(feats.ravel(), 0, w, channels, edge)
    for n in range(len(rows)):
        v, u, s = rows[n, 1], rows[n, 2], rows[n, 3]
        rough = own - grain(flat, table[v, 0] + (u * table[v, 3] + s) * channels, table[v, 3], channels, edge)
        there = np.int64(GRAIN * rough * rough)
        sums[:] = 0
        for i in range(h):
            for j in range(w):
                if edge[i, j]:
                    k = table[v, 0] + ((u + i) * table[v, 3] + s + j) * channels
                    cell = sums[i // CELL, j // CELL]
                    cell[channels] += 1
                    for c in range(channels):
                        d = np.int64(feats[i, j, c]) - flat[k + c]
                        there += d * d
                        cell[c] += d
        for i in range(sums.shape[0]):
            for j in range(sums.shape[1]):
                for c in range(channels):
                    there += TONE * sums[i, j, c] ** 2 // max(sums[i, j, channels], 1)
        rows[n, 0] = (rows[n, 0] + there // count * total) // 2
    for n in range(1, len(rows)):  # few rows: insertion keeps the order of equals
        k = n
        while k > 0 and rows[k - 1, 0] > rows[k, 0]:
            for c in range(4):
                rows[k - 1, c], rows[k, c] = rows[k, c], rows[k - 1, c]
            k -= 1
