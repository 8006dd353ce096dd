"""Boxes of an endless plane: what a slice means, the cells that a large one is made of, and what fits into memory."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ..arguments import called, pair
from ..disk.limits import free_memory
from ..errors import ParameterError, ResourceError
from ..geometry import Box
from ..methods.base import FARTHEST

SIDE = 1024
"""Side of the cells, px, that large windows are made of."""

MOST_CELLS = 1 << 22
SLICE = "give rows and columns as texture[y0:y1, x0:x1]"


@dataclass(frozen=True)
class Cell:
    """One piece of a stored picture: its number, its place among the cells, and its box within the picture."""

    number: int
    row: int
    column: int
    box: Box


@dataclass(frozen=True)
class Grid:
    """A picture of height x width px, cut into cells; the last of each row and column may be smaller."""

    height: int
    width: int
    rows: int
    columns: int

    def __post_init__(self) -> None:
        if self.down * self.across > MOST_CELLS:
            raise ParameterError(
                f"{self.width}x{self.height} px are {self.down * self.across} cells of {self.columns}x{self.rows}; "
                f"at most {MOST_CELLS}, so choose a smaller size or larger chunks."
            )

    @property
    def down(self) -> int:
        """Cells one below the other."""
        return -(-self.height // self.rows)

    @property
    def across(self) -> int:
        """Cells side by side."""
        return -(-self.width // self.columns)

    def __len__(self) -> int:
        return self.down * self.across

    def cell(self, number: int) -> Cell:
        """The cell of a number, row by row."""
        row, column = divmod(number, self.across)
        y, x = row * self.rows, column * self.columns
        box = Box(y, x, min(y + self.rows, self.height), min(x + self.columns, self.width))
        return Cell(number, row, column, box)

    def __iter__(self) -> Iterator[Cell]:
        return (self.cell(n) for n in range(len(self)))


def box_of(key: Any) -> Box:
    """Understand a slice of an endless plane; negative numbers are places, not counted from an end."""
    if not isinstance(key, tuple) or len(key) != 2 or not all(isinstance(k, slice) for k in key):
        raise ParameterError(f"texture[{_said(key)}] is no window; {SLICE}.")
    ends = []
    for one in key:
        if one.start is None or one.stop is None:
            raise ParameterError(f"texture[{_said(key)}]: an endless plane has no first or last pixel; {SLICE}.")
        if one.step not in (None, 1):
            raise ParameterError(f"texture[{_said(key)}]: every pixel is drawn; drop the step.")
        try:
            ends.append((operator.index(one.start), operator.index(one.stop)))
        except TypeError:
            raise ParameterError(f"texture[{_said(key)}]: rows and columns are whole numbers; {SLICE}.") from None
    (y0, y1), (x0, x1) = ends
    if y1 <= y0 or x1 <= x0:
        raise ParameterError(f"texture[{_said(key)}] is empty; {SLICE} with y0 < y1 and x0 < x1.")
    return Box(y0, x0, y1, x1)


def check_near(box: Box) -> None:
    """Refuse a box too far away to be told from its neighbours."""
    if min(box.y0, box.x0) < -FARTHEST or max(box.y1, box.x1) > FARTHEST:
        raise ParameterError(
            f"rows {box.y0}..{box.y1}, columns {box.x0}..{box.x1} px lie too far away; stay within 2**40 px."
        )


def sides_of(shape: Any) -> tuple[int, int]:
    """Understand a size: one number is a square."""
    try:
        height, width = pair(shape)
    except ValueError:
        raise ParameterError(f"shape={called(shape)} is no size; give (height, width) in px.") from None
    if min(height, width) < 1 or max(height, width) > FARTHEST:
        raise ParameterError(f"shape=({called(height)}, {called(width)}) is not allowed; give sides of 1 to 2**40 px.")
    return height, width


def check_memory(box: Box, pixel: int) -> None:
    """Refuse a window that cannot be held, and say how to stream it; `pixel` bytes each."""
    needed, free = box.height * box.width * pixel, free_memory()
    if free is not None and needed > free:
        raise ResourceError(
            f"a window of {box.width}x{box.height} px takes {gigabytes(needed)}, {gigabytes(free)} are free; stream it "
            "with texture.to_zarr(path, shape, origin=...), to_tiff or to_dask, or slice less."
        )


def gigabytes(count: int) -> str:
    """A number of bytes in words."""
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{max(count // 1_000_000, 1)} MB"


def _said(key: Any) -> str:
    parts = key if isinstance(key, tuple) else (key,)
    words = []
    for k in parts:
        if isinstance(k, slice):
            ends = ["" if v is None else called(v) for v in (k.start, k.stop)]
            words.append(":".join(ends if k.step is None else [*ends, called(k.step)]))
        else:
            words.append(called(k))
    return ", ".join(words)[:100]
