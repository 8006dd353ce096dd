"""Patches aligned to a lattice: all offsets are lattice vectors from the first patch, within a few px.

In a weave there is no straight joint to cut along, so rectangular blocks of whole periods end in the middle of a
strand. Graph-cut patches of free shape avoid that, but leave the lattice; patches aligned to it do neither. On a canvas
that wraps the lattice is stretched until a whole number of periods fits; the difference is spread over all patches.

Source: no paper; our combination of the lattice of Lopez Recas, Hilsmann and Eisert 2011 with the patches of Kwatra et
al. 2003.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..analysis import window_sums
from ..foundation.arrays import Mask, Pair
from ..foundation.geometry import UNIT
from ..lattice import Vector, Vectors

# px that a patch may lie off a lattice of two vectors, as real threads do. Seam costs of seven weaves together: 4 %
# less with 1 (rattan and chain mail 8 % more), 1 % more with 6 (parquet and bamboo 16 % more).
SLACK = 3
# px off the rows of a lattice of one vector. Seam costs relative to 3 px: planks 0.86, text 0.97, boards 1.09.
STRAIGHT = 1


def aligned_place(around: Sequence[Vector], first: tuple[Pair, Pair], at: Pair, shape: Sequence[int]) -> Pair:
    """Return the exemplar place, possibly beyond its border, that is lattice-aligned with a canvas pixel.

    Parameters
    ----------
    around : two vectors, (rows, columns) in 1/256 px
        The displacements in the exemplar that correspond to the full height and the full width of the canvas: the same
        lengths where the canvas does not wrap, the nearest lattice vectors where it does.
    first : two pairs (row, column)
        A pixel of the exemplar, and the canvas pixel that shows it.
    at : (row, column)
        The canvas pixel.
    shape : (rows, columns)
        Size of the canvas, px.
    """
    y, x = first[0]
    for step, n, here, there in zip(around, shape, first[1], at, strict=True):
        y, x = (p + (2 * (there - here) * s + n * UNIT) // (2 * n * UNIT) for p, s in zip((y, x), step, strict=True))
    return y, x


def aligned(valid: Mask, vectors: Vectors, place: Pair, slack: int) -> Mask:
    """Return which of the places `valid` are lattice-aligned with `place`, which may lie anywhere, within `slack` px.

    `vectors`: of the lattice, in 1/256 px. If no valid place is aligned, the slack is enlarged to 2 `slack` + 1, again
    and again, until one is. Returns bool, of the shape of `valid`.
    """
    (a, b), (c, d) = vectors
    area = a * d - b * c
    corners = [(y, x) for y in (-slack - 1, valid.shape[0] + slack) for x in (-slack - 1, valid.shape[1] + slack)]
    away = [((y - place[0]) * UNIT, (x - place[1]) * UNIT) for y, x in corners]
    numbers = [(y * d - x * c) // area for y, x in away], [(x * a - y * b) // area for y, x in away]
    m, n = np.ix_(*(range(min(k) - 1, max(k) + 3) for k in numbers))
    y = place[0] + (m * a + n * c + UNIT // 2) // UNIT + slack
    x = place[1] + (m * b + n * d + UNIT // 2) // UNIT + slack
    found = np.zeros([side + 2 * slack for side in valid.shape], bool)
    inside = (y >= 0) & (y < found.shape[0]) & (x >= 0) & (x < found.shape[1])
    found[y[inside], x[inside]] = True
    found = valid & (window_sums(found, (2 * slack + 1, 2 * slack + 1)) > 0)
    return found if found.any() or not valid.any() else aligned(valid, vectors, place, 2 * slack + 1)
