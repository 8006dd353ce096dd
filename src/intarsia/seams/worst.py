"""Where the seams of a map are worst: the places that are to be covered anew (Kwatra et al. 2003, 4, "refinement")."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.sums import moving_sums

Array = NDArray[Any]
Cell = tuple[int, int]
CELL = 8  # seams are added up in cells of so many px: half of the smallest automatic patch


class WorstSeams:
    """The windows with the dearest seams in their middle.

    Parameters
    ----------
    prices : int array, shape (H, W, n)
        What the map costs between every pixel and its right and lower neighbour; kept, and read again.
    patch : (rows, columns)
        Of the windows, not larger than the canvas.
    wraps : (rows, columns)
        Along which axes the canvas continues in itself.
    """

    def __init__(self, prices: Array, patch: tuple[int, int], wraps: tuple[bool, bool]) -> None:
        self.prices, self.patch, self.wraps = prices, patch, wraps
        self.shape = -(-prices.shape[0] // CELL), -(-prices.shape[1] // CELL)
        self._cells = np.zeros(self.shape, np.int64)
        self._tired = np.zeros(self.shape, bool)
        self._at = (0, 0)
        self.read()

    def place(self) -> tuple[int, int] | None:
        """First row and column of the worst window; None where every place with seams was given up."""
        scores = np.where(self._tired, 0, self._scores)
        y, x = divmod(int(scores.argmax()), self.shape[1])
        if scores[y, x] <= 0:
            return None
        self._at = (y, x)
        row, column = (self._first(axis, cell) for axis, cell in enumerate(self._at))
        return row, column

    def apart(self, around: int, share: int = 0) -> dict[Cell, tuple[int, int]]:
        """The worst windows of which no two come closer than `around` px: cell and first pixel of each, worst first.

        Those that cost less than `share` % of the mean are left out.
        """
        least = int(self._scores.sum()) * share // (100 * self._scores.size)
        scores, found = np.where(self._tired | (self._scores < least), 0, self._scores), dict[Cell, tuple[int, int]]()
        firsts = [np.array([self._first(axis, cell) for cell in range(n)]) for axis, n in enumerate(self.shape)]
        while scores.any():
            y, x = divmod(int(scores.argmax()), self.shape[1])
            found[y, x] = int(firsts[0][y]), int(firsts[1][x])
            near = []
            for axis, first in enumerate(found[y, x]):
                gap, length = np.abs(firsts[axis] - first), self.prices.shape[axis]
                gap = np.minimum(gap, length - gap) if self.wraps[axis] else gap
                near.append(np.flatnonzero(gap < self.patch[axis] + around))
            scores[np.ix_(*near)] = 0
        return found

    def give_up(self, cell: Cell | None = None) -> None:
        """Leave a window, by default the one last named, and those close to it, until something changes there."""
        radius = max(1, min(self.patch) // (4 * CELL))
        near = (self._near(axis, at - radius, at + radius) for axis, at in enumerate(cell or self._at))
        self._tired[np.ix_(*near)] = True

    def renew(self, *boxes: tuple[int, int, int, int]) -> None:
        """Read the prices of boxes again: something changed there."""
        changed = np.zeros(self.shape[0], bool)
        for box in boxes:
            rows, columns = (self._near(a, (box[a] - 1) // CELL, (box[a] + box[2 + a]) // CELL) for a in (0, 1))
            self._tired[np.ix_(rows, columns)] = False
            changed[rows] = True
        self._add_up(np.flatnonzero(changed))
        self._score()

    def read(self) -> None:
        """Read all prices again: they may have changed anywhere. What was given up stays so."""
        self._add_up(np.arange(self.shape[0]))
        self._score()

    def _add_up(self, rows: Array) -> None:
        begins = np.arange(0, self.prices.shape[1], CELL)
        for r in rows.tolist():
            line = self.prices[r * CELL : (r + 1) * CELL].sum(axis=(0, 2), dtype=np.int64)
            self._cells[r] = np.add.reduceat(line, begins)

    def _score(self) -> None:
        """Add up the middle half of the window around each cell."""
        scores = self._cells
        for axis, (size, wrap) in enumerate(zip(self.patch, self.wraps, strict=True)):
            radius = min(size // (4 * CELL), self.shape[axis] // 2)
            scores = moving_sums(scores, axis, radius, "wrap" if wrap else "constant")
        self._scores = scores

    def _first(self, axis: int, cell: int) -> int:
        length, size = self.prices.shape[axis], self.patch[axis]
        at = cell * CELL + CELL // 2 - size // 2
        return int(at % length if self.wraps[axis] else min(max(at, 0), length - size))

    def _near(self, axis: int, low: int, high: int) -> Array:
        """The cells from `low` to `high`, round the canvas where it wraps."""
        n = self.shape[axis]
        if not self.wraps[axis]:
            return np.arange(max(low, 0), min(high, n - 1) + 1)
        return np.unique(np.arange(low - 1, high + 2) % n)  # the last cell may be a part of one
