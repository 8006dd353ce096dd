"""What every two neighbouring pixels of a window cost, whichever of them a patch takes.

Much of it follows from the map alone and is read once for all patches that are tried in a window: what is shown, which
pixels stay, and where pieces meet. Between two pixels of one piece that goes on nothing is paid now, and the same
whichever of the two becomes new.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.cuts import STEEPEST
from ..kernels.jit import kernel
from ..kernels.windows import HOLE, canvas_place
from .energy_kernels import meeting, spot, through

OLD, FREE, NEW, ABSENT = 0, 1, 2, 3


@kernel
def look(
    grown: Any, locked: Any, pieces: Any, box: Any, target: Any, price: Any, step: int, old: Any, state: Any, paid: Any
) -> Any:
    """Read what a window shows, whatever patch is cut into it.

    Writes numbers of pixels into `old`, -1 in holes; what each pixel costs now with its right and lower neighbour into
    `paid` (2, h, w), where it is more than 0; and into `state` whether it stays, becomes new, may be either, or is left
    out. Holes of the `target` (first row and column in the window, rows, columns) become new, others are left out. A
    pixel stays where it is locked, and at the window's edge beside known pixels outside. Returns the pairs between
    which no piece goes on, (n, 5): row and column of the one, 1 if the other is the lower one, the pixel the one goes
    on with, the one before the other.
    """
    (variant, yx, wrap), table, channels = grown, pieces.table, pieces.channels
    (height, width), (h, w) = variant.shape, old.shape
    columns, shown, begins = np.empty(w, np.uint64), np.empty((3, h, w), np.int32), table[:, 0] // channels
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
    apart, counts = np.zeros((2, h, w), np.uint8), np.zeros((2, h), np.int64)
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
    joints, number = np.empty((counts.sum(), 5), np.int32), 0
    for k in range(2):
        for i in range(h):
            for j in range(w if counts[k, i] else 0):
                if apart[k, i, j]:
                    m, n = i + k, j + 1 - k
                    here, there = np.int64(old[i, j]), np.int64(old[m, n])
                    on = _beyond(pieces, shown[:, i, j], (k * step, step - k * step), here)
                    back = _beyond(pieces, shown[:, m, n], (-k * step, k * step - step), there)
                    if here >= 0 and there >= 0 and on != there:
                        paid[k, i, j] = meeting(pieces, (here, on), (back, there), price)
                    joint = joints[number]
                    joint[0], joint[1], joint[2], joint[3], joint[4] = i, j, k, on, back
                    number += 1
    return joints


@kernel
def _beyond(pieces: Any, shown: Any, way: Any, here: Any) -> Any:
    """The pixel with which the piece at pixel `here` goes on; its own where it does not, -1 where none is."""
    found = np.int64(-1)
    if here >= 0:
        y, x = shown[1] + way[0], shown[2] + way[1]
        found = np.int64(spot(pieces.table, pieces.usable, pieces.torus, pieces.channels, shown[0], y, x))
    return found if found >= 0 else here


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
def lay(pieces: Any, pick: Any, step: int, old: Any, seen: Any, new: Any, state: Any) -> None:
    """Write the numbers of the pixels that a patch shows into `new`, -1 where it does not reach.

    Writes what was `seen` (of :func:`look`) into `state`; where the patch does not reach, and beside, what is known
    stays, and holes are left out.
    """
    _, table, usable, torus, channels, _ = pieces
    (v, row, column), (h, w) = pick, new.shape
    begin, rows, columns = table[v, 0] // channels, table[v, 1], table[v, 2]
    missing = 0
    for i in range(h):
        y = row + i * step
        for j in range(w):
            x = column + j * step
            if 0 <= y < rows and 0 <= x < columns:
                place = begin + y * table[v, 3] + x
                new[i, j] = place if usable[place] else -1
            else:
                new[i, j] = spot(table, usable, torus, channels, v, y, x)
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
    """Write prices into `terms` (3, 2, h, w): of each pixel and its right, and its lower neighbour.

    First what is paid if both stay, which is there already; then if the second becomes new, then if the first does.
    """
    h, w = old.shape
    gap = np.zeros((h + 1, w + 1), np.int32)
    _measure_gaps(pieces.flat, pieces.channels, old, new, gap)
    knee, none = np.float64(max(price.knee, 1)), np.int32(0)
    for k in range(2):
        for i in range(h):
            one, two, first, second = gap[i], gap[i + k][1 - k :], terms[1, k, i], terms[2, k, i]
            end = w - 1 + k if i + k < h else 0
            for j in range(np.uint64(w)):
                cost = np.int32(one[j] + two[j]) if j < end else none
                if price.knee > 0:  # as :func:`sharpened` does
                    square = np.float64(cost) * np.float64(cost) / knee
                    cost = np.int32(STEEPEST * cost) if cost >= STEEPEST * price.knee else np.int32(square)
                first[j] = cost
                second[j] = cost
    if price.inside > 0:
        _mind_elements(pieces.inside, price, old, new, terms)
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
def _measure_gaps(flat: Any, channels: int, old: Any, new: Any, gap: Any) -> None:
    """Write into `gap` what ``feature_distance`` says of every pixel's two numbers; 0 where one is missing."""
    h, w = old.shape
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
            out[j] = root + (root * root < squares[j])


@kernel
def _mind_elements(inside: Any, price: Any, old: Any, new: Any, terms: Any) -> None:
    """Make the prices of pairs where pieces go on dearer inside elements, and cheaper at joints: see ``through``."""
    h, w = old.shape
    for k in range(2):
        for i in range(h - k):
            for j in range(w - 1 + k):
                m, n = i + k, j + 1 - k
                known = old[i, j] >= 0 and old[m, n] >= 0 and new[i, j] >= 0 and new[m, n] >= 0
                if known and old[i, j] != new[i, j]:
                    was, will = (old[i, j], old[m, n]), (new[i, j], new[m, n])
                    terms[1, k, i, j] = through(inside, was, will, terms[1, k, i, j], price)
                    terms[2, k, i, j] = through(inside, will, was, terms[2, k, i, j], price)
