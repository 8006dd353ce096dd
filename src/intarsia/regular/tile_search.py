"""Best tile: the parallelogram of one lattice cell whose opposite borders match best, and its exact repetition.

Repeated side by side it gives a regular pattern; if the exemplar is regular no joint is visible. It is the fallback for
exemplars of hardly more than one period.

The position along both lattice vectors is an exact fraction, so that nothing drifts, however far out. On a canvas that
wraps, the lattice is strained a little so that it closes.

Source: Lopez Recas 2011 (near-regular textures), section 4.1 and eq. 3.29. Departures: borders are compared by vectors
rounded to whole px; differences are summed in whole numbers; pixels under a mask are not used; vectors of fractions of
a px; the strain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from ..analysis.features import features
from ..foundation import MethodError, ParameterError
from ..foundation.arrays import Int16, Int32, Int64, Mask, Pair
from ..foundation.geometry import UNIT
from ..foundation.params import Weights
from ..foundation.run import Run
from ..lattice import STRAIN, Pairs, Vector, Vectors, cell_of
from ..lattice.correlation_peaks import overlap
from ..model import Exemplar
from ..model.canvas import Canvas
from .tile_kernels import lay_tile

Rates = list[list[Fraction]]

BITS = 61  # bits of a number so that a sum of two with sign fits into 64


@dataclass(frozen=True)
class TileLayout:
    """Repetition of a tile over a canvas.

    Attributes
    ----------
    anchor : (y, x)
        The tile's corner in exemplar px; canvas px of the same coordinates is a copy of it.
    vectors : ((dy, dx), (dy, dx))
        The tile's sides in the exemplar, 1/256 px.
    rates : [[Fraction, Fraction], [Fraction, Fraction]]
        By how many first and second vectors the position in the tile advances per px down, and per px to the right.
    """

    anchor: Vector
    vectors: Vectors
    rates: Rates

    @classmethod
    def of(cls, anchor: Vector, vectors: Vectors, canvas: Canvas) -> TileLayout:
        """Return the layout of a tile on a canvas; it is strained along axes that wrap, by 2 % at most.

        Raise ParameterError if a wrapped axis needs more strain.
        """
        (p, q), (r, s) = vectors
        area, lengths = p * s - q * r, (canvas.height, canvas.width)
        sides = [_once_around(vectors, canvas, axis) for axis in (0, 1)]
        rates = [
            [Fraction(n, length) for n in side] if side else [Fraction(UNIT * n, area) for n in free]
            for side, length, free in zip(sides, lengths, ((s, -q), (-r, p)), strict=True)
        ]
        fixed = math.lcm(*(length for side, length in zip(sides, lengths, strict=True) if side)).bit_length()
        bits = BITS - max(abs(n) for v in vectors for n in v).bit_length() - fixed
        if _denominator(rates).bit_length() > bits + fixed:
            one = 1 << bits  # for very long vectors rates are rounded to fit into 64 bits
            rates = [
                rate if side else [Fraction(round(f * one), one) for f in rate]
                for rate, side in zip(rates, sides, strict=True)
            ]
        return cls(anchor, vectors, rates)

    def window(self, y0: int, x0: int, height: int, width: int, run: Run | None = None) -> Int32:
        """Return the exemplar pixels (height, width, 2) of a window; y0, x0: any whole numbers."""
        whole = _denominator(self.rates)
        steps = [[int(f * whole) % whole for f in rate] for rate in self.rates]
        y, x = y0 - self.anchor[0], x0 - self.anchor[1]
        first = [(y * steps[0][k] + x * steps[1][k]) % whole for k in (0, 1)]
        begin, rates, vectors, anchor = (np.array(n, np.int64) for n in (first, steps, self.vectors, self.anchor))
        out = np.empty((height, width, 2), np.int32)
        lay_tile(out, begin, rates, whole, vectors, anchor)
        return out


def _denominator(rates: Rates) -> int:
    return math.lcm(*(f.denominator for rate in rates for f in rate))


def read_offsets(vectors: Vectors) -> tuple[Mask, Vector]:
    """Return which px around its corner a tile of sides in 1/256 px may read, and the corner's index in that array.

    For fractional vectors: all px whose square meets the parallelogram. For whole ones: those of one period.
    """
    corners = np.array([(0, 0), *vectors, np.add(*vectors)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    above, before = (int(n) for n in -((low + UNIT // 2) // UNIT))
    below, after = (int(n) for n in (high + UNIT // 2) // UNIT)
    y, x = (np.arange(-a, b + 1, dtype=np.int64) * UNIT for a, b in ((above, below), (before, after)))
    whole = all(n % UNIT == 0 for v in vectors for n in v)
    inside = np.ones((len(y), len(x)), bool)
    for v, other in (vectors, vectors[::-1]):  # how far along one vector, across the other
        area = v[0] * other[1] - v[1] * other[0]
        along = y[:, None] * other[1] - x[None, :] * other[0]
        if area < 0:
            area, along = -area, -along
        slack = 0 if whole else UNIT // 2 * (abs(other[0]) + abs(other[1]))
        inside &= (along >= -slack) & ((along < area) if whole else (along <= area + slack))
    return inside, (above, before)


def periods_along(vectors: Vectors, axis: int, longest: int) -> list[tuple[int, int, int]]:
    """Return the lattice vectors within 2 % of the downward (axis 0) or rightward (axis 1) direction, by length.

    Each as its multiples of both vectors and its length in px, rounded, at most `longest`; of equal lengths the one of
    least strain first.
    """
    (p, q), (r, s) = (v if axis == 0 else v[::-1] for v in vectors)
    swapped = abs(q) > abs(s)  # `a` counts the vector with the smaller component across the axis
    if swapped:
        (p, q), (r, s) = (r, s), (p, q)
    step = p - r * q / s  # along the axis per count of `a`
    most = math.ceil((longest * UNIT + abs(r)) / max(abs(step), 1.0))
    reach = min(8, math.ceil(STRAIN * longest * UNIT / abs(s)))  # of many at long distances the nearest suffice
    a, near = (n.ravel() for n in np.meshgrid(np.arange(-most, most + 1), np.arange(-reach, reach + 1)))
    b = near - ((2 * a * q + abs(s)) // (2 * abs(s))) * (1 if s > 0 else -1)
    forward, aside = a * p + b * r, a * q + b * s
    px = (forward + UNIT // 2) // UNIT
    good = (px > 0) & (px <= longest)
    strain = np.hypot(forward - px * UNIT, aside) / (np.maximum(px, 1) * UNIT)
    good &= strain <= STRAIN
    order = np.flatnonzero(good)[np.lexsort((strain[good], px[good]))]
    counts = (b, a) if swapped else (a, b)
    return [(int(counts[0][k]), int(counts[1][k]), int(px[k])) for k in order]


def _once_around(vectors: Vectors, canvas: Canvas, axis: int) -> Vector | None:
    """Return the multiples of both vectors that go once around the canvas along an axis; None if it does not wrap."""
    length, wraps = ((canvas.height, canvas.wrap.y), (canvas.width, canvas.wrap.x))[axis]
    if not wraps:
        return None
    longest = length + 4 * max(abs(v[axis]) for v in vectors) // UNIT + 2
    found = periods_along(vectors, axis, longest)
    v, w = vectors
    strains = [
        math.hypot(a * v[axis] + b * w[axis] - length * UNIT, a * v[1 - axis] + b * w[1 - axis]) / (length * UNIT)
        for a, b, _ in found
    ]
    if strains and min(strains) <= STRAIN:
        return found[strains.index(min(strains))][:2]
    near = (max((n for *_, n in found if n < length), default=0), min((n for *_, n in found if n > length), default=0))
    fits = " or ".join(str(n) for n in near if n)
    raise ParameterError(
        f"wrap: {('height', 'width')[axis]}={length} px is no whole number of periods (at most {100 * STRAIN:.0f} % "
        f"strain); " + (f"choose {fits} px." if fits else f"none up to {longest} px is, so drop wrap.")
    )


BAND = 8  # px: default width of the borders compared
SHARES = (12, 10, 8, 6, 5, 4)  # sixteenths of the exemplar: lengths tried along courses, where there is no period


class Tile(NamedTuple):
    """A tile of an exemplar.

    Attributes
    ----------
    anchor : (y, x)
        The corner of the parallelogram, exemplar px.
    vectors : ((dy, dx), (dy, dx))
        Its sides, whole px.
    cost : int
        Sum of the squared differences of both pairs of opposite borders, in squared feature units.
    costs : int64 array, shape (H, W)
        The cost of every anchor; -1 if the tile or its border leaves the exemplar.
    """

    anchor: Vector
    vectors: Vectors
    cost: int
    costs: Int64


def best_tile(
    features: Int16, vectors: Vectors, usable: Mask | None = None, band: int = BAND
) -> Tile:
    """Find the tile whose left and right, and top and bottom borders match best.

    Parameters
    ----------
    features : int16 array, shape (H, W, C)
        Of the exemplar.
    vectors : two (dy, dx)
        Of the lattice, in 1/256 px; not parallel.
    usable : bool array, shape (H, W), optional
        False where pixels must not be used.
    band : int
        Width of the compared borders, centred on the sides, px.

    Returns
    -------
    Tile
        The one of least cost, of equals the first by rows.

    Raises
    ------
    ParameterError
        If the band is below 1 or the vectors, rounded to px, are parallel.
    MethodError
        If no tile with its borders fits into the exemplar.
    """
    whole = _in_px(vectors[0]), _in_px(vectors[1])
    (p, q), (r, s) = whole
    if band < 1 or p * s == q * r:
        raise ParameterError(f"band={band}, vectors {vectors}: give a band of at least 1 px and two directions.")
    height, width, _ = features.shape
    mask = np.ones((height, width), np.bool_) if usable is None else usable
    costs = np.zeros((height, width), np.int64)
    for step, side in (whole, whole[::-1]):
        difference = squared_steps(features, mask, step)
        if abs(side[0]) >= abs(side[1]):
            _add_border(costs, difference, side, band)
        else:
            _add_border(costs.T, difference.T, side[::-1], band)
    _drop_outside(costs, mask, vectors)
    if not (costs >= 0).any():
        raise MethodError(
            f"no tile of {abs(p * s - q * r)} px with a border of {band} px fits into the exemplar "
            f"({width} x {height} px); choose a narrower band, or a larger exemplar."
        )
    order = np.where(costs >= 0, costs, np.iinfo(np.int64).max)
    y, x = divmod(int(order.argmin()), width)
    return Tile((y, x), whole, int(costs[y, x]), costs)


def _add_border(costs: Int64, difference: Int64, side: Vector, band: int) -> None:
    """Add to the cost of every anchor the differences in a band around a side (dy, dx), |dy| >= |dx|, dy not 0.

    In every row of the side the band is `band` px wide, centred on the side. The cost is -1 if a difference is missing.
    """
    (dy, dx), (height, width) = side, costs.shape
    rows = abs(dy)
    around = np.pad(difference, rows + band, constant_values=-1)
    sums = np.cumsum([np.maximum(around, 0), around < 0], axis=2)  # differences, and number of missing ones
    bands = sums[:, :, band:] - sums[:, :, :-band]
    total = np.zeros((2, height, width), np.int64)
    for i in range(rows):
        top = rows + band + (i if dy > 0 else -i)
        left = rows + band - 1 + (2 * i * dx + rows) // (2 * rows) - band // 2
        total += bands[:, top : top + height, left : left + width]
    costs[...] = np.where((costs < 0) | (total[1] > 0), -1, costs + total[0])


def squared_steps(features: Int16, usable: Mask, step: Vector) -> Int64:
    """Return the squared difference of every px from the one a step away; -1 if either is not usable."""
    out, (here, there) = np.full(usable.shape, -1, np.int64), overlap(usable.shape, step)
    apart = features[there].astype(np.int64) - features[here]
    out[here] = np.where(usable[here] & usable[there], (apart * apart).sum(axis=2), -1)
    return out


def period_difference(features: Int16, vectors: Sequence[Vector], usable: Mask) -> float:
    """Return how much the periods of a texture differ: 0 if they are equal, 1 if as much as random pairs of pixels.

    The root mean square of the differences over both vectors (1/256 px, rounded to px), divided by that of random
    pairs.
    """
    known = features[usable].astype(np.float64)
    spread = 2 * float(((known - known.mean(axis=0)) ** 2).sum(axis=1).mean())
    if spread == 0:
        return 0.0
    total, count = 0, 0
    for vector in vectors:
        found = squared_steps(features, usable, _in_px(vector))
        total += int(found[found >= 0].sum())
        count += int((found >= 0).sum())
    return math.sqrt(total / count / spread) if count else 1.0


@dataclass(frozen=True)
class Tiling:
    """The best tile of an exemplar, its exact vectors in 1/256 px, and the width in px of the compared borders."""

    tile: Tile
    vectors: Vectors
    band: int

    @classmethod
    def of(cls, lattice: Pairs, weights: Weights, band: int, exemplar: Exemplar) -> Tiling:
        """Find the best tile; the band is halved until one fits. Raise MethodError if none fits with a band of 1 px.

        With one lattice vector several lengths along the courses are tried, and the least cost per px of border wins.
        """
        picture = features([exemplar], weights).pictures[0]
        shape = int(picture.shape[0]), int(picture.shape[1])
        first, second = cell_of(lattice, shape)
        pairs = [(first, second)] if second is not None else [(first, v) for v in _sides(first, shape)]
        while True:
            found: list[Tiling] = []
            for pair in pairs:
                with suppress(MethodError):
                    found.append(cls(best_tile(picture, pair, exemplar.usable, band), pair, band))
            if found:
                return min(found, key=lambda t: t.tile.cost / sum(math.hypot(*v) for v in t.vectors))
            if band == 1:
                listed = " and ".join(f"{x / UNIT:.1f},{y / UNIT:.1f} px" for y, x in pairs[-1])
                raise MethodError(
                    f"no tile of one period ({listed}) and its border fit into the exemplar ({shape[1]} x "
                    f"{shape[0]} px); give a larger exemplar, or use method repeat."
                )
            band //= 2

    def layout(self, canvas: Canvas) -> TileLayout:
        """Return the layout over the endless plane, or around a canvas that wraps."""
        return TileLayout.of(self.tile.anchor, self.vectors, canvas)


def _in_px(vector: Vector) -> Vector:
    """Round 1/256 px to px, halves up."""
    return (vector[0] + UNIT // 2) // UNIT, (vector[1] + UNIT // 2) // UNIT


def _drop_outside(costs: Int64, mask: Mask, vectors: Vectors) -> None:
    """Set the cost to -1 for anchors whose tile leaves the exemplar or holds an unusable px."""
    height, width = costs.shape
    read, (above, before) = read_offsets(vectors)
    below, after = read.shape[0] - 1 - above, read.shape[1] - 1 - before
    costs[:above], costs[:, :before] = -1, -1
    costs[max(height - below, 0) :], costs[:, max(width - after, 0) :] = -1, -1
    if not mask.all():
        from scipy.signal import fftconvolve

        held = np.rint(fftconvolve((~mask).astype(np.float64), read[::-1, ::-1].astype(np.float64)))
        costs[held[below:, after:][:height, :width] > 0] = -1


def _sides(vector: Vector, shape: Pair) -> list[Vector]:
    """Return vectors perpendicular to the only lattice vector, longest first: 12/16 to 4/16 of the room there is."""
    length = math.hypot(*vector)
    y, x = -vector[1] / length, vector[0] / length
    room = min(n / abs(c) if abs(c) > 1e-9 else math.inf for n, c in zip(shape, (y, x), strict=True))
    return [(round(y * room * k / 16 * UNIT), round(x * room * k / 16 * UNIT)) for k in SHARES]
