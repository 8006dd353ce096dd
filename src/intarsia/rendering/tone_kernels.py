"""Steps of tone across seams: the constant part of the difference of two pieces around each pixel of their seam."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int64, Mask
from ..kernels.jit import kernel
from ..kernels.maps import HOLE, J

REACH = 8  # px to either side of a seam within which both pieces are compared
APART = REACH // 2  # px between compared places, which are 5 x 5
LEAST = 5  # places that must exist in both pieces, else the step is 0


class Surroundings(NamedTuple):
    """Local statistics of the exemplars, concatenated."""

    means: Int64  # (N, C): means over small squares
    counts: Mask  # (N,): the pixels that count; empty: all
    variance: float  # of the pixels that count, summed over channels


@kernel
def _place(side: Any, dy: int, dx: int) -> int:
    """Return the index of the exemplar pixel for the canvas pixel (dy, dx) from a given one; -1 outside the exemplar.

    `side`: the index of the exemplar's first pixel, its height, width, whether it is toroidal; and row, column and pose
    of the given pixel.
    """
    begin, height, width, toroidal, row, column, pose = side
    y, x = row + J[pose, 0] * dy + J[pose, 1] * dx, column + J[pose, 2] * dy + J[pose, 3] * dx
    if not toroidal and not (0 <= y < height and 0 <= x < width):
        return -1
    found: int = begin + y % height * width + x % width
    return found


@kernel
def _step(around: Any, one: Any, other: Any, scale: int, sums: Any, step: Any) -> None:
    """Write the step between two pieces per channel: the constant part of their difference; 0 if it is not constant.

    Both are compared in 5 x 5 places, up to REACH px to all sides. With m the mean difference and v its variance the
    step is m (1 - v / |m|^2), 0 at least. It is reduced if the difference at the seam itself is smaller than m, or if
    |m|^2 exceeds the variance of the exemplar, as the content then differs. `sums` (2, C) are overwritten.
    """
    means, counts, variance = around
    squares, count, seen, channels = np.float64(0), 0, False, means.shape[1]  # sums of whole numbers of 17 bits
    total, here = sums
    total[:], here[:], step[:] = 0, 0, 0
    for dy in range(-REACH, REACH + 1, APART):
        for dx in range(-REACH, REACH + 1, APART):
            p, q = _place(one, dy * scale, dx * scale), _place(other, dy * scale, dx * scale)
            if p < 0 or q < 0 or (counts.size and not (counts[p] and counts[q])):
                continue
            for c in range(channels):
                apart = np.float64(means[p, c] - means[q, c])
                total[c] += apart
                squares += apart * apart
                if dy == 0 and dx == 0:
                    here[c], seen = apart, True
            count += 1
    steady, along = 0.0, 0.0
    for c in range(channels):
        mean = total[c] / max(count, 1)
        steady += mean * mean
        along += mean * (here[c] if seen else mean)
    if count < LEAST or along <= 0:
        return
    share = max(1 - max(squares / count - steady, 0.0) / steady, 0.0)
    share *= min(along / steady, 1.0) * min(variance / steady, 1.0)
    for c in range(channels):
        step[c] = np.floor(share * (total[c] / count) + 0.5)


@kernel
def seam_steps(part: Any, table: Any, around: Any, scale: int, out: Any) -> None:
    """Add the divergence of the correction, the steps at seams with the opposite sign, to `out` (h, w, C).

    `part` is a map (yx, which, pose) of as many pixels; where the piece of a pixel is lighter by d than that of the
    next one, to the right or below, d is added at the pixel and subtracted at the next.
    """
    yx, which, pose = part
    (height, width), channels = which.shape, out.shape[2]
    sums, step = np.empty((2, channels)), np.empty(channels)
    for y in range(height):
        for x in range(width):
            for down in range(2):
                v, u = y + down, x + 1 - down
                if v >= height or u >= width or which[y, x] == HOLE or which[v, u] == HOLE:
                    continue
                one, other, turn = table[which[y, x]], table[which[v, u]], pose[v, u]
                row, column = np.int64(yx[y, x, 0]), np.int64(yx[y, x, 1])
                before, aside = yx[v, u, 0] - np.int64(J[turn, 1 - down]), yx[v, u, 1] - np.int64(J[turn, 3 - down])
                if which[y, x] == which[v, u] and pose[y, x] == turn:
                    off = before - row, aside - column
                    if off == (0, 0) or (other[3] and off[0] % other[1] == 0 and off[1] % other[2] == 0):
                        continue  # the piece continues: no seam
                here = one[0], one[1], one[2], one[3], row, column, pose[y, x]
                there = other[0], other[1], other[2], other[3], before, aside, turn
                _step(around, here, there, scale, sums, step)
                for c in range(channels):
                    out[y, x, c] += np.int64(step[c])
                    out[v, u, c] -= np.int64(step[c])
