"""Kernels of block assembly: phases, the ring around a gap, the best block for a gap, its cut."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..foundation.geometry import UNIT
from ..kernels.cuts import PLAIN, min_cut, seam_costs
from ..kernels.jit import kernel
from ..kernels.maxflow import FREE, NEW, OLD

FAR = np.int64(1) << 60
LIMIT = np.int64(1) << 32  # above any mismatch


@kernel
def add_phase_costs(picture: Any, shift: Any, border: int, period: float, total: Any, count: Any) -> None:
    """Add, for every row, the cost of the cheapest path along a band of `border` rows around it.

    The cost of a pixel is the distance (1/16 units) between the picture (H, W, C) and itself shifted by `shift`.
    Row y counts for phase floor(y mod period); `total`, `count` (ceil(period),) int64.
    """
    height, width, channels = picture.shape
    y0, x0 = max(0, -shift[0]), max(0, -shift[1])
    y1, x1 = min(height, height - shift[0]), min(width, width - shift[1])
    rows, columns = y1 - y0, x1 - x0
    if rows < border or columns < 8:
        return
    cost = np.empty((rows, columns), np.int32)
    for y in range(rows):
        for x in range(columns):
            s = 0
            for c in range(channels):
                d = int(picture[y0 + y, x0 + x, c]) - int(picture[y0 + y + shift[0], x0 + x + shift[1], c])
                s += d * d
            cost[y, x] = int(16.0 * np.sqrt(np.float64(s)))
    here, last = np.empty(border, np.int64), np.empty(border, np.int64)
    for top in range(rows - border + 1):
        for k in range(border):
            last[k] = cost[top + k, 0]
        for x in range(1, columns):
            for k in range(border):
                best = last[k]
                if k > 0 and last[k - 1] < best:
                    best = last[k - 1]
                if k + 1 < border and last[k + 1] < best:
                    best = last[k + 1]
                here[k] = best + cost[top + k, x]
            for k in range(border):
                last[k] = here[k]
        best = last[0]
        for k in range(1, border):
            best = min(best, last[k])
        phase = int((y0 + top + border // 2) % period)
        total[phase] += best // columns
        count[phase] += 1


@kernel
def all_usable(places: Any, sides: Any, valid: Any) -> Any:
    """Say of every place (n, 2) whether the block spanned by `sides` (2, 2) covers usable pixels only."""
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
def nearest_side(a: float, b: float, down: float, across: float) -> Any:
    """Of a pixel (a, b) px from a block's upper and left edge: which neighbour it lies towards, and how deep.

    `down`, `across`: the block's size across these edges. Returns (side, depth): sides 0 up, 1 down, 2 left,
    3 right; depth in px, positive inside the block, negative in the neighbour; side -1 for what belongs to none
    of the four (a corner, or nearer to another edge of the neighbour): the wedges are mitred.
    """
    if 0 <= a < down and 0 <= b < across:
        side, depth = 0, a
        if down - a < depth:
            side, depth = 1, down - a
        if b < depth:
            side, depth = 2, b
        if across - b < depth:
            side, depth = 3, across - b
        return side, depth
    if 0 <= b < across and (a < 0 or a >= down):
        out = -a if a < 0 else a - down
        if out <= b and out <= across - b and out <= down / 2:
            return (0 if a < 0 else 1), -out
    elif 0 <= a < down:
        out = -b if b < 0 else b - across
        if out < a and out < down - a and out <= across / 2:
            return (2 if b < 0 else 3), -out
    return -1, 0.0


@kernel
def ring(frame: Any, half: float, sides: Any, core: Any) -> None:
    """Describe the window of a gap: `sides` (h, w) int8, the neighbour that a pixel of the seam zone lies
    towards or -1; `core` (h, w): 1 inside the gap.

    `frame` (8,): block sides (rows, columns; dy, dx) and corner in 1/256 px, relative to the window's first
    pixel; `half`: half the border, px.
    """
    h, w = core.shape
    determinant = float(frame[0] * frame[3] - frame[1] * frame[2])
    down = determinant / np.sqrt(float(frame[2]) ** 2 + float(frame[3]) ** 2) / UNIT
    across = determinant / np.sqrt(float(frame[0]) ** 2 + float(frame[1]) ** 2) / UNIT
    for y in range(h):
        for x in range(w):
            dy, dx = y * UNIT - frame[4], x * UNIT - frame[5]
            a = float(dy * frame[3] - dx * frame[2]) / determinant * down
            b = float(dx * frame[0] - dy * frame[1]) / determinant * across
            core[y, x] = 0 <= a < down and 0 <= b < across
            side, depth = nearest_side(a, b, down, across)
            sides[y, x] = side if abs(depth) < half and side >= 0 else -1


@kernel
def neighbours_of(picture: Any, usable: Any, zone: Any, t: Any, step: int) -> Any:
    """What the neighbours of a gap show in every `step`-th pixel of its seam zone: places (n, 2), values (n, C).

    `zone` (m, 3): rows, columns, side of the seam zone's pixels (canvas px relative to the window); `t` (4, 2):
    the neighbours' shifts. Pixels that a neighbour cannot show are left out.
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
    return places[:n], values[:n]


@kernel
def mismatch(picture: Any, usable: Any, places: Any, values: Any, sampled: int, ty: int, tx: int, limit: Any) -> Any:
    """Mean squared difference (1/16 units) around a gap, if it is filled with shift (ty, tx).

    `places`, `values`: as :func:`neighbours_of` makes them of `sampled` pixels. Those without a source here do not
    count; FAR where fewer than half have both sources, or where the mean is above `limit` for certain.
    """
    height, width = usable.shape
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
    """Say whether a block can be read whole at shift (ty, tx)."""
    for y in range(core.shape[0]):
        for x in range(core.shape[1]):
            if core[y, x] and not readable(usable, y + ty, x + tx):
                return False
    return True


@kernel
def best_fits(
    picture: Any, usable: Any, core: Any, zone: Any, t: Any, shifts: Any, tolerance: int, keep: int
) -> Any:
    """Find the best shifts for a gap, at most `keep`: mismatch, shift, (n, 3).

    All `shifts` (n, 2) are compared on a part of the zone, the best `keep` then moved by up to `tolerance` px.
    """
    coarse, out = max(1, len(zone) // 300), np.empty((keep, 3), np.int64)
    fine = max(1, len(zone) // 1200)
    rough, rough_values = neighbours_of(picture, usable, zone, t, coarse)
    places, values = neighbours_of(picture, usable, zone, t, fine)
    few, many = -(-len(zone) // coarse), -(-len(zone) // fine)
    first = best_shifts(picture, usable, rough, rough_values, few, shifts, keep)
    count = 0
    for k in range(len(first)):
        y, x = shifts[first[k], 0], shifts[first[k], 1]
        best, by, bx = mismatch(picture, usable, rough, rough_values, few, y, x, LIMIT), y, x
        for dy in range(-tolerance, tolerance + 1):
            for dx in range(-tolerance, tolerance + 1):
                d = mismatch(picture, usable, rough, rough_values, few, y + dy, x + dx, best)
                if d < best or (d == best and abs(dy) + abs(dx) < abs(by - y) + abs(bx - x)):
                    best, by, bx = d, y + dy, x + dx
        if not covers(usable, core, by, bx):
            by, bx = y, x
            if not covers(usable, core, by, bx):
                continue
        out[count, 0] = mismatch(picture, usable, places, values, many, by, bx, LIMIT)
        out[count, 1], out[count, 2] = by, bx
        count += 1
    return out[:count]


@kernel
def best_shifts(picture: Any, usable: Any, places: Any, values: Any, sampled: int, shifts: Any, keep: int) -> Any:
    """The numbers of the `keep` shifts with the least mismatch, the best first; of equals the first ones."""
    order, cost = np.empty(keep, np.int64), np.empty(keep, np.int64)
    count = 0
    for n in range(len(shifts)):
        limit = cost[keep - 1] if count == keep else LIMIT
        d = mismatch(picture, usable, places, values, sampled, shifts[n, 0], shifts[n, 1], limit)
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
    """Cut a gap's block into its window: what the gap decides, (h, w), and the exemplar pixels shown there, (h, w, 2).

    `sides`, `core`: as :func:`ring` makes them; `t` (4, 2): the neighbours' shifts, `ty`, `tx` the gap's, relative to
    the window's first pixel.
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
    """Say whether an exemplar pixel exists and may be used."""
    return bool(0 <= y < usable.shape[0] and 0 <= x < usable.shape[1] and usable[y, x])


@kernel
def at_rim(sides: Any, core: Any, y: int, x: int) -> bool:
    """Say whether a pixel of the seam zone touches what is not in the zone.

    Or, inside the gap, what lies towards another neighbour: if both stayed, these two would meet along the mitre in a
    seam that no cut counts.
    """
    h, w = core.shape
    for k in range(4):
        a, b = y + (k == 0) - (k == 1), x + (k == 2) - (k == 3)
        if a < 0 or b < 0 or a >= h or b >= w or sides[a, b] < 0 or (core[y, x] and sides[a, b] != sides[y, x]):
            return True
    return False
