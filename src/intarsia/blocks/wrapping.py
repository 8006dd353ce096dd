"""How blocks lie on a canvas that closes on itself.

Around a wrapped canvas the lattice is stretched a little: M' maps whole periods onto the canvas, and the block at q
is read near M M'^-1 q.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..errors import ParameterError
from ..lattice.vectors import UNIT
from . import gap_kernels
from .grid import BlockGrid

STRAIN = 0.02  # how much the lattice may be stretched to close around a wrapped canvas
Place = tuple[int, int]


@dataclass(frozen=True, eq=False)
class LaidBlocks:
    """The blocks of an endless or a wrapped canvas, and the windows around them."""

    grid: BlockGrid  # how they lie, strained a little where the canvas wraps
    around: Place  # blocks around a wrapped canvas down the rows and along them, 0 where it does not wrap
    lengths: Place  # rows and columns of the canvas, px
    half: float  # half the width of the zone in which gaps are cut, px

    @classmethod
    def of(cls, grid: BlockGrid, canvas: Canvas, half: float) -> LaidBlocks:
        """Strain a grid so that it closes around a wrapped canvas: an even number of upright blocks each way.

        ParameterError above 2 % of strain, slant included.
        """
        around, sides = [], []
        for axis, (length, wrap) in enumerate(((canvas.height, canvas.wrap.y), (canvas.width, canvas.wrap.x))):
            side = (grid.rows, grid.columns)[axis]
            if not wrap:
                around.append(0)
                sides.append(side)
                continue
            count = 2 * max(1, round(length * UNIT / (2 * side[axis])))
            slant = abs(side[1 - axis]) / side[axis]
            strain = math.hypot(length * UNIT / (count * side[axis]) - 1, slant)
            if strain > STRAIN:
                good = [] if slant > STRAIN else [n * side[axis] / UNIT for n in (count - 2, count, count + 2) if n > 0]
                fitting = list(map(round, good))
                raise ParameterError(unfit(axis, length, "is no even number of blocks", strain, fitting))
            straight = -(-length * UNIT // count)  # upwards: no pixel is left between two blocks
            sides.append((straight, 0) if axis == 0 else (0, straight))
            around.append(count)
        laid = BlockGrid(sides[0], sides[1], grid.phase, grid.cell)
        return cls(laid, (around[0], around[1]), (canvas.height, canvas.width), half)

    def origin(self, i: int, j: int) -> Place:
        """First corner of a block, 1/256 px; around a wrapped canvas the last one ends where the first begins."""
        y, x = self.grid.origin(i, j)
        if self.around[0]:
            y += i * self.lengths[0] * UNIT // self.around[0] - i * self.grid.rows[0]
        if self.around[1]:
            x += j * self.lengths[1] * UNIT // self.around[1] - j * self.grid.columns[1]
        return y, x

    def number(self, i: int, j: int) -> Place:
        """Number of a block; around a wrapped canvas the numbers return."""
        return returning(self.around, i, j)

    def window(self, i: int, j: int) -> tuple[Place, NDArray[np.int8], NDArray[np.uint8]]:
        """First pixel of a block's window, the neighbour that each of its pixels lies towards, and the block."""
        (y, x), (at, shape) = self.origin(i, j), self._box(i, j)
        frame = np.array((*self.grid.rows, *self.grid.columns, y - at[0] * UNIT, x - at[1] * UNIT), np.int64)
        sides, core = np.empty(shape, np.int8), np.empty(shape, np.uint8)
        gap_kernels.ring(frame, np.zeros(2, np.int64), self.half, sides, core)
        return at, sides, core

    def meeting(self, y0: int, x0: int, height: int, width: int) -> list[Place]:
        """The blocks whose windows meet a box of the canvas, row by row."""
        reach = math.ceil(self.half) + 1
        ends = [(y, x) for y in (y0 - reach, y0 + height + reach) for x in (x0 - reach, x0 + width + reach)]
        rows, columns = zip(*(self.grid.block_of(y, x) for y, x in ends), strict=True)
        found = []
        for i in range(min(rows) - 1, max(rows) + 2):
            for j in range(min(columns) - 1, max(columns) + 2):
                (y, x), (tall, wide) = self._box(i, j)
                if y < y0 + height and x < x0 + width and y + tall > y0 and x + wide > x0:
                    found.append((i, j))
        return found

    def _box(self, i: int, j: int) -> tuple[Place, Place]:
        """First pixel and shape of the window around a block, its seam zone included."""
        y, x = self.origin(i, j)
        reach = math.ceil(self.half) + 1
        before, shape = self.grid.before(), self.grid.extent()
        at = (y // UNIT + before[0] - reach, x // UNIT + before[1] - reach)
        return at, (shape[0] + 2 * reach + 1, shape[1] + 2 * reach + 1)


def beside(i: int, j: int) -> tuple[Place, ...]:
    """The blocks above, below, to the left and to the right."""
    return (i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)


def returning(counts: Place, i: int, j: int) -> Place:
    """Number of a block of which so many lie around an axis; 0: they do not return."""
    rows, columns = counts
    return (i % rows if rows else i), (j % columns if columns else j)


def unfit(axis: int, length: int, what: str, strain: float, good: list[int]) -> str:
    """Say why a canvas does not close, and at which sizes it does."""
    remedy = f"choose {' or '.join(map(str, good))} px." if good else "the lattice is slanted; drop wrap."
    return f"wrap: {('height', 'width')[axis]}={length} px {what} (strain {100 * strain:.1f} %, at most 2 %); {remedy}"
