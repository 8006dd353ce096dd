"""Chains along a course: whole bricks joined joint on joint, or runs of one long piece, from anchor to anchor."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.draws import below, draw
from ..kernels.jit import kernel

FAR = np.int64(1) << 60  # more than any chain costs
STRETCH = 8  # a px by which joints are widened or narrowed; halved: 3.8 px on 10 walls instead of 3.0, doubled: 2.1
SLIVER = 3000  # the shortest of all pieces; at 0 six wrapped walls cut theirs to a third; halved and doubled: the same


@kernel
def link(length: int, sizes: Any, start: Any, joint: Any, pair: Any, closing: Any, rules: Any, out: Any) -> int:
    """Choose the elements of a chain of `length` px: `out` (n, 3): element, first column, end. Returns how many.

    `sizes` (K,): lengths of the elements; `start` (K, length + 1): what an element costs by where it begins;
    `joint` (length + 1,): what a joint costs by where it lies; `pair` (K, K): what one after another costs;
    `closing` (K,): before what follows the chain. `rules`: the first element; by how many px the chain may miss
    its length; the least px that the last element may be cut to, and what cutting it costs; what an element costs
    that was shown two or three before; which element follows the chain, or -1. The last element may be cut, so that
    there always is a chain.
    """
    first, slack, least, cut, again = rules[0], rules[1], rules[2], rules[3], rules[4]
    following = rules[5]
    count = len(sizes)
    best = np.full((length + slack + 1, count), FAR, np.int64)
    back = np.full((length + slack + 1, count), -1, np.int64)
    if sizes[first] <= length + slack:
        best[sizes[first], first] = start[first, 0]
    for u in range(1, length):
        for k in range(count):
            if best[u, k] == FAR:
                continue
            before = back[u, k]
            third = back[u - sizes[k], before] if before >= 0 else -1
            for m in range(count):
                v = u + sizes[m]
                if v > length + slack:
                    continue
                cost = best[u, k] + pair[k, m] + joint[u] + start[m, u]
                if m in (before, third):
                    cost += again
                if cost < best[v, m]:
                    best[v, m], back[v, m] = cost, k
    end, last, tail, least_cost = 0, first, -1, FAR
    for u in range(1, length + slack + 1):
        for k in range(count):
            if best[u, k] == FAR:
                continue
            if abs(length - u) <= slack:
                cost = best[u, k] + closing[k] + STRETCH * abs(length - u)
                if following >= 0 and back[u, k] == following:
                    cost += again
                if cost < least_cost:
                    end, last, tail, least_cost = u, k, -1, cost
            rest = length - u
            if rest <= 0:
                continue
            for m in range(count):
                if sizes[m] > rest:
                    cost = best[u, k] + pair[k, m] + joint[u] + start[m, u] + closing[m] + cut
                    cost += SLIVER * max(0, least - rest) // least
                    if m == back[u, k] or k == following:
                        cost += again
                    if cost < least_cost:
                        end, last, tail, least_cost = u, k, m, cost
    if least_cost == FAR:
        out[0, 0], out[0, 1], out[0, 2] = first, 0, length
        return 1
    return _written(length, sizes, back, np.array([end, last, tail]), out)


@kernel
def _written(length: int, sizes: Any, back: Any, found: Any, out: Any) -> int:
    """Walk a chain back and write it forwards; what it misses of its length is spread over its joints."""
    end, last, tail = found[0], found[1], found[2]
    n, u, k = 0, end, last
    while u > 0:
        n += 1
        u, k = u - sizes[k], back[u, k]
    missing = length - end if tail < 0 else 0
    u, k = end, last
    for at in range(n - 1, -1, -1):
        out[at, 0], out[at, 2] = k, u + missing * (at + 1) // n
        u, k = u - sizes[k], back[u, k]
        out[at, 1] = u + missing * at // n
    if tail >= 0:
        out[n, 0], out[n, 1], out[n, 2] = tail, end, length
        n += 1
    return n


@kernel
def leap_costs(strip: Any, half: int, spare: int) -> Any:
    """What it costs to leave a strip (h, n, C) before column x and go on at column z: (n, n) int64.

    The mean distance (1/16 units) of the columns around both, `half` to each side; FAR nearer than `spare` columns
    to an end.
    """
    height, n, channels = strip.shape
    single = np.zeros((n, n), np.int64)
    for x in range(n):
        for z in range(x):
            total = np.int64(0)
            for y in range(height):
                for c in range(channels):
                    d = np.int64(strip[y, x, c]) - np.int64(strip[y, z, c])
                    total += d * d
            single[x, z] = single[z, x] = int(16.0 * np.sqrt(np.float64(total // height)))
    out = np.full((n, n), FAR, np.int64)
    for x in range(spare, min(n, n - spare + 1)):
        for z in range(spare, min(n, n - spare + 1)):
            total = np.int64(0)
            for t in range(-half, half):
                total += single[x + t, z + t]
            out[x, z] = total // (2 * half)
    return out


@kernel
def best_leaps(costs: Any, apart: int, keep: int) -> Any:
    """The cheapest leaps from every column that go at least `apart` columns: targets (n, keep), -1 for none."""
    n = len(costs)
    out = np.full((n, keep), -1, np.int64)
    for x in range(n):
        order = np.argsort(costs[x], kind="mergesort")
        count = 0
        for z in order:
            if costs[x, z] == FAR or count == keep:
                break
            near = abs(z - x) < apart
            for k in range(count):
                near |= 2 * abs(out[x, k] - z) < apart
            if not near:
                out[x, count] = z
                count += 1
    return out


@kernel
def leap(length: int, costs: Any, leaps: Any, ends: Any, fee: int, key: Any, out: Any) -> int:
    """Walk `length` columns from ends[0] to ends[1] with the cheapest leaps: `out` (n, 3): column, from, to.

    `fee`: what every leap costs besides; up to as much again is drawn by `key` (uint64) for each.
    """
    n, keep = leaps.shape
    best = np.full((length + 1, n + 1), FAR, np.int64)
    came = np.full((length + 1, n + 1), -1, np.int64)
    best[0, ends[0]] = 0
    for u in range(length + 1):
        if u > 0:
            for x in range(n):  # leaps at u: from what ran on to x
                if best[u, x] == FAR or came[u, x] >= 0:
                    continue
                for k in range(keep):
                    z = leaps[x, k]
                    if z < 0:
                        break
                    cost = best[u, x] + costs[x, z] + fee + below(fee + 1, draw(key, 0, 0, x, z))
                    if cost < best[u, z]:
                        best[u, z], came[u, z] = cost, x
        if u < length:
            for x in range(n):
                if best[u, x] < best[u + 1, x + 1]:
                    best[u + 1, x + 1] = best[u, x]
    last, least = ends[1], best[length, ends[1]]
    for x in range(n):
        cost = best[length, x] + costs[x, ends[1]] + fee if costs[x, ends[1]] < FAR else FAR
        if best[length, x] < FAR and cost < least:
            last, least = x, cost
    count, u, x = 0, length, last
    while u > 0:
        if came[u, x] >= 0:
            out[count, 0], out[count, 1], out[count, 2] = u, came[u, x], x
            count += 1
            x = came[u, x]
        u, x = u - 1, x - 1
    return count
