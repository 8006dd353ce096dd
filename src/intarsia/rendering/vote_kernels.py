"""Pieces of a map, and how many votes each of them gives to every pixel around it.

All pixels with one key (exemplar, pose, offset ``o = S(q) - J q``) read the same exemplar pixel
``u = o + J p`` when they vote for `p`. So votes are counted per piece, by running sums over its box: a column
sum is moved down row by row, a row sum is moved right pixel by pixel, whatever the feather.

Frames: a *cell* is a box of output pixels with a halo for the feather f. The arrays of a cell start
``f // 2`` px above and left of its first pixel, so that pixel (y, x) of the cell hears rows y .. y + f and
columns x .. x + f of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from ..kernels.pieces_of_maps import BOTTOM, HOLE, LEFT, OX, OY, POSE, RIGHT, TOP, WHICH, J, label_pieces

Map = tuple[NDArray[np.int32], NDArray[np.uint8], NDArray[np.uint8]]
"""What a map shows: pixels (H, W, 2), exemplars (H, W) and poses (H, W)."""


class VotedExemplars(NamedTuple):
    """The exemplars laid end to end, so that one number names any pixel of any of them."""

    table: NDArray[np.int64]  # (n, 4): number of the first pixel, height, width, 1 if toroidal
    near: NDArray[np.uint16]  # (pixels,): distance to the nearest unusable pixel, capped; 0 where unusable


class Voters(NamedTuple):
    """Who votes in one cell."""

    labels: NDArray[np.int32]  # (height + feather, width + feather): number of the group, -1 for no vote
    groups: NDArray[np.int64]  # (n, 8): key and box of every group, sorted by key
    feather: int


@kernel
def cut_window(
    full: Map, origin: tuple[int, int], scale: int, wrap: tuple[bool, bool], exemplars: NDArray[np.int64], part: Map
) -> bool:
    """Cut a box out of a map that is `scale` times enlarged; outside the canvas there are holes.

    `origin` is the first pixel in enlarged px, `part` receives (yx, which, pose). Enlarging turns the s x s
    sub-pixels of a pixel with its pose: S' = s S + (J (2 d - (s - 1)) + (s - 1)) / 2. Returns False where the
    map points outside its exemplars.
    """
    yx, which, pose = full
    out, out_which, out_pose = part
    rows, columns = which.shape
    for i in range(out_which.shape[0]):
        my = (origin[0] + i) // scale
        ty = 2 * (origin[0] + i - my * scale) - (scale - 1)
        if wrap[0]:
            my %= rows
        for j in range(out_which.shape[1]):
            mx = (origin[1] + j) // scale
            tx = 2 * (origin[1] + j - mx * scale) - (scale - 1)
            if wrap[1]:
                mx %= columns
            out_which[i, j] = HOLE
            out_pose[i, j] = 0
            out[i, j, 0] = out[i, j, 1] = 0
            if not (0 <= my < rows and 0 <= mx < columns) or which[my, mx] == HOLE:
                continue
            w, p = which[my, mx], pose[my, mx]
            if w >= exemplars.shape[0] or p > 7:
                return False
            u = scale * yx[my, mx, 0] + (J[p, 0] * ty + J[p, 1] * tx + scale - 1) // 2
            v = scale * yx[my, mx, 1] + (J[p, 2] * ty + J[p, 3] * tx + scale - 1) // 2
            if not (0 <= u < exemplars[w, 1] and 0 <= v < exemplars[w, 2]):
                return False
            out[i, j, 0], out[i, j, 1] = u, v
            out_which[i, j], out_pose[i, j] = w, p
    return True


@kernel
def _merge(
    table: NDArray[np.int64], order: NDArray[np.int64], key: NDArray[np.int64], feather: int, labels: NDArray[np.int32]
) -> NDArray[np.int64]:
    """Join pieces of one key that can be heard by one pixel, and put group numbers into `labels`."""
    groups = np.empty_like(table)
    group_of = np.full(table.shape[0], -1, np.int32)
    count = 0
    for i in range(order.size):
        k = order[i]
        piece = table[k]
        if piece[WHICH] == HOLE:
            continue
        last = groups[count - 1]
        if count == 0 or key[k] != key[order[i - 1]] or piece[LEFT] >= last[RIGHT] + feather:
            groups[count] = piece
            count += 1
        else:
            last[TOP], last[LEFT] = min(last[TOP], piece[TOP]), min(last[LEFT], piece[LEFT])
            last[BOTTOM], last[RIGHT] = max(last[BOTTOM], piece[BOTTOM]), max(last[RIGHT], piece[RIGHT])
        group_of[k] = count - 1
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            labels[y, x] = group_of[labels[y, x]]
    return groups[:count]


def make_plan(part: Map, origin: tuple[int, int], exemplars: NDArray[np.int64], feather: int) -> Voters:
    """Find who votes in a cell: pieces of one key become one group, groups are sorted by key.

    Sums of floating point numbers follow that order, so it must be the same at a pixel from whatever window
    it is seen. Offsets compare alike from everywhere, for they all shift together; only around toroidal
    exemplars they are taken modulo its size, and so from a fixed origin.
    """
    labels, table = label_pieces(*part)
    known = table[:, WHICH] != HOLE
    number = np.where(known, table[:, WHICH], 0)
    j = J[table[:, POSE]]
    height, width, toroidal = exemplars[number, 1], exemplars[number, 2], exemplars[number, 3] != 0
    oy = np.where(toroidal, (table[:, OY] - j[:, 0] * origin[0] - j[:, 1] * origin[1]) % height, table[:, OY])
    ox = np.where(toroidal, (table[:, OX] - j[:, 2] * origin[0] - j[:, 3] * origin[1]) % width, table[:, OX])
    key = (((table[:, WHICH] << 3) + table[:, POSE] << 26) + oy + (1 << 25) << 26) + ox + (1 << 25)
    order = np.lexsort((table[:, LEFT], key))
    return Voters(labels, _merge(table, order, key, feather, labels), feather)


@kernel
def _add_row(
    labels: NDArray[np.int32], y: int, box: NDArray[np.int64], g: int, columns: NDArray[np.int32], sign: int
) -> None:
    if box[TOP] <= y < box[BOTTOM]:
        for x in range(box[LEFT], box[RIGHT]):
            columns[x - box[LEFT]] += sign * (labels[y, x] == g)


@kernel
def scratch(plan: Voters) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Make room for the column sums of a group, and for the hits of one row: column, weight, pixel read."""
    width = plan.labels.shape[1]
    return np.zeros(width + 2 * plan.feather + 2, np.int32), np.empty((3, width), np.int64)


@kernel
def open_group(plan: Voters, g: int, begin: int, end: int, columns: NDArray[np.int32]) -> tuple[int, int]:
    """Start counting the votes of a group in rows begin .. end - 1; returns the rows that hear it."""
    box, f = plan.groups[g], plan.feather
    columns[: box[RIGHT] - box[LEFT] + 2 * f + 2] = 0
    first = max(begin, box[TOP] - f)
    counts = columns[f + 1 :]  # a margin of zeros on both sides spares every test for the box's edge
    for y in range(first, first + f):
        _add_row(plan.labels, y, box, g, counts, 1)
    return first, min(end, box[BOTTOM])


@kernel
def weigh_row(
    plan: Voters, ground: VotedExemplars, g: int, y: int, first: int, columns: NDArray[np.int32],
    hits: NDArray[np.int64],
) -> int:  # fmt: skip
    """List the votes of group `g` in row `y` (rows must come in turn from `first`); returns how many hits."""
    box, f = plan.groups[g], plan.feather
    counts = columns[f + 1 :]
    _add_row(plan.labels, y + f, box, g, counts, 1)
    if y > first:
        _add_row(plan.labels, y - 1, box, g, counts, -1)
    pose, which = box[POSE], box[WHICH]
    a, b, c, d = J[pose, 0], J[pose, 1], J[pose, 2], J[pose, 3]
    base, height = ground.table[which, 0], ground.table[which, 1]
    width, toroidal = ground.table[which, 2], ground.table[which, 3] != 0
    x0, x1 = max(0, box[LEFT] - f), min(plan.labels.shape[1] - f, box[RIGHT])
    py, px = y + f // 2, x0 + f // 2
    uy, ux = box[OY] + a * py + b * px, box[OX] + c * py + d * px
    if toroidal:
        uy, ux = uy % height, ux % width
    at = x0 - box[LEFT] + f + 1  # place of column x in `columns`
    votes = 0
    for k in range(at, at + f):
        votes += columns[k]
    n = 0
    for x in range(x0, x1):
        votes += columns[at + f]
        if votes > 0 and 0 <= uy < height and 0 <= ux < width:
            u = base + uy * width + ux
            near = np.int64(ground.near[u])
            if near > 0:
                hits[0, n], hits[1, n], hits[2, n] = x, votes * near, u
                n += 1
        votes -= columns[at]
        at += 1
        uy += b
        ux += d
        if toroidal:  # steps are -1, 0 or 1
            uy = 0 if uy == height else (height - 1 if uy < 0 else uy)
            ux = 0 if ux == width else (width - 1 if ux < 0 else ux)
    return n
