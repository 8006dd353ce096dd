"""Courses without joints, such as boards: one course of the exemplar is copied on and on, with leaps."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..draws import below, draw
from ..lattice.vectors import UNIT
from . import chain_kernels
from .brickwork import Brickwork
from .rows import STAGE, CourseLayout, Piece, Rows
from .wall_kernels import OPEN

LONG = 1024  # px from anchor to anchor; halved and doubled: leaps elsewhere, nothing is seen


class Leaps(NamedTuple):
    """How boards leap; seams are what leaps differ by on planks and on a knotted board of 320 px (docs/design/012)."""

    keep: int = 10  # from every column, so that a walk is short; 5 and 20: the same
    overlap: int = 10  # columns compared on each side; halved: seams of 48.7 instead of 47.0, doubled: 48.6 for 47.2
    spare: int = 32  # columns on each side in which the cut may wander; halved: 55.7 for 47.2, doubled: 46.1
    longest: int = 1024  # columns of a course that are used: the table of leaps takes 8 MiB of them
    small: int = 64  # columns of a course that may leap from anywhere to anywhere; halved: the same
    loop: int = 45  # percent of its columns that a leap goes at least, or knots return; 22: 52.0, 60: 61.0 for 47.2
    shade: int = 60  # a change of colour, where a difference of single pixels counts 16; 0: 56.8, 30: 54.4, 240: 46.1
    fee: float = 0.1  # of leaps are cheaper than what each costs besides; halved and doubled: 8 % of pixels change


LEAPS = Leaps()


class Boards(CourseLayout):
    """Courses without joints along the rows of an endless canvas; each shows one course of the exemplar."""

    def __init__(self, picture: NDArray[np.int16], work: Brickwork, rows: Rows, seed: int) -> None:
        super().__init__(rows, seed, LONG * UNIT)
        self.picture, self.work = picture, work
        self._leaps: dict[int, tuple[Array, Array, int]] = {}

    def course(self, i: int) -> int:
        """The exemplar's course that a course shows: dealt from shuffled decks, no two alike side by side."""
        turn, around = self.rows.turn, self.rows.around
        closed = math.gcd(turn, around) if around else abs(turn)
        i = i % closed if turn else (i % around if around else i)  # once around a board meets itself
        courses = self.work.courses
        n = len(courses)
        number, at = divmod(i, n)
        order = list(self.dealt(n, number, 0))
        if n > 2 and order[0] == self.dealt(n, number - 1, 0)[-1]:
            order[0], order[1] = order[1], order[0]
        if around and n > 2 and i == around - 1 and order[at] == self.dealt(n, 0, 0)[0]:
            at = (at + 1) % n
        return courses[order[at]]

    def _late(self, i: int, s: int, place: int, room: int) -> int:
        return below(max(1, room), draw(self.seed, STAGE, 1, i, s))

    def _shown(self, i: int, s: int) -> int:
        """The column of its board that an anchor shows."""
        i, s, _ = self.named(i, s)
        costs, _, half = self._table(self.course(i))
        return half + below(max(1, len(costs) - 3 * half), draw(self.seed, STAGE, 2, i, s))

    def _chained(self, i: int, s: int) -> list[Piece]:
        k = self.course(i)
        costs, leaps, _ = self._table(k)
        first, here, there = self.anchor(i, s), self._shown(i, s), self._shown(i, s + 1)
        length = self.anchor(i, s + 1) - first
        known = costs[costs < chain_kernels.FAR]
        fee = int(np.quantile(known, LEAPS.fee)) if len(known) else 1
        out = np.empty((length + 1, 3), np.int64)
        key = np.uint64(draw(self.seed, STAGE, 3, i, s))
        count = chain_kernels.leap(length, costs, leaps, np.array([here, there], np.int64), max(fee, 1), key, out)
        x0, x1 = self._span(k)
        pieces, at, shown = [], 0, here
        for u, _, to in [*out[:count][::-1].tolist(), (length, 0, 0)]:
            if u > at:
                low = x0 + shown
                pieces.append(Piece(first + at, first + u, low, k, OPEN, OPEN, x0, x1, k))
            at, shown = u, to
        return pieces

    def _span(self, k: int) -> tuple[int, int]:
        x0, x1 = self.work.spans[k]
        spare = max(0, x1 - x0 - LEAPS.longest) // 2
        return x0 + spare, x1 - spare

    def _table(self, k: int) -> tuple[Array, Array, int]:
        """What leaps in a course cost, and the best from every column."""
        if k not in self._leaps:
            x0, x1 = self._span(k)
            x = np.arange(x0, x1)
            above, below_ = self.work.beds[k], self.work.beds[k + 1]
            tall = max(1, self.work.line.pitch // UNIT)
            y = (above[x] + below_[x] - tall) // 2 + np.arange(tall)[:, None]
            strip = self.picture[np.clip(y, 0, self.picture.shape[0] - 1), x]
            n = x1 - x0
            half = max(1, min(LEAPS.spare, n // 6))
            costs = chain_kernels.leap_costs(np.ascontiguousarray(strip), min(LEAPS.overlap, half), half)
            costs[costs < chain_kernels.FAR] += _shades(strip, 2 * half)[costs < chain_kernels.FAR]
            apart, keep = (1, n) if n <= LEAPS.small else (LEAPS.loop * n // 100, LEAPS.keep)
            self._leaps[k] = costs, chain_kernels.best_leaps(costs, apart, keep), half
        return self._leaps[k]


def _shades(strip: Array, wide: int) -> NDArray[np.int64]:
    """How much the colour of a board changes at each leap: before column x and from column z on, (n, n)."""
    mean = strip.mean(axis=0)
    total = np.concatenate([np.zeros((1, mean.shape[1])), np.cumsum(mean, axis=0)])
    at = np.arange(len(mean))
    first, end = np.maximum(at - wide, 0), np.minimum(at + wide, len(mean))
    before = (total[at] - total[first]) / np.maximum(at - first, 1)[:, None]
    after = (total[end] - total[at]) / np.maximum(end - at, 1)[:, None]
    gap = np.sqrt(((before[:, None] - after) ** 2).sum(axis=2))
    return np.asarray(np.rint(LEAPS.shade * gap), np.int64)
