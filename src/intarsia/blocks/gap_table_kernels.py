"""Kernels of a mosaic's gaps where places are few: how pairs of places fit, and how often each is taken."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from .gap_kernels import FAR, covers, readable


@kernel
def pair_sums(picture: Any, usable: Any, zone: Any, own: Any, near: Any, slack: int) -> Any:
    """How places of a gap fit those of one neighbour: squared differences over `zone`, and px; (k, n, moves) each.

    `zone` (m, 3): px of the gap's window towards this neighbour; `own` (n, 2), `near` (k, 2): what is added to them
    to read a place of the gap, of the neighbour. The gap's is moved by up to `slack` px, row by row of moves. Whole
    numbers, as float64: these are summed many at once.
    """
    channels, side, places = picture.shape[2], 2 * slack + 1, len(near)
    theirs, there = np.zeros((len(zone), channels, places)), np.zeros((len(zone), places))
    for m in range(len(zone)):
        for k in range(places):
            y, x = zone[m, 0] + near[k, 0], zone[m, 1] + near[k, 1]
            if readable(usable, y, x):
                there[m, k] = 1.0
                for c in range(channels):
                    theirs[m, c, k] = picture[y, x, c]
    sums, px = np.zeros((places, len(own), side * side)), np.zeros((places, len(own), side * side))
    total, count, square = np.empty(places), np.empty(places), np.empty(places)
    for n in range(len(own)):
        for move in range(side * side):
            total[:], count[:] = 0.0, 0.0
            for m in range(len(zone)):
                v = zone[m, 0] + own[n, 0] + move // side - slack
                u = zone[m, 1] + own[n, 1] + move % side - slack
                if not readable(usable, v, u):
                    continue
                square[:] = 0.0
                for c in range(channels):
                    mine = np.float64(picture[v, u, c])
                    for k in range(places):
                        square[k] += (theirs[m, c, k] - mine) * (theirs[m, c, k] - mine)
                for k in range(places):
                    total[k] += square[k] * there[m, k]
                    count[k] += there[m, k]
            sums[:, n, move], px[:, n, move] = total, count
    return sums, px


@kernel
def box(core: Any) -> Any:
    """First and last row and column of a block in its window: (top, left, bottom, right)."""
    top, left, bottom, right = core.shape[0], core.shape[1], -1, -1
    for y in range(core.shape[0]):
        for x in range(core.shape[1]):
            if core[y, x]:
                top, left, bottom, right = min(top, y), min(left, x), y, max(right, x)
    return top, left, bottom, right


@kernel
def move_within(usable: Any, core: Any, most: int, shift: Any) -> None:
    """Move a `shift` (2,) by up to `most` px, so that a block rounded past the edges of a sheet is read whole."""
    top, left, bottom, right = box(core)
    y = min(max(shift[0], -top), usable.shape[0] - 1 - bottom)
    x = min(max(shift[1], -left), usable.shape[1] - 1 - right)
    shift[0] += min(max(y - shift[0], -most), most)
    shift[1] += min(max(x - shift[1], -most), most)


@kernel
def whole_moves(usable: Any, core: Any, own: Any, slack: int) -> Any:
    """Say for which moves of which places of a gap, (n, moves), its `core` can be read whole; `own` as for pairs."""
    side, masked = 2 * slack + 1, not usable.all()
    top, left, bottom, right = box(core)
    out = np.zeros((len(own), side * side), np.bool_)
    for n in range(len(own)):
        for move in range(side * side):
            v, u = own[n, 0] + move // side - slack, own[n, 1] + move % side - slack
            if top + v >= 0 and left + u >= 0 and bottom + v < usable.shape[0] and right + u < usable.shape[1]:
                out[n, move] = not masked or covers(usable, core, v, u)
    return out


@kernel
def gap_costs(sums: Any, px: Any, barred: Any, around: Any, sampled: int, bar: int, costs: Any, moves: Any) -> None:
    """Write what each place costs in each gap at its best move, and that move: `costs`, `moves` (gaps, n).

    `sums`, `px`: :func:`pair_sums` of the four sides; `barred`: for each side (k, n) 1 for places that repeat it, 2
    for those that only continue it, which cost `bar` more; `around` (gaps, 4): the place of each neighbour; `sampled`:
    px of the zone that were compared. The cost is a mean squared difference in 1/16 units; FAR where fewer than half
    of the px have both sources.
    """
    mean = np.empty(sums[0].shape[2])
    for g in range(costs.shape[0]):
        a, b, c, d = around[g, 0], around[g, 1], around[g, 2], around[g, 3]
        for n in range(costs.shape[1]):
            for move in range(len(mean)):
                count = px[0][a, n, move] + px[1][b, n, move] + px[2][c, n, move] + px[3][d, n, move]
                total = sums[0][a, n, move] + sums[1][b, n, move] + sums[2][c, n, move] + sums[3][d, n, move]
                mean[move] = total / count if 2.0 * count >= sampled else np.inf
            best = 0
            for move in range(1, len(mean)):
                if mean[move] < mean[best]:
                    best = move
            costs[g, n], moves[g, n] = FAR, best
            if mean[best] < np.inf:
                worst = max(barred[0][a, n], barred[1][b, n], barred[2][c, n], barred[3][d, n])
                costs[g, n] = np.int64(np.floor(16.0 * mean[best])) + np.int64(worst) * bar


@kernel
def auction(costs: Any, shares: Any, rounds: int, even: int, bar: int, prices: Any) -> None:
    """Raise `prices` (n,) of places that more gaps take than their share, lower the others, ever more gently.

    `costs` (gaps, n); those from `bar` on are taken only where nothing is cheaper. `shares` (n,): how many gaps each
    place is for, in parts of their sum; a place taken by `even` percent more or fewer than these keeps its price. The
    unit of a price is what the second best place of a gap costs more than the best, on average.
    """
    gaps, count = costs.shape
    spread, known = np.int64(0), np.int64(0)
    for g in range(gaps):
        best, second = np.int64(bar), np.int64(bar)
        for n in range(count):
            if costs[g, n] < best:
                best, second = costs[g, n], best
            elif costs[g, n] < second:
                second = costs[g, n]
        if second < bar:
            spread += second - best
            known += 1
    unit = spread // known if known > 0 else spread
    taken, whole = np.zeros(count, np.int64), shares.sum()
    for k in range(rounds):
        taken[:] = 0
        for g in range(gaps):
            best, at = FAR, -1
            for n in range(count):
                if costs[g, n] < FAR and (at < 0 or costs[g, n] + prices[n] < best):
                    best, at = costs[g, n] + prices[n], n
            if at >= 0:
                taken[at] += 1
        for n in range(count):
            due = gaps * shares[n]
            more = taken[n] * whole - due
            if abs(more) * 100 > even * due:
                prices[n] += more * unit * 8 // (due * (k + 8))
    least = prices.min()
    for n in range(count):
        prices[n] -= least
