"""Kernels of block mosaics: costs of phases, overlap regions, the search for the block of a gap, its graph cut.

A gap is a block between random ones (``mosaic.py``); its overlap with each neighbour is a wedge with mitred ends.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..foundation.geometry import UNIT
from ..kernels.cuts import PLAIN, min_cut, seam_costs
from ..kernels.jit import kernel
from ..kernels.maxflow import FREE, NEW, OLD
from ..kernels.shortest_paths import accumulate

FAR = np.int64(1) << 60  # mismatch of shifts that cannot be used
LIMIT = np.int64(1) << 32  # above any mismatch


@kernel
def crossings(cost: Any, band: int) -> Any:
    """Return the cost per px of the cheapest path down each band of columns of a field (n, k): (k - band + 1,)."""
    out = np.empty(cost.shape[1] - band + 1, np.int64)
    for first in range(len(out)):
        out[first] = accumulate(cost[:, first : first + band], 0)[-1].min() // len(cost)
    return out


@kernel
def all_usable(places: Any, sides: Any, valid: Any) -> Any:
    """Return for every place (n, 2) whether the block spanned by `sides` (2, 2) covers usable pixels only."""
    ok = np.ones(len(places), np.bool_)
    determinant = sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0]
    height, width = valid.shape
    for y in range(height):
        for x in range(width):
            if valid[y, x]:
                continue
            for n in range(len(places)):
                dy, dx = y * UNIT + UNIT // 2 - places[n, 0], x * UNIT + UNIT // 2 - places[n, 1]
                a, b = dy * sides[1, 1] - dx * sides[1, 0], dx * sides[0, 0] - dy * sides[0, 1]
                if 0 <= a < determinant and 0 <= b < determinant:
                    ok[n] = False
    return ok


@kernel
def wedges(frame: Any, half: float, sides: Any, core: Any) -> None:
    """Write the window of a block: `sides` (h, w), the neighbour whose overlap a pixel belongs to, and `core` (h, w).

    `core` is true in the block itself. Neighbours are 0 up, 1 down, 2 left, 3 right; -1 for pixels more than `half` px
    from the block's edges, and outside of the block at its corners or nearer to another edge of the neighbour. `frame`:
    block sides (rows, columns; dy, dx) and corner in 1/256 px, relative to the window's first pixel.
    """
    determinant = float(frame[0] * frame[3] - frame[1] * frame[2])
    down = determinant / np.sqrt(float(frame[2]) ** 2 + float(frame[3]) ** 2) / UNIT
    across = determinant / np.sqrt(float(frame[0]) ** 2 + float(frame[1]) ** 2) / UNIT
    for y in range(core.shape[0]):
        for x in range(core.shape[1]):
            dy, dx = y * UNIT - frame[4], x * UNIT - frame[5]
            a = float(dy * frame[3] - dx * frame[2]) / determinant * down  # px from the upper edge
            b = float(dx * frame[0] - dy * frame[1]) / determinant * across  # px from the left edge
            side, depth = 0, a
            for k, edge in enumerate((down - a, b, across - b)):
                if edge < depth:
                    side, depth = k + 1, edge
            core[y, x] = near = 0 <= a < down and 0 <= b < across
            if side < 2:
                near |= b < across and -depth <= min(b, across - b, down / 2)
            else:
                near |= -depth < min(a, down - a) and -depth <= across / 2
            sides[y, x] = side if near and abs(depth) < half else -1


@kernel
def neighbours_of(picture: Any, usable: Any, zone: Any, t: Any, step: int) -> Any:
    """Return every `step`-th pixel of a gap's overlap as its neighbours have it: places (n, 2), values (n, C).

    Also return the number of pixels sampled; those for which the neighbour has no usable source are left out. `zone`
    (m, 3): rows, columns, side of the overlap's pixels (canvas px relative to the window); `t` (4, 2): the neighbours'
    shifts.
    """
    channels = picture.shape[2]
    places = np.empty((len(zone), 2), np.int64)
    values = np.empty((len(zone), channels), np.int16)
    n = 0
    for k in range(0, len(zone), step):
        side = zone[k, 2]
        y, x = zone[k, 0] + t[side, 0], zone[k, 1] + t[side, 1]
        if readable(usable, y, x):
            places[n, 0], places[n, 1] = zone[k, 0], zone[k, 1]
            for c in range(channels):
                values[n, c] = picture[y, x, c]
            n += 1
    return places[:n], values[:n], -(-len(zone) // step)


@kernel
def mismatch(picture: Any, usable: Any, seen: Any, ty: int, tx: int, limit: Any) -> Any:
    """Return 16 times the mean squared difference in the overlap of a gap that is read at shift (ty, tx).

    `seen`: from :func:`neighbours_of`. Pixels without a usable source are left out; FAR if fewer than half of those
    sampled have both sources, or if the result is certainly above `limit`.
    """
    height, width = usable.shape
    places, values, sampled = seen
    total, count, n = np.int64(0), 0, len(places)
    for begin in range(0, n, 16):
        for k in range(begin, min(begin + 16, n)):
            y, x = places[k, 0] + ty, places[k, 1] + tx
            if 0 <= y < height and 0 <= x < width and usable[y, x]:
                count += 1
                for c in range(picture.shape[2]):
                    d = np.int32(picture[y, x, c]) - np.int32(values[k, c])
                    total += d * d
        if 16 * total > (limit + 1) * n:
            return FAR
    if 2 * count < sampled or count == 0:
        return FAR
    return 16 * total // count


@kernel
def covers(usable: Any, core: Any, ty: int, tx: int) -> bool:
    """Return whether all pixels of a block are usable at shift (ty, tx)."""
    for y in range(core.shape[0]):
        for x in range(core.shape[1]):
            if core[y, x] and not readable(usable, y + ty, x + tx):
                return False
    return True


@kernel
def best_fits(
    picture: Any, usable: Any, core: Any, zone: Any, t: Any, shifts: Any, tolerance: int, keep: int
) -> Any:
    """Return the best shifts for a gap, at most `keep`: rows of mismatch, ty, tx, (n, 3).

    All `shifts` (n, 2) are compared on some 300 pixels of the overlap; the best `keep` are refined by up to `tolerance`
    px per axis, and measured on some 1200. Shifts at which the block is not usable throughout are left out.
    """
    rough = neighbours_of(picture, usable, zone, t, max(1, len(zone) // 300))
    fine = neighbours_of(picture, usable, zone, t, max(1, len(zone) // 1200))
    count, out = 0, np.empty((keep, 3), np.int64)
    for k in best_shifts(picture, usable, rough, shifts, keep):
        y, x = shifts[k, 0], shifts[k, 1]
        best, by, bx = mismatch(picture, usable, rough, y, x, LIMIT), y, x
        for dy in range(-tolerance, tolerance + 1):
            for dx in range(-tolerance, tolerance + 1):
                d = mismatch(picture, usable, rough, y + dy, x + dx, best)
                if d < best or (d == best and abs(dy) + abs(dx) < abs(by - y) + abs(bx - x)):
                    best, by, bx = d, y + dy, x + dx
        if not covers(usable, core, by, bx):
            by, bx = y, x
            if not covers(usable, core, by, bx):
                continue
        out[count, 0] = mismatch(picture, usable, fine, by, bx, LIMIT)
        out[count, 1], out[count, 2] = by, bx
        count += 1
    return out[:count]


@kernel
def best_shifts(picture: Any, usable: Any, seen: Any, shifts: Any, keep: int) -> Any:
    """Return the indices of the `keep` shifts with the least mismatch, the best first; of equals the first ones."""
    order, cost = np.empty(keep, np.int64), np.empty(keep, np.int64)
    count = 0
    for n in range(len(shifts)):
        limit = cost[keep - 1] if count == keep else LIMIT
        d = mismatch(picture, usable, seen, shifts[n, 0], shifts[n, 1], limit)
        if d == FAR or (count == keep and d >= limit):
            continue
        at = min(count, keep - 1)
        while at > 0 and cost[at - 1] > d:
            cost[at], order[at] = cost[at - 1], order[at - 1]
            at -= 1
        cost[at], order[at] = d, n
        count = min(count + 1, keep)
    return order[:count]


@kernel
def fill_gap(picture: Any, usable: Any, sides: Any, core: Any, t: Any, ty: int, tx: int) -> Any:
    """Cut a gap's block into its window by a min cut.

    Return which pixels of the window it owns, (h, w), and the exemplar pixels, (h, w, 2): owned ones may be taken from
    a neighbour. `sides` (h, w): the neighbour that a pixel of the overlap belongs to, or -1; `core` (h, w): the block;
    `t` (4, 2): the neighbours' shifts, `ty`, `tx` the gap's, relative to the window's first pixel.
    """
    h, w = core.shape
    channels = picture.shape[2]
    state = np.empty((h, w), np.uint8)
    old, new = np.zeros((h, w, channels), np.int16), np.zeros((h, w, channels), np.int16)
    take, owner, out = np.ones((h, w), np.uint8), np.empty((h, w), np.bool_), np.empty((h, w, 2), np.int64)
    for y in range(h):
        for x in range(w):
            side = sides[y, x]
            mine = readable(usable, y + ty, x + tx)
            theirs = side >= 0 and readable(usable, y + t[side, 0], x + t[side, 1])
            state[y, x] = NEW if core[y, x] else OLD
            if side >= 0 and mine and theirs:
                state[y, x] = state[y, x] if at_rim(sides, core, y, x) else FREE
                for c in range(channels):
                    old[y, x, c] = picture[y + t[side, 0], x + t[side, 1], c]
                    new[y, x, c] = picture[y + ty, x + tx, c]
            elif side >= 0:
                state[y, x] = NEW if mine and (core[y, x] or not theirs) else OLD
    right, down = seam_costs(old, new, PLAIN)
    min_cut(state, right, down, take)
    for y in range(h):
        for x in range(w):
            side = sides[y, x]
            owner[y, x] = core[y, x] or (side >= 0 and take[y, x])
            own = take[y, x] or side < 0
            out[y, x, 0], out[y, x, 1] = y + (ty if own else t[side, 0]), x + (tx if own else t[side, 1])
    return owner, out


@kernel
def readable(usable: Any, y: int, x: int) -> bool:
    """Return whether an exemplar pixel exists and is usable."""
    return bool(0 <= y < usable.shape[0] and 0 <= x < usable.shape[1] and usable[y, x])


@kernel
def at_rim(sides: Any, core: Any, y: int, x: int) -> bool:
    """Return whether a pixel of the overlap touches one outside of it, or, in the gap, another neighbour's overlap.

    Such pixels are fixed: if both kept their neighbours, these would meet along the mitre in a seam of no counted cost.
    """
    h, w = core.shape
    for k in range(4):
        a, b = y + (k == 0) - (k == 1), x + (k == 2) - (k == 3)
        if a < 0 or b < 0 or a >= h or b >= w or sides[a, b] < 0 or (core[y, x] and sides[a, b] != sides[y, x]):
            return True
    return False
