"""The tile that repeats best: the piece of an exemplar, one lattice cell large, whose opposite sides agree most.

Laid side by side it gives an endless regular pattern; where the exemplar is regular nothing shows the joints. It is
also what is left where an exemplar holds hardly more than one period.

Source: Lopez Recas 2011 (near-regular textures), section 4.1. Departures: borders are compared by vectors rounded to
whole px; differences are added up in whole numbers; pixels under a mask are not used.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..canvas import Canvas
from ..errors import MethodError, ParameterError
from ..exemplar import Exemplar
from ..lattice.vectors import UNIT, Pairs, Vector, cell_of
from .tile_kernels import band_costs, squared_steps
from .tile_layout import TileLayout, read_offsets

Mask = NDArray[np.bool_]

BAND = 8  # px: width of the border that is compared
SHARES = (12, 10, 8, 6, 5, 4)  # of the exemplar, in sixteenths: sides that are tried in a direction without a period


@dataclass(frozen=True)
class Tile:
    """A tile of an exemplar.

    Attributes
    ----------
    anchor : (y, x)
        The corner of the parallelogram, exemplar px.
    vectors : ((dy, dx), (dy, dx))
        Its sides, whole px.
    cost : int
        Sum of the squared differences of both pairs of opposite borders, in feature units.
    costs : int64 array, shape (H, W)
        The cost of every anchor; -1 where the tile or its border leaves the exemplar.
    """

    anchor: Vector
    vectors: tuple[Vector, Vector]
    cost: int
    costs: NDArray[np.int64]


def best_tile(
    features: NDArray[np.int16], vectors: tuple[Vector, Vector], usable: Mask | None = None, band: int = BAND
) -> Tile:
    """Find the tile whose left and right, and top and bottom borders agree best.

    Parameters
    ----------
    features : int16 array, shape (H, W, C)
    vectors : two (dy, dx)
        Of the lattice, in 1/256 px; not parallel.
    usable : bool array, shape (H, W), optional
        False where pixels must not be used.
    band : int
        Width of the compared borders, centred on the sides, px.

    Raises
    ------
    ParameterError
        where the band is below 1 or the vectors are parallel.
    MethodError
        where no tile with its borders fits into the exemplar.
    """
    whole = _in_px(vectors[0]), _in_px(vectors[1])
    (p, q), (r, s) = whole
    if band < 1 or p * s == q * r:
        raise ParameterError(f"band={band}, vectors {vectors}: give a band of at least 1 px and two directions.")
    height, width, _ = features.shape
    mask = np.ones((height, width), np.bool_) if usable is None else usable
    costs = np.zeros((height, width), np.int64)
    difference = np.empty((height, width), np.int64)
    for step, side in (whole, whole[::-1]):
        squared_steps(features, mask, *step, difference)
        if abs(side[0]) >= abs(side[1]):
            band_costs(difference, side[0], side[1], band, costs)
        else:
            band_costs(difference.T, side[1], side[0], band, costs.T)
    _drop_outside(costs, mask, vectors)
    if not (costs >= 0).any():
        raise MethodError(
            f"no tile of {abs(p * s - q * r)} px with a border of {band} px fits into the exemplar "
            f"({width} x {height} px); choose a narrower band, or a larger exemplar."
        )
    order = np.where(costs >= 0, costs, np.iinfo(np.int64).max)
    y, x = divmod(int(order.argmin()), width)
    return Tile((y, x), whole, int(costs[y, x]), costs)


def unlikeness(features: NDArray[np.int16], vectors: Sequence[Vector], usable: Mask) -> float:
    """Say how much the periods of a texture differ: 0 they are equal, 1 they are no more alike than any two places.

    The root mean square of the differences over both vectors (1/256 px, taken as whole px), over that of any two px.
    """
    known = features[usable].astype(np.float64)
    spread = 2 * float(((known - known.mean(axis=0)) ** 2).sum(axis=1).mean())
    if spread == 0:
        return 0.0
    found = np.empty(features.shape[:2], np.int64)
    total, count = 0, 0
    for vector in vectors:
        squared_steps(features, usable, *_in_px(vector), found)
        total += int(found[found >= 0].sum())
        count += int((found >= 0).sum())
    return math.sqrt(total / count / spread) if count else 1.0


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
                listed = " and ".join(f"{x / UNIT:.1f},{y / UNIT:.1f} px" for y, x in pairs[-1])
                raise MethodError(
                    f"no tile of one period ({listed}) and its border fit into the exemplar ({shape[1]} x "
                    f"{shape[0]} px); give a larger exemplar, or use method repeat."
                )
            band //= 2

    def layout(self, canvas: Canvas | None = None) -> TileLayout:
        """The tile over the endless plane, or around a canvas that wraps."""
        return TileLayout.of(self.tile.anchor, self.vectors, canvas)


def _in_px(vector: Vector) -> Vector:
    """Round 1/256 px to px, halves up."""
    return (vector[0] + UNIT // 2) // UNIT, (vector[1] + UNIT // 2) // UNIT


def _drop_outside(costs: NDArray[np.int64], mask: Mask, vectors: tuple[Vector, Vector]) -> None:
    """Give cost -1 to anchors whose tile leaves the exemplar, or holds a px that cannot be used."""
    height, width = costs.shape
    read, (above, before) = read_offsets(vectors)
    below, after = read.shape[0] - 1 - above, read.shape[1] - 1 - before
    costs[:above], costs[:, :before] = -1, -1
    costs[max(height - below, 0) :], costs[:, max(width - after, 0) :] = -1, -1
    if not mask.all():
        from scipy.signal import fftconvolve

        held = np.rint(fftconvolve((~mask).astype(np.float64), read[::-1, ::-1].astype(np.float64)))
        costs[held[below:, after:][:height, :width] > 0] = -1


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
