"""What takes long where striking things are covered: how placements strike, and what is to go."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..arrays import Int32, Int64
from ..kernels.jit import kernel
from ..kernels.windows import canvas_place


class Looks(NamedTuple):
    """What all variants show, one after the other, each row by row."""

    things: Int32  # (pixels of all variants,): the thing that a pixel belongs to, 0: none
    strikes: Int32  # the same: how much it strikes
    frames: Int64  # (V, 3): where a variant begins in these, rows and columns


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
