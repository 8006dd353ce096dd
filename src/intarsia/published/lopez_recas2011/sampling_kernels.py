"""Kernels of random sampling and gap filling: places of the lattice, borders of gaps, the patch that fits best."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.jit import kernel
from ...kernels.lattice_points import lattice_points

FIRST = 4  # runs of a border that every place is compared on; then a comparison ends where it is hopeless


@kernel
def sampled(first: Any, v1: Any, v2: Any, valid: Any, bits: Any) -> Any:
    """Draw for every block one of its places in the lattice: (n, 2) px; -1 where it has none.

    `first` (n, 2): a place of each block in the lattice, 1/256 px; `valid` (h, w): where a patch may begin;
    `bits` (n,): 32 drawn bits for each.
    """
    out = np.full((len(first), 2), -1, np.int64)
    low = np.zeros(2, np.int64)
    high = np.array([valid.shape[0] - 1, valid.shape[1] - 1], np.int64)
    for n in range(len(first)):
        places = lattice_points(first[n], v1, v2, low, high)[0]
        count = 0
        for k in range(len(places)):
            if valid[places[k, 0], places[k, 1]]:
                places[count] = places[k]
                count += 1
        if count:
            out[n] = places[(bits[n] * count) >> 32]
    return out


@kernel
def near_places(first: Any, v1: Any, v2: Any, valid: Any, slack: int, marks: Any) -> Any:
    """List where a patch may begin within `slack` px of the places of a block: (n, 2) px, in raster order.

    `marks` (h, w) uint8: scratch, all 0 before and after.
    """
    height, width = valid.shape
    low = np.array([-slack, -slack], np.int64)
    high = np.array([height - 1 + slack, width - 1 + slack], np.int64)
    places = lattice_points(first, v1, v2, low, high)[0]
    count = 0
    for k in range(len(places)):
        for y in range(max(0, places[k, 0] - slack), min(height, places[k, 0] + slack + 1)):
            for x in range(max(0, places[k, 1] - slack), min(width, places[k, 1] + slack + 1)):
                if valid[y, x] and marks[y, x] == 0:
                    marks[y, x] = 1
                    count += 1
    found = np.empty((count, 2), np.int64)
    n = 0
    for y in range(height):
        for x in range(width):
            if marks[y, x]:
                marks[y, x] = 0
                found[n, 0], found[n, 1] = y, x
                n += 1
    return found


@kernel
def wedges(height: int, width: int, border: int) -> Any:
    """Describe the border of a gap of height x width px: (n, 3), row and column from its outer corner, and side.

    The border is centred on the edge. Sides: 0 above, 1 below, 2 left, 3 right; they meet in 45 degree mitres.
    """
    rows, columns = height + border, width + border
    out = np.empty((rows * columns, 3), np.int64)
    count = 0
    for y in range(rows):
        for x in range(columns):
            depth, side = y, 0
            for k, other in ((1, rows - 1 - y), (2, x), (3, columns - 1 - x)):
                if other < depth:
                    depth, side = other, k
            if depth < border:
                out[count, 0], out[count, 1], out[count, 2] = y, x, side
                count += 1
    return out[:count].copy()


@kernel
def template(picture: Any, ring: Any, sources: Any, out: Any) -> None:
    """Compose the border of a gap from its neighbours: `out` (n C,); `sources` (4, 2): what to add to `ring`."""
    channels = picture.shape[2]
    for k in range(len(ring)):
        side = ring[k, 2]
        y, x = ring[k, 0] + sources[side, 0], ring[k, 1] + sources[side, 1]
        for c in range(channels):
            out[k * channels + c] = picture[y, x, c]


@kernel
def best_by_difference(flat: Any, stride: int, channels: int, runs: Any, border: Any, places: Any) -> int:
    """Find the place with the least sum of squared differences from a border, the first of equals.

    `flat`: the exemplar's values, `stride` to a row; `runs` (n, 3): stretches of a row that are compared at once,
    where they begin in `flat` (from the place) and in `border`, and how many values; `places` (m, 2).
    """
    total = np.empty(len(places), np.int64)
    lead, few = 0, min(FIRST, len(runs))
    for m in range(len(places)):
        at = places[m, 0] * stride + places[m, 1] * channels
        total[m] = _difference(flat, at, runs[:few], border, np.int64(1) << 62)
        if total[m] < total[lead]:
            lead = m
    best, cost = -1, np.int64(1) << 62
    for turn in range(-1, len(places)):  # the most promising one first: the others then end early
        m = lead if turn < 0 else turn
        if total[m] > cost or turn == lead:
            continue
        at = places[m, 0] * stride + places[m, 1] * channels
        d = total[m] + _difference(flat, at, runs[few:], border, cost - total[m])
        if d < cost or (d == cost and m < best):
            best, cost = m, d
    return best


@kernel
def _difference(flat: Any, at: int, runs: Any, border: Any, limit: Any) -> Any:
    """Squared differences along runs; the sum so far once that exceeds `limit`."""
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


@kernel
def ring_sums(picture: Any, height: int, width: int, border: int) -> Any:
    """Add up values and squares in the border of every place: two int64 arrays (h, w, C), by running sums."""
    rows, columns, channels = picture.shape
    tall, wide = height + border, width + border
    out = np.zeros((2, rows - tall + 1, columns - wide + 1, channels), np.int64)
    running = np.zeros((rows + 1, columns + 1), np.int64)
    for c in range(channels):
        for power in range(2):
            for y in range(rows):
                line = np.int64(0)
                for x in range(columns):
                    v = np.int64(picture[y, x, c])
                    line += v * v if power else v
                    running[y + 1, x + 1] = running[y, x + 1] + line
            for y in range(out.shape[1]):
                for x in range(out.shape[2]):
                    for a, sign in ((0, 1), (border, -1)):
                        b, s, e, t = y + a, x + a, y + tall - a, x + wide - a
                        if e > b and t > s:
                            box = running[e, t] - running[b, t] - running[e, s] + running[b, s]
                            out[power, y, x, c] += sign * box
    return out[0], out[1]


@kernel
def best_by_correlation(
    flat: Any, stride: int, channels: int, runs: Any, border: Any, places: Any, sums: Any, squares: Any
) -> int:  # fmt: skip
    """Find the place whose border correlates best (GNCC of all channels), the first of equals.

    As :func:`best_by_difference`; `sums`, `squares`: of :func:`ring_sums`.
    """
    own = np.zeros((2, channels), np.int64)
    for k in range(len(border)):
        v = np.int64(border[k])
        own[0, k % channels] += v
        own[1, k % channels] += v * v
    best, score = -1, -(np.int64(1) << 62)
    for m in range(len(places)):
        y, x = places[m, 0], places[m, 1]
        g = _exact_correlation(flat, y * stride + x * channels, runs, border, sums[y, x], squares[y, x], own)
        if g > score:
            best, score = m, g
    return best


@kernel
def _exact_correlation(flat: Any, at: int, runs: Any, border: Any, sums: Any, squares: Any, own: Any) -> Any:
    """GNCC of a border and a place, all channels, in 1e-9; 0 where one of them is flat."""
    channels = len(sums)
    n = np.int64(len(border) // channels)
    products = np.zeros(channels, np.int64)
    for k in range(len(runs)):
        f = flat[at + runs[k, 0] : at + runs[k, 0] + runs[k, 2]]
        g = border[runs[k, 1] : runs[k, 1] + runs[k, 2]]
        for s in range(len(f)):
            products[s % channels] += np.int64(f[s]) * np.int64(g[s])
    above, below = np.int64(0), 0.0
    for c in range(channels):
        above += n * products[c] - sums[c] * own[0, c]
        first, second = n * squares[c] - sums[c] ** 2, n * own[1, c] - own[0, c] ** 2
        below += np.sqrt(np.float64(max(first, 0)) * np.float64(max(second, 0)))
    if below <= 0.0:
        return np.int64(0)
    return np.int64(np.rint(1e9 * np.float64(above) / below))
