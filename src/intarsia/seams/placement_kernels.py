"""Costs of a placement besides its seams: repeats nearby, mirror images, whole exemplars side by side.

A variant is an exemplar in one of the eight isometries.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..foundation.arrays import Pair
from ..kernels.jit import kernel
from ..kernels.maps import HOLE, canvas_place

ONE = 256  # the unit of repeats: every pixel of a window is repeated once
NEAR = 3  # additional weight of a repeat at the middle of the window; falls linearly to 0 at `reach_of` px


class Look(NamedTuple):
    """A part of the canvas, possibly over borders that wrap, sampled at every `step`-th px."""

    y: int
    x: int
    rows: int
    columns: int
    step: int


@kernel
def posed_place(turn: Any, y: int, x: int) -> Pair:
    """Return where a pixel of a variant lies in another variant of the same exemplar."""
    return turn[0] * y + turn[1] * x + turn[4], turn[2] * y + turn[3] * x + turn[5]


def reach_of(rows: int, columns: int) -> int:
    """Return how far from the middle of a window a repeat counts more, px: 1.5 times its longer side."""
    return 3 * max(rows, columns) // 2 + 1


@kernel
def repeats(grown: Any, pieces: Any, turns: Any, look: Any, box: Any, rows: Any, once: int, out: Any) -> None:
    """Write for each candidate its weighted repeats of pixels around the window into `out`; ONE = all of it, once.

    A repeat is a sampled canvas pixel whose exemplar pixel the candidate would show in the window. At the middle of the
    window it counts NEAR, falling linearly to 0 at :func:`reach_of` px along the farther axis. A pixel that already
    lies where the candidate would put it is a continuation, no repeat: it counts minus `once`, which cancels its share
    in the occurrences of the whole map (:attr:`GraphcutMap.told`). Repeats in other isometries count, too.

    Parameters
    ----------
    grown, pieces
        The map, and the posed exemplars (:class:`.energy_kernels.Pieces`).
    turns : (V, V, 7)
        As ``PosedExemplars.turns``.
    look : Look
        Where the canvas is sampled, from the middle of the first step on.
    box : (4,)
        First row and column of the window, its rows and columns.
    rows : (n, 4)
        Distance, variant, row and column of the candidates.
    once : int
        What one occurrence anywhere in the map counts.
    out : (n,) int64
    """
    (variant, yx, wrap), table, torus, step = grown, pieces.table, pieces.torus, look.step
    (height, width), h, w = variant.shape, box[2], box[3]
    reach = 3 * max(h, w) // 2 + 1
    out[:] = 0
    for a in range(step // 2, look.rows, step):
        y = (look.y + a) % height
        dy = y - (box[0] + h // 2)
        if wrap[0]:
            dy = (dy + height // 2) % height - height // 2
        for b in range(step // 2, look.columns, step):
            x = (look.x + b) % width
            v, dx = variant[y, x], x - (box[1] + w // 2)
            if wrap[1]:
                dx = (dx + width // 2) % width - width // 2
            near = max(reach - max(abs(dy), abs(dx)), 0)
            for k in range(len(rows) if v != HOLE else 0):
                u, i, j = rows[k, 1], int(yx[y, x, 0]), int(yx[y, x, 1])
                if u != v:
                    if not turns[v, u, 6]:
                        continue
                    i, j = posed_place(turns[v, u], i, j)
                i, j = i - rows[k, 2], j - rows[k, 3]
                if torus[u]:
                    i, j = i % table[u, 1], j % table[u, 2]
                if not (0 <= i < h and 0 <= j < w):
                    continue
                if u == v and i == dy + h // 2 and j == dx + w // 2:
                    out[k] -= once  # the candidate continues the canvas here
                else:
                    out[k] += NEAR * ONE * near // reach
    for k in range(len(rows)):
        out[k] = out[k] * step * step // (h * w)


@kernel
def mirrored_pixels(grown: Any, pieces: Any, turns: Any, box: Any, rows: Any, step: int, out: Any) -> None:
    """Count for each candidate the pixels that the canvas shows nearby in another isometry, as next to a mirror.

    Nearby: less than half a window's longer side away along both axes. Every `step`-th canvas pixel along both axes is
    sampled, and stands for `step` squared. `box` and `rows` as in :func:`repeats`, `turns` as ``PosedExemplars.turns``.
    """
    (variant, yx, wrap), table, torus = grown, pieces.table, pieces.torus
    height, width = variant.shape
    h, w = box[2], box[3]
    near = max(h, w) // 2
    out[:] = 0
    for a in range(-near, h + near, step):
        y = canvas_place(box[0] + a, height, wrap[0])
        for b in range(-near, w + near, step):
            x = canvas_place(box[1] + b, width, wrap[1])
            if y < 0 or x < 0 or variant[y, x] == HOLE:
                continue
            for k in range(len(rows)):
                turn = turns[variant[y, x], rows[k, 1]]
                if not turn[6]:
                    continue
                i, j = posed_place(turn, yx[y, x, 0], yx[y, x, 1])
                i, j = i - rows[k, 2], j - rows[k, 3]
                if torus[rows[k, 1]]:
                    i, j = i % table[rows[k, 1], 1], j % table[rows[k, 1], 2]
                if 0 <= i < h and 0 <= j < w and abs(i - a) < near and abs(j - b) < near:
                    out[k] += step * step


@kernel
def repeats_whole_exemplar(grown: Any, pieces: Any, box: Any, rows: Any, near: int, out: Any) -> None:
    """Set `out` to 1 for candidates that repeat what the map shows one exemplar height or width away, else to 0.

    Tested are 9 points of the window against the 9 displacements by -1, 0 or 1 exemplar heights and widths, within
    `near` px. If the opposite borders of an exemplar fit, such placements cost no seam at all, and the result would be
    copies of the whole exemplar, side by side. Displacements that, round a canvas that wraps, are shorter than the
    window along both axes are left out. `box` and `rows` as in :func:`repeats`.
    """
    (variant, yx, wrap), table = grown, pieces.table
    (height, width), h, w = variant.shape, box[2], box[3]
    for k in range(len(rows)):
        v, out[k] = rows[k, 1], 0
        rise, run, torus = table[v, 1], table[v, 2], pieces.torus[v]
        for way in range(9):
            dy, dx = (way // 3 - 1) * rise, (way % 3 - 1) * run
            away = (dy + height // 2) % height - height // 2 if wrap[0] else dy
            aside = (dx + width // 2) % width - width // 2 if wrap[1] else dx
            for spot in range(9 if abs(away) >= h or abs(aside) >= w else 0):
                i, j = h // 2 + (spot // 3 - 1) * (h // 3), w // 2 + (spot % 3 - 1) * (w // 3)
                y, x = canvas_place(box[0] + i + dy, height, wrap[0]), canvas_place(box[1] + j + dx, width, wrap[1])
                if y < 0 or x < 0 or variant[y, x] != v:
                    continue
                a, b = yx[y, x, 0] - rows[k, 2] - i, yx[y, x, 1] - rows[k, 3] - j
                if torus:
                    a, b = (a + near) % rise - near, (b + near) % run - near
                if abs(a) <= near and abs(b) <= near:
                    out[k] = 1
