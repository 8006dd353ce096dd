"""By how much one of two pieces is lighter than the other where they meet."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..foundation.arrays import Array, Floats, Int32, Int64, Mask
from ..kernels.maps import HOLE, J

REACH = 8  # px to either side: so far around a seam both pieces are compared
LEAST = 5  # of 25 places must exist in both, or nothing is known of a step
AROUND = [(i * (REACH // 2), j * (REACH // 2)) for i in range(-2, 3) for j in range(-2, 3)]


class Surroundings(NamedTuple):
    """What pieces are compared by: means over small squares (N, C), and the variance; `counts` (N,), none: all."""

    means: Int64
    counts: Mask
    variance: float


class Sides(NamedTuple):
    """Pieces at places where they meet others: first pixel, height, width, toroidal (n, 4); pixels (n, 2); J (n, 4)."""

    table: Int64
    at: Int64
    j: Int64

    def place(self, dy: int, dx: int) -> Int64:
        """The numbers of the pixels so far away on the canvas; -1 where there are none."""
        y, x = (self.at[:, k] + self.j[:, 2 * k] * dy + self.j[:, 2 * k + 1] * dx for k in range(2))
        begin, height, width, toroidal = self.table.T
        inside = (toroidal != 0) | ((y >= 0) & (x >= 0) & (y < height) & (x < width))
        return np.where(inside, begin + y % height * width + x % width, -1)


def _steps(around: Surroundings, one: Sides, other: Sides, scale: int) -> Int64:
    """By how much (n, C) one piece is lighter than the other, as far as they show the same; 0 where there is no step.

    Both are compared in 5 x 5 places, REACH px to all sides: m their mean difference, v its variance, the step is
    m (1 - v / |m|^2), and less where there is less of it at the seam itself, or where it is larger than what colours
    of the exemplar usually differ by: there, something else begins.
    """
    means, counts, variance = around
    total, squares, count = np.zeros((len(one.at), means.shape[1])), np.zeros(len(one.at)), np.zeros(len(one.at))
    here, seen = total.copy(), np.zeros(len(one.at), np.bool_)
    for dy, dx in AROUND:
        p, q = one.place(dy * scale, dx * scale), other.place(dy * scale, dx * scale)
        known = (p >= 0) & (q >= 0)
        if counts.size:
            known &= counts[p] & counts[q]
        apart: Floats = np.where(known[:, None], means[p] - means[q], 0).astype(np.float64)  # whole numbers of 17 bits
        total += apart
        squares += (apart * apart).sum(axis=1)
        count += known
        if dy == dx == 0:
            here, seen = apart, known
    mean = total / np.maximum(count, 1)[:, None]
    steady, along = np.zeros(len(mean)), np.zeros(len(mean))
    for m, h in zip(mean.T, here.T, strict=True):
        steady += m * m
        along += m * np.where(seen, h, m)
    there = (count >= LEAST) & (along > 0)
    size = np.where(there, steady, 1)
    share = np.maximum(1 - np.maximum(squares / np.maximum(count, 1) - steady, 0) / size, 0)
    share *= np.minimum(along / size, 1) * np.minimum(variance / size, 1)
    return np.floor(np.where(there, share, 0)[:, None] * mean + 0.5).astype(np.int64)


def seam_steps(part: tuple[Array, ...], table: Int64, around: Surroundings, scale: int) -> Int32:
    """The divergence (h, w, C) of the steps that are to be evened out.

    `part` is a map (yx, which, pose) of so many pixels; where a pixel and the next are of pieces of which one is
    lighter by d, the next one has to gain d on it.
    """
    yx, which, pose = part
    out = np.zeros((*which.shape, around.means.shape[1]), np.int32)
    for down, this, that in ((0, np.s_[:, :-1], np.s_[:, 1:]), (1, np.s_[:-1], np.s_[1:])):
        ahead = J[:, 1 - down :: 2].astype(np.int32)[np.minimum(pose[that], 7)]  # how the second goes on from the first
        behind = yx[that] - ahead
        same = (which[this] == which[that]) & (pose[this] == pose[that])
        on = same & (behind[..., 0] == yx[this][..., 0]) & (behind[..., 1] == yx[this][..., 1])
        y, x = np.nonzero(~on & (which[this] != HOLE) & (which[that] != HOLE))
        one, other = (Sides(table[which[side][y, x]], at[y, x].astype(np.int64), J[pose[side][y, x]])
                      for side, at in ((this, yx[this]), (that, behind)))  # fmt: skip
        turns = (other.table[:, 3:] != 0) & ((other.at - one.at) % other.table[:, 1:3] == 0)
        left = ~(same[y, x] & ((one.at == other.at) | turns).all(axis=1))
        y, x = y[left], x[left]
        one, other = (Sides(side.table[left], side.at[left], side.j[left]) for side in (one, other))
        step = _steps(around, one, other, scale)
        out[this][y, x] += step
        out[that][y, x] -= step
    return out
