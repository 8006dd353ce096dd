"""The windows with the worst seams of a map, to be refined (Kwatra et al. 2003, section 4, "refinement")."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..foundation.arrays import Array, Pair
from ..foundation.filters import moving_sums

CELL = 8  # px: side of the cells in which seam costs are summed, half of the smallest automatic patch


class WorstSeams:
    """Finds the windows with the highest seam costs in their middle.

    Parameters
    ----------
    prices : int array, shape (H, W, 2)
        Seam costs between every pixel and its right and lower neighbour; kept by reference.
    patch : (rows, columns)
        Size of the windows, px; not larger than the canvas.
    wraps : (rows, columns)
        Whether the canvas is toroidal along each axis.
    """

    def __init__(self, prices: Array, patch: Pair, wraps: tuple[bool, bool]) -> None:
        self.prices, self.patch, self.wraps = prices, patch, wraps
        self.shape = -(-prices.shape[0] // CELL), -(-prices.shape[1] // CELL)
        self._tired = np.zeros(self.shape, bool)

    def scores(self) -> Array:
        """Return the seam cost in about the middle half of the window around each cell; 0 counts beyond borders."""
        both = self.prices.reshape(len(self.prices), -1)  # to the right and below, pixel by pixel
        cells: Array = np.add.reduceat(both, np.arange(0, both.shape[1], 2 * CELL), axis=1, dtype=np.int64)
        cells = np.add.reduceat(cells, np.arange(0, len(cells), CELL), axis=0)
        for axis, (size, n, wrap) in enumerate(zip(self.patch, self.shape, self.wraps, strict=True)):
            cells = moving_sums(cells, axis, min(size // (4 * CELL), n // 2), "wrap" if wrap else "constant")
        return cells

    def apart(self, around: int) -> dict[Pair, Pair]:
        """Return the windows of highest cost that lie at least `around` px from one another.

        Chosen greedily, the most expensive first; of equal ones the first in raster order. Left out are cells that
        :meth:`give_up` marked. Returns the first pixel of each window by its cell.
        """
        left, found = np.where(self._tired, 0, self.scores()), dict[Pair, Pair]()
        firsts = [np.array([self._first(axis, cell) for cell in range(n)]) for axis, n in enumerate(self.shape)]
        for k in np.argsort(-left, axis=None, kind="stable")[: np.count_nonzero(left > 0)].tolist():
            at = divmod(k, self.shape[1])
            if left[at] <= 0:
                continue
            found[at] = int(firsts[0][at[0]]), int(firsts[1][at[1]])
            near = []
            for axis, first in enumerate(found[at]):
                gap, length = np.abs(firsts[axis] - first), self.prices.shape[axis]
                gap = np.minimum(gap, length - gap) if self.wraps[axis] else gap
                near.append(np.flatnonzero(gap < self.patch[axis] + around))
            left[np.ix_(*near)] = 0
        return found

    def give_up(self, cell: Pair) -> None:
        """Skip the windows around a cell and the cells close to it, until :meth:`renew` reports a change there."""
        radius = max(1, min(self.patch) // (4 * CELL))
        self._tired[self._near(*((at - radius, at + radius) for at in cell))] = True

    def renew(self, *boxes: tuple[int, int, int, int]) -> None:
        """Consider the cells of changed boxes (first row, first column, rows, columns) again."""
        for box in boxes:
            self._tired[self._near(*(((box[a] - 1) // CELL, (box[a] + box[2 + a]) // CELL) for a in (0, 1)))] = False

    def _first(self, axis: int, cell: int) -> int:
        """Return the first pixel of the window centred on a cell, moved onto the canvas."""
        length, size = self.prices.shape[axis], self.patch[axis]
        at = cell * CELL + CELL // 2 - size // 2
        return int(at % length if self.wraps[axis] else min(max(at, 0), length - size))

    def _near(self, *ends: Pair) -> Any:
        """Return the index of the cells from the first to the last along each axis, round the canvas where it wraps."""
        axes = []
        for (low, high), n, wrap in zip(ends, self.shape, self.wraps, strict=True):
            along = np.arange(low - wrap, high + 1 + wrap)  # the last cell may be a part of one
            axes.append(np.unique(along % n) if wrap else along[(along >= 0) & (along < n)])
        return np.ix_(*axes)
