"""How blocks lie on a canvas that closes on itself.

Around a wrapped canvas the lattice is stretched a little: M' maps whole periods onto the canvas, and the block at q
is read near M M'^-1 q.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..canvas import Canvas
from ..errors import ParameterError
from ..lattice.vectors import UNIT, Vector
from .grid import BlockGrid

STRAIN = 0.02  # how much the lattice may be stretched to close around a wrapped canvas
Place = tuple[int, int]


def closed_grid(grid: BlockGrid, canvas: Canvas) -> tuple[BlockGrid, Place]:
    """Strain a grid so that it closes around a wrapped canvas: an even number of upright blocks each way.

    Returns the grid and the number of blocks around each axis, 0 where it does not wrap. ParameterError above 2 %
    of strain, slant included.
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
            raise ParameterError(_unfit(axis, length, "is no even number of blocks", strain, list(map(round, good))))
        straight = -(-length * UNIT // count)  # upwards: no pixel is left between two blocks
        sides.append((straight, 0) if axis == 0 else (0, straight))
        around.append(count)
    return BlockGrid(sides[0], sides[1], grid.phase, grid.cell), (around[0], around[1])


def _unfit(axis: int, length: int, what: str, strain: float, good: list[int]) -> str:
    remedy = f"choose {' or '.join(map(str, good))} px." if good else "the lattice is slanted; choose variant=plain."
    return f"wrap: {('height', 'width')[axis]}={length} px {what} (strain {100 * strain:.1f} %, at most 2 %); {remedy}"


@dataclass(frozen=True)
class Closing:
    """Blocks of a canvas, and the lattice under it.

    Attributes
    ----------
    block : (rows, columns)
        Size of a block, px; around a wrapped canvas some are one px shorter.
    lengths, around : (rows, columns)
        Size of the canvas, and how many blocks lie around it; 0 blocks where it does not wrap.
    turns : ((int, int), (int, int))
        The lattice vectors, 1/256 px, that go once around; one px along the axis where it does not wrap.
    """

    block: Place
    lengths: Place
    around: Place
    turns: tuple[Vector, Vector]

    def begin(self, i: int, j: int) -> Place:
        """First pixel of a block."""
        y, x = (
            n * length // count if count else n * side
            for n, length, count, side in zip((i, j), self.lengths, self.around, self.block, strict=True)
        )
        return y, x

    def block_of(self, y: int, x: int) -> Place:
        """The block that holds a pixel."""
        i, j = (
            ((p + 1) * count - 1) // length if count else p // side
            for p, length, count, side in zip((y, x), self.lengths, self.around, self.block, strict=True)
        )
        return i, j

    def name(self, i: int, j: int) -> Place:
        """Number of a block; around a wrapped canvas the numbers return."""
        rows, columns = self.around
        return (i % rows if rows else i), (j % columns if columns else j)

    def lattice_place(self, i: int, j: int) -> Place:
        """Where a block begins in the lattice, 1/256 px: as on the canvas, less the stretch."""
        y, x = self.begin(*self.name(i, j))
        (a, b), (c, d) = self.turns
        tall, wide = (n if count else 1 for n, count in zip(self.lengths, self.around, strict=True))
        whole = tall * wide
        return (
            (2 * (y * a * wide + x * c * tall) + whole) // (2 * whole),
            (2 * (y * b * wide + x * d * tall) + whole) // (2 * whole),
        )


def closing(cell: tuple[Vector, Vector], side: int, canvas: Canvas) -> Closing:
    """Lay blocks of `side` px on a canvas; ParameterError where it does not close on the lattice."""
    block, around, turns = [], [], []
    for axis, (length, wrap) in enumerate(((canvas.height, canvas.wrap.y), (canvas.width, canvas.wrap.x))):
        if wrap:
            count = 2 * max(1, round(length / (2 * side)))
            block.append(-(-length // count))
            around.append(count)
            turns.append(turn(cell, length, axis))
        else:
            block.append(side)
            around.append(0)
            turns.append((UNIT, 0) if axis == 0 else (0, UNIT))
    return Closing((block[0], block[1]), (canvas.height, canvas.width), (around[0], around[1]), (turns[0], turns[1]))


def turn(cell: tuple[Vector, Vector], length: int, axis: int) -> Vector:
    """The lattice vector that goes once around an axis of `length` px; ParameterError above 2 % of stretch."""
    goal = (length * UNIT, 0) if axis == 0 else (0, length * UNIT)
    best = min(_points_near(cell, goal), key=lambda v: (_apart(v, goal), v))
    if _apart(best, goal) <= STRAIN * length * UNIT:
        return best
    good = []
    for way in (-1, 1):
        for n in range(1, 4 * length + 4096):
            size = length + way * n
            if size < 1:
                break
            there = (size * UNIT, 0) if axis == 0 else (0, size * UNIT)
            if min(_apart(v, there) for v in _points_near(cell, there)) <= STRAIN * size * UNIT / 2:
                good.append(size)
                break
    strain = _apart(best, goal) / (length * UNIT)
    raise ParameterError(_unfit(axis, length, "is no whole number of periods", strain, good))


def _points_near(cell: tuple[Vector, Vector], goal: Vector) -> list[Vector]:
    """Lattice points around a place, the origin left out."""
    (a, b), (c, d) = cell
    area = a * d - b * c
    m, n = (goal[0] * d - goal[1] * c) // area, (goal[1] * a - goal[0] * b) // area
    return [
        (s * a + t * c, s * b + t * d) for s in range(m - 1, m + 3) for t in range(n - 1, n + 3) if (s, t) != (0, 0)
    ]


def _apart(a: Vector, b: Vector) -> float:
    return math.hypot(a[0] - b[0], a[1] - b[1])
