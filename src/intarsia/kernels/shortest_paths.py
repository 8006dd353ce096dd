"""Cheapest paths by dynamic programming: along bed and head joints, and for cuts that never turn back."""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel

BARRED = 1 << 40


@kernel
def accumulate(cost: Any, bend: int) -> Any:
    """Return the cumulative costs (n, k) of the cheapest paths from the first row, at most one step aside a row; int64.

    A step aside costs `bend`.
    """
    n, k = cost.shape
    total = np.empty((n, k), np.int64)
    for j in range(k):
        total[0, j] = cost[0, j]
    for t in range(1, n):
        for j in range(k):
            best = total[t - 1, j]
            if j > 0 and total[t - 1, j - 1] + bend < best:
                best = total[t - 1, j - 1] + bend
            if j + 1 < k and total[t - 1, j + 1] + bend < best:
                best = total[t - 1, j + 1] + bend
            total[t, j] = best + cost[t, j]
    return total


@kernel
def trace(total: Any, end: int, bend: int) -> Any:
    """Return the cheapest path that ends in column `end` of the last row: its column in every row (n,) int64.

    Of equal steps the straight one is taken, then the left one.
    """
    n, k = total.shape
    path = np.empty(n, np.int64)
    j = end
    path[n - 1] = j
    for t in range(n - 1, 0, -1):
        best, least = j, total[t - 1, j]
        if j > 0 and total[t - 1, j - 1] + bend < least:
            best, least = j - 1, total[t - 1, j - 1] + bend
        if j + 1 < k and total[t - 1, j + 1] + bend < least:
            best = j + 1
        j = best
        path[t - 1] = j
    return path


@kernel
def cheapest(cost: Any) -> Any:
    """Return the cheapest path down a field of costs (n, k): its column in every row; of equal ends the middle one."""
    total = accumulate(cost, 0)
    n, k = cost.shape
    end = k // 2
    for j in range(k):
        if total[n - 1, j] < total[n - 1, end]:
            end = j
    return trace(total, end, 0)


@kernel
def least_cut(cost: Any, gap: Any) -> Any:
    """Return the least cut between two layers, line by line: the first pixel of the second layer, (n,) int64.

    `cost` (n, K + 1): the cost to cut a line before pixel k; `gap` (n, K): the cost if a pixel is of one layer and its
    neighbour in the next line of the other. A cut may go any distance along the lines. Of equal cuts the
    one that goes straight on, else the one further left.
    """
    n, count = cost.shape
    total = np.empty((n, count), np.int64)
    came = np.empty((n, count), np.int64)
    for k in range(count):
        total[0, k] = cost[0, k]
    for t in range(1, n):
        for k in range(count):
            total[t, k], came[t, k] = total[t - 1, k], k
        for k in range(1, count):
            over = total[t, k - 1] + gap[t - 1, k - 1] + gap[t, k - 1]
            if over < total[t, k]:
                total[t, k], came[t, k] = over, came[t, k - 1]
        for k in range(count - 2, -1, -1):
            over = total[t, k + 1] + gap[t - 1, k] + gap[t, k]
            if over < total[t, k]:
                total[t, k], came[t, k] = over, came[t, k + 1]
        for k in range(count):
            total[t, k] += cost[t, k]
    path = np.empty(n, np.int64)
    k = count // 2
    for j in range(count):
        if total[n - 1, j] < total[n - 1, k]:
            k = j
    for t in range(n - 1, -1, -1):
        path[t] = k
        if t > 0:
            k = came[t, k]
    return path
