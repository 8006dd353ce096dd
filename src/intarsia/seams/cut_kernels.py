"""Minimum cuts over existing seams (Kwatra et al. 2003, 3.1), by max flow on the pixel grid.

The old pixels of a window may belong to several pieces. Where two of these meet there is a seam already. Its cost is
paid unless the new patch covers it (Kwatra, Schoedl, Essa, Turk and Bobick, SIGGRAPH 2003, section 3.1). The paper adds
a node for every old seam, between its two pixels; here the same energy is expressed on the pixel grid itself:

* cost if both pixels stay old: a; only the left one becomes new: c; only the right one: b; both: 0;
* a part a1 = min(a, b) is a unary cost of the left pixel for staying old, the rest of a one of the right pixel; what
  remains of b and c are the capacities of two arcs. Where b + c < a, which a metric excludes but other costs do not,
  b + c is used in place of a to find the cut, as in the paper; the cost of the cut found is then summed with a.

Pieces are continued beyond their seams as the exemplar continues, so the cost of a seam follows from the map alone.
Where the exemplar ends, its last pixel is used in place of the next.

Much follows from the map alone and is read once for all patches that are tried in a window: which pixels it shows,
which of them must stay, and where pieces meet (joints). Between two pixels of one piece the old cost is 0, and the
costs of replacing only one or only the other are equal.
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
    """Read what a window of :func:`recut` shows, independent of the patch cut into it; return its joints.

    `old` (h, w): receives pixel numbers, -1 in holes. `paid` (2, h, w), zeros: receives the present seam cost of each
    pixel and its right, and its lower neighbour. `state` (h, w): receives NEW for holes to be filled, ABSENT for other
    holes, OLD for locked pixels and for pixels at the window's edge next to known pixels outside, FREE for the rest.

    Returns the joints, the pairs of neighbours of which the second does not continue the first in the exemplar (with
    gradient costs all pairs), (n, 5) int32: row and column of the first pixel; 0 if the second is its right neighbour,
    1 if its lower one; the number of the pixel that continues the first at the second; of that which continues the
    second at the first.
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
    """Return the joints of :func:`read_window` and write their costs; `shown` (3, h, w): variants, rows, columns."""
    h, w = old.shape
    joints, number = np.empty((2 * h * w, 5), np.int32), 0
    for k in range(2):
        down, right = np.int32(k * step), np.int32(step - k * step)
        for i in range(h - k):
            v, row, column = shown[0, i], shown[1, i], shown[2, i]
            u, y, x = shown[0, i + k][1 - k :], shown[1, i + k][1 - k :], shown[2, i + k][1 - k :]
            for j in range(w - 1 + k):
                leaps = (y[j] - row[j] != down) | (x[j] - column[j] != right) | price.gradient
                if (v[j] != u[j]) | ((v[j] != HOLE) & leaps):
                    m, n = i + k, j + 1 - k
                    here, there = np.int64(old[i, j]), np.int64(old[m, n])
                    on = beyond(pieces, shown[:, i, j], (k * step, step - k * step), here)
                    back = beyond(pieces, shown[:, m, n], (-k * step, k * step - step), there)
                    if here >= 0 and there >= 0 and on != there:
                        paid[k, i, j] = meeting(pieces, (here, on), (back, there), price)
                    joint = joints[number]
                    joint[0], joint[1], joint[2], joint[3], joint[4] = i, j, k, on, back
                    number += 1
    return joints[:number]


@kernel
def _keep_edges(grown: Any, box: Any, step: int, old: Any, state: Any) -> None:
    """Set `state` to OLD for known pixels at a window's edge next to known pixels outside the window."""
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

    Copies `seen`, the state from :func:`read_window`, into `state`. Where the patch does not extend, known pixels and
    their known neighbours become OLD, holes ABSENT.
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

    ``terms[0]``: the costs if both stay old, which is there already; ``terms[1]``: if only the second pixel of a pair
    becomes new; ``terms[2]``: if only the first does.
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
            continue  # neither pixel can become new, so these terms are never used
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


NEVER = 1 << 60  # reported as the cost of a cut whose computation was given up


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
    """Return the change of the energy by the best cut of a patch in a window; NEVER if it is at least `limit`.

    `read`: the joints, pixel numbers, states and terms from :func:`read_window`. The cut is written into `out`.
    """
    (price, usage), (joints, old, seen, terms) = prices, read
    new, state, most = np.empty(old.shape, np.int32), np.empty(old.shape, np.uint8), np.int64(MOST)
    place_patch(pieces, pick, step, old, seen, new, state)
    price_all(pieces, price, joints, old, new, state, terms)
    used, sure = usage.rate.size > 0, np.int64(0)
    more = np.empty(old.shape if used else (0, 0), np.int64)
    if used:
        sure = price_usage(usage, step, old, new, state, more)
    if limit < NEVER:
        most = np.int64(limit) - sure  # bound of the flow, above which the change of the energy reaches the limit
        for number in range(len(joints)):
            most += terms[0, joints[number, 2], joints[number, 0], joints[number, 1]]
    if not least_cut(state, terms, more, out, most):
        return NEVER
    return cut_change(terms, out) + (np.sum(more * out) if used else 0)


@kernel
def recut(
    grown: Any, locked: Any, pieces: Any, windows: Any, picks: Any, prices: Any, step: int, take: Any, best: Any
) -> None:
    """Compute the cuts of alternative patches in windows of the map, over existing seams, and report the best one.

    The map does not change.

    Parameters
    ----------
    windows : (n, 8) int64
        For each patch the window's first row and column (inside the canvas, or over a border that wraps), its rows and
        columns, and the same four numbers of the part in which holes are filled, relative to the window's first
        pixel. Consecutive equal windows are read once.
    picks : (n, 4) int64
        For each patch its number, by which ties are broken; variant, row and column of the pixel shown at the window's
        first pixel, which may lie outside the variant.
    prices : pair
        The seam cost (:class:`~intarsia.kernels.cuts.SeamPrice`) and the :class:`.occurrence_kernels.Usage`.
    step : int
        Every `step`-th pixel along both axes is sampled.
    take : uint8 array, sampled rows and columns, or (0, 0)
        Receives 1 where the best patch replaces the map, unless it is empty.
    best : (2,) int64
        On entry a bound of the change, and a number for ties; on return, if a patch is better, the change of the energy
        and the number of the best one. Negative changes lower the energy.
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
            limit = best[0] + (number < best[1])  # of equal changes that of the lowest number is kept
            change = _cut_in(pieces, pick, prices, step, limit, (joints, old, seen, terms), out)
            if change < limit:
                best[0], best[1] = change, number
                if take.size:
                    take[:] = out
            k += 1


@kernel
def write_cut(grown: Any, pieces: Any, usage: Any, box: Any, pick: Any, take: Any) -> None:
    """Write the pixels of a patch where `take` is 1 into the map, and update their occurrences.

    `box`: first row and column of the window. `pick`: variant, row and column shown at its first pixel.
    """
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
