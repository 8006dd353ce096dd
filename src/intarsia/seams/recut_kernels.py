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

from ..kernels.jit import kernel
from ..kernels.maxflow import MOST, push_flow
from ..kernels.windows import canvas_place
from .pair_kernels import ABSENT, FREE, OLD, lay, look, price_all

NEVER = 1 << 60  # what a cut is said to cost that was given up
NOTHING = np.zeros((0, 0), np.int32)


class Draft(NamedTuple):
    """What a cut is drawn on, and what it says: of every `step`-th px of a window, as many rows and columns."""

    step: int
    saved: NDArray[np.int32]  # what staying costs each besides its seams; or of no size: nothing
    take: NDArray[np.uint8]  # the answer: 1 where the patch is taken


def drafted(window: tuple[int, int, int, int], step: int, saved: NDArray[np.int32] | None = None) -> Draft:
    """A draft of a cut into a window (first row and column, rows, columns) on which nothing is drawn yet."""
    take = np.empty((-(-window[2] // step), -(-window[3] // step)), np.uint8)
    return Draft(step, NOTHING if saved is None else saved, take)


@kernel
def least_cut(state: Any, terms: Any, saved: Any, out: Any, most: Any) -> Any:
    """Choose between old and new for every pixel so that the terms of :func:`price_all` add up to the least.

    `saved` (h, w): what each pixel costs besides if it stays, where that is more than nothing.
    Of several such choices `out` (1 = new) is the one with the fewest old pixels. Where nothing must stay, all
    becomes new. Returns whether `out` says so: not if all choices cost `most` or more.
    """
    h, w = state.shape
    kept = 0
    for i in range(h):
        for j in range(w):
            kept += state[i, j] == OLD
            out[i, j] = state[i, j] != ABSENT
    if kept == 0:
        return True
    stride = w + 2
    size = (h + 2) * stride
    kind = np.full(size, FREE, np.uint8)
    room = np.zeros(4 * size, np.int32)
    excess = np.zeros(size, np.int64)
    for i in range(h):
        begin = np.uint64((i + 1) * stride + 1)
        for j in range(np.uint64(w)):
            p = begin + j
            if state[i, j] != ABSENT:
                kind[p] = state[i, j]
            if saved.size and state[i, j] == FREE and saved[i, j] > 0:
                excess[p] += saved[i, j]
        for k in range(2):
            a, b, c, on, d = terms[0, k, i], terms[1, k, i], terms[2, k, i], 1 if k == 0 else stride, np.uint64(2 * k)
            for j in range(np.uint64(w)):
                p = begin + j
                q = p + np.uint64(on)
                if a[j] == 0:
                    if c[j]:
                        room[np.uint64(4) * p + d] = c[j]
                    if b[j]:
                        room[np.uint64(4) * q + d + np.uint64(1)] = b[j]
                    continue
                mine = min(a[j], b[j])
                rest = min(a[j] - mine, c[j])
                excess[p] += mine
                excess[q] += rest
                room[np.uint64(4) * p + d] = c[j] - rest
                room[np.uint64(4) * q + d + np.uint64(1)] = b[j] - mine
    level, came = push_flow(kind, room, excess, stride, most)
    for i in range(h):
        for j in range(w):
            out[i, j] = 1 if level[(i + 1) * stride + j + 1] >= size and state[i, j] != ABSENT else 0
    return came < most


@kernel
def cut_change(terms: Any, out: Any) -> Any:
    """Return by how much the seams of a window become dearer if what `out` says is replaced."""
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
    pieces: Any, pick: Any, price: Any, draft: Any, limit: Any, joints: Any, old: Any, seen: Any, terms: Any
) -> Any:
    """Cut a patch into what :func:`look` read of a window; see :func:`recut`. NEVER if it is given up."""
    new, state, most = np.empty(old.shape, np.int32), np.empty(old.shape, np.uint8), np.int64(MOST)
    lay(pieces, pick, draft.step, old, seen, new, state)
    price_all(pieces, price, joints, old, new, state, terms)
    if limit < NEVER and draft.saved.size == 0:
        most = np.int64(limit)  # at least what flows will be paid, in place of what is paid now
        for number in range(len(joints)):
            most += terms[0, joints[number, 2], joints[number, 0], joints[number, 1]]
    found = least_cut(state, terms, draft.saved, draft.take, most)
    return cut_change(terms, draft.take) if found else NEVER


@kernel
def recut(
    grown: Any, locked: Any, pieces: Any, box: Any, target: Any, picks: Any, price: Any, draft: Any, best: Any
) -> None:
    """Cut patches into a window of the map, one instead of another, old seams remembered, and note the best.

    `box`: the window's first row and column (inside the canvas, or over a border that wraps), rows and columns;
    `picks` (n, 4): the number of each, by which ties are settled, its variant, row and column of the pixel shown at the
    window's first pixel, which may lie outside the variant. The draft says which pixels of the last one to take.
    `best` (2,): by how much the seams become dearer, negative where a patch covers seams that cost more than its own,
    and the number of the patch; what does not better it is given up, and it stays. What is saved by leaving, of the
    draft, draws the cut, and is not in what seams cost; where anything is, no cut is given up before it is drawn.
    """
    h, w = draft.take.shape
    old, seen, terms = np.empty((h, w), np.int32), np.empty((h, w), np.uint8), np.zeros((3, 2, h, w), np.int32)
    joints = look(grown, locked, pieces, box, target, price, draft.step, old, seen, terms[0])
    for k in range(len(picks)):
        number, pick = picks[k, 0], (picks[k, 1], picks[k, 2], picks[k, 3])
        limit = best[0] + (number < best[1])  # of two that cost as much the first is taken
        change = _cut_in(pieces, pick, price, draft, limit, joints, old, seen, terms)
        if change < limit:
            best[0], best[1] = change, number


@kernel
def write_cut(grown: Any, pieces: Any, box: Any, pick: Any, take: Any) -> tuple[int, int, int, int]:
    """Write what `take` says of a patch into the map; `box` and `pick` as in :func:`recut`.

    Returns the first row and column of the box of what is written, in the window, its rows and columns.
    """
    (variant, yx, wrap), table = grown, pieces.table
    height, width = variant.shape
    rows, columns = table[pick[0], 1], table[pick[0], 2]
    top, left, bottom, right = take.shape[0], take.shape[1], 0, 0
    for i in range(take.shape[0]):
        y = canvas_place(box[0] + i, height, wrap[0])
        for j in range(take.shape[1]):
            if take[i, j]:
                x = canvas_place(box[1] + j, width, wrap[1])
                variant[y, x] = pick[0]
                yx[y, x, 0] = (pick[1] + i) % rows
                yx[y, x, 1] = (pick[2] + j) % columns
                top, left, bottom, right = min(top, i), min(left, j), max(bottom, i + 1), max(right, j + 1)
    return min(top, bottom), min(left, right), max(bottom - top, 0), max(right - left, 0)
