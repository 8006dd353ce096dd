"""A tile laid out over the endless plane, or strained a little so that it closes around a canvas.

How far a px lies along both lattice vectors is an exact fraction, so that nothing drifts, however far out.

Source: Lopez Recas 2011 (near-regular textures), eq. 3.29. Departures: vectors of fractions of a px; the strain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..errors import ParameterError
from ..lattice.vectors import UNIT, Vector
from ..run import Run
from .tile_kernels import lay_tile

Rates = tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]

STRAIN = 0.02  # how much a lattice may be strained to close around a canvas
BITS = 61  # what fits into 64 bits with a sign and a sum of two


@dataclass(frozen=True)
class TileLayout:
    """Where a tile repeats.

    Attributes
    ----------
    anchor : (y, x)
        The tile's corner, exemplar px; canvas px (y, x) shows it.
    vectors : ((dy, dx), (dy, dx))
        The tile's sides in the exemplar, 1/256 px.
    rates : ((Fraction, Fraction), (Fraction, Fraction))
        How many sides one px down, and one px to the right, goes along the first and the second vector.
    """

    anchor: Vector
    vectors: tuple[Vector, Vector]
    rates: Rates

    @classmethod
    def of(cls, anchor: Vector, vectors: tuple[Vector, Vector], canvas: Canvas | None = None) -> TileLayout:
        """Lay a tile out as its sides say; ParameterError where the canvas wraps at no whole number of them."""
        (p, q), (r, s) = vectors
        area = p * s - q * r
        free = Fraction(UNIT * s, area), Fraction(-UNIT * q, area)
        right = Fraction(-UNIT * r, area), Fraction(UNIT * p, area)
        sides = [None, None] if canvas is None else [_once_around(vectors, canvas, axis) for axis in (0, 1)]
        lengths = [1, 1] if canvas is None else [canvas.height, canvas.width]
        down, across = (
            otherwise if side is None else (Fraction(side[0], n), Fraction(side[1], n))
            for side, n, otherwise in zip(sides, lengths, (free, right), strict=True)
        )
        fixed = math.lcm(*(n for side, n in zip(sides, lengths, strict=True) if side is not None))
        bits = BITS - max(abs(n) for v in vectors for n in v).bit_length() - fixed.bit_length()
        rates = (down, across)
        if math.lcm(*(f.denominator for rate in rates for f in rate)).bit_length() > bits + fixed.bit_length():
            one = 1 << bits  # a lattice of very long vectors: rounded, beyond any px
            down, across = (
                rate if side is not None else (Fraction(round(rate[0] * one), one), Fraction(round(rate[1] * one), one))
                for rate, side in zip(rates, sides, strict=True)
            )
        return cls(anchor, vectors, (down, across))

    def window(
        self, y0: int, x0: int, height: int, width: int, run: Run | None = None
    ) -> tuple[NDArray[np.int32], None]:
        """The exemplar pixels (height, width, 2) of a window, all upright; y0 and x0 may be negative and huge."""
        whole = math.lcm(*(f.denominator for rate in self.rates for f in rate))
        steps = [[int(f * whole) % whole for f in rate] for rate in self.rates]
        y, x = y0 - self.anchor[0], x0 - self.anchor[1]
        first = [(y * steps[0][k] + x * steps[1][k]) % whole for k in (0, 1)]
        begin, rates, vectors, anchor = (np.array(n, np.int64) for n in (first, steps, self.vectors, self.anchor))
        out = np.empty((height, width, 2), np.int32)
        lay_tile(out, begin, rates, whole, vectors, anchor)
        return out, None


def read_offsets(vectors: tuple[Vector, Vector]) -> tuple[NDArray[np.bool_], Vector]:
    """Which px around its corner a tile of sides in 1/256 px may read, and where in that array the corner is.

    Real vectors: all px whose square meets the parallelogram. Whole ones: those of one period, no more.
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


def periods_along(vectors: tuple[Vector, Vector], axis: int, longest: int) -> list[tuple[int, int, int]]:
    """List which periods lead straight down (axis 0) or to the right (axis 1), at most `longest` px, rising.

    Each as the number of both vectors, and the length in px, rounded.
    """
    ((p, q), (r, s)) = vectors if axis == 0 else ((vectors[0][1], vectors[0][0]), (vectors[1][1], vectors[1][0]))
    swapped = abs(q) > abs(s)  # count the vector that leads less far aside
    if swapped:
        (p, q), (r, s) = (r, s), (p, q)
    step = p - r * q / s  # forward, for each vector counted
    most = math.ceil((longest * UNIT + abs(r)) / max(abs(step), 1.0))
    reach = min(8, math.ceil(STRAIN * longest * UNIT / abs(s)))  # far out there are many, and the nearest suffice
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


def _once_around(vectors: tuple[Vector, Vector], canvas: Canvas, axis: int) -> Vector | None:
    """How many of both vectors go once around the canvas along an axis; None where it does not wrap."""
    length, wraps = ((canvas.height, canvas.wrap.y), (canvas.width, canvas.wrap.x))[axis]
    if not wraps:
        return None
    longest = length + 4 * max(abs(v[axis]) for v in vectors) // UNIT + 2
    found = periods_along(vectors, axis, longest)
    strains = [
        math.hypot(a * v[axis] + b * w[axis] - length * UNIT, a * v[1 - axis] + b * w[1 - axis]) / (length * UNIT)
        for v, w in (vectors,)
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
