"""Plain repetition of the tile that repeats best: what is left where an exemplar holds hardly more than one period."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..canvas import Canvas
from ..errors import MethodError
from ..exemplar import Exemplar
from ..lattice.vectors import UNIT, Pairs, Vector, cell_of
from .best_tile import Tile, best_tile
from .tile_layout import TileLayout

SHARES = (12, 10, 8, 6, 5, 4)  # of the exemplar, in sixteenths: sides that are tried in a direction without a period


@dataclass(frozen=True)
class Tiling:
    """The best tile of an exemplar, and the width in px of the border that was compared."""

    tile: Tile
    vectors: tuple[Vector, Vector]
    band: int

    @classmethod
    def of(cls, lattice: Pairs, weights: tuple[float, ...] | None, band: int, exemplar: Exemplar) -> Tiling:
        """Find the tile; MethodError where none fits, however narrow its border is."""
        picture = features([exemplar], weights).pictures[0]
        shape = int(picture.shape[0]), int(picture.shape[1])
        first, second = cell_of(lattice, shape)
        pairs = [(first, second)] if second is not None else [(first, v) for v in _sides(first, shape)]
        while True:
            found = [t for t in (_fitting(picture, pair, exemplar.usable, band) for pair in pairs) if t is not None]
            if found:
                return min(found, key=lambda t: t.tile.cost / sum(math.hypot(*v) for v in t.vectors))
            if band == 1:
                raise MethodError(
                    f"no tile of one period ({_listed(pairs[-1])}) and its border fit into the exemplar ({shape[1]} x "
                    f"{shape[0]} px); give a larger exemplar, or use method repeat."
                )
            band //= 2

    def layout(self, canvas: Canvas | None = None) -> TileLayout:
        """The tile over the endless plane, or around a canvas that wraps."""
        return TileLayout.of(self.tile.anchor, self.vectors, canvas)


def _fitting(
    picture: NDArray[np.int16], vectors: tuple[Vector, Vector], usable: NDArray[np.bool_] | None, band: int
) -> Tiling | None:
    try:
        return Tiling(best_tile(picture, vectors, usable, band), vectors, band)
    except MethodError:
        return None


def _sides(vector: Vector, shape: tuple[int, int]) -> list[Vector]:
    """Sides across the only lattice vector: there nothing returns, so any length may be cut off. The longest first."""
    length = math.hypot(*vector)
    y, x = -vector[1] / length, vector[0] / length
    room = min(n / abs(c) if abs(c) > 1e-9 else math.inf for n, c in zip(shape, (y, x), strict=True))
    return [(round(y * room * k / 16 * UNIT), round(x * room * k / 16 * UNIT)) for k in SHARES]


def _listed(vectors: tuple[Vector, Vector]) -> str:
    return " and ".join(f"{x / UNIT:.1f},{y / UNIT:.1f} px" for y, x in vectors)
