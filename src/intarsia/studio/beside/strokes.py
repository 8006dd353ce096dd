"""In the process beside: strokes of a brush, as a number for every place of an endless canvas.

The number of a place follows from its coordinates and the strokes alone. It is one of the 256 that a gray picture of
8 bits can say, so that a command that is given such a picture draws the same bytes.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

SIDE = 256  # px of a block of numbers that is kept
KEPT = 96  # blocks, of 512 kB each
ROUNDED = 256  # of a painting, of 64 kB each
STEPS = 255

Numbers = NDArray[np.float64]

_blocks: OrderedDict[tuple[Any, ...], Numbers] = OrderedDict()


@dataclass(frozen=True)
class Stroke:
    """A round brush that went from point to point: full within half its radius (px), then less and less.

    `strength`: the number that it leads to, 0 to 1; None: back to what is where nothing was painted.
    """

    radius: float
    strength: float | None
    points: tuple[tuple[float, float], ...]  # x, y

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.radius, self.strength, self.points))

    @cached_property
    def blocks(self) -> frozenset[tuple[int, int]]:
        """The blocks, row and column, that it may touch."""
        found = set()
        for (ax, ay), (bx, by) in self.legs:
            (top, below), (left, right) = (self._span(*ends) for ends in ((ay, by), (ax, bx)))
            found |= {(y, x) for y in range(top, below + 1) for x in range(left, right + 1)}
        return frozenset(found)

    @property
    def legs(self) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        """From which point to which it went; a dab goes from its point to itself."""
        return list(zip(self.points, self.points[1:] or self.points, strict=False))

    def _span(self, a: float, b: float) -> tuple[int, int]:
        return int((min(a, b) - self.radius) // SIDE), int((max(a, b) + self.radius) // SIDE)

    def over(self, below: Numbers, ground: float, block: tuple[int, int]) -> Numbers:
        """Paint over the numbers of a block."""
        top, left = (n * SIDE for n in block)
        apart = np.full(below.shape, self.radius * self.radius)
        for (ax, ay), (bx, by) in self.legs:
            rows, cols = (
                slice(max(0, int(min(a, b) - self.radius - first)), max(0, int(max(a, b) + self.radius - first) + 2))
                for a, b, first in ((ay, by, top), (ax, bx, left))
            )
            part = apart[rows, cols]
            if part.size:
                y = np.arange(SIDE, dtype=np.float64)[rows, None] + (top - ay)
                x = np.arange(SIDE, dtype=np.float64)[None, cols] + (left - ax)
                dy, dx = by - ay, bx - ax
                share = np.clip((y * dy + x * dx) / max(dy * dy + dx * dx, 1e-9), 0.0, 1.0)
                y, x = y - share * dy, x - share * dx
                np.minimum(part, y * y + x * x, out=part)
        soft = np.clip(2.0 * (1.0 - np.sqrt(apart) / self.radius), 0.0, 1.0)
        weight = soft * soft * (3.0 - 2.0 * soft)
        aim = ground if self.strength is None else self.strength
        return np.asarray(below + (aim - below) * weight)


@dataclass(frozen=True)
class Painting:
    """What part of the jitter holds where, 0 to 1: `ground`, and strokes over it, the last one on top."""

    ground: float
    strokes: tuple[Stroke, ...]

    def __call__(self, y: Any, x: Any) -> Numbers:
        """Return the numbers at rows (n, 1) and columns (1, m), px."""
        rows, cols = (np.asarray(a, np.float64).ravel().astype(np.int64) for a in (y, x))
        out = np.full((len(rows), len(cols)), np.rint(self.ground * STEPS), np.uint8)
        across: dict[int, Any] = {}
        for block_row, touched in self._touched.items():
            down = np.flatnonzero(rows // SIDE == block_row)
            for block_column in touched if len(down) else ():
                if block_column not in across:
                    across[block_column] = np.flatnonzero(cols // SIDE == block_column)
                along = across[block_column]
                if len(along):
                    numbers = self._block(block_row, block_column)
                    out[np.ix_(down, along)] = numbers[np.ix_(rows[down] % SIDE, cols[along] % SIDE)]
        return out / float(STEPS)

    def reaches(self) -> tuple[int, int, int, int]:
        """The first row and column, and those behind the last, that strokes may touch, px; of none: no pixel."""
        down = [n for row in self._touched for n in (row, row + 1)]
        along = [n for row in self._touched.values() for column in row for n in (column, column + 1)]
        if not down:
            return 0, 0, 0, 0
        return min(down) * SIDE, min(along) * SIDE, max(down) * SIDE, max(along) * SIDE

    @cached_property
    def _touched(self) -> dict[int, dict[int, tuple[Stroke, ...]]]:
        """The strokes that may touch a block, by its row and its column."""
        found: dict[int, dict[int, tuple[Stroke, ...]]] = {}
        for stroke in self.strokes:
            for row, column in stroke.blocks:
                there = found.setdefault(row, {})
                there[column] = (*there.get(column, ()), stroke)
        return found

    @cached_property
    def _rounded(self) -> dict[tuple[int, int], NDArray[np.uint8]]:
        return {}

    def _block(self, row: int, column: int) -> NDArray[np.uint8]:
        """What a block says, in 1 / 255."""
        known = self._rounded
        if (row, column) not in known:
            numbers = self._blended(row, column, self._touched[row][column])
            known[row, column] = np.rint(numbers * STEPS).astype(np.uint8)
        found = known[row, column]
        while len(known) > ROUNDED:
            known.pop(next(iter(known)))
        return found

    def _blended(self, row: int, column: int, strokes: tuple[Stroke, ...]) -> Numbers:
        """The numbers of a block before they are rounded; a further stroke begins with what is kept."""
        done = len(strokes)
        while done and (self.ground, row, column, strokes[:done]) not in _blocks:
            done -= 1
        if done:
            numbers = _blocks[self.ground, row, column, strokes[:done]]
            _blocks.move_to_end((self.ground, row, column, strokes[:done]))
        else:
            numbers = np.full((SIDE, SIDE), self.ground)
        if done == len(strokes):
            return numbers
        for stroke in strokes[done:]:
            numbers = stroke.over(numbers, self.ground, (row, column))
        _blocks[self.ground, row, column, strokes] = numbers
        while len(_blocks) > KEPT:
            _blocks.popitem(last=False)
        return numbers


def painting_of(given: Any) -> Painting:
    """Return what JSON tells of strokes."""
    strokes = tuple(
        Stroke(float(one["radius"]), one["strength"], tuple((float(x), float(y)) for x, y in one["points"]))
        for one in given["strokes"]
    )
    return Painting(float(given["ground"]), strokes)
