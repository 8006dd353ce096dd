"""Patches in step: all lie whole steps of one lattice from the first, give or take a few px.

Where threads cross over and under there is no straight joint to cut along: blocks of whole periods end in the middle of
a strand, wherever they begin. Patches of free shape find their way around it, but miss the lattice. In step they do
both.

Source: no paper; the lattice of Lopez Recas, Hilsmann and Eisert 2011 asked of the patches of Kwatra et al. 2003.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..lattice.vectors import UNIT, Vector
from .step_kernels import mark_steps

Mask = NDArray[np.bool_]
Place = tuple[int, int]

# px off the lattice, as threads are not quite where it says. Of seven weaves together seams cost 4 % less with 1 (of
# rattan and chain mail 8 % more), 1 % more with 6 (of parquet and bamboo 16 %)
SLACK = 3


def in_step(valid: Mask, vectors: tuple[Vector, Vector], place: Place, slack: int = SLACK) -> Mask:
    """Say which of the places `valid` lie whole steps from `place`, which may lie anywhere, give or take `slack` px.

    `vectors` in 1/256 px. Where none does, the slack grows until one does; bool, as `valid`.
    """
    (a, b), (c, d) = vectors
    area = a * d - b * c
    corners = [(y, x) for y in (-slack - 1, valid.shape[0] + slack) for x in (-slack - 1, valid.shape[1] + slack)]
    away = [((y - place[0]) * UNIT, (x - place[1]) * UNIT) for y, x in corners]
    numbers = [(y * d - x * c) // area for y, x in away], [(x * a - y * b) // area for y, x in away]
    ends = np.array([(min(k) - 1, max(k) + 3) for k in numbers], np.int64)
    there = np.zeros(valid.shape, np.uint8)
    mark_steps(np.array(vectors, np.int64), ends, place, False, (UNIT, slack), valid.view(np.uint8), there)
    found = there.view(bool)
    return found if found.any() or not valid.any() else in_step(valid, vectors, place, 2 * slack + 1)
