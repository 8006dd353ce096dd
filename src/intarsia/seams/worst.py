"""Where the seams of a map are worst: the places that are to be covered anew (Kwatra et al. 2003, 4, "refinement").

What changed is read again where it changed, and of every row of cells the highest is known: so to name the worst place
of a canvas does not take longer the larger it is, but for one look at each row.
"""

from __future__ import annotations

import numpy as np

from ..analysis import window_sums
from ..foundation.arrays import Array, Pair

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

    def __init__(self, prices: Array, patch: Pair, wraps: tuple[bool, bool]) -> None:
        self.prices, self.patch, self.wraps = prices, patch, wraps
        self.shape = -(-prices.shape[0] // CELL), -(-prices.shape[1] // CELL)
        self._cells = np.zeros(self.shape, np.int64)
        self._tired = np.zeros(self.shape, bool)
        self._radius = [min(size // (4 * CELL), n // 2) for size, n in zip(patch, self.shape, strict=True)]
        self._scores, self._open = np.zeros(self.shape, np.int64), Highest(np.zeros(self.shape, np.int64))
        self.read()

    def apart(self, around: int, share: int = 0, most: int | None = None) -> dict[Pair, Pair]:
        """The worst windows of which no two come closer than `around` px: cell and first pixel of each, worst first.

        Those that cost less than `share` % of the mean are left out, and all but the first `most`.
        """
        least = int(self._scores.sum()) * share // (100 * self._scores.size)
        scores, found = Highest(np.where(self._scores < least, 0, self._open.values)), dict[Pair, Pair]()
        firsts = [np.array([self._first(axis, cell) for cell in range(n)]) for axis, n in enumerate(self.shape)]
        while len(found) != most and (at := scores.first()) is not None:
            found[at] = int(firsts[0][at[0]]), int(firsts[1][at[1]])
            near = []
            for axis, first in enumerate(found[at]):
                gap, length = np.abs(firsts[axis] - first), self.prices.shape[axis]
                gap = np.minimum(gap, length - gap) if self.wraps[axis] else gap
                near.append(np.flatnonzero(gap < self.patch[axis] + around))
            scores.put(near[0], near[1], 0)
        return found

    def give_up(self, cell: Pair) -> None:
        """Leave a window and those close to it, until something changes there."""
        radius = max(1, min(self.patch) // (4 * CELL))
        near = [self._runs(axis, at - radius, at + radius) for axis, at in enumerate(cell)]
        for rows in near[0]:
            for columns in near[1]:
                self._tired[rows, columns] = True
                self._score(rows, columns)

    def renew(self, *boxes: tuple[int, int, int, int]) -> None:
        """Read the prices of boxes again: something changed there."""
        for box in boxes:
            cells = [((box[a] - 1) // CELL, (box[a] + box[2 + a]) // CELL) for a in (0, 1)]
            for rows in self._runs(0, *cells[0]):
                for columns in self._runs(1, *cells[1]):
                    self._tired[rows, columns] = False
                    self._add_up(rows, columns)
            wide = [(low - r, high + r) for (low, high), r in zip(cells, self._radius, strict=True)]
            for rows in self._runs(0, *wide[0]):
                for columns in self._runs(1, *wide[1]):
                    self._score(rows, columns)

    def read(self) -> None:
        """Read all prices again: they may have changed anywhere. What was given up stays so."""
        every = slice(0, self.shape[1])
        for r in range(self.shape[0]):
            self._add_up(slice(r, r + 1), every)
        self._score(slice(0, self.shape[0]), every)

    def _add_up(self, rows: slice, columns: slice) -> None:
        """Add up the prices of all pixels of some cells."""
        y, x = (slice(part.start * CELL, part.stop * CELL) for part in (rows, columns))
        sums = self.prices[y, x].sum(axis=2, dtype=np.int64)
        for axis in (0, 1):
            sums = np.add.reduceat(sums, np.arange(0, sums.shape[axis], CELL), axis)
        self._cells[rows, columns] = sums

    def _score(self, rows: slice, columns: slice) -> None:
        """Add up the middle half of the window around each of some cells; nothing lies beyond a border."""
        places, inside = [], []
        for part, r, n, wrap in zip((rows, columns), self._radius, self.shape, self.wraps, strict=True):
            at = np.arange(part.start - r, part.stop + r)
            places.append(at % n)
            inside.append(wrap | ((at >= 0) & (at < n)))
        cells = np.where(inside[0][:, None] & inside[1], self._cells[np.ix_(*places)], 0)
        self._scores[rows, columns] = window_sums(cells, (2 * self._radius[0] + 1, 2 * self._radius[1] + 1))
        left = np.where(self._tired[rows, columns], 0, self._scores[rows, columns])
        self._open.put(np.arange(rows.start, rows.stop), np.arange(columns.start, columns.stop), left)

    def _first(self, axis: int, cell: int) -> int:
        length, size = self.prices.shape[axis], self.patch[axis]
        at = cell * CELL + CELL // 2 - size // 2
        return int(at % length if self.wraps[axis] else min(max(at, 0), length - size))

    def _runs(self, axis: int, low: int, high: int) -> list[slice]:
        """The cells from `low` to `high`, in two runs where the canvas wraps there."""
        n = self.shape[axis]
        if not self.wraps[axis]:
            return [slice(max(low, 0), min(high, n - 1) + 1)]
        low, high = low - 1, high + 2  # the last cell may be a part of one
        if high - low >= n:
            return [slice(0, n)]
        low, high = low % n, (high - 1) % n + 1
        return [slice(low, high)] if low < high else [slice(0, high), slice(low, n)]


class Highest:
    """Numbers of a grid of which the highest is asked for again and again; the highest of each row is known."""

    def __init__(self, values: Array) -> None:
        self.values = values
        self._rows = values.max(axis=1)

    def first(self) -> Pair | None:
        """The cell with the highest number, the first of several; None where none is above 0."""
        y = int(self._rows.argmax())
        return (y, int(self.values[y].argmax())) if self._rows[y] > 0 else None

    def put(self, rows: Array, columns: Array, values: Array | int) -> None:
        """Write numbers into some rows and columns."""
        self.values[np.ix_(rows, columns)] = values
        self._rows[rows] = self.values[rows].max(axis=1)
