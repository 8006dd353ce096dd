"""Where the courses of a canvas lie: straight rows at exact places, which close around a wrapped canvas.

What lies in a course is made from anchor to anchor, columns that follow from their number and the seed alone: any part
can be made without the others.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arrays import Int64, Pair
from ..canvas import Canvas
from ..draws import below, deck, draw
from ..errors import ParameterError
from ..lattice.candidates import UNIT
from ..lattice.lattice import unfit
from .brickwork import Line

ORDER, PHASE = 1 << 20, 1 << 21  # keep its draws apart from those of chains
SPARE = 64  # px above the height of a canvas that sums of heights are looked for: far above what may be strained
STAGE = 2012  # keeps the draws of courses apart from those of others
STRAIN = 0.02  # how much the pitch may be stretched to close around a wrapped canvas


@dataclass(frozen=True)
class Rows:
    """Where the courses of an endless canvas lie; course i begins at row ``place(2 i, column)``, in 1/256 px."""

    width: int  # columns of a canvas that wraps along the courses, else 0
    around: int  # courses around a canvas that wraps down the rows, else 0
    turn: int  # once around along the courses, course i goes on as course i + turn

    def place(self, twice: int, u: int) -> int:
        """The row at which course `twice` / 2 begins in a column, in 1/256 px; exact however far out."""
        raise NotImplementedError

    def course_at(self, y: int, u: int) -> int:
        """The course that covers a pixel."""
        raise NotImplementedError

    def row(self, twice: int, u: int) -> int:
        """The same as `place` in whole px."""
        return self.place(twice, u) // UNIT

    def rows(self, i: int, first: int, count: int, y0: int) -> Int64:
        """The rows, counted from `y0`, at which course i begins in `count` columns."""
        return np.full(count, self.row(2 * i, first) - y0, np.int64)

    def named(self, i: int, turns: int) -> int:
        """The number of a course `turns` times around; around a canvas numbers return."""
        i += self.turn * turns
        return i % self.around if self.around else i

    def rank(self, name: int) -> int:
        """When a course is laid: after those of lower rank, of which at most two lie side by side."""
        if self.around and name >= self.around - self.around % 4:
            return 4 + name % 4
        return (0, 2, 1, 3)[name % 4]


def turned(canvas: Canvas, upright: bool) -> tuple[bool, bool, int, int]:
    """Whether a canvas wraps down and along its courses, and its sides so (`upright`: they run down the canvas)."""
    wraps, sides = (canvas.wrap.y, canvas.wrap.x), (canvas.height, canvas.width)
    return (*wraps[::-1], *sides[::-1]) if upright else (*wraps, *sides)


@dataclass(frozen=True)
class CourseRows(Rows):
    """The courses of an endless canvas, which run along x and may lean."""

    phase: int  # the row at which course 0 begins in column 0, 1/256 px
    pitch: Pair  # px from course to course, as a fraction
    slope: Pair  # px down for each px along, as a fraction

    @classmethod
    def of(cls, line: Line, canvas: Canvas, upright: bool) -> CourseRows:
        """Lay the rows of an exemplar on a canvas (`upright`: the courses run down the canvas); ParameterError."""
        down, along, height, width = turned(canvas, upright)
        pitch, around, slope, turn = (line.pitch, UNIT), 0, line.slope, 0
        if down:
            around = max(1, round(height * UNIT / line.pitch))
            strain = height * UNIT / (around * line.pitch) - 1
            if abs(strain) > STRAIN:
                fitting = [round(n * line.pitch / UNIT) for n in (around - 1, around, around + 1) if n > 0]
                good = sorted(sorted(fitting, key=lambda n: abs(n - height))[:2])
                raise ParameterError(unfit(int(upright), height, "is no whole number of courses", strain, good))
            pitch = (height, around)
        if along:
            turn = round(width * line.slope[0] * pitch[1] / (line.slope[1] * pitch[0]))
            slope = (turn * pitch[0], pitch[1] * width)
        return cls(width if along else 0, around, turn, line.phase, pitch, slope)

    def place(self, twice: int, u: int) -> int:
        (a, b), (c, d) = self.pitch, self.slope
        return self.phase + (twice * UNIT * a * d + u * c * 2 * UNIT * b) // (2 * b * d)

    def rows(self, i: int, first: int, count: int, y0: int) -> Int64:
        if self.slope[0] == 0:
            return super().rows(i, first, count, y0)
        return np.array([self.row(2 * i, first + k) - y0 for k in range(count)], np.int64)

    def course_at(self, y: int, u: int) -> int:
        (a, b), (c, d) = self.pitch, self.slope
        return (y * UNIT * b * d - self.phase * b * d - u * c * UNIT * b) // (UNIT * a * d)


@dataclass(frozen=True)
class StackedRows(Rows):
    """Courses of unequal heights on an endless canvas, which run along x."""

    heights: tuple[int, ...]  # of the courses of the exemplar, px
    seed: int
    order: tuple[int, ...]  # of a canvas that wraps down the rows: its courses from top to bottom; else none
    stretch: Pair  # of all heights, as a fraction
    _orders: dict[int, tuple[int, ...]] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def of(cls, heights: tuple[int, ...], canvas: Canvas, upright: bool, seed: int) -> StackedRows:
        """Stack courses on a canvas (`upright`: they run down the canvas); ParameterError where they cannot close."""
        down, along, height, width = turned(canvas, upright)
        rows = cls(width if along else 0, 0, 0, heights, seed, (), (1, 1))
        if not down:
            return rows
        order = rows._closing(height)
        total = sum(heights[k] for k in order)
        if abs(height - total) > STRAIN * total:
            name = "width" if upright else "height"
            raise ParameterError(
                f"wrap: {name}={height} px is no sum of heights of courses ({', '.join(map(str, sorted(heights)))} "
                f"px); choose {max(total, min(heights))} px."
            )
        return cls(rows.width, len(order), 0, heights, seed, order, (height, total))

    def kind(self, i: int) -> int:
        """Which course of the exemplar course `i` is as high as."""
        number, k = divmod(i, self.around or len(self.heights))
        return self._ordered(number)[k]

    def place(self, twice: int, u: int) -> int:
        i, half = divmod(twice, 2)
        return (self._top(i) + self._top(i + half)) // 2

    def course_at(self, y: int, u: int) -> int:
        low, high = -1, 1
        while self.row(2 * low, u) > y:
            low *= 2
        while self.row(2 * high, u) <= y:
            high *= 2
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.row(2 * middle, u) <= y else (low, middle)
        return low

    def _ordered(self, number: int) -> tuple[int, ...]:
        """The courses of the exemplar in the order in which they are laid, the `number`-th time."""
        if self.order:
            return self.order
        if number not in self._orders:
            self._orders[number] = tuple(deck(len(self.heights), self.seed, STAGE, ORDER, number, 0))
        return self._orders[number]

    def _top(self, i: int) -> int:
        """The row at which course i begins, 1/256 px."""
        number, k = divmod(i, self.around or len(self.heights))
        order, (high, of) = self._ordered(number), self.stretch
        at = number * sum(self.heights[c] for c in order) + sum(self.heights[c] for c in order[:k])
        return (at - below(max(self.heights), draw(self.seed, STAGE, PHASE))) * UNIT * high // of

    def _closing(self, height: int) -> tuple[int, ...]:
        """Courses whose heights add up to a canvas as nearly as can be, all about as often."""
        most = max(0, height // sum(self.heights) - 1)
        order = [k for number in range(most) for k in self._ordered(number)]
        rest = height - most * sum(self.heights)
        sums: dict[int, tuple[int, ...]] = {0: ()}
        for k in (*self._ordered(most), *self._ordered(most + 1), *self._ordered(most + 2)):
            for total, some in list(sums.items()):
                if total + self.heights[k] <= rest + SPARE:
                    sums.setdefault(total + self.heights[k], (*some, k))
        best = min(sums, key=lambda total: (abs(total - rest), total))
        return (*order, *sums[best])


class Piece(NamedTuple):
    """A piece of a course on the canvas."""

    first: int  # its columns on the canvas, up to the middle of the joints at both ends
    end: int
    source: int  # the exemplar column that `first` shows
    course: int  # of the exemplar that it is a piece of
    left: int  # what lies at its left end: a joint, FACE or OPEN
    right: int  # and at its right end
    low: int  # the exemplar column of the left end
    high: int  # and of the right one
    brick: int  # its number


@dataclass(eq=False)
class CourseLayout:
    """What lies where in the courses of an endless canvas; `step`: 1/256 px from anchor to anchor."""

    rows: Rows
    seed: int
    step: int
    parts: int = 0
    _known: dict[Pair, list[Piece]] = field(default_factory=dict)
    _anchors: dict[Pair, int] = field(default_factory=dict)
    _decks: dict[tuple[int, int, int], list[int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.parts = max(1, round(self.rows.width * UNIT / self.step)) if self.rows.width else 0

    def pieces(self, i: int, first: int, end: int) -> list[Piece]:
        """The pieces of course i that touch some columns, from left to right."""
        s = (first * self.parts // self.rows.width if self.parts else first * UNIT // self.step) - 1
        found: list[Piece] = []
        while self.anchor(i, s) < end:
            found += [p for p in self.chain(i, s) if p.end > first and p.first < end]
            s += 1
        return found

    def anchor(self, i: int, s: int) -> int:
        """The column of anchor s of course i."""
        i, s, by = self.named(i, s)
        if (i, s) not in self._anchors:
            place = s * self.rows.width // self.parts if self.parts else s * self.step // UNIT
            room = (self.rows.width // self.parts if self.parts else self.step // UNIT) // 2
            self._anchors[i, s] = place + self._late(i, s, place, room)
        return self._anchors[i, s] + by

    def chain(self, i: int, s: int) -> list[Piece]:
        """The pieces of course i between its anchors s and s + 1."""
        i, s, by = self.named(i, s)
        if (i, s) not in self._known:
            self._known[i, s] = self._chained(i, s)
        return [p._replace(first=p.first + by, end=p.end + by) for p in self._known[i, s]]

    def named(self, i: int, s: int) -> tuple[int, int, int]:
        """The course and the anchor that are the same around a canvas, and how many columns further on they lie."""
        if not self.parts:
            return self.rows.named(i, 0), s, 0
        turns, s = divmod(s, self.parts)
        return self.rows.named(i, turns), s, turns * self.rows.width

    def dealt(self, count: int, number: int, s: int) -> list[int]:
        """A shuffled deck of so many cards."""
        if (count, number, s) not in self._decks:
            self._decks[count, number, s] = deck(count, self.seed, STAGE, 64, number, s)
        return self._decks[count, number, s]

    def _late(self, i: int, s: int, place: int, room: int) -> int:
        """How far behind its place an anchor lies, less than `room` so that anchors stay in order."""
        raise NotImplementedError

    def _chained(self, i: int, s: int) -> list[Piece]:
        """The pieces from an anchor to the next."""
        raise NotImplementedError
