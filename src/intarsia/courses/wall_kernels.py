"""Courses laid in rows: pieces cut together in their joints, and courses cut together in the beds between them.

A scene is what the exemplar shows: (picture (H, W, C) int16, usable (H, W), faces (H, W): what a pixel costs where
it does not belong, beds (n, W), joints (m, H), and (2,) how wide the right and the left half
of a joint are). A piece is a row of ten numbers:
first column and end on the canvas, what to add to a canvas column and row to read it, the number of its course,
what lies at its left and right end (a joint's number; FACE: the course is cut there; OPEN: it runs on), and the
exemplar columns of both ends.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from ..kernels.paths import least_cut

FACE, OPEN = -1, -2  # names, beside the numbers of joints
UNREADABLE = 1 << 20  # more than any cut costs without it: a hundred times the largest distance of two pixels
STEP = 8  # what a pixel beyond its joint counts at least


@kernel
def readable(usable: Any, y: int, x: int) -> bool:
    """Say whether an exemplar pixel exists and may be used."""
    return bool(0 <= y < usable.shape[0] and 0 <= x < usable.shape[1] and usable[y, x])


@kernel
def apart(picture: Any, a: int, b: int, y: int, x: int) -> int:
    """The distance of two exemplar pixels; those outside count as the nearest inside."""
    h, w = picture.shape[:2]
    a, b, y, x = min(max(a, 0), h - 1), min(max(b, 0), w - 1), min(max(y, 0), h - 1), min(max(x, 0), w - 1)
    total = np.int64(0)
    for c in range(picture.shape[2]):
        d = np.int64(picture[a, b, c]) - np.int64(picture[y, x, c])
        total += d * d
    return int(np.sqrt(np.float64(total)))


@kernel
def astray(scene: Any, piece: Any, y: int, x: int, side: int) -> int:
    """What it costs to show the exemplar's (y, x) as part of a piece, beyond its left (0) or right (1) joint."""
    if not readable(scene[1], y, x):
        return UNREADABLE
    kind, end = piece[5 + side], piece[7 + side]
    if kind == OPEN:
        return 0
    if kind == FACE:
        beyond = x < end + scene[5][0] if side == 0 else x >= end - scene[5][1]
    else:
        beyond = x < scene[4][kind, y] if side == 0 else x >= scene[4][kind, y]
    return int(scene[2][y, x]) + STEP if beyond else 0


@kernel
def junction(scene: Any, left: Any, right: Any, first: int, cut: Any, reach: int) -> None:
    """Cut two pieces together, row by row from canvas row `first`: `cut` (n,) is the first column of the right one."""
    n, wide = len(cut), 2 * reach + 1
    u = right[0]
    cost = np.empty((n, wide), np.int64)
    gaps = np.empty((n, 2 * reach), np.int64)
    gap = np.empty(2 * reach + 2, np.int64)
    wrong = np.empty((2, 2 * reach + 2), np.int64)
    for r in range(n):
        y = first + r
        for k in range(2 * reach + 2):  # columns u - reach - 1 .. u + reach
            x = u - reach - 1 + k
            gap[k] = apart(scene[0], y + left[3], x + left[2], y + right[3], x + right[2])
            wrong[0, k] = astray(scene, left, y + left[3], x + left[2], 1)
            wrong[1, k] = astray(scene, right, y + right[3], x + right[2], 0)
        gaps[r] = gap[1 : 2 * reach + 1]
        before, after = np.int64(0), np.int64(0)
        for k in range(1, 2 * reach + 2):
            after += wrong[1, k]
        for k in range(wide):  # the right piece begins at column u - reach + k
            cost[r, k] = gap[k] + gap[k + 1] + before + after
            if k + 1 < wide:
                before += wrong[0, k + 1]
                after -= wrong[1, k + 1]
    path = least_cut(cost, gaps)
    for r in range(n):
        cut[r] = u - reach + path[r]


@kernel
def lay(scene: Any, pieces: Any, rows: Any, spans: Any, out: Any, wrong: Any) -> None:
    """Lay the pieces of a course: `out` (R, w, 2) the exemplar pixels, `wrong` (R, w) what lies beyond its beds.

    `rows` (w,): the canvas row of the first row of `out` in each column; `spans` (n, 3): for the junction before
    every piece its first canvas row, how many rows, and how far it may reach; `pieces` (n, 10) from left to right
    over all columns, canvas columns counted from the first of `out`.
    """
    tall, wide = out.shape[:2]
    n = len(pieces)
    cuts = np.empty((n, max(1, spans[:, 1].max())), np.int64)
    for k in range(1, n):
        junction(scene, pieces[k - 1], pieces[k], spans[k, 0], cuts[k, : spans[k, 1]], spans[k, 2])
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
            p = pieces[k]
            a, b = y + p[3], x + p[2]
            out[v, x, 0], out[v, x, 1] = a, b
            if not readable(scene[1], a, b):
                wrong[v, x] = UNREADABLE
                continue
            beyond = a < scene[3][p[4], b] or a >= scene[3][p[4] + 1, b]
            wrong[v, x] = scene[2][a, b] + STEP if beyond else 0


@kernel
def part(scene: Any, upper: Any, lower: Any, shift: Any, reach: int) -> Any:
    """What each cut between two courses costs: (w, 2 reach + 2); cut k leaves k rows of the band to the upper.

    Also how much both courses differ at each pixel of the band: (w, 2 reach + 1).

    `upper`, `lower`: (pixels (R, w, 2), wrong (R, w)) as :func:`lay` makes them; the band is the first
    2 reach + 1 rows of the lower one, and lies `shift` (w,) rows down in the upper one.
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
            gap[k] = apart(scene[0], a[0], a[1], b[0], b[1])
            after += lower[1][k, x]
        before = np.int64(0)
        for k in range(band + 1):
            cost[x, k] = before + after + gap[max(k - 1, 0)] + gap[min(k, band - 1)]
            if k < band:
                before += upper[1][shift[x] + k, x]
                after -= lower[1][k, x]
    return cost, gaps


@kernel
def pour(pixels: Any, rows: Any, top: Any, end: Any, out: Any, at: Any) -> None:
    """Write the rows top .. end of a laid course (R, w, 2) to a window `out` whose first column is column -`at`."""
    for x in range(len(top)):
        u = x + at
        if not 0 <= u < out.shape[1]:
            continue
        for v in range(top[x], end[x]):
            y = rows[x] + v
            if 0 <= y < out.shape[0]:
                out[y, u, 0], out[y, u, 1] = pixels[v, x, 0], pixels[v, x, 1]
