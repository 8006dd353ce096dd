"""By how much one of two pieces is lighter than the other where they meet."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Array, Int32, Int64, Mask
from ..kernels.jit import kernel
from ..kernels.maps import HOLE, J

REACH = 8  # px to either side: so far around a seam both pieces are compared
LEAST = 5  # of 25 places must exist in both, or nothing is known of a step


class Surroundings(NamedTuple):
    """What pieces are compared by: means over small squares (N, C), and the variance; `counts` (N,), none: all."""

    means: Int64
    counts: Mask
    variance: float


@kernel
def _meant(at: Int64, y: int, x: int) -> int:
    """The pixel of the ground at row y, column x of an exemplar (first pixel, height, width, toroidal), or -1."""
    height, width = at[1], at[2]
    if at[3] != 0:
        y, x = y % height, x % width
    if not (0 <= y < height and 0 <= x < width):
        return -1
    found: int = at[0] + y * width + x
    return found


@kernel
def _step(
    around: Surroundings, one: Int64, other: Int64, scale: int, at: Any, out: Int64
) -> bool:
    """Write into `out` (C,) by how much one piece is lighter than the other, as far as they show the same.

    `at` (2, 6): of both pieces row and column of the exemplar at one place, and the matrix of the pose. Returns
    whether there is a step. Both are compared in 5 x 5 places, REACH px to all sides: m their mean difference, v its
    variance, the step is m (1 - v / |m|^2), and less where there is less of it at the seam itself, or where it is
    larger than what colours of the exemplar usually differ by: there, something else begins.
    """
    means, counts, variance = around
    channels = means.shape[1]
    total, here = np.zeros(channels), np.zeros(channels)
    squares, n, seen = 0.0, 0, False
    for i in range(-2, 3):
        for j in range(-2, 3):
            dy, dx = i * (REACH // 2) * scale, j * (REACH // 2) * scale
            p = _meant(one, at[0, 0] + at[0, 2] * dy + at[0, 3] * dx, at[0, 1] + at[0, 4] * dy + at[0, 5] * dx)
            q = _meant(other, at[1, 0] + at[1, 2] * dy + at[1, 3] * dx, at[1, 1] + at[1, 4] * dy + at[1, 5] * dx)
            if p < 0 or q < 0 or (counts.size > 0 and not (counts[p] and counts[q])):
                continue
            n += 1
            for c in range(channels):
                apart = float(means[p, c] - means[q, c])
                total[c] += apart
                squares += apart * apart
                if i == 0 and j == 0:
                    here[c], seen = apart, True
    if n < LEAST:
        return False
    steady, along = 0.0, 0.0
    for c in range(channels):
        total[c] /= n
        steady += total[c] * total[c]
        along += total[c] * (here[c] if seen else total[c])
    if along <= 0.0:
        return False
    share = max(1.0 - max(squares / n - steady, 0.0) / steady, 0.0)
    share *= min(along / steady, 1.0) * min(variance / steady, 1.0)
    for c in range(channels):
        out[c] = np.int64(np.floor(share * total[c] + 0.5))
    return True


@kernel
def seam_steps(part: tuple[Array, ...], table: Int64, around: Surroundings, scale: int, out: Int32) -> None:
    """Add the divergence of the steps that are to be evened out to `out` (h, w, C).

    `part` is a map (yx, which, pose) of so many pixels; where a pixel and the next are of pieces of which one is
    lighter by d, the next one has to gain d on it.
    """
    yx, which, pose = part
    height, width, channels = out.shape
    step, at = np.zeros(channels, np.int64), np.zeros((2, 6), np.int64)
    for y in range(height):
        for x in range(width):
            for down in range(2):
                v, u = y + down, x + 1 - down
                if v >= height or u >= width or which[y, x] == HOLE or which[v, u] == HOLE:
                    continue
                for k in range(4):
                    at[0, 2 + k], at[1, 2 + k] = J[pose[y, x], k], J[pose[v, u], k]
                one, other = table[which[y, x]], table[which[v, u]]
                goes_on = which[y, x] == which[v, u] and pose[y, x] == pose[v, u]
                for k in range(2):  # where both pieces show the first of the two pixels
                    ahead = 2 + 2 * k + 1 - down
                    at[0, k], at[1, k] = yx[y, x, k], yx[v, u, k] - at[1, ahead]
                    behind = at[1, k] - at[0, k]
                    goes_on = goes_on and (behind == 0 or (one[3] != 0 and behind % one[1 + k] == 0))
                if goes_on:
                    continue
                if _step(around, one, other, scale, at, step):
                    for c in range(channels):
                        out[y, x, c] += step[c]
                        out[v, u, c] -= step[c]
