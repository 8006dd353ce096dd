"""Cuts that remember old seams: a new patch may run over them, and so replace the bad ones.

The old pixels of a window may be of several pieces. Where two of them meet there is a seam already, with a price of
its own, which is paid unless the new patch covers it (Kwatra, Schoedl, Essa, Turk and Bobick, SIGGRAPH 2003, 3.1).
The paper gives every old seam a node between its two pixels; here the same energy is laid on the grid itself:

* both pixels stay: the old price a; only the left one becomes new: c; only the right one: b; both: nothing;
* a part a1 = min(a, b) of the price is paid by the left pixel for staying, the rest by the right one, and what
  remains of b and c are two arcs. Where b + c < a, which no distance allows, but other prices do, a counts as b + c
  in the choice of the cut, as in the paper; what the cut then costs is added up as it is.

Pieces are read as they go on in their exemplar, so what a seam costs follows from the map alone. Where a piece does
not go on, its last pixel stands for what would be there.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.cuts import sharpened
from ..kernels.jit import kernel
from ..kernels.maxflow import push_flow
from ..kernels.windows import HOLE, canvas_place
from .energy_kernels import feature_distance, meeting, spot, through

OLD, FREE, NEW, ABSENT = 0, 1, 2, 3


class Draft(NamedTuple):
    """What a cut is drawn on, and what it says: of every `step`-th px of a window, as many rows and columns."""

    step: int
    saved: NDArray[np.int32]  # what staying costs each besides its seams
    take: NDArray[np.uint8]  # the answer: 1 where the patch is taken


@kernel
def fix(grown: Any, locked: Any, box: Any, target: Any, step: int, old: Any, new: Any, state: Any) -> None:
    """Say of every pixel of a window whether it stays, becomes new, may be either, or is left out.

    Holes of the `target` (first row and column in the window, rows, columns) become new, others are left out. A
    pixel stays where it is locked, where the patch does not reach, or does not reach a known neighbour, and at the
    window's edge beside known pixels outside.
    """
    variant, wrap = grown.variant, grown.wrap
    height, width = variant.shape
    h, w = old.shape
    for i in range(h):
        y = canvas_place(box[0] + i * step, height, wrap[0])
        for j in range(w):
            x = canvas_place(box[1] + j * step, width, wrap[1])
            if old[i, j] < 0:
                inside = 0 <= i * step - target[0] < target[2] and 0 <= j * step - target[1] < target[3]
                state[i, j] = NEW if inside and new[i, j] >= 0 else ABSENT
                continue
            state[i, j] = OLD if locked[y, x] or new[i, j] < 0 else FREE
            for k in range(4):
                a, b = i + (k == 0) - (k == 1), j + (k == 2) - (k == 3)
                if 0 <= a < h and 0 <= b < w:
                    if old[a, b] >= 0 and new[a, b] < 0:
                        state[i, j] = OLD
                    continue
                ny = canvas_place(box[0] + a * step, height, wrap[0])
                nx = canvas_place(box[1] + b * step, width, wrap[1])
                if ny >= 0 and nx >= 0 and variant[ny, nx] != HOLE:
                    state[i, j] = OLD


@kernel
def pair_terms(
    pieces: Any, source: Any, price: Any, step: int, old: Any, new: Any, state: Any, terms: Any
) -> None:  # fmt: skip
    """Write into `terms` (h, w, 2, 3) the prices (a, b, c) of each pixel and its right and lower neighbour.

    a: both stay, b: the second becomes new, c: the first does. 0 beside pixels that are left out. `source` (h, w, 3):
    variant, row and column that the window shows.
    """
    flat, channels = pieces.flat, pieces.channels
    h, w = old.shape
    gap = np.empty((h, w), np.int32)
    for i in range(h):
        for j in range(w):
            both = old[i, j] >= 0 and new[i, j] >= 0
            gap[i, j] = feature_distance(flat, channels, old[i, j], new[i, j]) if both else -1
    smooth = not price.gradient
    for k in range(2):
        down, right = k * step, step - k * step
        for i in range(h):
            for j in range(w):
                m, n = i + k, j + 1 - k
                a, b, c = 0, 0, 0
                if m < h and n < w and state[i, j] != ABSENT and state[m, n] != ABSENT:
                    known = smooth and gap[i, j] >= 0 and gap[m, n] >= 0 and source[i, j, 0] == source[m, n, 0]
                    goes_on = source[i, j, 1] + down == source[m, n, 1] and source[i, j, 2] + right == source[m, n, 2]
                    if known and goes_on:
                        b = gap[i, j] + gap[m, n]
                        b = c = sharpened(b, price.knee) if price.knee > 0 else b
                        if price.inside > 0 and old[i, j] != new[i, j]:
                            was, will = (old[i, j], old[m, n]), (new[i, j], new[m, n])
                            b = through(pieces.inside, was, will, b, price)
                            c = through(pieces.inside, will, was, c, price)
                    else:
                        a, b, c = _three(
                            pieces, source[i, j], source[m, n], (down, right), old[i, j], old[m, n], new[i, j],
                            new[m, n], price,
                        )  # fmt: skip
                terms[i, j, k, 0], terms[i, j, k, 1], terms[i, j, k, 2] = a, b, c


@kernel
def _three(
    pieces: Any, one: Any, two: Any, way: Any, here: int, there: int, fresh: int, next_: int, price: Any
) -> tuple[int, int, int]:
    """The prices of one pair wherever a seam, a hole or the end of the patch is near."""
    _, table, usable, torus, channels, _ = pieces
    on, back = here, there  # where a piece does not go on its last pixel stands for what would be there
    if here >= 0:
        found = spot(table, usable, torus, channels, one[0], one[1] + way[0], one[2] + way[1])
        on = found if found >= 0 else on
    if there >= 0:
        found = spot(table, usable, torus, channels, two[0], two[1] - way[0], two[2] - way[1])
        back = found if found >= 0 else back
    a, b, c = 0, 0, 0
    if here >= 0 and there >= 0 and on != there:
        a = meeting(pieces, (here, on), (back, there), price)
    if fresh < 0 and next_ < 0:
        return a, 0, 0  # neither can change: b and c are never paid
    if fresh < 0:
        fresh = next_
    if next_ < 0:
        next_ = fresh
    if here >= 0:
        b = meeting(pieces, (here, on), (fresh, next_), price)
    if there >= 0:
        c = meeting(pieces, (fresh, next_), (back, there), price)
    return a, b, c


@kernel
def least_cut(state: Any, terms: Any, saved: Any, out: Any) -> None:
    """Choose between old and new for every pixel so that the terms of :func:`pair_terms` add up to the least.

    `saved` (h, w): what each pixel costs besides if it stays, where that is more than nothing.
    Of several such choices `out` (1 = new) is the one with the fewest old pixels. Where nothing must stay, all
    becomes new.
    """
    h, w = state.shape
    kept = 0
    for i in range(h):
        for j in range(w):
            kept += state[i, j] == OLD
            out[i, j] = state[i, j] != ABSENT
    if kept == 0:
        return
    stride = w + 2
    size = (h + 2) * stride
    kind = np.full(size, FREE, np.uint8)
    room = np.zeros(4 * size, np.int32)
    excess = np.zeros(size, np.int64)
    for i in range(h):
        for j in range(w):
            p = (i + 1) * stride + j + 1
            if state[i, j] != ABSENT:
                kind[p] = state[i, j]
            if state[i, j] == FREE and saved[i, j] > 0:
                excess[p] += saved[i, j]
            for k in range(2):
                m, n = i + k, j + 1 - k
                if m >= h or n >= w or (state[i, j] != FREE and state[m, n] != FREE):
                    continue  # what neither can change is no arc
                q = p + 1 if k == 0 else p + stride
                a, b, c = terms[i, j, k]
                mine = min(a, b)
                rest = min(a - mine, c)
                excess[p] += mine
                excess[q] += rest
                room[4 * p + 2 * k] = c - rest
                room[4 * q + 2 * k + 1] = b - mine
    level = push_flow(kind, room, excess, stride)
    for i in range(h):
        for j in range(w):
            p = (i + 1) * stride + j + 1
            out[i, j] = 1 if level[p] >= size and state[i, j] != ABSENT else 0


@kernel
def cut_change(terms: Any, out: Any) -> int:
    """Return by how much the seams of a window become dearer if what `out` says is replaced."""
    h, w = out.shape
    total = 0
    for i in range(h):
        for j in range(w):
            for k in range(2):
                m, n = i + k, j + 1 - k
                if m >= h or n >= w:
                    continue
                a, b, c = terms[i, j, k]
                if out[i, j] == 0 and out[m, n] == 1:
                    total += b - a
                elif out[i, j] == 1 and out[m, n] == 0:
                    total += c - a
                elif out[i, j] == 1:
                    total -= a
    return total


@kernel
def recut(
    grown: Any, locked: Any, pieces: Any, box: Any, target: Any, pick: Any, price: Any, draft: Any
) -> int:
    """Cut a patch into a window of the map, old seams remembered: which pixels to take, and what it costs.

    `box`: the window's first row and column (inside the canvas, or over a border that wraps), rows and columns;
    `pick`: variant, row and column of the pixel shown at its first pixel, which may lie outside the variant. Returns
    by how much the seams become dearer; negative where the patch covers seams that cost more than its own. What is
    saved by leaving, of the `draft`, draws the cut, and is not in what is returned.
    """
    step, saved, out = draft
    h, w = out.shape
    (variant, yx, wrap), (_, table, usable, torus, channels, _) = grown, pieces
    height, width = variant.shape
    old, new = np.empty((h, w), np.int64), np.empty((h, w), np.int64)
    source = np.empty((h, w, 3), np.int32)
    begins = table[:, 0] // channels
    for i in range(h):
        y, row = canvas_place(box[0] + i * step, height, wrap[0]), pick[1] + i * step
        for j in range(w):
            x, column = canvas_place(box[1] + j * step, width, wrap[1]), pick[2] + j * step
            v, at = variant[y, x], yx[y, x]
            source[i, j, 0], source[i, j, 1], source[i, j, 2] = v, at[0], at[1]
            old[i, j] = begins[v] + at[0] * table[v, 3] + at[1] if v != HOLE else -1
            if 0 <= row < table[pick[0], 1] and 0 <= column < table[pick[0], 2]:
                place = begins[pick[0]] + row * table[pick[0], 3] + column
                new[i, j] = place if usable[place] else -1
            else:
                new[i, j] = spot(table, usable, torus, channels, pick[0], row, column)
    state = np.empty((h, w), np.uint8)
    fix(grown, locked, box, target, step, old, new, state)
    terms = np.empty((h, w, 2, 3), np.int32)
    pair_terms(pieces, source, price, step, old, new, state, terms)
    least_cut(state, terms, saved, out)
    return cut_change(terms, out)


@kernel
def write_cut(grown: Any, pieces: Any, box: Any, pick: Any, take: Any) -> None:
    """Write what `take` says of a patch into the map; `box` and `pick` as in :func:`recut`."""
    (variant, yx, wrap), table = grown, pieces.table
    height, width = variant.shape
    rows, columns = table[pick[0], 1], table[pick[0], 2]
    for i in range(take.shape[0]):
        y = canvas_place(box[0] + i, height, wrap[0])
        for j in range(take.shape[1]):
            if take[i, j]:
                x = canvas_place(box[1] + j, width, wrap[1])
                variant[y, x] = pick[0]
                yx[y, x, 0] = (pick[1] + i) % rows
                yx[y, x, 1] = (pick[2] + j) % columns
