"""Minimum cuts over existing seams (Kwatra et al. 2003, 3.1), by max flow on the pixel grid.

The old pixels of a window may be of several pieces. Where two of them meet there is a seam already, with a price of
its own, which is paid unless the new patch covers it (Kwatra, Schoedl, Essa, Turk and Bobick, SIGGRAPH 2003, 3.1).
The paper gives every old seam a node between its two pixels; here the same energy is laid on the grid itself:

* both pixels stay: the old price a; only the left one becomes new: c; only the right one: b; both: nothing;
* a part a1 = min(a, b) of the price is paid by the left pixel for staying, the rest by the right one, and what
  remains of b and c are two arcs. Where b + c < a, which no distance allows, but other prices do, a counts as b + c
  in the choice of the cut, as in the paper; what the cut then costs is added up as it is.

Pieces are read as they go on in their exemplar, so what a seam costs follows from the map alone. Where a piece does
not go on, its last pixel stands for what would be there.

What every two neighbouring pixels of a window cost, whichever of them a patch takes.

Much of it follows from the map alone and is read once for all patches that are tried in a window: what is shown, which
pixels stay, and where pieces meet. Between two pixels of one piece that goes on nothing is paid now, and the same
whichever of the two becomes new.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.cuts import STEEPEST
from ..kernels.jit import kernel
from ..kernels.maps import HOLE, canvas_place
from ..kernels.maxflow import ABSENT, FREE, MOST, NEW, OLD, least_cut
from .energy_kernels import TWICE, beyond, meeting, source_at, spot
from .occurrence_kernels import price_usage


@kernel
def read_window(
    grown: Any, locked: Any, pieces: Any, window: Any, price: Any, step: int, old: Any, state: Any, paid: Any
) -> Any:
    """Read what a window of :func:`recut` shows, independent of the patch cut into it.

    Writes numbers of pixels into `old`, -1 in holes; what each pixel costs now with its right and lower neighbour into
    `paid` (2, h, w), where it is more than 0; and into `state` whether it stays, becomes new, may be either, or is left
    out. Holes that are to be filled become new, others are left out. A pixel stays where it is locked, and at the
    window's edge beside known pixels outside. Returns the pairs between which no piece goes on, (n, 5): row and column
    of the one, 1 if the other is the lower one, the pixel the one goes on with, the one before the other.
    """
    (variant, yx, wrap), table, channels = grown, pieces.table, pieces.channels
    (height, width), (h, w), box, target = variant.shape, old.shape, window[:4], window[4:]
    columns, shown, begins = np.empty(w, np.uint64), np.empty((3, h, w), np.int32), np.empty(len(table), np.int64)
    for k in range(len(table)):
        begins[k] = table[k, 0] // channels
    for j in range(w):
        columns[j] = canvas_place(box[1] + j * step, width, wrap[1])
    for i in range(h):
        y = canvas_place(box[0] + i * step, height, wrap[0])
        line, at, guard, numbers, states = variant[y], yx[y], locked[y], old[i], state[i]
        v, row, column = shown[0, i], shown[1, i], shown[2, i]
        near = 0 <= i * step - target[0] < target[2]
        for j in range(np.uint64(w)):
            x = columns[j]
            v[j], row[j], column[j] = line[x], at[x, 0], at[x, 1]
            if v[j] == HOLE:
                inside = near and 0 <= np.int64(j) * step - target[1] < target[3]
                numbers[j], states[j] = -1, NEW if inside else ABSENT
            else:
                piece = np.uint64(v[j])
                numbers[j] = begins[piece] + row[j] * table[piece, 3] + column[j]
                states[j] = OLD if guard[x] else FREE
    _keep_edges(grown, box, step, old, state)
    return _find_joints(pieces, price, step, shown, old, paid)


@kernel
def _find_joints(pieces: Any, price: Any, step: int, shown: Any, old: Any, paid: Any) -> Any:
    """List the pairs between which no piece goes on, and price them; `shown` (3, h, w): variants, rows and columns."""
    h, w = old.shape
    apart, counts, total = np.zeros((2, h, w), np.uint8), np.zeros((2, h), np.int64), 0
    for k in range(2):
        down, right = np.int32(k * step), np.int32(step - k * step)
        for i in range(h - k):
            v, row, column, out = shown[0, i], shown[1, i], shown[2, i], apart[k, i]
            u, y, x = shown[0, i + k][1 - k :], shown[1, i + k][1 - k :], shown[2, i + k][1 - k :]
            count = 0
            for j in range(np.uint64(w - 1 + k)):
                leaps = (y[j] - row[j] != down) | (x[j] - column[j] != right) | price.gradient
                out[j] = (v[j] != u[j]) | ((v[j] != HOLE) & leaps)
                count += out[j]
            counts[k, i] = count
            total += count
    joints, number = np.empty((total, 5), np.int32), 0
    for k in range(2):
        for i in range(h):
            for j in range(w if counts[k, i] else 0):
                if apart[k, i, j]:
                    m, n = i + k, j + 1 - k
                    here, there = np.int64(old[i, j]), np.int64(old[m, n])
                    on = beyond(pieces, shown[:, i, j], (k * step, step - k * step), here)
                    back = beyond(pieces, shown[:, m, n], (-k * step, k * step - step), there)
                    if here >= 0 and there >= 0 and on != there:
                        paid[k, i, j] = meeting(pieces, (here, on), (back, there), price)
                    joint = joints[number]
                    joint[0], joint[1], joint[2], joint[3], joint[4] = i, j, k, on, back
                    number += 1
    return joints


@kernel
def _keep_edges(grown: Any, box: Any, step: int, old: Any, state: Any) -> None:
    """Let the known pixels at a window's edge stay that lie beside known ones outside."""
    variant, wrap = grown.variant, grown.wrap
    (height, width), (h, w) = variant.shape, old.shape
    for i in range(h):
        for j in range(0, w, 1 if i == 0 or i == h - 1 else max(w - 1, 1)):
            for k in range(4):
                a, b = i + (k == 0) - (k == 1), j + (k == 2) - (k == 3)
                if old[i, j] < 0 or (0 <= a < h and 0 <= b < w):
                    continue
                y = canvas_place(box[0] + a * step, height, wrap[0])
                x = canvas_place(box[1] + b * step, width, wrap[1])
                if y >= 0 and x >= 0 and variant[y, x] != HOLE:
                    state[i, j] = OLD


@kernel
def place_patch(pieces: Any, pick: Any, step: int, old: Any, seen: Any, new: Any, state: Any) -> None:
    """Write the numbers of the pixels that a patch shows into `new`, -1 where it does not reach.

    Writes what was `seen` (of :func:`look`) into `state`; where the patch does not reach, and beside, what is known
    stays, and holes are left out.
    """
    table, usable = pieces.table, pieces.usable
    (v, row, column), (h, w) = pick, new.shape
    begin, rows, columns = table[v, 0] // pieces.channels, table[v, 1], table[v, 2]
    missing = 0
    for i in range(h):
        y = row + i * step
        for j in range(w):
            x = column + j * step
            if 0 <= y < rows and 0 <= x < columns:
                place = begin + y * table[v, 3] + x
                new[i, j] = place if usable[place] else -1
            else:
                new[i, j] = spot(pieces, v, y, x)
            missing += new[i, j] < 0
            state[i, j] = seen[i, j]
    for i in range(h if missing else 0):
        for j in range(w):
            if new[i, j] >= 0:
                continue
            state[i, j] = ABSENT if old[i, j] < 0 else OLD
            for k in range(4 if old[i, j] >= 0 else 0):
                a, b = i + (k == 0) - (k == 1), j + (k == 2) - (k == 3)
                if 0 <= a < h and 0 <= b < w and old[a, b] >= 0:
                    state[a, b] = OLD


@kernel
def price_all(pieces: Any, price: Any, joints: Any, old: Any, new: Any, state: Any, terms: Any) -> None:
    """Write seam costs into `terms` (3, 2, h, w): of each pixel and its right, and its lower neighbour.

    First what is paid if both stay, which is there already; then if the second becomes new, then if the first does.
    """
    h, w = old.shape
    gap = np.zeros((h + 1, w + 1), np.int32)
    _measure_gaps(pieces, old, new, gap)
    knee, none = np.float64(max(price.threshold, 1)), np.int32(0)
    for k in range(2):
        for i in range(h):
            one, two, first, second = gap[i], gap[i + k][1 - k :], terms[1, k, i], terms[2, k, i]
            end = w - 1 + k if i + k < h else 0
            for j in range(np.uint64(w)):
                cost = np.int32(one[j] + two[j]) if j < end else none
                if price.threshold > 0:  # as :func:`truncated_quadratic` does
                    square = np.float64(cost) * np.float64(cost) / knee
                    cost = np.int32(STEEPEST * cost) if cost >= STEEPEST * price.threshold else np.int32(square)
                first[j] = cost
                second[j] = cost
    for number in range(len(joints)):
        i, j, k, on, back = joints[number]
        m, n = i + k, j + 1 - k
        terms[1, k, i, j], terms[2, k, i, j] = 0, 0
        fresh, next_ = new[i, j], new[m, n]
        if state[i, j] == ABSENT or state[m, n] == ABSENT or (fresh < 0 and next_ < 0):
            continue  # neither can change: what that would cost is never paid
        fresh, next_ = fresh if fresh >= 0 else next_, next_ if next_ >= 0 else fresh
        if old[i, j] >= 0:
            terms[1, k, i, j] = meeting(pieces, (old[i, j], on), (fresh, next_), price)
        if old[m, n] >= 0:
            terms[2, k, i, j] = meeting(pieces, (fresh, next_), (back, old[m, n]), price)


@kernel
def _measure_gaps(pieces: Any, old: Any, new: Any, gap: Any) -> None:
    """Write ``seen_distance`` of every pixel's old and new number into `gap`; 0 where one is missing."""
    (h, w), flat, channels, visible = old.shape, pieces.flat, pieces.channels, pieces.visible
    squares = np.zeros(w, np.int64)
    for i in range(h):
        a, b, out = old[i], new[i], gap[i]
        for j in range(np.uint64(w)):
            total = np.int64(0)
            if a[j] >= 0 and b[j] >= 0:
                here, there = np.uint64(a[j]) * np.uint64(channels), np.uint64(b[j]) * np.uint64(channels)
                for c in range(np.uint64(channels)):
                    difference = np.int64(flat[here + c]) - np.int64(flat[there + c])
                    total += difference * difference
            squares[j] = total
        for j in range(np.uint64(w)):
            root = np.int64(np.sqrt(np.float64(squares[j])))
            root += root * root < squares[j]
            out[j] = root * (np.int64(visible[a[j]]) + np.int64(visible[b[j]])) >> TWICE if root else 0


NEVER = 1 << 60  # what a cut is said to cost that was given up


@kernel
def cut_change(terms: Any, out: Any) -> Any:
    """Return the change of a window's seam costs when the pixels in `out` are replaced."""
    h, w = out.shape
    total = np.int64(0)
    for k in range(2):
        for i in range(h - k):
            a, b, c, one, two = terms[0, k, i], terms[1, k, i], terms[2, k, i], out[i], out[i + k][1 - k :]
            for j in range(np.uint64(w - 1 + k)):
                if one[j] != two[j]:
                    total += (c[j] if one[j] else b[j]) - a[j]
                elif one[j]:
                    total -= a[j]
    return total


@kernel
def _cut_in(
    pieces: Any, pick: Any, prices: Any, step: int, limit: Any, read: Any, out: Any
) -> Any:
    """Cut a patch into what :func:`look` read of a window; see :func:`recut`. NEVER if it is given up."""
    (price, usage), (joints, old, seen, terms) = prices, read
    new, state, most = np.empty(old.shape, np.int32), np.empty(old.shape, np.uint8), np.int64(MOST)
    place_patch(pieces, pick, step, old, seen, new, state)
    price_all(pieces, price, joints, old, new, state, terms)
    used, sure = usage.rate.size > 0, np.int64(0)
    more = np.empty(old.shape if used else (0, 0), np.int64)
    if used:
        sure = price_usage(usage, step, old, new, state, more)
    if limit < NEVER:
        most = np.int64(limit) - sure  # at least what flows will be paid, in place of what is paid now
        for number in range(len(joints)):
            most += terms[0, joints[number, 2], joints[number, 0], joints[number, 1]]
    if not least_cut(state, terms, more, out, most):
        return NEVER
    return cut_change(terms, out) + (np.sum(more * out) if used else 0)


@kernel
def recut(
    grown: Any, locked: Any, pieces: Any, windows: Any, picks: Any, prices: Any, step: int, take: Any, best: Any
) -> None:
    """Cut patches into windows of the map, one instead of another, old seams remembered, and note the best.

    `windows` (n, 8): of each patch the window's first row and column (inside the canvas, or over a border that wraps),
    rows and columns, and those of what is to be filled, from the window's first pixel; what equal ones in a row show is
    read once. `picks` (n, 4): its number, by which ties are settled, variant, row and column of the pixel shown at the
    window's first pixel, which may lie outside the variant.
    Of every `step`-th px of the best's window `take`, unless it has no size, says whether it is taken. `best` (2,): by
    how much the seams become dearer, negative where a patch covers seams that cost more than its own, and the number of
    the patch; what does not better it is given up, and it stays. `prices`: of seams, and of what is shown already,
    which is part of that.
    """
    k = 0
    while k < len(picks):
        window = windows[k]
        h, w = -(-window[2] // step), -(-window[3] // step)
        old, seen, out = np.empty((h, w), np.int32), np.empty((h, w), np.uint8), np.empty((h, w), np.uint8)
        terms = np.zeros((3, 2, h, w), np.int32)
        joints = read_window(grown, locked, pieces, window, prices[0], step, old, seen, terms[0])
        while k < len(picks) and (windows[k] == window).all():
            number, pick = picks[k, 0], (picks[k, 1], picks[k, 2], picks[k, 3])
            limit = best[0] + (number < best[1])  # of two that cost as much the first is taken
            change = _cut_in(pieces, pick, prices, step, limit, (joints, old, seen, terms), out)
            if change < limit:
                best[0], best[1] = change, number
                if take.size:
                    take[:] = out
            k += 1


@kernel
def write_cut(grown: Any, pieces: Any, usage: Any, box: Any, pick: Any, take: Any) -> None:
    """Write the pixels `take` of a patch into the map, and count them; `box` and `pick` as in :func:`recut`."""
    (variant, yx, wrap), table, (height, width) = grown, pieces.table, grown.variant.shape
    v, rows, columns = pick[0], table[pick[0], 1], table[pick[0], 2]
    begin = table[v, 0] // pieces.channels
    for i in range(take.shape[0]):
        y, row = canvas_place(box[0] + i, height, wrap[0]), (pick[1] + i) % rows
        for j in range(take.shape[1]):
            if take[i, j]:
                x, column = canvas_place(box[1] + j, width, wrap[1]), (pick[2] + j) % columns
                old = source_at(grown, pieces, y, x)
                if old >= 0:
                    usage.shown[usage.origin[old]] -= 1
                usage.shown[usage.origin[begin + row * table[v, 3] + column]] += 1
                variant[y, x], yx[y, x, 0], yx[y, x, 1] = v, row, column
