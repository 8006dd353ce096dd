"""Repetition costs of Multrus 2003, 4.2.1: distances are multiplied by 1 + the number of uses of a patch."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ...foundation.arrays import Array
from ...patches.repetition import Repetition
from ...patches.repetition_kernels import ONE, placement
from ...search import Candidates, Prices, Search, WindowGrid


class UseFactors(Prices):
    """Use counts by which distances are multiplied, as 1 + uses; ONE is one use."""


class UseMarks(Repetition):
    """Distance times (1 + mean uses of a patch's pixels): the alternative that the source names."""

    in_turn: ClassVar[bool] = True

    def __init__(
        self, search: Search, layout: WindowGrid, strength: float, striking: list[Array] | None = None
    ) -> None:
        super().__init__(search, layout, 0.0, striking)
        self.search_prices = UseFactors(
            [self._flat[o : o + a * b].reshape(a, b) for o, a, b in self._offsets.tolist()], 0
        )

    def account(self) -> None:
        """Do nothing: uses count at once."""

    def prices(self, row: int, column: int, found: Candidates) -> Array:
        """Return for every candidate its squared distance times (1 + uses)**2."""
        plain = super().prices(row, column, found)
        begins, rows, columns = self._offsets[found.rows[:, 1]].T
        y, x = (found.rows[:, 2 + k] // self.search.factor for k in (0, 1))
        uses = self._flat[begins + np.minimum(y, rows - 1) * columns + np.minimum(x, columns - 1)]
        return np.asarray(plain * (ONE + uses.astype(np.int64)) ** 2 >> 16)


class UseCounter(UseMarks):
    """Distance times (1 + uses of any patch that touches it)."""

    def add(self, row: int, column: int, pick: tuple[int, int, int]) -> None:
        """Count a patch (variant, row, column) placed at a window, for all patches that would overlap it."""
        self.laid += 1
        place, laid, factor = self.grid[row, column], self._laid, self.search.factor
        placement(laid.frames, laid.shape, *pick, *self.layout.at(row, column), place)
        for v in np.flatnonzero(laid.frames[:, 0] == place[5]).tolist():
            first, j = laid.frames[v, 1:3], laid.frames[v, 3:7].reshape(2, 2)
            begin = (j.T @ (place[6:8] - 2 * first) - laid.shape + 1) // 2 // factor  # back by J
            (y, x), (height, width) = begin.tolist(), (laid.shape // factor).tolist()
            uses = self.search_prices.counts[v]
            uses[max(0, y - height + 1) : max(0, y + height), max(0, x - width + 1) : max(0, x + width)] += ONE
