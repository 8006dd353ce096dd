"""Kernels of blending by votes: the votes of every piece for the pixels around it, and their weighted sums.

All pixels with one key (exemplar, pose, offset ``o = S(q) - J q``) read the same exemplar pixel
``u = o + J p`` when they vote for `p`. So votes are counted per piece, by running sums over its box: a column
sum is moved down row by row, a row sum is moved right pixel by pixel, at a cost independent of the feather.

Coordinates: a *cell* is a box of output pixels with a halo for the feather f. The arrays of a cell start
``f // 2`` px above and left of its first pixel, so that pixel (y, x) of the cell gets the votes of rows y .. y + f and
columns x .. x + f of them.

Votes are added group by group in the order of the plan, so that floating point sums never depend on the window;
there is one kernel for each kind of blending, and one that copies.
"""

from __future__ import annotations

from math import floor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.arrays import Array, Float32, Floats, Int32, Int64, Mask, Pair, UInt8
from ..kernels.jit import kernel
from ..kernels.maps import BOTTOM, HOLE, LEFT, OX, OY, POSE, RIGHT, TOP, WHICH, J, label_pieces

Map = tuple[Int32, UInt8, UInt8]
"""The arrays of a map: source pixels (H, W, 2), exemplars (H, W) and poses (H, W)."""


class Reach(NamedTuple):
    """The exemplars concatenated, so that one index identifies any pixel of any of them, and their usable pixels."""

    table: Int64  # (n, 4): index of the first pixel, height, width, 1 if toroidal
    free: Mask  # (N,): which pixels are usable; empty if all are
    near: NDArray[np.uint16]  # (N,): chessboard distance to the nearest unusable pixel, capped; empty without a feather


class VoteGroups(NamedTuple):
    """The groups of pieces that vote in one cell."""

    labels: Int32  # (height + feather, width + feather): index of the group, -1 for no vote
    groups: Int64  # (n, 8): key and box of every group, sorted by key
    feather: int  # px

    @property
    def shape(self) -> Pair:
        """Height and width of the cell."""
        return self.labels.shape[0] - self.feather, self.labels.shape[1] - self.feather


@kernel
def cut_window(
    full: Map, frame: Float32 | None, sub: Float32 | None, origin: Pair, scale: int, wrap: tuple[bool, bool],
    exemplars: Int64, part: Map, places: tuple[Floats, Floats] | None,
) -> bool:  # fmt: skip
    """Write a box of a map that is enlarged `scale` times; pixels outside the canvas become holes.

    `origin` is the first pixel in enlarged px, `part` receives (yx, which, pose). Enlarging turns the s x s
    sub-pixels of a pixel with its pose: S' = s S + (J (2 d - (s - 1)) + (s - 1)) / 2. Returns False where the
    map points outside its exemplars.

    For a map with a `frame` (H, W, 2, 2) in place of poses, or with fractions `sub` (H, W, 2), `places` receives the
    positions S' (h, w, 2), plus s times the fraction, and J (h, w, 4); yx is then the pixel nearest to S' without the
    fraction, within the enlarged exemplar pixel of the map.
    """
    yx, which, pose = full
    out, out_which, out_pose = part
    rows, columns = which.shape
    for i in range(out_which.shape[0]):
        my = (origin[0] + i) // scale
        ty = 2 * (origin[0] + i - my * scale) - (scale - 1)
        if wrap[0]:
            my %= rows
        for k in range(out_which.shape[1]):
            mx = (origin[1] + k) // scale
            tx = 2 * (origin[1] + k - mx * scale) - (scale - 1)
            if wrap[1]:
                mx %= columns
            out_which[i, k] = HOLE
            out_pose[i, k] = 0
            out[i, k, 0] = out[i, k, 1] = 0
            if not (0 <= my < rows and 0 <= mx < columns) or which[my, mx] == HOLE:
                continue
            w, p = which[my, mx], pose[my, mx]
            if w >= exemplars.shape[0] or p > 7:
                return False
            u, v = scale * yx[my, mx, 0], scale * yx[my, mx, 1]
            if not (0 <= u < exemplars[w, 1] and 0 <= v < exemplars[w, 2]):
                return False
            if places is None:
                u += (J[p, 0] * ty + J[p, 1] * tx + scale - 1) // 2
                v += (J[p, 2] * ty + J[p, 3] * tx + scale - 1) // 2
            else:
                at, j = places[0], places[1][i, k]
                for c in range(4):
                    j[c] = J[p, c] if frame is None else frame[my, mx, c // 2, c % 2]
                down = (j[0] * ty + j[1] * tx + (scale - 1)) / 2
                right = (j[2] * ty + j[3] * tx + (scale - 1)) / 2
                at[i, k, 0] = u + (down if sub is None else down + scale * np.float64(sub[my, mx, 0]))
                at[i, k, 1] = v + (right if sub is None else right + scale * np.float64(sub[my, mx, 1]))
                u += min(max(floor(down + 0.5), 0), scale - 1)
                v += min(max(floor(right + 0.5), 0), scale - 1)
            out[i, k, 0], out[i, k, 1] = u, v
            out_which[i, k], out_pose[i, k] = w, p
    return True


def group_votes(part: tuple[Array, ...], origin: Pair, exemplars: Int64, feather: int) -> VoteGroups:
    """Return the groups that vote in a cell: pieces of one key are one group if both vote for one pixel.

    Groups are sorted by key: sums of floating point numbers follow that order, so it must be the same at a pixel in
    every window. The order of offsets does not depend on the window, as all shift together; only of toroidal
    exemplars they are taken modulo the size, and so relative to a fixed origin.
    """
    labels, table = label_pieces(*part[:3])
    known = np.flatnonzero(table[:, WHICH] != HOLE)
    pieces = table[known]
    number, j = pieces[:, WHICH], J[pieces[:, POSE]]
    height, width, toroidal = exemplars[number, 1], exemplars[number, 2], exemplars[number, 3] != 0
    oy, ox = pieces[:, OY], pieces[:, OX]
    oy = np.where(toroidal, (oy - j[:, 0] * origin[0] - j[:, 1] * origin[1]) % height, oy)
    ox = np.where(toroidal, (ox - j[:, 2] * origin[0] - j[:, 3] * origin[1]) % width, ox)
    key = (((number << 3) + pieces[:, POSE] << 26) + oy + (1 << 25) << 26) + ox + (1 << 25)
    order = np.lexsort((pieces[:, LEFT], key))
    pieces, key = pieces[order], key[order]
    apart = np.cumsum(np.diff(key, prepend=key[0]) != 0) * (labels.shape[1] + feather)  # so that keys never meet
    heard = np.maximum.accumulate(pieces[:, RIGHT] + apart) + feather
    begins = np.append(True, pieces[1:, LEFT] + apart[1:] >= heard[:-1])
    first = np.flatnonzero(begins)
    groups = pieces[first]
    groups[:, [TOP, LEFT]] = np.minimum.reduceat(pieces[:, [TOP, LEFT]], first)
    groups[:, [BOTTOM, RIGHT]] = np.maximum.reduceat(pieces[:, [BOTTOM, RIGHT]], first)
    group_of = np.full(len(table), -1, np.int32)
    group_of[known[order]] = np.cumsum(begins) - 1
    return VoteGroups(group_of.take(labels), groups, feather)


@kernel
def _add_row(
    labels: Int32, y: int, box: Int64, g: int, columns: Int32, sign: int
) -> None:
    if box[TOP] <= y < box[BOTTOM]:
        for x in range(box[LEFT], box[RIGHT]):
            columns[x - box[LEFT]] += sign * (labels[y, x] == g)


@kernel
def scratch(plan: VoteGroups) -> tuple[Int32, Int64]:
    """Return arrays for the column sums of a group, and for the votes of one row: column, weight, pixel index."""
    width = plan.labels.shape[1]
    return np.zeros(width + 2 * plan.feather + 2, np.int32), np.empty((3, width), np.int64)


@kernel
def open_group(plan: VoteGroups, g: int, begin: int, end: int, columns: Int32) -> Pair:
    """Start the column sums of a group for rows begin .. end - 1; return the range of rows that it votes in."""
    box, f = plan.groups[g], plan.feather
    columns[: box[RIGHT] - box[LEFT] + 2 * f + 2] = 0
    first = max(begin, box[TOP] - f)
    counts = columns[f + 1 :]  # margins of zeros on both sides make tests for the box's edge unnecessary
    for y in range(first, first + f):
        _add_row(plan.labels, y, box, g, counts, 1)
    return first, min(end, box[BOTTOM])


@kernel
def weigh_row(
    plan: VoteGroups, reach: Reach, g: int, y: int, first: int, columns: Int32,
    hits: Int64,
) -> int:  # fmt: skip
    """List the votes of group `g` in row `y` (rows must come in turn from `first`); return how many."""
    box, f = plan.groups[g], plan.feather
    counts = columns[f + 1 :]
    _add_row(plan.labels, y + f, box, g, counts, 1)
    if y > first:
        _add_row(plan.labels, y - 1, box, g, counts, -1)
    pose, which = box[POSE], box[WHICH]
    a, b, c, d = J[pose, 0], J[pose, 1], J[pose, 2], J[pose, 3]
    base, height = reach.table[which, 0], reach.table[which, 1]
    width, toroidal = reach.table[which, 2], reach.table[which, 3] != 0
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
            near = np.int64(reach.near[u])
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
"""(channel, sign), (8, 3) each: component c of a vector in an isometry is sign * old[channel]."""


@kernel
def copy_cell(
    yx: Int32, which: UInt8, exemplars: Int64, samples: Array, out: Array
) -> bool:
    """Copy every pixel's exemplar pixel; return False if any is a hole or lies outside, where `out` is unchanged."""
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
    heard: tuple[VoteGroups, Reach], values: Array, light: Int32 | None, opacity: Array | None, turn: Turn,
    first: Int64 | None, sums: tuple[Array, Array],
) -> None:  # fmt: skip
    """Add up w * value for every pixel and channel, and w: the number of votes for an exemplar pixel times its `near`.

    `values` (N, C) are light, or codes if the table of their `light` is given. `opacity` (N,) multiplies w, if it is
    given: transparent pixels have no vote. `sums` = (total, weight). If `first` is given, it holds 8 u + pose of the
    first vote, -1 at the start, and `total` the sum of w * (value - value of the first vote): exactly zero where all
    agree, whatever the rounding. Branches on None are compiled away.
    """
    plan, reach = heard
    columns, hits = scratch(plan)
    (channel, sign), (total, weight) = turn, sums
    for g in range(plan.groups.shape[0]):
        pose = plan.groups[g, POSE]
        begin, end = open_group(plan, g, 0, weight.shape[0], columns)
        for y in range(begin, end):
            n = weigh_row(plan, reach, g, y, begin, columns, hits)
            for i in range(n):
                x, w, u = hits[0, i], hits[1, i], hits[2, i]
                if opacity is not None:
                    if not opacity[u] > 0:
                        continue
                    w = w * opacity[u]
                weight[y, x] += w
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
def encode_light(total: Array, weight: Array, coding: tuple[Int32, Int32, int], out: Array) -> None:
    """Divide total (h, w, C) by weight (h, w) once, rounding half up to codes.

    `coding`: the light at which each code begins, empty if codes are light, and a lookup table with its shift, where
    the search for a code starts.
    """
    steps, shelf, shift = coding
    for y in range(weight.shape[0]):
        for x in range(weight.shape[1]):
            w = weight[y, x]
            if w == 0:
                continue
            for c in range(total.shape[2]):
                if steps.size == 0:
                    out[y, x, c] = (2 * total[y, x, c] + w) // (2 * w)
                    continue
                value = np.int64(total[y, x, c] // w)
                code = np.int64(shelf[value >> shift])
                while code < steps.size and steps[code] <= value:
                    code += 1
                out[y, x, c] = code


@kernel
def vote_label(
    plan: VoteGroups, reach: Reach, ranks: Int32, begin: int, slots: tuple[Int32, Int64], weight: Int64
) -> None:
    """Add up the weight of every label that gets votes in rows from `begin` on.

    `slots` = (label, weight), (rows, w, K) each for at most K labels, weight 0 where a slot is free: the first one has
    the largest weight, the smallest label of equals. `weight` (rows, w) is that of all.
    """
    columns, hits = scratch(plan)
    label, share = slots
    for g in range(plan.groups.shape[0]):
        first, last = open_group(plan, g, begin, begin + weight.shape[0], columns)
        for y in range(first, last):
            n = weigh_row(plan, reach, g, y, first, columns, hits)
            for i in range(n):
                row, x, w, rank = y - begin, hits[0, i], hits[1, i], ranks[hits[2, i]]
                k = 0
                while share[row, x, k] > 0 and label[row, x, k] != rank:
                    k += 1
                weight[row, x] += w
                w += share[row, x, k]
                if w > share[row, x, 0] or (w == share[row, x, 0] and rank < label[row, x, 0]):
                    label[row, x, k], share[row, x, k] = label[row, x, 0], share[row, x, 0]
                    k = 0
                label[row, x, k], share[row, x, k] = rank, w


@kernel
def _decoded(v: Any, top: Any, signed: bool) -> float:
    return float(v) if signed else 2.0 * v - top


@kernel
def encode_vectors(
    samples: Array, turn: Turn, first: Int64, top: Any, signed: bool, total: Floats | None, weight: Floats | None,
    out: Array,
) -> None:  # fmt: skip
    """Write the codes (h, w, 3) of pixels `first` (h, w), 8 u + pose of `samples` (N, 3), turned by their poses.

    With a `total` (h, w, 3) those of its vectors, made unit length and rounded half up, unless they are 0. With a
    `weight` (h, w) it is relative to so many times the vector of the first pixel; where votes then cancel the weight
    becomes 0. `top` is the code of +1, of the type of samples; its opposite is 0, or -1 (`signed`).
    """
    channel, sign = turn
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            u, p = first[y, x] >> 3, first[y, x] & 7
            for c in range(3):
                v = samples[u, channel[p, c]]
                out[y, x, c] = v if sign[p, c] > 0 else (-v if signed else top - v)
            if total is not None:
                a, b, z = total[y, x, 0], total[y, x, 1], total[y, x, 2]
                if a == 0.0 and b == 0.0 and z == 0.0:
                    continue
                if weight is not None:
                    w = weight[y, x]
                    a += sign[p, 0] * _decoded(samples[u, channel[p, 0]], top, signed) * w
                    b += sign[p, 1] * _decoded(samples[u, channel[p, 1]], top, signed) * w
                    z += sign[p, 2] * _decoded(samples[u, channel[p, 2]], top, signed) * w
                length = np.sqrt((a * a + b * b) + z * z)
                if length == 0.0:
                    if weight is not None:
                        weight[y, x] = 0.0
                    continue
                for c, n in enumerate((a / length, b / length, z / length)):
                    share = n if signed else (n + 1.0) / 2.0
                    if top > 1:
                        out[y, x, c] = np.int64(floor(min(max(share, 0.0), 1.0) * top + 0.5))
                    else:
                        out[y, x, c] = share
