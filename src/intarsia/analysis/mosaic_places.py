"""Which blocks a mosaic is made of, and where in the exemplar they may be read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from ..errors import MethodError
from .blockgrid import UNIT, BlockGrid, Vector, block_vectors, phased, positions
from .mosaic_settings import Settings

BORDER = 14  # px, where none is given
Array = NDArray[Any]


class FewPlaces(MethodError):
    """The exemplar holds too little for a mosaic; its best tile can still be repeated."""


def nearest(usable: NDArray[np.bool_]) -> NDArray[np.intp] | None:
    """For every pixel the nearest usable one (2, H, W); None where all are usable."""
    if usable.all():
        return None
    return np.asarray(distance_transform_edt(~usable, return_distances=False, return_indices=True), np.intp)


def thinned(places: NDArray[np.int64], slack: int) -> NDArray[np.int64]:
    """The first place in every square of slack + 1 px."""
    first = np.unique(places // ((slack + 1) * UNIT), axis=0, return_index=True)[1]
    return places[np.sort(first)]


def grid_and_places(
    method: Settings, picture: Array, usable: Array, cell: tuple[Vector, Vector | None], element: float
) -> tuple[BlockGrid, dict[tuple[int, int], NDArray[np.int64]]]:
    """Choose the blocks; smaller ones where the exemplar holds too few places for large ones."""
    room = picture.shape[:2]
    wide = min(max(1.5 * element, 48.0), min(room) / 2.5)
    target = float(method.block) if method.block is not None else None
    for wanted in (target, 1.0):
        rows, columns = block_vectors(*cell, wanted, wide, (int(room[0]), int(room[1])))
        grid = phased(picture, rows, columns, cell, method.border or BORDER)
        places = {(i, j): positions(grid, usable, (i, j)) for i in (0, 1) for j in (0, 1)}
        if min(len(p) for p in places.values()) >= 2:
            return grid, places
    raise FewPlaces("the exemplar holds fewer than two places for a block of one period; give a larger exemplar.")
