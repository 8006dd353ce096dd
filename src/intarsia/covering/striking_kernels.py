"""What takes long where striking things are covered: how often placements are shown already, and what they show."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..arrays import Int32, Int64, Pair
from ..kernels.jit import kernel
from ..kernels.windows import HOLE, canvas_place

ONE, NEAR = 256, 3  # as of `seams/placement_kernels.py`: all of it, once; how much more a repeat beside it counts
CELL = 16  # px of a variant: samples of a map are kept by these


class Looks(NamedTuple):
    """What all variants show, one after the other, each row by row."""

    things: Int32  # (pixels of all variants,): the thing that a pixel belongs to, 0: none
    strikes: Int32  # the same: how much it strikes
    frames: Int64  # (V, 3): where a variant begins in these, rows and columns


class Samples(NamedTuple):
    """Every so many-th pixel of a map, by cells of what it shows."""

    at: Int32  # (n, 4): row and column on the canvas, row and column in the variant
    begin: Int64  # (cells + 1,): where a cell begins in these
    cells: Int64  # (V, 3): the first cell of a variant, rows and columns of cells
    step: int


@kernel
def sort_samples(grown: Any, samples: Any) -> None:
    """Sort the samples of a map, from the middle of the first step on, by the cells of what they show."""
    variant, yx, _ = grown
    at, begin, cells, step = samples
    height, width = variant.shape
    begin[:] = 0
    for place in range(2):  # counted, then put
        for y in range(step // 2, height, step):
            for x in range(step // 2, width, step):
                v = variant[y, x]
                if v == HOLE:
                    continue
                cell = cells[v, 0] + yx[y, x, 0] // CELL * cells[v, 2] + yx[y, x, 1] // CELL
                if place == 0:
                    begin[cell] += 1
                    continue
                begin[cell] -= 1
                k = begin[cell]
                at[k, 0], at[k, 1], at[k, 2], at[k, 3] = y, x, yx[y, x, 0], yx[y, x, 1]
        if place == 0:
            for cell in range(1, len(begin)):
                begin[cell] += begin[cell - 1]


@kernel
def _posed_place(turn: Any, y: int, x: int) -> Pair:
    """Where a pixel of a variant lies in another one of the same exemplar."""
    return turn[0] * y + turn[1] * x + turn[4], turn[2] * y + turn[3] * x + turn[5]


@kernel
def _touches(cell: int, first: int, count: int, length: int, torus: bool) -> bool:
    """Whether a cell along an axis holds any of `count` px from the first on, round a torus of this length."""
    begin = cell * CELL
    if torus:
        return (begin - first) % length < count or (first - begin) % length < CELL
    return begin < first + count and begin + CELL > first


@kernel
def count_shown(grown: Any, pieces: Any, turns: Any, samples: Any, box: Any, rows: Any, out: Any) -> None:
    """Count for each placement how much of what it shows is on the canvas already: ONE = all of it, once.

    The same as :func:`..seams.placement_kernels.repeats` without courses, but only cells are looked at that hold what
    is shown. `samples`: of the map as it is.
    """
    (variant, _, wrap), table, torus = grown, pieces.table, pieces.torus
    (height, width), h, w = variant.shape, box[2], box[3]
    at, begin, cells, step = samples
    reach = 3 * max(h, w) // 2 + 1
    for k in range(len(rows)):
        u, row, column, total = rows[k, 1], rows[k, 2], rows[k, 3], 0
        for v in range(len(cells)):
            if u != v and not turns[v, u, 6]:
                continue
            p, q, r, s = row, column, row + h - 1, column + w - 1  # opposite corners, as they lie in the variant
            if u != v:
                (p, q), (r, s) = _posed_place(turns[u, v], p, q), _posed_place(turns[u, v], r, s)
            p, r, q, s = min(p, r), abs(p - r) + 1, min(q, s), abs(q - s) + 1
            for a in range(cells[v, 1]):
                if not _touches(a, p, r, table[v, 1], torus[v]):
                    continue
                for b in range(cells[v, 2]):
                    if not _touches(b, q, s, table[v, 2], torus[v]):
                        continue
                    cell = cells[v, 0] + a * cells[v, 2] + b
                    for n in range(begin[cell], begin[cell + 1]):
                        i, j = int(at[n, 2]), int(at[n, 3])
                        if u != v:
                            i, j = _posed_place(turns[v, u], i, j)
                        i, j = i - row, j - column
                        if torus[u]:
                            i, j = i % table[u, 1], j % table[u, 2]
                        if not (0 <= i < h and 0 <= j < w):
                            continue
                        dy, dx = at[n, 0] - (box[0] + h // 2), at[n, 1] - (box[1] + w // 2)
                        if wrap[0]:
                            dy = (dy + height // 2) % height - height // 2
                        if wrap[1]:
                            dx = (dx + width // 2) % width - width // 2
                        if u == v and i == dy + h // 2 and j == dx + w // 2:
                            continue  # it goes on from the canvas
                        far = max(abs(dy), abs(dx))
                        total += ONE + (NEAR * ONE * (reach - far) // reach if far < reach else 0)
        out[k] = total * step * step // (h * w)


@kernel
def mean_strikes(looks: Any, box: Any, rows: Any, out: Any) -> None:
    """Write how much what each placement shows strikes on average, rounded down; beyond it lies its beginning."""
    h, w = box[2], box[3]
    for k in range(len(rows)):
        begin, height, width = looks.frames[rows[k, 1]]
        total, first = 0, rows[k, 3] % width
        for i in range(h):
            row, column = begin + (rows[k, 2] + i) % height * width, first
            for _ in range(w):
                total += looks.strikes[row + column]
                column = column + 1 if column + 1 < width else 0
        out[k] = total // (h * w)


@kernel
def things_shown(grown: Any, looks: Any, out: Any) -> None:
    """Write the thing that every pixel of a map shows, (H, W) int32; 0: none."""
    variant, yx, _ = grown
    for y in range(variant.shape[0]):
        for x in range(variant.shape[1]):
            v = variant[y, x]
            if v == HOLE:
                out[y, x] = 0
            else:
                out[y, x] = looks.things[looks.frames[v, 0] + yx[y, x, 0] * looks.frames[v, 2] + yx[y, x, 1]]


@kernel
def mark_part(part: Any, wrap: Any, box: Any, number: int, edge: int, price: int, out: Any) -> int:
    """Write a price where a box shows a part, or lies within `edge` steps of it, 0 elsewhere; returns its pixels.

    `out` (rows, columns) int32. What lies outside the box does not count.
    """
    height, width = part.shape
    h, w, count = box[2], box[3], 0
    out[:] = 0
    for i in range(h):
        y = canvas_place(box[0] + i, height, wrap[0])
        for j in range(w):
            if part[y, canvas_place(box[1] + j, width, wrap[1])] != number:
                continue
            count += 1
            for a in range(max(i - edge, 0), min(i + edge + 1, h)):
                far = edge - abs(a - i)
                out[a, max(j - far, 0) : min(j + far + 1, w)] = price
    return count
