"""Kernels of the pyramid search: reduced pictures and windows, and the search level by level (Multrus 2003, 4.3)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...foundation.arrays import Int16, Int32, Int64, Mask
from ...kernels.jit import kernel
from ...search.fourier_kernels import FAR, insert, row_spans, window_distance

UNKNOWN, KNOWN, OUTSIDE = 0, 1, 2


class Fee(NamedTuple):
    """What repeats cost at the positions of one posed exemplar."""

    counts: Int32  # (rows, columns): uses; 256 = one full repeat
    weight: int  # price of such a repeat, in 1 / 65536 of the usual distance
    multiply: bool  # distances are multiplied by 1 + repeats instead


class Rung(NamedTuple):
    """One posed exemplar at one level of the pyramid."""

    flat: Int16  # (numbers,): the features of the level, all exemplars one after the other
    frame: Int64  # (4,): where it begins in flat, its height, width and stride, px of the level
    allowed: Mask  # (rows, columns): positions that are searched
    level: int  # px of it are 2**level px
    variant: int


@kernel
def halve(feats: Any, state: Any, weights: Any, loose: bool, out: Any, out_state: Any) -> None:
    """Filter a picture with 3 x 3 `weights` and keep every second pixel.

    `state` (h, w): KNOWN, UNKNOWN, or OUTSIDE the canvas, which is left out of averages. A pixel of `out` is known
    if all nine around its centre are; `loose`: if any is. A seam of n px thus keeps floor(n / 2).
    """
    rows, columns, channels = out.shape
    height, width = state.shape
    total = np.empty(channels, np.int64)
    for y in range(rows):
        for x in range(columns):
            total[:] = 0
            n, missing = np.int64(0), False
            for i in range(max(2 * y - 1, 0), min(2 * y + 2, height)):
                for j in range(max(2 * x - 1, 0), min(2 * x + 2, width)):
                    missing = missing or state[i, j] == UNKNOWN
                    if state[i, j] == KNOWN:
                        share = weights[i - 2 * y + 1, j - 2 * x + 1]
                        n += share
                        for c in range(channels):
                            total[c] += share * feats[i, j, c]
            there = KNOWN
            if state[2 * y, 2 * x] == OUTSIDE:
                there = OUTSIDE
            elif n == 0 or (missing and not loose):
                there = UNKNOWN
            out_state[y, x] = there
            for c in range(channels):
                out[y, x, c] = (2 * total[c] + n) // (2 * n) if there == KNOWN else 0


@kernel
def mark_outside(state: Any, y0: int, x0: int, canvas: Any, wrap: Any) -> None:
    """Mark the pixels of a window at (y0, x0) that lie outside the canvas, `canvas` (2,) px high and wide."""
    height, width = canvas
    for i in range(state.shape[0]):
        for j in range(state.shape[1]):
            if (not wrap[0] and not 0 <= y0 + i < height) or (not wrap[1] and not 0 <= x0 + j < width):
                state[i, j] = OUTSIDE


@kernel
def reduce_windows(feats: Any, state: Any, weights: Any, loose: Any, out: Any, out_state: Any) -> None:
    """Apply :func:`halve` to n windows; `loose` (n,) says for which of them any known pixel is enough."""
    for k in range(len(feats)):
        halve(feats[k], state[k], weights, loose[k], out[k], out_state[k])


@kernel
def priced(d: int, count: int, unit: int, multiply: bool) -> int:
    """Distance and price of repeats, as the short-list of the FFT search reckons it."""
    if multiply:
        return int((d * (256 + np.int64(count)) ** 2) >> 16)
    return int(d + ((np.int64(count) * unit) >> 16))


@kernel
def keep(best: Any, count: int, cost: int, v: int, y: int, x: int) -> int:
    """Put a position among the best (K + 1, 4), sorted, equal costs by place; return how many there are."""
    size = len(best) - 1
    if count == size and cost > best[size - 1, 0]:
        return count
    return min(insert(best, count, cost, v, y, x), size)


@kernel
def low_quantile(dist: Any) -> int:
    """The 5 % quantile of the distances on a grid of about 500 positions; -1 if none of them is allowed."""
    step = max(1, int(np.sqrt(dist.size / 500.0)))
    some = dist[::step, ::step].copy().ravel()
    some = some[some >= 0]
    if len(some) == 0:
        return -1
    return int(np.partition(some, len(some) // 20)[len(some) // 20])


@kernel
def measure_all(window: Any, known: Any, flat: Any, frame: Any, allowed: Any, dist: Any) -> None:
    """Write the squared distance at every position, -1 where none is `allowed`; `window` (h * w * C,) int16.

    `frame` (4,): where the picture begins in `flat`, its height, width and stride in px.
    """
    h, w = known.shape
    channels = len(window) // (h * w)
    spans = np.empty((h, 3), np.int64)
    row_spans(known, spans)
    for y in range(allowed.shape[0]):
        start = frame[0] + y * frame[3] * channels
        for x in range(allowed.shape[1]):
            dist[y, x] = -1
            if allowed[y, x]:
                at = start + x * channels
                dist[y, x] = window_distance(window, known, spans, flat, at, frame[3] * channels, 1, FAR)


@kernel
def list_level(costs: Any, rung: Any, fee: Any, unit: Any, best: Any, count: int) -> int:
    """List the positions of a level that cost at least 0, repeats added; return how many are `best` (K + 1, 4).

    Of the repeats, which are those at level 0, every 2**level-th is read.
    """
    (_, _, allowed, level, v), (counts, _, multiply) = rung, fee
    for y in range(allowed.shape[0]):
        row = counts[min(y << level, counts.shape[0] - 1)]
        for x in range(allowed.shape[1]):
            if costs[y, x] >= 0:
                cost = priced(costs[y, x], row[min(x << level, counts.shape[1] - 1)], unit, multiply)
                count = keep(best, count, cost, v, y, x)
    return count


@kernel
def search_level(
    feats: Any, known: Any, rung: Any, fee: Any, listed: Any, kept: Any, many: Any, reach: Any
) -> None:
    """Search a variant at a level for n windows, near what the coarser level kept, as :func:`mark_near` has it.

    The lists (n, K + 1, 4) keep K of all variants. The usual distance, if it is not known, is the low quantile.
    """
    (flat, frame, allowed, _, v), (best, found, usual) = rung, listed
    dist, near = np.empty(allowed.shape, np.int64), np.empty(allowed.shape, np.bool_)
    for k in range(len(feats)):
        mark_near(kept[k], many[k], v, reach, allowed, near)
        measure_all(feats[k].ravel(), known[k], flat, frame, near, dist)
        if usual[k] < 0:
            usual[k] = low_quantile(dist)
        found[k] = list_level(dist, rung, fee, (fee.weight * max(usual[k], 0)) >> 8, best[k], found[k])


@kernel
def mark_near(kept: Any, many: int, v: int, reach: Any, allowed: Any, near: Any) -> None:
    """Mark in `near` the `allowed` positions at most `reach` (2,) from what a coarser level kept of variant `v`.

    `kept` (K, 4), of which ``many`` rows count; below 0: there is no coarser level, and all that is allowed is near.
    """
    rows, columns = allowed.shape
    near[:, :] = False
    if many < 0:
        near[:, :] = allowed
    for i in range(many):
        if kept[i, 1] == v:
            cy, cx = min(2 * kept[i, 2], rows - 1), min(2 * kept[i, 3], columns - 1)
            top, left = max(cy - reach[0], 0), max(cx - reach[1], 0)
            bottom, right = cy + reach[0] + 1, cx + reach[1] + 1
            near[top:bottom, left:right] = allowed[top:bottom, left:right]
