"""Kernels of walls: course layout by dynamic programming, least cuts in head joints and in bed joints.

A scene is the data of the exemplar: (picture (H, W, C) int16, usable (H, W), faces (H, W): the cost of a pixel beyond
its piece, beds (n, W), joints (m, H), and (2,) the widths of the right and the left half of a joint). A piece is a row
of nine numbers: first column and end on the canvas, the offsets from canvas columns and rows to those of the exemplar,
the number of its course, the joints at its left and right end (NO_JOINT: cut there), the exemplar columns of its ends.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from ..kernels.shortest_paths import least_cut
from .block_kernels import readable

FAR = np.int64(1) << 60  # cost of an impossible chain
STRETCH = 8  # cost per px that joints are widened or narrowed; halved: 3.8 px on 10 walls instead of 3.0, doubled: 2.1
SLIVER = 3000  # largest cost of a cut piece that is too short; 0: six wrapped walls have some; halved, doubled: same


@kernel
def best_chain(length: int, sizes: Any, start: Any, joint: Any, pair: Any, closing: Any, rules: Any, out: Any) -> int:
    """Find the cheapest chain of `length` px by dynamic programming; return the number of its elements.

    Write to `out` (n, 3) for each: element, first column, end.

    `sizes` (K,): lengths of the elements, px; `start` (K, length + 1): cost of an element by its first column; `joint`
    (length + 1,): cost of a joint by column; `pair` (K, K): cost of the second after the first; `closing` (K,): cost of
    the last element before the one that follows the chain. `rules`: the first element; the px by which the chain may
    miss its length; the least px that the last element may be cut to without further cost, and the cost of cutting; the
    cost of an element that is also second or third before; the element that follows the chain, or -1. The last element
    may be cut, so that there always is a chain.
    """
    first, slack, least, cut, again, following = rules[0], rules[1], rules[2], rules[3], rules[4], rules[5]
    count = len(sizes)
    best = np.full((length + slack + 1, count), FAR, np.int64)
    back = np.full((length + slack + 1, count), -1, np.int64)
    if sizes[first] <= length + slack:
        best[sizes[first], first] = start[first, 0]
    end, last, tail, least_cost = 0, first, -1, FAR
    for u in range(1, length + slack + 1):
        rest = length - u
        for k in range(count):
            if best[u, k] == FAR:
                continue
            before = back[u, k]
            third = back[u - sizes[k], before] if before >= 0 else -1
            if abs(rest) <= slack:
                cost = best[u, k] + closing[k] + STRETCH * abs(rest)
                if following >= 0 and before == following:
                    cost += again
                if cost < least_cost:
                    end, last, tail, least_cost = u, k, -1, cost
            if rest <= 0:
                continue
            for m in range(count):
                v = u + sizes[m]
                grown = best[u, k] + pair[k, m] + joint[u] + start[m, u]
                if v <= length + slack:
                    cost = grown + again if m in (before, third) else grown
                    if cost < best[v, m]:
                        best[v, m], back[v, m] = cost, k
                if v > length:
                    cost = grown + closing[m] + cut + SLIVER * max(0, least - rest) // least
                    if m == before or k == following:
                        cost += again
                    if cost < least_cost:
                        end, last, tail, least_cost = u, k, m, cost
    if least_cost == FAR:
        out[0, 0], out[0, 1], out[0, 2] = first, 0, length
        return 1
    return _written(length, sizes, back, end, last, tail, out)


@kernel
def _written(length: int, sizes: Any, back: Any, end: int, last: int, tail: int, out: Any) -> int:
    """Trace a chain back and write it in order; px missing from its length are spread over its joints."""
    n, u, k = 0, end, last
    while u > 0:
        n += 1
        u, k = u - sizes[k], back[u, k]
    missing = length - end if tail < 0 else 0
    u, k = end, last
    for at in range(n - 1, -1, -1):
        out[at, 0], out[at, 2] = k, u + missing * (at + 1) // n
        u, k = u - sizes[k], back[u, k]
        out[at, 1] = u + missing * at // n
    if tail >= 0:
        out[n, 0], out[n, 1], out[n, 2] = tail, end, length
        n += 1
    return n


NO_JOINT = -1  # in place of a joint's number: the piece is cut there
UNREADABLE = 1 << 20  # cost of a pixel that is not usable, a hundred times the largest distance of two pixels
STEP = 8  # least cost of a pixel beyond its joint or bed
BEYOND = 1 << 40  # px: a column beyond any exemplar


@kernel
def misplacement_cost(usable: Any, faces: Any, y: int, x: int, beyond: bool) -> int:
    """Return the cost of an exemplar pixel (y, x): 0 within its piece, UNREADABLE if not usable; `beyond`: outside."""
    if not readable(usable, y, x):
        return UNREADABLE
    return int(faces[y, x]) + STEP if beyond else 0


@kernel
def colour_distance(picture: Any, a: int, b: int, y: int, x: int) -> int:
    """Return the colour distance of exemplar pixels (a, b) and (y, x), clamped to the border, rounded down."""
    h, w = picture.shape[:2]
    a, b, y, x = min(max(a, 0), h - 1), min(max(b, 0), w - 1), min(max(y, 0), h - 1), min(max(x, 0), w - 1)
    total = np.int64(0)
    for c in range(picture.shape[2]):
        d = np.int64(picture[a, b, c]) - np.int64(picture[y, x, c])
        total += d * d
    return int(np.sqrt(np.float64(total)))


@kernel
def border(joints: Any, half: int, kind: int, end: int, side: int, y: int) -> int:
    """Return the exemplar column up to which a piece may be used on the left (side 0) or right (1) in row `y`.

    That is its joint, or for a cut end `end` less half a joint. There is no limit above and below the exemplar.
    """
    if kind == NO_JOINT:
        return end + half if side == 0 else end - half
    if not 0 <= y < joints.shape[1]:
        return -BEYOND if side == 0 else BEYOND
    return int(joints[kind, y])


@kernel
def cut_head_joint(scene: Any, left: Any, right: Any, first: int, cut: Any, reach: int) -> None:
    """Cut two pieces row by row from canvas row `first`: `cut` (n,) is the first column of the right one."""
    n, wide = len(cut), 2 * reach + 1
    u = right[0]
    cost = np.empty((n, wide), np.int64)
    gaps = np.empty((n, 2 * reach), np.int64)
    gap = np.empty(2 * reach + 2, np.int64)
    wrong = np.empty((2, 2 * reach + 2), np.int64)
    picture, usable, faces, _, joints, halves = scene
    for r in range(n):
        y, x = first + r, u - reach - 1  # columns u - reach - 1 .. u + reach
        high = border(joints, halves[1], left[6], left[8], 1, y + left[3])
        low = border(joints, halves[0], right[5], right[7], 0, y + right[3])
        for k in range(2 * reach + 2):
            a, b, c, d = y + left[3], x + k + left[2], y + right[3], x + k + right[2]
            gap[k] = colour_distance(picture, a, b, c, d)
            wrong[0, k], wrong[1, k] = (
                misplacement_cost(usable, faces, a, b, b >= high),
                misplacement_cost(usable, faces, c, d, d < low),
            )
        gaps[r] = gap[1:-1]
        before, after = np.int64(0), wrong[1, 1:].sum()
        for k in range(wide):  # the right piece begins at column u - reach + k
            cost[r, k] = gap[k] + gap[k + 1] + before + after
            if k + 1 < wide:
                before += wrong[0, k + 1]
                after -= wrong[1, k + 1]
    cut[:] = u - reach + least_cut(cost, gaps)


@kernel
def place_course(scene: Any, pieces: Any, rows: Any, spans: Any, out: Any, wrong: Any) -> None:
    """Place the pieces of a course: `out` (R, w, 2) the exemplar pixels, `wrong` (R, w) their costs beyond its beds.

    `rows` (w,): the canvas row of the first row of `out` in each column; `spans` (n, 3): for the joint before every
    piece its first canvas row, number of rows, and the largest distance of the cut, px; `pieces` (n, 9): from left to
    right over all columns, canvas columns counted from the first of `out`.
    """
    tall, wide = out.shape[:2]
    n = len(pieces)
    _, usable, faces, beds, _, _ = scene
    cuts = np.empty((n, spans[:, 1].max()), np.int64)
    for k in range(1, n):
        cut_head_joint(scene, pieces[k - 1], pieces[k], spans[k, 0], cuts[k, : spans[k, 1]], spans[k, 2])
    at = 0
    for x in range(wide):
        while at + 1 < n and pieces[at, 1] <= x:
            at += 1
        for v in range(tall):
            y = rows[x] + v
            k = at
            if k > 0 and x < cuts[k, min(max(y - spans[k, 0], 0), spans[k, 1] - 1)]:
                k -= 1
            elif k + 1 < n and x >= cuts[k + 1, min(max(y - spans[k + 1, 0], 0), spans[k + 1, 1] - 1)]:
                k += 1
            a, b, course = y + pieces[k, 3], x + pieces[k, 2], pieces[k, 4]
            out[v, x, 0], out[v, x, 1] = a, b
            column = min(max(b, 0), beds.shape[1] - 1)
            beyond = a < beds[course, column] or a >= beds[course + 1, column]
            wrong[v, x] = misplacement_cost(usable, faces, a, b, beyond)


@kernel
def bed_costs(scene: Any, upper: Any, lower: Any, shift: Any, reach: int) -> Any:
    """Return the cost of each cut between two courses: (w, 2 reach + 2); cut k leaves k rows of the band to the upper.

    Also return the colour distance of both courses at each pixel of the band: (w, 2 reach + 1).

    `upper`, `lower`: (pixels (R, w, 2), wrong (R, w)) from :func:`place_course`; the band is the first 2 reach + 1 rows
    of the lower one, and lies `shift` (w,) rows down in the upper one.
    """
    band = 2 * reach + 1
    wide = len(shift)
    cost = np.empty((wide, band + 1), np.int64)
    gaps = np.empty((wide, band), np.int64)
    for x in range(wide):
        gap = gaps[x]
        after = np.int64(0)
        for k in range(band):
            a, b = upper[0][shift[x] + k, x], lower[0][k, x]
            gap[k] = colour_distance(scene[0], a[0], a[1], b[0], b[1])
            after += lower[1][k, x]
        before = np.int64(0)
        for k in range(band + 1):
            cost[x, k] = before + after + gap[max(k - 1, 0)] + gap[min(k, band - 1)]
            if k < band:
                before += upper[1][shift[x] + k, x]
                after -= lower[1][k, x]
    return cost, gaps


@kernel
def write_course(pixels: Any, rows: Any, top: Any, end: Any, out: Any, at: Any) -> None:
    """Write the rows top .. end - 1 of a course (R, w, 2) to a window `out`.

    `rows` (w,): the window's row for the first row of the course; `at`: the window's column for its first column.
    """
    for x in range(len(top)):
        u = x + at
        if not 0 <= u < out.shape[1]:
            continue
        for v in range(top[x], end[x]):
            y = rows[x] + v
            if 0 <= y < out.shape[0]:
                out[y, u, 0], out[y, u, 1] = pixels[v, x, 0], pixels[v, x, 1]
