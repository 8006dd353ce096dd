"""Course rows of a canvas: rows at which straight courses begin, exact anywhere, closing around a canvas that wraps.

Courses of one pitch have the height 1, in units of that pitch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ..foundation import ParameterError
from ..foundation.arrays import Int64, Pair
from ..foundation.geometry import UNIT
from ..foundation.run import below, deck, draw
from ..lattice import STRAIN, misfit_message
from ..model.canvas import Canvas
from .masonry import Line

DEALT, ORDER, PHASE = 64, 1 << 20, 1 << 21  # keys of random numbers: decks of bricks, order of courses, first row
SPARE = 64  # px by which sums of heights that are tried may exceed the canvas; far more than the strain allows
STAGE = 2012  # key of the random numbers of courses, which makes them independent of other stages


@dataclass(frozen=True)
class Rows:
    """The courses of an endless canvas along x, possibly slanted; course i begins at ``place(2 i, column)``."""

    width: int  # columns of a canvas that wraps along the courses, else 0
    around: int  # courses around a canvas that wraps down the rows, else 0
    turn: int  # once around the canvas along the courses, course i continues as course i + turn
    phase: int  # the row at which course 0 begins in column 0, 1/256 px
    pitch: Pair  # px per unit of height, as a fraction
    slope: Pair = (0, 1)  # px down for each px along, as a fraction
    heights: tuple[int, ...] = (1,)  # of the courses of the exemplar, which follow in shuffled decks
    seed: int = 0  # of the shuffles
    order: tuple[int, ...] = (0,)  # if not empty: fixed order of these courses, repeated, in place of the decks

    @classmethod
    def equal(cls, line: Line, canvas: Canvas, upright: bool) -> Rows:
        """Place courses of one pitch on a canvas (`upright`: they run down it).

        Raise ParameterError if they cannot close.
        """
        down, along, height, width = course_axes(canvas, upright)
        pitch, around, slope, turn = (line.pitch, UNIT), 0, line.slope, 0
        if down:
            around = max(1, round(height * UNIT / line.pitch))
            strain = height * UNIT / (around * line.pitch) - 1
            if abs(strain) > STRAIN:
                fitting = [round(n * line.pitch / UNIT) for n in (around - 1, around, around + 1) if n > 0]
                good = sorted(sorted(fitting, key=lambda n: abs(n - height))[:2])
                raise ParameterError(
                    misfit_message(int(upright), height, "is no whole number of courses", strain, good)
                )
            pitch = (height, around)
        if along:
            turn = round(width * line.slope[0] * pitch[1] / (line.slope[1] * pitch[0]))
            slope = (turn * pitch[0], pitch[1] * width)
        return cls(width if along else 0, around, turn, line.phase, pitch, slope)

    @classmethod
    def stacked(cls, heights: tuple[int, ...], canvas: Canvas, upright: bool, seed: int) -> Rows:
        """Stack courses of unequal heights, px, on a canvas. Raise ParameterError if they cannot close."""
        down, along, height, width = course_axes(canvas, upright)
        order = closing(heights, height, seed) if down else ()
        total = sum(heights[k] for k in order) if down else height
        if abs(height - total) > STRAIN * total:
            name = "width" if upright else "height"
            raise ParameterError(
                f"wrap: {name}={height} px is no sum of heights of courses ({', '.join(map(str, sorted(heights)))} "
                f"px); choose {max(total, min(heights))} px."
            )
        phase = -below(max(heights), draw(seed, STAGE, PHASE)) * UNIT * height // total
        return cls(width if along else 0, len(order), 0, phase, (height, total), (0, 1), heights, seed, order)

    def _dealt(self, i: int) -> tuple[int, Sequence[int], int]:
        """Return the number of whole decks before course i, the deck that it is in, and its index there."""
        number, k = divmod(i, len(self.order or self.heights))
        return number, self.order or cached_deck(len(self.heights), self.seed, STAGE, ORDER, number, 0), k

    def kind(self, i: int) -> int:
        """Return the index of the exemplar course whose height course `i` has."""
        _, order, k = self._dealt(i)
        return order[k]

    def _top(self, i: int) -> int:
        """Return the sum of the heights from course 0 to course i."""
        number, order, k = self._dealt(i)
        return number * sum(self.heights[c] for c in order) + sum(self.heights[c] for c in order[:k])

    def place(self, twice: int, u: Any) -> Any:
        """Return the row at which course `twice` / 2 begins in columns `u`, 1/256 px, for whole numbers of any size.

        Odd `twice`: the middle of a course.
        """
        (a, b), (c, d) = self.pitch, self.slope
        at = self._top(twice // 2) + self._top((twice + 1) // 2)
        return self.phase + (at * UNIT * a * d + u * c * 2 * UNIT * b) // (2 * b * d)

    def row(self, twice: int, u: Any) -> Any:
        """Return :meth:`place` in px, rounded down."""
        return self.place(twice, u) // UNIT

    def rows(self, i: int, first: int, count: int, y0: int) -> Int64:
        """Return the rows, counted from `y0`, at which course i begins in `count` columns."""
        return np.asarray(self.row(2 * i, first + np.arange(count).astype(object)) - y0, np.int64)

    def course_at(self, y: int, u: int) -> int:
        """Return the number of the course that covers row `y` in column `u`."""
        low, high = -1, 1
        while self.row(2 * low, u) > y:
            low *= 2
        while self.row(2 * high, u) <= y:
            high *= 2
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.row(2 * middle, u) <= y else (low, middle)
        return low

    def named(self, i: int, turns: int) -> int:
        """Return the number of a course `turns` times around, modulo the courses around the canvas."""
        i += self.turn * turns
        return i % self.around if self.around else i

    def rank(self, name: int) -> int:
        """Return the rank of a course: it is laid out after the courses of lower rank within two of it."""
        if self.around and name >= self.around - self.around % 4:
            return 4 + name % 4
        return (0, 2, 1, 3)[name % 4]


def course_axes(canvas: Canvas, upright: bool) -> tuple[bool, bool, int, int]:
    """Return whether a canvas wraps across, and along its courses, and its sides in this order, px.

    `upright`: the courses run down the rows.
    """
    wraps, sides = (canvas.wrap.y, canvas.wrap.x), (canvas.height, canvas.width)
    return (*wraps[::-1], *sides[::-1]) if upright else (*wraps, *sides)


cached_deck = lru_cache(1 << 12)(deck)


def closing(heights: tuple[int, ...], height: int, seed: int) -> tuple[int, ...]:
    """Return indices of courses whose heights add up to `height` px as nearly as possible, about equally often each.
    """
    most = max(0, height // sum(heights) - 1)
    decks = [cached_deck(len(heights), seed, STAGE, ORDER, number, 0) for number in range(most + 3)]
    rest = height - most * sum(heights)
    sums: dict[int, tuple[int, ...]] = {0: ()}
    for k in chain(*decks[most:]):
        for total, some in list(sums.items()):
            if total + heights[k] <= rest + SPARE:
                sums.setdefault(total + heights[k], (*some, k))
    best = min(sums, key=lambda total: (abs(total - rest), total))
    return (*chain(*decks[:most]), *sums[best])


class Piece(NamedTuple):
    """A piece of a course on the canvas."""

    first: int  # first column on the canvas, in the middle of the joint
    end: int  # column on the canvas after the last, in the middle of the next joint
    source: int  # the exemplar column at `first`
    course: int  # number of its course in the exemplar
    left: int  # number of the joint at its left end; NO_JOINT: it is cut there
    right: int  # number of the joint at its right end, or NO_JOINT
    low: int  # exemplar column of the left end
    high: int  # exemplar column of the right end
    brick: int  # its number in the table of bricks
