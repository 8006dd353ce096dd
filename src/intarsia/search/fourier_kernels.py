"""Kernels of the patch search: coarse pictures, the best of a distance map, exact distances.

All decisions use integer arithmetic. The transforms are floating point, but of small whole numbers, so that rounding
their results to the nearest whole number makes them exact.

Names: `feats` (n, h, w, C) and `known` (n, h, w) are windows and their masks, `posed` an
:class:`~intarsia.kernels.maps.OrientedExemplars`. Distances are sums of squared differences over known pixels.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.arrays import Int32, Int64, Mask, UInt8
from ..kernels.jit import kernel


@kernel
def measure(feats: Any, known: Any, posed: Any, rows: Any) -> None:
    """Write the squared distance of every patch into its row of `rows` (n, 4): distance, variant, row, column.

    `feats` (h, w, C), `known` (h, w): of one window. On entry the distance is a bound; a patch that is farther gets
    some number above it.
    """
    flat, table = posed
    h, w = known.shape
    channels = feats.shape[2]
    window = feats.reshape(h * w * channels)
    spans = np.empty((h, 3), np.int64)
    row_spans(known, spans)
    for k in range(len(rows)):
        v, stride = rows[k, 1], table[rows[k, 1], 3] * channels
        start = table[v, 0] + rows[k, 2] * stride + rows[k, 3] * channels
        rows[k, 0] = window_distance(window, known, spans, flat, start, stride, 1, rows[k, 0])


@kernel
def complete(
    correlated: Any, axes: int, scale: float, feats: Any, known: Any, posed: Any, found: Any, counts: Any
) -> None:
    """Add positions that the short-lists of n windows missed, so that the best of one variant is among `found`.

    For searches at full resolution. Rounding changes the difference of two reduced pictures by at most 1 per pixel and
    axis, so the root of the exact distance, times `scale`, is at least the root of the reduced distance less the
    root of (known pixels * `axes`). Positions that may be nearer than the best found are measured exactly. `correlated`
    is a :class:`Correlated`; `found` (n, K, 4) stays sorted, and `counts` (n,) is updated.
    """
    correlations, squares, slots, energies, valid, variant = correlated
    flat, table = posed
    h, w = known.shape[1:]
    channels = feats.shape[3]
    spans = np.empty((h, 3), np.int64)
    stride = table[variant, 3] * channels
    for k in range(len(slots)):
        if counts[k] < 1:
            continue
        window = feats[k].reshape(h * w * channels)
        row_spans(known[k], spans)
        doubt = np.sqrt(float(known[k].sum()) * axes)
        best = found[k, 0, 0]
        more = 2.0 - energies[k]  # correlations are not rounded here: distances are wrong by less than 1
        limit = (np.sqrt(float(best)) * scale + doubt) ** 2 + more
        for y in range(valid.shape[0]):
            cor, own, ok = correlations[k, y], squares[slots[k], y], valid[y]
            for x in range(valid.shape[1]):  # in double precision: sums over large patches need it
                if np.float64(own[x]) - 2.0 * np.float64(cor[x]) > limit or not ok[x]:
                    continue
                start = table[variant, 0] + y * stride + x * channels
                d = window_distance(window, known[k], spans, flat, start, stride, 1, best)
                if d < best:
                    counts[k] = insert(found[k], min(counts[k], found.shape[1] - 1), d, variant, y, x)
                    best = d
                    limit = (np.sqrt(float(best)) * scale + doubt) ** 2 + more


class Correlated(NamedTuple):
    """n windows correlated with one variant, and what is needed to convert that into distances."""

    values: NDArray[np.floating[Any]]  # (n, >= rows, >= columns): correlation at every position
    squares: Int32  # (m, rows, columns): the variant's sums of squares under m masks
    slots: Int64  # (n,): which of the masks is the window's
    energies: Int64  # (n,): sums of squares of the windows
    valid: Mask  # (rows, columns): where a patch may begin
    variant: int  # its number


class Listed(NamedTuple):
    """The short-lists of n windows, K positions each."""

    best: Int64  # (n, K, 4): cost, variant, row, column, cheapest first
    counts: Int64  # (n,): how many there are
    usual: Int64  # (n,): the usual distance, -1 while unknown


@kernel
def quantised(total: Any, count: int, mean: Any, axis: Any, clip: int) -> Any:
    """Return the mean of `count` feature values, given as sums (C,), projected on an axis: from -clip to clip."""
    q = np.int64(0)
    for c in range(len(axis)):
        q += (total[c] - mean[c] * count) * axis[c]
    q = q >> 2 if count == 4 else q // count  # 4 by far the most often, and a shift is much faster
    q = (q + (1 << 23)) >> 24
    return min(max(q, -clip), clip)


@kernel
def coarse(
    feats: Any, known: Any, factor: int, mean: Any, axes: Any, clip: int, templates: Any, masks: Any
) -> Any:
    """Average cells of factor x factor px of n pictures, project and quantise them; return sums of squares (n,) int64.

    `mean` (C,) is the features' mean; `axes` (K, C) int64 are the K directions kept, in 2**-24. `masks` (n, rows,
    columns) uint8 receives 1 where at least half of a cell is known, else 0. `templates` (n, K, rows, columns) float64
    receives whole numbers within `clip` where the mask is 1; elsewhere it is not written.
    """
    n, axis, rows, columns = templates.shape
    energies, total = np.zeros(n, np.int64), np.empty(feats.shape[3], np.int64)
    for k in range(n):
        picture, there = feats[k], known[k]
        for y in range(rows):
            for x in range(columns):
                count = 0
                for i in range(factor):
                    for j in range(factor):
                        count += there[y * factor + i, x * factor + j]
                masks[k, y, x] = 2 * count >= factor * factor
                if not masks[k, y, x]:
                    continue
                for c in range(len(total)):
                    part = np.int64(0)
                    for i in range(factor):
                        for j in range(factor):
                            part += picture[y * factor + i, x * factor + j, c]  # 0 where not known
                    total[c] = part
                for a in range(axis):
                    q = quantised(total, count, mean, axes[a], clip)
                    templates[k, a, y, x] = q
                    energies[k] += q * q
    return energies


ROWS = 20  # rows of a window, about, on which neighbouring positions are compared in a refinement
FAR = np.int64(1) << 62  # above any distance
NONE = np.int32((1 << 31) - 1)  # reduced distance where no patch may begin
MOST_DIFFERENCE = 4092  # largest difference of two features, those used in the search only (2 * 2046) included
MOST_SQUARES = ((1 << 31) - 1) // MOST_DIFFERENCE**2  # squares of such differences whose sum stays below 2**31


class Among(NamedTuple):
    """The valid first pixels of patches of all variants, one after the other."""

    valid: UInt8  # (positions,): 1 where a patch may begin
    offsets: Int64  # (V, 3): where a variant's positions begin, their rows and columns


@kernel
def patch_distances(correlation: Any, energies: Any, energy: int, valid: Any, out: Any) -> int:
    """Write the squared distance at every position, NONE where no patch may begin; return the usual distance.

    distance = sum of squares of the exemplar under the mask - 2 correlation + sum of squares of the window. The usual
    distance is the 5 % quantile over about 500 positions on a grid, or a quarter of their mean if that is more: where a
    flat part of the exemplar fits perfectly, a repeat still has a price. -1 if no position on the grid is valid.
    The values of reduced pictures are so small that all distances stay below NONE (:func:`.fourier.most_steps`).
    """
    h, w = valid.shape
    for y in range(h):
        cor, own, ok, d = correlation[y], energies[y], valid[y], out[y]
        for x in range(w):
            whole = np.int32(np.floor(cor[x] + 0.5))
            value = np.int32(own[x] + np.int32(energy) - np.int32(2) * whole)
            d[x] = value if ok[x] else NONE
    step = max(1, int(np.sqrt(h * w / 500.0)))
    sample = np.empty(((h + step - 1) // step) * ((w + step - 1) // step), np.int32)
    n = 0
    for y in range(0, h, step):
        for x in range(0, w, step):
            if out[y, x] != NONE:
                sample[n] = out[y, x]
                n += 1
    if n == 0:
        return -1
    mean = sample[:n].sum() // n
    return max(int(smallest(sample, n, n // 20)), int(mean >> 2))


@kernel
def smallest(values: Any, n: int, k: int) -> Any:
    """Return the number that comes `k`-th, from 0, when the first `n` of int32 `values` are sorted.

    By bisection of the range of values, counting in each step.
    """
    low, high = values[0], values[0]
    for i in range(np.uint64(n)):
        low, high = min(low, values[i]), max(high, values[i])
    while low < high:
        middle = np.int32(low + (np.int64(high) - low) // 2)
        count = 0
        for i in range(np.uint64(n)):
            count += values[i] <= middle
        if count > k:
            high = middle
        else:
            low = np.int32(middle + 1)
    return low


@kernel
def short_list(correlated: Any, penalty: Any, weight: int, listed: Any) -> None:
    """Insert the best positions of one variant for n windows into their lists, as :func:`keep_best` does.

    `penalty` (rows, columns) int32: uses of each position, 256 = one full repeat, which costs `weight` / 65536 of the
    usual distance. The usual distance, where unknown, is that of this variant.
    """
    correlations, squares, slots, energies, valid, variant = correlated
    best, counts, usual = listed
    dist = np.empty(valid.shape, np.int32)
    for k in range(len(slots)):
        q = patch_distances(correlations[k], squares[slots[k]], energies[k], valid, dist)
        if usual[k] < 0:
            usual[k] = q
        unit = weight * max(usual[k], 0) >> 8
        counts[k] = keep_best(dist, penalty, unit, variant, best[k], counts[k])


@kernel
def keep_best(dist: Any, penalty: Any, unit: int, variant: int, best: Any, count: int) -> int:
    """Insert the positions of smallest cost into `best`; return how many it holds.

    Cost is distance + penalty * unit / 2**16, rounded down.

    `best` (K, 4) int64: cost, variant, row, column, cheapest first. Equal costs: the earlier position stays.
    """
    size = len(best)
    worst = best[size - 1, 0] if count == size else np.int64(NONE)
    for y in range(len(dist)):
        d, p = dist[y], penalty[y]
        least = NONE
        for x in range(np.uint64(len(d))):
            least = min(least, d[x])
        if least >= worst:  # a penalty only adds
            continue
        for x in range(len(d)):
            if d[x] >= worst:
                continue
            cost: Any = np.int64(d[x]) + ((np.int64(p[x]) * unit) >> 16)
            if cost < worst or count < size:
                count = insert(best, min(count, size - 1), cost, variant, y, x)
                worst = best[size - 1, 0] if count == size else worst
    return count


@kernel
def row_spans(known: Any, spans: Any) -> None:
    """Write for every row the first known pixel, one past the last, and 1 if all between are known."""
    for i in range(known.shape[0]):
        lo, hi, n = known.shape[1], 0, 0
        for j in range(known.shape[1]):
            if known[i, j]:
                lo, hi, n = min(lo, j), j + 1, n + 1
        spans[i, 0], spans[i, 1], spans[i, 2] = min(lo, hi), hi, n == hi - min(lo, hi)


@kernel
def window_distance(
    window: Any, known: Any, spans: Any, flat: Any, start: int, stride: int, step: int, limit: Any
) -> Any:
    """Sum the squared differences over the known pixels of every `step`-th row; stop once above `limit`.

    `window` (h * w * C,) int16; the patch begins at ``flat[start]``, its rows `stride` numbers apart; `spans`: from
    :func:`row_spans`. The result is the sum over known pixels of (window - patch)**2. Differences are at most
    MOST_DIFFERENCE, so sums of MOST_SQUARES squares fit into 32 bits; unsigned offsets let the compiler vectorise the
    innermost loop.
    """
    (h, w), total, one = known.shape, np.int64(0), np.uint64(1)
    channels = np.uint64(len(window) // (h * w))
    for i in range(0, h, step):
        j, last, line = np.uint64(spans[i, 0]), np.uint64(spans[i, 1]), known[i]
        begin, other = np.uint64(i * w) * channels, np.uint64(start + i * stride)
        while j < last:  # run by run of known pixels
            a = j * channels
            j = last if spans[i, 2] else j
            while j < last and line[j]:
                j += one
            while a < j * channels:
                part, m = np.int32(0), min(j * channels - a, np.uint64(MOST_SQUARES))
                c, d = begin + a, other + a
                for k in range(m):
                    apart = np.int16(window[c + k] - flat[d + k])
                    part = np.int32(part + np.int32(apart) * np.int32(apart))
                total += part
                a += m
            while j < last and not line[j]:
                j += one
        if total > limit:
            return total
    return total


@kernel
def refine(
    feats: Any, known: Any, posed: Any, among: Any, coarse: Any, counts: Any, factor: int, found: Any
) -> None:
    """Refine the coarse candidates of n windows to full resolution and measure them exactly.

    `coarse` (n, K, 4): cost, variant, row, column in cells of `factor` px, of which `counts` (n,) are valid. `found`
    (n, K, 4) int64 receives exact distance, variant, row, column in px, best first, and `counts` their number; -1 where
    no pixel of a window is known. A candidate is moved to the best of a position and its eight neighbours, at
    distances of half a cell, a quarter and so on to 1 px, compared on some of the rows.
    """
    (flat, table), (valid, offsets) = posed, among
    h, w = known.shape[1:]
    channels = feats.shape[3]
    spans = np.empty((h, 3), np.int64)
    for m in range(len(feats)):
        window, there = feats[m].reshape(h * w * channels), known[m]
        row_spans(there, spans)
        many, count = counts[m], -1
        for i in range(h):
            if spans[i, 1] > 0:
                count = 0
        for n in range(many if count == 0 else 0):
            v = coarse[m, n, 1]
            begin, rows, columns = offsets[v]
            stride = table[v, 3] * channels
            y, x, step = coarse[m, n, 2] * factor, coarse[m, n, 3] * factor, factor
            while step > 1:
                step //= 2
                near, cy, cx = FAR, y, x
                for k in range(9):  # the middle first: it makes the limit small
                    u, s = y + ((k + 4) // 3 % 3 - 1) * step, x + ((k + 4) % 3 - 1) * step
                    if u < 0 or s < 0 or u >= rows or s >= columns:
                        continue
                    if step == 1 and not valid[begin + u * columns + s]:
                        continue
                    start = table[v, 0] + u * stride + s * channels
                    d = window_distance(window, there, spans, flat, start, stride, max(h // ROWS, 1), near)
                    if d < near:
                        near, cy, cx = d, u, s
                y, x = cy, cx
            if y < rows and x < columns and valid[begin + y * columns + x]:
                start = table[v, 0] + y * stride + x * channels
                d = window_distance(window, there, spans, flat, start, stride, 1, FAR)
                count = insert(found[m], count, d, v, y, x)
        counts[m] = count


@kernel
def insert(found: Any, count: int, d: int, v: int, u: int, s: int) -> int:
    """Insert a row into `found`, sorted by (distance, variant, row, column), if it is new; return the new count."""
    at = count
    while at > 0:
        p = found[at - 1]
        if p[0] < d or (p[0] == d and (p[1] < v or (p[1] == v and (p[2] < u or (p[2] == u and p[3] < s))))):
            break
        if p[0] == d and p[1] == v and p[2] == u and p[3] == s:
            return count
        at -= 1
    for k in range(count, at, -1):
        for c in range(found.shape[1]):
            found[k, c] = found[k - 1, c]
    found[at, 0], found[at, 1], found[at, 2], found[at, 3] = d, v, u, s
    return count + 1
