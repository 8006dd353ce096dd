"""Short-lists by correlations that are not whole numbers yet, only known to be near them.

Positions that the error leaves in doubt are correlated again in whole numbers. The lists are those of
:func:`fourier_kernels.short_list`, number by number.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from .fourier_kernels import FAR, HALF, NONE, insert, row_spans, smallest, usual_of, usual_step

AGAIN = 16  # so many products a position, on average, are quicker than a transform in doubles
LEAST_AGAIN = 64
ALL = 1 << 40


class Rough(NamedTuple):
    """One window correlated with one posed exemplar, by floats."""

    correlation: NDArray[np.floating[Any]]  # (>= rows, >= columns)
    own: NDArray[np.int32]  # (rows, columns): the exemplar's energy under the window's mask
    energy: int  # of the window
    valid: NDArray[np.bool_]  # (rows, columns): where a patch may begin
    slack: int  # distances are wrong by so much at most


class Whole(NamedTuple):
    """The same in whole numbers: what :func:`product` multiplies."""

    picture: NDArray[np.int16]  # (K, R, C)
    template: NDArray[np.int16]  # (K, h, w)
    spans: NDArray[np.int64]  # (h, 3): of every row of the template, where it is known


@kernel
def wrong(parts: Any, norms: Any, share: float, last: float) -> Any:
    """By what n correlations are wrong: `share` of the norms (n,), and `last` of the norms of their spectra.

    `parts` (n, h, w): real and imaginary parts of the half that a real transform has, in turns.
    """
    out = np.empty(len(parts), np.float64)
    total = np.empty(parts.shape[2], parts.dtype)
    for b in range(len(parts)):
        total[:] = 0
        for y in range(parts.shape[1]):  # down the columns: sums that stay apart run in vector registers
            row = parts[b, y]
            for x in range(np.uint64(len(row))):
                total[x] += row[x] * row[x]
        whole = -float(total[0]) - float(total[1])
        for x in range(len(total)):
            whole += 2.0 * float(total[x])
        out[b] = share * norms[b] + last * np.sqrt(whole)
    return out


@kernel
def product(picture: Any, template: Any, spans: Any, y: int, x: int) -> Any:
    """Correlate a picture (K, R, C) and a template (K, h, w), int16 both, at one position: a whole number."""
    _, rows, columns = picture.shape
    k, h, w = template.shape
    flat, own = picture.reshape(k * rows * columns), template.reshape(k * h * w)
    total = np.int32(0)
    for c in range(k):
        for i in range(h):
            lo = spans[i, 0]
            a, b = np.uint64((c * h + i) * w + lo), np.uint64((c * rows + y + i) * columns + x + lo)
            for j in range(np.uint64(spans[i, 1] - lo)):
                total = np.int32(total + np.int32(own[a + j]) * np.int32(flat[b + j]))
    return total


@kernel
def near_short_list(
    correlated: Any, slacks: Any, picture: Any, templates: Any, masks: Any, fee: Any, listed: Any, least: Any,
    doubtful: Any, most: int,
) -> None:  # fmt: skip
    """Do what :func:`fourier_kernels.short_list` does, by distances that may be wrong by `slacks` (n,).

    `least` (n, rows): the smallest distance of every row of positions, or less. Windows of which too many positions
    are in doubt are left, and marked in `doubtful` (n,) uint8: those that take more than `most` products a position.
    """
    correlations, squares, slots, energies, valid, variant = correlated
    best, counts, usual = listed
    spans = np.empty((templates.shape[2], 3), np.int64)
    for k in range(len(slots)):
        if doubtful[k]:
            continue
        rough = Rough(correlations[k], squares[slots[k]], energies[k], valid, slacks[k])
        whole = Whole(picture, templates[k], spans)
        row_spans(masks[k], spans)
        if usual[k] < 0:
            usual[k] = usual_distance(rough, whole)
        unit = fee.weight * max(usual[k], 0) >> 8
        limit = last_cost(rough, fee, unit, best[k], counts[k], least[k])
        left = products_left(most * valid.size, templates[k], spans)
        count = measure(rough, whole, fee, unit, variant, best[k], counts[k], least[k], limit, left)
        if count < 0:
            doubtful[k] = 1
        else:
            counts[k] = count


@kernel
def products_left(products: int, template: Any, spans: Any) -> int:
    """How many positions are correlated again for about so many products."""
    cells = 0
    for i in range(len(spans)):
        cells += spans[i, 1] - spans[i, 0]
    return max(products // max(cells * len(template), 1), LEAST_AGAIN)


@kernel
def distance_row(correlation: Any, own: Any, energy: int, valid: Any, out: Any) -> Any:
    """Write own - 2 correlation + energy for a row of positions, NONE where no patch may begin; return the least."""
    for x in range(np.uint64(len(out))):
        whole = np.int32(np.floor(correlation[x] + HALF))
        value = np.int32(own[x] + np.int32(energy) - np.int32(2) * whole)
        out[x] = value if valid[x] else NONE
    least = NONE
    for x in range(np.uint64(len(out))):
        least = min(least, out[x])
    return least


@kernel
def usual_distance(rough: Any, exact: Any) -> int:
    """The usual distance, as :func:`fourier_kernels.patch_distances` tells it.

    With a sample that is wrong by up to `slack` its quantile is so, too. What lies farther below it or above it does
    so in truth; the rest is needed in whole numbers, and all where the mean may be the larger one.
    """
    (correlation, own, energy, valid, slack), (picture, template, spans) = rough, exact
    h, w = valid.shape
    step = usual_step(h, w)
    sample = np.empty(((h + step - 1) // step) * ((w + step - 1) // step), np.int32)
    places = np.empty(len(sample), np.int64)
    n, total = 0, np.int64(0)
    for y in range(0, h, step):
        for x in range(0, w, step):
            if valid[y, x]:
                whole = np.int64(np.floor(correlation[y, x] + HALF))
                sample[n], places[n] = np.int32(own[y, x] + energy - 2 * whole), y * w + x
                total += sample[n]
                n += 1
    if n == 0 or slack == 0:
        return usual_of(sample, n)
    quantile = np.int64(smallest(sample, n, n // 20))
    low, high = quantile - 2 * slack, quantile + 2 * slack
    by_mean = (total // n + slack) >> 2 >= quantile - slack
    for i in range(n):
        if by_mean or low <= sample[i] <= high:
            y, x = places[i] // w, places[i] % w
            sample[i] = np.int32(own[y, x] + energy - 2 * np.int64(product(picture, template, spans, y, x)))
    return usual_of(sample, n) if by_mean else int(smallest(sample, n, n // 20))


@kernel
def cost_of(distance: Any, repeats: Any, unit: int) -> Any:
    """What a position costs by its distance: :func:`fourier_kernels.keep_best`. More for more distance."""
    return np.int64(distance) + ((np.int64(repeats) * unit) >> 16)


@kernel
def last_cost(rough: Any, fee: Any, unit: int, best: Any, count: int, least: Any) -> Any:
    """What the last of the list costs at most, with every distance more by `slack`; NONE while the list has room."""
    (correlation, own, energy, valid, slack), (penalty, _) = rough, fee
    size = len(best)
    costs = np.empty(size, np.int64)
    costs[:] = NONE
    costs[:count] = best[:count, 0]
    dist = np.empty(valid.shape[1], np.int32)
    full = count == size
    for y in range(len(valid)):
        lowest = distance_row(correlation[y], own[y], energy + slack, valid[y], dist)
        least[y] = np.int64(lowest) - 2 * slack
        worst = costs[size - 1]
        if lowest >= worst:
            continue
        p = penalty[y]
        for x in range(len(dist)):
            if dist[x] >= worst:
                continue
            cost = cost_of(dist[x], p[x], unit)
            if full and cost >= worst:
                continue
            k = min(count, size - 1)
            while k > 0 and costs[k - 1] > cost:
                costs[k] = costs[k - 1]
                k -= 1
            costs[k] = cost
            count = min(count + 1, size)
            full = count == size
            if full:
                worst = costs[size - 1]
    return costs[size - 1] if full else FAR


@kernel
def measure(
    rough: Any, whole: Any, fee: Any, unit: int, variant: int, best: Any, count: int, least: Any, limit: int, most: int
) -> int:
    """Put the positions that cost `limit` at most into `best`, by whole numbers; return how many it holds.

    -1, with the list half done, where more than `most` have to be correlated again.
    """
    (correlation, own, energy, valid, slack), (penalty, _) = rough, fee
    picture, template, spans = whole
    size = len(best)
    dist = np.empty(valid.shape[1], np.int32)
    for y in range(len(valid)):
        if least[y] > limit:
            continue
        distance_row(correlation[y], own[y], energy + slack, valid[y], dist)
        p = penalty[y]
        for x in range(len(dist)):
            if dist[x] == NONE or dist[x] - 2 * slack > limit:
                continue
            exact = np.int64(dist[x])
            if slack > 0:
                if cost_of(max(exact - 2 * slack, 0), p[x], unit) > limit:
                    continue
                most -= 1
                if most < 0:
                    return -1
                exact = own[y, x] + energy - 2 * np.int64(product(picture, template, spans, y, x))
            cost = cost_of(exact, p[x], unit)
            if count == size and cost >= best[size - 1, 0]:
                continue
            count = insert(best, min(count, size - 1), cost, variant, y, x)
            if count == size:
                limit = min(limit, best[size - 1, 0])
    return count
