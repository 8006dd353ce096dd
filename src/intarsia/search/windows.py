"""The windows of a canvas, in which patches are laid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array


@dataclass(frozen=True)
class WindowGrid:
    """The windows of a canvas: first rows, first columns, their size, and the canvas they lie on.

    Windows are a grid, named by row and column of it; or they lie freely at `places`, named by (number, 0).
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    patch: tuple[int, int]
    height: int
    width: int
    wrap_y: bool
    wrap_x: bool
    places: tuple[tuple[int, int], ...] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of windows."""
        return (len(self.rows), len(self.columns)) if self.places is None else (len(self.places), 1)

    def at(self, row: int, column: int) -> tuple[int, int]:
        """First pixel of a window on the canvas."""
        return (self.rows[row], self.columns[column]) if self.places is None else self.places[row]

    @property
    def wraps(self) -> tuple[bool, bool]:
        """Whether rows and columns continue in themselves."""
        return self.wrap_y, self.wrap_x

    def widened(self, picture: Array, outside: int) -> Array:
        """A picture of the canvas with a window's size more on all sides: around the torus, or `outside`."""
        for axis, (size, wrap) in enumerate(zip(self.patch, self.wraps, strict=True)):
            pad = [(size, size) if a == axis else (0, 0) for a in (0, 1)]
            picture = np.pad(picture, pad, mode="wrap") if wrap else np.pad(picture, pad, constant_values=outside)
        return picture

    def of_windows(self, every: Array) -> Array:
        """Of what is known of all windows of a :meth:`widened` picture, that of the grid's own: (rows, columns)."""
        return np.asarray(every[np.ix_(np.array(self.rows) + self.patch[0], np.array(self.columns) + self.patch[1])])

    def within(self, radius: int, places: Array, at: tuple[int, int]) -> Array:
        """Which of the places (n, 2) lie within a radius of one, along each axis."""
        gaps = np.abs(places - at)
        for axis, (length, wrap) in enumerate(zip((self.height, self.width), self.wraps, strict=True)):
            if wrap:
                gaps[:, axis] = np.minimum(gaps[:, axis], length - gaps[:, axis])
        return np.asarray((gaps <= radius).all(axis=1))
