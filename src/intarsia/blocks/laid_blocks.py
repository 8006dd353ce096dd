"""Where the blocks of a mosaic lie on the canvas, and the windows around them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..lattice.vectors import UNIT
from . import gap_kernels
from .grid import BlockGrid

Array = NDArray[Any]


@dataclass(frozen=True, eq=False, kw_only=True)
class LaidBlocks:
    """The blocks of an endless or a wrapped canvas.

    Attributes
    ----------
    canvas : BlockGrid
        How they lie (strained a little where the canvas wraps).
    around : (rows, columns)
        Blocks around a wrapped canvas along each axis, 0 where it does not wrap.
    lengths : (rows, columns)
        Size of the canvas, px.
    half : float
        Half the width of the zone in which gaps are cut, px.
    """

    canvas: BlockGrid
    around: tuple[int, int]
    lengths: tuple[int, int]
    half: float

    def _origin(self, i: int, j: int) -> tuple[int, int]:
        """First corner of a block, 1/256 px; around a wrapped canvas the last one ends where the first begins."""
        y, x = self.canvas.origin(i, j)
        if self.around[0]:
            y += i * self.lengths[0] * UNIT // self.around[0] - i * self.canvas.rows[0]
        if self.around[1]:
            x += j * self.lengths[1] * UNIT // self.around[1] - j * self.canvas.columns[1]
        return y, x

    def _name(self, i: int, j: int) -> tuple[int, int]:
        """Number of a block; around a wrapped canvas the numbers return."""
        rows, columns = self.around
        return (i % rows if rows else i), (j % columns if columns else j)

    def _ring(self, i: int, j: int) -> tuple[tuple[int, int], Array, Array]:
        """First pixel of a block's window, the neighbour that each of its pixels lies towards, and the block."""
        at, shape = self._box(i, j)
        sides, core = np.empty(shape, np.int8), np.empty(shape, np.uint8)
        gap_kernels.ring(self._frame(i, j, at), np.zeros(2, np.int64), self.half, sides, core)
        return at, sides, core

    def _box(self, i: int, j: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """First pixel and shape of the window around a block, its seam zone included."""
        y, x = self._origin(i, j)
        reach = math.ceil(self.half) + 1
        before, shape = self.canvas.before(), self.canvas.extent()
        at = (y // UNIT + before[0] - reach, x // UNIT + before[1] - reach)
        return at, (shape[0] + 2 * reach + 1, shape[1] + 2 * reach + 1)

    def _frame(self, i: int, j: int, at: tuple[int, int]) -> NDArray[np.int64]:
        y, x = self._origin(i, j)
        return np.array((*self.canvas.rows, *self.canvas.columns, y - at[0] * UNIT, x - at[1] * UNIT), np.int64)

    def _touches(self, i: int, j: int, y0: int, x0: int, height: int, width: int) -> bool:
        at, shape = self._box(i, j)
        return at[0] < y0 + height and at[1] < x0 + width and at[0] + shape[0] > y0 and at[1] + shape[1] > x0
