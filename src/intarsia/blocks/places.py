"""Which blocks a mosaic is made of, and where in the exemplar they may be read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MethodError
from ..lattice.vectors import UNIT, Vector
from .completed import Continued, continued
from .grid import BlockGrid, block_vectors, phased, positions
from .settings import Settings

BORDER = 14  # px, where none is given
Array = NDArray[Any]


class FewPlaces(MethodError):
    """The exemplar holds too little for a mosaic; its best tile can still be repeated."""


def thinned(places: NDArray[np.int64], slack: int) -> NDArray[np.int64]:
    """The first place in every square of slack + 1 px."""
    first = np.unique(places // ((slack + 1) * UNIT), axis=0, return_index=True)[1]
    return places[np.sort(first)]


Places = dict[tuple[int, int], NDArray[np.int64]]


def grid_and_places(
    method: Settings, picture: Array, usable: Array, cell: tuple[Vector, Vector | None], element: float
) -> tuple[BlockGrid, Continued, Places]:
    """Choose the blocks and complete the periods around them; smaller ones where there are too few places for large.

    Returns the grid as it lies in the exemplar, what blocks are read from, and their places there.
    """
    room = int(picture.shape[0]), int(picture.shape[1])
    wide = min(max(1.5 * element, 48.0), min(room) / 2.5)
    target = float(method.block) if method.block is not None else None
    border = method.border or BORDER
    for wanted in (target, 1.0):
        rows, columns = block_vectors(*cell, wanted, wide, room)
        grid, costs = phased(picture, rows, columns, cell, border)
        ground = continued(picture, usable, grid, _steps(cell, wide, room), costs, border)
        placed = ground.placed(grid)
        places = {(i, j): positions(placed, ground.usable, (i, j)) for i in (0, 1) for j in (0, 1)}
        if min(len(p) for p in places.values()) >= 2:
            return grid, ground, places
    raise FewPlaces("the exemplar holds fewer than two places for a block of one period; give a larger exemplar.")


def _steps(cell: tuple[Vector, Vector | None], wide: float, room: tuple[int, int]) -> tuple[float, float]:
    """Px from period to period along both axes, 0 along one that is free."""
    rows, columns = block_vectors(*cell, 1.0, wide, room)
    v1, v2 = cell
    down = abs(v1[0]) >= abs(v1[1])
    free = (False, False) if v2 is not None else (not down, down)
    return 0.0 if free[0] else rows[0] / UNIT, 0.0 if free[1] else columns[1] / UNIT
