"""Add up the votes of all groups of a cell, one kernel for each way to mix; and copy without mixing.

Every kernel walks the groups in the order of the plan, so that floating point sums never depend on the
window. Arrays named `squares` (sum of squared weights) are filled unless they are empty.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from .vote_kernels import VotedExemplars, Voters, open_group, scratch, weigh_row

Array = NDArray[Any]
LIMB = 14
"""Linear light has two limbs of this many bits, so that sums weighted by 16-bit opacity fit into 64 bits."""

Turn = tuple[NDArray[np.int64], NDArray[np.int64]]
"""(channel, sign), (8, 3) each: what a pose makes of the components."""


@kernel
def copy_cell(
    yx: NDArray[np.int32], which: NDArray[np.uint8], exemplars: NDArray[np.int64], samples: Array, out: Array
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
def vote_plain(
    plan: Voters, ground: VotedExemplars, samples: Array, light: NDArray[np.int32], total: NDArray[np.int64],
    weight: NDArray[np.int64], squares: NDArray[np.float64],
) -> None:  # fmt: skip
    """Integer pixels: add w * light[code] for every channel."""
    columns, hits = scratch(plan)
    for g in range(plan.groups.shape[0]):
        first, last = open_group(plan, g, 0, weight.shape[0], columns)
        for y in range(first, last):
            n = weigh_row(plan, ground, g, y, first, columns, hits)
            for i in range(n):
                x, w, u = hits[0, i], hits[1, i], hits[2, i]
                weight[y, x] += w
                for c in range(samples.shape[1]):
                    total[y, x, c] += w * light[samples[u, c]]
            if squares.size > 0:
                for i in range(n):
                    squares[y, hits[0, i]] += float(hits[1, i]) * float(hits[1, i])


@kernel
def settle_plain(
    total: NDArray[np.int64], weight: NDArray[np.int64], steps: NDArray[np.int32], shelf: NDArray[np.int32], shift: int,
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
def vote_relative(
    plan: Voters, ground: VotedExemplars, values: Array, turn: tuple[NDArray[np.int64], NDArray[np.int64]],
    total: Array, first: NDArray[np.int64], weight: NDArray[np.int64], squares: NDArray[np.float64],
) -> None:  # fmt: skip
    """Add w * (value - value of the first voter): exactly zero where all agree, whatever the rounding.

    `turn` = (channel, sign), (8, C) each: what a pose makes of the channels. `first` holds 8 u + pose of the
    first voter, -1 at the start.
    """
    columns, hits = scratch(plan)
    channel, sign = turn
    for g in range(plan.groups.shape[0]):
        pose = plan.groups[g, 1]
        begin, last = open_group(plan, g, 0, weight.shape[0], columns)
        for y in range(begin, last):
            n = weigh_row(plan, ground, g, y, begin, columns, hits)
            for i in range(n):
                x, w, u = hits[0, i], hits[1, i], hits[2, i]
                weight[y, x] += w
                if squares.size > 0:
                    squares[y, x] += float(w) * float(w)
                if first[y, x] < 0:
                    first[y, x] = 8 * u + pose
                    continue
                v, q = first[y, x] >> 3, first[y, x] & 7
                for c in range(values.shape[1]):
                    mine = sign[pose, c] * values[u, channel[pose, c]]
                    theirs = sign[q, c] * values[v, channel[q, c]]
                    total[y, x, c] += w * (mine - theirs)


@kernel
def vote_alpha(
    plan: Voters, ground: VotedExemplars, samples: Array, light: NDArray[np.int32],
    limbs: tuple[NDArray[np.int64], NDArray[np.int64]], opaque: NDArray[np.int64], weight: NDArray[np.int64],
    squares: NDArray[np.float64],
) -> None:  # fmt: skip
    """Integer pixels with opacity a: add w a * light in two limbs; w * light while all are transparent."""
    columns, hits = scratch(plan)
    high, low = limbs
    colours = samples.shape[1] - 1
    for g in range(plan.groups.shape[0]):
        first, last = open_group(plan, g, 0, weight.shape[0], columns)
        for y in range(first, last):
            n = weigh_row(plan, ground, g, y, first, columns, hits)
            for i in range(n):
                x, w, u = hits[0, i], hits[1, i], hits[2, i]
                a = np.int64(samples[u, colours])
                weight[y, x] += w
                if a > 0 and opaque[y, x] == 0:
                    high[y, x] = 0
                    low[y, x] = 0
                    if squares.size > 0:
                        squares[y, x] = 0.0
                if a == 0 and opaque[y, x] > 0:
                    continue
                opaque[y, x] += w * a
                if a > 0:
                    w *= a
                if squares.size > 0:
                    squares[y, x] += float(w) * float(w)
                for c in range(colours):
                    value = np.int64(light[samples[u, c]])
                    high[y, x, c] += w * (value >> LIMB)
                    low[y, x, c] += w * (value & ((1 << LIMB) - 1))


@kernel
def vote_alpha_float(
    plan: Voters, ground: VotedExemplars, values: Array, total: NDArray[np.float64], first: NDArray[np.int64],
    opaque: NDArray[np.float64], weight: NDArray[np.int64], squares: NDArray[np.float64],
) -> None:  # fmt: skip
    """Float pixels with opacity: as :func:`vote_alpha`, relative to the first voter.

    `total` (h, w, C) has the opacity last, plainly weighted; `first` (h, w, 2) the voters that colour and
    opacity are relative to.
    """
    columns, hits = scratch(plan)
    n_c = values.shape[1] - 1
    for g in range(plan.groups.shape[0]):
        begin, last = open_group(plan, g, 0, weight.shape[0], columns)
        for y in range(begin, last):
            n = weigh_row(plan, ground, g, y, begin, columns, hits)
            for i in range(n):
                x, w, u = hits[0, i], hits[1, i], hits[2, i]
                a = float(values[u, n_c])
                if weight[y, x] == 0:
                    first[y, x] = u
                weight[y, x] += w
                total[y, x, n_c] += w * (a - float(values[first[y, x, 1], n_c]))
                if a > 0.0 and opaque[y, x] == 0.0:
                    first[y, x, 0] = u
                    total[y, x, :n_c] = 0.0
                    if squares.size > 0:
                        squares[y, x] = 0.0
                if a <= 0.0 and opaque[y, x] > 0.0:
                    continue
                share = w * a if a > 0.0 else float(w)
                if a > 0.0:
                    opaque[y, x] += share
                if squares.size > 0:
                    squares[y, x] += share * share
                for c in range(n_c):
                    total[y, x, c] += share * (float(values[u, c]) - float(values[first[y, x, 0], c]))


@kernel
def vote_label(
    plan: Voters, ground: VotedExemplars, ranks: NDArray[np.int32], begin: int, end: int,
    slots: tuple[NDArray[np.int32], NDArray[np.int64]],
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
    label: NDArray[np.int32], share: NDArray[np.int64], out: NDArray[np.int32], weight: NDArray[np.int64]
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
    samples: Array, turn: Turn, total: Array, first: NDArray[np.int64], weight: NDArray[np.int64], top: int,
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
