"""Pieces of a map, how many votes each of them gives to every pixel around it, and what these add up to.

All pixels with one key (exemplar, pose, offset ``o = S(q) - J q``) read the same exemplar pixel
``u = o + J p`` when they vote for `p`. So votes are counted per piece, by running sums over its box: a column
sum is moved down row by row, a row sum is moved right pixel by pixel, whatever the feather.

Frames: a *cell* is a box of output pixels with a halo for the feather f. The arrays of a cell start
``f // 2`` px above and left of its first pixel, so that pixel (y, x) of the cell hears rows y .. y + f and
columns x .. x + f of them.

What adds up votes walks the groups in the order of the plan, so that floating point sums never depend on the window;
there is one kernel for each way to mix, and one that copies. Arrays named `squares` (sum of squared weights) are filled
unless they are empty.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Floats, Int32, Int64, Pair, UInt8
from ..kernels.jit import kernel
from ..kernels.pieces_of_maps import BOTTOM, HOLE, LEFT, OX, OY, POSE, RIGHT, TOP, WHICH, J, label_pieces

Map = tuple[Int32, UInt8, UInt8]
"""What a map shows: pixels (H, W, 2), exemplars (H, W) and poses (H, W)."""


class VotedExemplars(NamedTuple):
    """The exemplars laid end to end, so that one number names any pixel of any of them."""

    table: Int64  # (n, 4): number of the first pixel, height, width, 1 if toroidal
    near: NDArray[np.uint16]  # (pixels,): distance to the nearest unusable pixel, capped; 0 where unusable


class Voters(NamedTuple):
    """Who votes in one cell."""

    labels: Int32  # (height + feather, width + feather): number of the group, -1 for no vote
    groups: Int64  # (n, 8): key and box of every group, sorted by key
    feather: int

    @property
    def shape(self) -> Pair:
        """Height and width of the cell."""
        return self.labels.shape[0] - self.feather, self.labels.shape[1] - self.feather


@kernel
def cut_window(
    full: Map, origin: Pair, scale: int, wrap: tuple[bool, bool], exemplars: Int64, part: Map
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
    table: Int64, order: Int64, key: Int64, feather: int, labels: Int32
) -> Int64:
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
            for c in range(len(piece)):
                groups[count, c] = piece[c]
            count += 1
        else:
            last[TOP], last[LEFT] = min(last[TOP], piece[TOP]), min(last[LEFT], piece[LEFT])
            last[BOTTOM], last[RIGHT] = max(last[BOTTOM], piece[BOTTOM]), max(last[RIGHT], piece[RIGHT])
        group_of[k] = count - 1
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            labels[y, x] = group_of[labels[y, x]]
    return groups[:count]


def make_plan(part: Map, origin: Pair, exemplars: Int64, feather: int) -> Voters:
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
    labels: Int32, y: int, box: Int64, g: int, columns: Int32, sign: int
) -> None:
    if box[TOP] <= y < box[BOTTOM]:
        for x in range(box[LEFT], box[RIGHT]):
            columns[x - box[LEFT]] += sign * (labels[y, x] == g)


@kernel
def scratch(plan: Voters) -> tuple[Int32, Int64]:
    """Make room for the column sums of a group, and for the hits of one row: column, weight, pixel read."""
    width = plan.labels.shape[1]
    return np.zeros(width + 2 * plan.feather + 2, np.int32), np.empty((3, width), np.int64)


@kernel
def open_group(plan: Voters, g: int, begin: int, end: int, columns: Int32) -> Pair:
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
    plan: Voters, ground: VotedExemplars, g: int, y: int, first: int, columns: Int32,
    hits: Int64,
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


LIMB = 14
"""Linear light has two limbs of this many bits, so that sums weighted by 16-bit opacity fit into 64 bits."""

Turn = tuple[Int64, Int64]
"""(channel, sign), (8, 3) each: what a pose makes of the components."""


@kernel
def copy_cell(
    yx: Int32, which: UInt8, exemplars: Int64, samples: Array, out: Array
) -> bool:
    """Copy for every pixel its exemplar pixel; False where there is a hole, or none such pixel, and `out` stays."""
    whole = True
    for y in range(which.shape[0]):
        for x in range(which.shape[1]):
            w, u, v = which[y, x], yx[y, x, 0], yx[y, x, 1]
            if w >= exemplars.shape[0] or not (0 <= u < exemplars[w, 1] and 0 <= v < exemplars[w, 2]):
                whole = False
                continue
            k = exemplars[w, 0] + u * exemplars[w, 2] + v
            for c in range(samples.shape[1]):
                out[y, x, c] = samples[k, c]
    return whole


@kernel
def add_votes(
    heard: tuple[Voters, VotedExemplars], values: Array, light: Int32 | None, opacity: Array | None, turn: Turn,
    first: Int64 | None, sums: tuple[Array, Array], squares: Floats | None,
) -> None:  # fmt: skip
    """Add up w * value for every pixel and channel, and w, which is the number of votes for what is read.

    `values` (N, C) are codes where a table of their `light` is given. `opacity` (N,) multiplies w, if it is given: what
    is transparent has no vote. `sums` = (total, weight). Where there is a `first`, it holds 8 u + pose of the
    first voter, -1 at the start, and `total` the sum of w * (value - value of the first voter): exactly zero where all
    agree, whatever the rounding. What is None costs nothing: it is left out of what is compiled.
    """
    plan, ground = heard
    columns, hits = scratch(plan)
    (channel, sign), (total, weight) = turn, sums
    for g in range(plan.groups.shape[0]):
        pose = plan.groups[g, POSE]
        begin, end = open_group(plan, g, 0, weight.shape[0], columns)
        for y in range(begin, end):
            n = weigh_row(plan, ground, g, y, begin, columns, hits)
            for i in range(n):
                x, w, u = hits[0, i], hits[1, i], hits[2, i]
                if opacity is not None:
                    if not opacity[u] > 0:
                        continue
                    w = w * opacity[u]
                weight[y, x] += w
                if squares is not None:
                    squares[y, x] += float(w) * float(w)
                if first is None:
                    for c in range(total.shape[2]):
                        total[y, x, c] += w * (values[u, c] if light is None else light[values[u, c]])
                elif first[y, x] < 0:
                    first[y, x] = 8 * u + pose
                else:
                    v, q = first[y, x] >> 3, first[y, x] & 7
                    for c in range(total.shape[2]):
                        mine = sign[pose, c] * values[u, channel[pose, c]]
                        theirs = sign[q, c] * values[v, channel[q, c]]
                        total[y, x, c] += w * (mine - theirs)


@kernel
def settle_plain(
    total: Int64, weight: Int64, steps: Int32, shelf: Int32, shift: int,
    out: Array,
) -> None:  # fmt: skip
    """Divide once, rounding half up to codes; `steps` are the lights at which codes begin, empty for none."""
    for y in range(weight.shape[0]):
        for x in range(weight.shape[1]):
            w = weight[y, x]
            if w == 0:
                continue
            for c in range(total.shape[2]):
                if steps.size == 0:
                    out[y, x, c] = (2 * total[y, x, c] + w) // (2 * w)
                else:  # the number of steps <= value; a shelf of starting points shortens the walk
                    value = total[y, x, c] // w
                    code = shelf[value >> shift]
                    while code < steps.size and steps[code] <= value:
                        code += 1
                    out[y, x, c] = code


@kernel
def vote_label(
    plan: Voters, ground: VotedExemplars, ranks: Int32, begin: int, end: int,
    slots: tuple[Int32, Int64],
) -> bool:  # fmt: skip
    """Rows begin .. end - 1: add up the weight of every label that is heard; False where slots run out.

    `slots` = (label, weight), (rows, w, K) each, weight 0 where a slot is free.
    """
    columns, hits = scratch(plan)
    label, share = slots
    for g in range(plan.groups.shape[0]):
        first, last = open_group(plan, g, begin, end, columns)
        for y in range(first, last):
            n = weigh_row(plan, ground, g, y, first, columns, hits)
            for i in range(n):
                x, w, rank = hits[0, i], hits[1, i], ranks[hits[2, i]]
                k = 0
                while k < label.shape[2] and share[y - begin, x, k] > 0 and label[y - begin, x, k] != rank:
                    k += 1
                if k == label.shape[2]:
                    return False
                label[y - begin, x, k] = rank
                share[y - begin, x, k] += w
    return True


@kernel
def settle_label(
    label: Int32, share: Int64, out: Int32, weight: Int64
) -> None:
    """Choose the label with the largest share, the smallest of equals."""
    for y in range(label.shape[0]):
        for x in range(label.shape[1]):
            best = np.int64(0)
            for k in range(label.shape[2]):
                s = share[y, x, k]
                if s == 0:
                    break
                weight[y, x] += s
                if s > best or (s == best and label[y, x, k] < out[y, x]):
                    best = s
                    out[y, x] = label[y, x, k]


@kernel
def turn_codes(codes: Array, pose: NDArray[np.integer[Any]], turn: Turn, top: int, out: Array) -> None:
    """Turn codes (h, w, 3) by their poses; the opposite of a code v is top - v."""
    channel, sign = turn
    for y in range(pose.shape[0]):
        for x in range(pose.shape[1]):
            p = pose[y, x]
            for c in range(3):
                v = codes[y, x, channel[p, c]]
                out[y, x, c] = top - v if sign[p, c] < 0 else v


@kernel
def settle_vectors(
    samples: Array, turn: Turn, total: Array, first: Int64, weight: Int64, top: int,
    out: Array,
) -> None:  # fmt: skip
    """Return votes as codes of vectors of length 1, rounded half up; where all agree, that of the first voter.

    `total` (h, w, 3) is relative to the first voter (8 u + pose), see `vote_relative`. Where votes cancel the weight
    becomes 0.
    """
    channel, sign = turn
    for y in range(weight.shape[0]):
        for x in range(weight.shape[1]):
            if weight[y, x] == 0:
                continue
            u, p = first[y, x] >> 3, first[y, x] & 7
            for c in range(3):
                v = samples[u, channel[p, c]]
                out[y, x, c] = top - v if sign[p, c] < 0 else v
            if total[y, x, 0] == 0 and total[y, x, 1] == 0 and total[y, x, 2] == 0:
                continue
            w = weight[y, x]
            a = float((2 * np.int64(out[y, x, 0]) - top) * w + total[y, x, 0])
            b = float((2 * np.int64(out[y, x, 1]) - top) * w + total[y, x, 1])
            z = float((2 * np.int64(out[y, x, 2]) - top) * w + total[y, x, 2])
            length = np.sqrt((a * a + b * b) + z * z)
            if length == 0.0:
                weight[y, x] = 0
                continue
            for c, n in enumerate((a, b, z)):
                out[y, x, c] = np.int64(np.floor(min(max((n / length + 1.0) / 2.0, 0.0), 1.0) * top + 0.5))
