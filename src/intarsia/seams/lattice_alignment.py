"""Patches aligned to a lattice: all offsets are lattice vectors from the first patch, within a few px.

Where threads cross there is no straight joint to cut along, so blocks of whole periods end in the middle of a strand;
patches of free shape find their way around it, but miss the lattice. Aligned ones do both. On a canvas that wraps the
lattice is stretched until it holds whole periods: what is off by that is taken up a little from patch to patch.

Source: no paper; the lattice of Lopez Recas, Hilsmann and Eisert 2011 asked of the patches of Kwatra et al. 2003.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..analysis import window_sums
from ..foundation.arrays import Mask, Pair
from ..foundation.geometry import UNIT
from ..lattice import Vector, Vectors

# px off the lattice, as threads are not quite where it says. Of seven weaves together seams cost 4 % less with 1 (of
# rattan and chain mail 8 % more), 1 % more with 6 (of parquet and bamboo 16 %)
SLACK = 3
STRAIGHT = 1  # across rows of one vector: seams of planks cost 0.86 of those with 3, of text 0.97, of boards 1.09


def aligned_place(around: Sequence[Vector], first: tuple[Pair, Pair], at: Pair, shape: Sequence[int]) -> Pair:
    """Return the exemplar place, possibly beyond its border, that is lattice-aligned with a canvas pixel.

    `first`: a px of the exemplar, and where the canvas shows it. `around`: where all rows and all columns of the canvas
    lead, (rows, columns) in 1/256 px: as far as on the canvas, or steps of the lattice where it wraps.
    """
    y, x = first[0]
    for step, n, here, there in zip(around, shape, first[1], at, strict=True):
        y, x = (p + (2 * (there - here) * s + n * UNIT) // (2 * n * UNIT) for p, s in zip((y, x), step, strict=True))
    return y, x


def aligned(valid: Mask, vectors: Vectors, place: Pair, slack: int) -> Mask:
    """Return which of the places `valid` are lattice-aligned with `place`, which may lie anywhere, within `slack` px.

    `vectors` in 1/256 px. Where none does, the slack grows until one does; bool, as `valid`.
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
