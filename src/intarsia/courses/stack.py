"""Where courses of unequal heights lie: those of the exemplar, each as often as others, in an order that is drawn."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..draws import below, deck, draw
from ..errors import ParameterError
from ..lattice.vectors import UNIT
from .rows import STAGE, STRAIN, rank_of

ORDER, PHASE = 1 << 20, 1 << 21  # keep its draws apart from those of chains
SPARE = 64  # px above the height of a canvas that sums of heights are looked for: far above what may be strained


@dataclass(frozen=True)
class StackedRows:
    """Courses of unequal heights on an endless canvas, which run along x; the members are those of `CourseRows`."""

    heights: tuple[int, ...]  # of the courses of the exemplar, px
    seed: int
    order: tuple[int, ...]  # of a canvas that wraps down the rows: its courses from top to bottom; else none
    stretch: tuple[int, int]  # of all heights, as a fraction
    width: int  # columns of a canvas that wraps along the courses, else 0
    turn: int = 0
    _orders: dict[int, tuple[int, ...]] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def of(cls, heights: tuple[int, ...], canvas: Canvas, upright: bool, seed: int) -> StackedRows:
        """Stack courses on a canvas (`upright`: they run down the canvas); ParameterError where they cannot close."""
        down, along = (canvas.wrap.x, canvas.wrap.y) if upright else (canvas.wrap.y, canvas.wrap.x)
        height, width = (canvas.width, canvas.height) if upright else (canvas.height, canvas.width)
        rows = cls(heights, seed, (), (1, 1), width if along else 0)
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
        return cls(heights, seed, order, (height, total), rows.width)

    @property
    def around(self) -> int:
        """How many courses lie around a canvas that wraps down the rows, else 0."""
        return len(self.order)

    def kind(self, i: int) -> int:
        """Which course of the exemplar course `i` is as high as."""
        number, k = divmod(i, self.around or len(self.heights))
        return self._ordered(number)[k]

    def row(self, twice: int, u: int) -> int:
        """The row at which course `twice` / 2 begins; exact however far out."""
        return self.place(twice, u) // UNIT

    def place(self, twice: int, u: int) -> int:
        """The same in 1/256 px."""
        i, half = divmod(twice, 2)
        return (self._top(i) + self._top(i + half)) // 2

    def rows(self, i: int, first: int, count: int, y0: int) -> NDArray[np.int64]:
        """The rows, counted from `y0`, at which course i begins in `count` columns."""
        return np.full(count, self.row(2 * i, first) - y0, np.int64)

    def course_at(self, y: int, u: int) -> int:
        """The course that covers a pixel."""
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
        """The number of a course; around a canvas numbers return."""
        return i % self.around if self.around else i

    def rank(self, name: int) -> int:
        """When a course is laid: after those of lower rank, of which at most two lie side by side."""
        return rank_of(name, self.around)

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
