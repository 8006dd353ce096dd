"""Kernels of random sampling and gap filling: places near a lattice, and the best match of a border."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.jit import kernel

FIRST = 4  # runs of a border that every place is compared on; then a comparison ends where it is hopeless


@kernel
def near_lattice(places: Any, valid: Any, slack: int) -> Any:
    """Return the `valid` (h, w) first pixels of patches that lie within `slack` px of places (n, 2): (h, w)."""
    height, width = valid.shape
    marks = np.zeros(valid.shape, np.bool_)
    for k in range(len(places)):
        for y in range(max(0, places[k, 0] - slack), min(height, places[k, 0] + slack + 1)):
            for x in range(max(0, places[k, 1] - slack), min(width, places[k, 1] + slack + 1)):
                marks[y, x] = valid[y, x]
    return marks


@kernel
def best_place(picture: Any, runs: Any, border: Any, places: Any) -> int:
    """Return the place with the least sum of squared differences from a border, the first of equals.

    `runs` (n, 3): stretches of a row of `picture` (H, W, C) that are compared at once, where they begin in its numbers
    (from the place) and in those of the `border`, and how many numbers; `places` (m, 2).
    """
    flat, total = picture.reshape(picture.size), np.empty(len(places), np.int64)
    lead, few = 0, min(FIRST, len(runs))
    for m in range(len(places)):
        at = (places[m, 0] * picture.shape[1] + places[m, 1]) * picture.shape[2]
        total[m] = _difference(flat, at, runs[:few], border, np.int64(1) << 62)
        if total[m] < total[lead]:
            lead = m
    best, cost = -1, np.int64(1) << 62
    for turn in range(-1, len(places)):  # the most promising one first: the others then end early
        m = lead if turn < 0 else turn
        if total[m] > cost or turn == lead:
            continue
        at = (places[m, 0] * picture.shape[1] + places[m, 1]) * picture.shape[2]
        d = total[m] + _difference(flat, at, runs[few:], border, cost - total[m])
        if d < cost or (d == cost and m < best):
            best, cost = m, d
    return best


@kernel
def _difference(flat: Any, at: int, runs: Any, border: Any, limit: Any) -> Any:
    """Return the sum of squared differences along runs, or the partial sum once it exceeds `limit`."""
    total = np.int64(0)
    for k in range(len(runs)):
        f = flat[at + runs[k, 0] : at + runs[k, 0] + runs[k, 2]]
        g = border[runs[k, 1] : runs[k, 1] + runs[k, 2]]
        part = np.int32(0)  # a run is short enough for 32 bits
        for e in range(len(f)):
            d = np.int32(f[e]) - np.int32(g[e])
            part += d * d
        total += part
        if total > limit:
            break
    return total
