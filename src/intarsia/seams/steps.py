"""Patches in step: all lie whole steps of one lattice from the first, give or take a few px.

Where threads cross over and under there is no straight joint to cut along: blocks of whole periods end in the middle of
a strand, wherever they begin. Patches of free shape find their way around it, but miss the lattice. In step they do
both.

Source: no paper; the lattice of Lopez Recas, Hilsmann and Eisert 2011 asked of the patches of Kwatra et al. 2003.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..lattice.vectors import UNIT, Vector

Mask = NDArray[np.bool_]
Place = tuple[int, int]

# px off the lattice, as threads are not quite where it says. Of seven weaves together seams cost 4 % less with 1 (of
# rattan and chain mail 8 % more), 1 % more with 6 (of parquet and bamboo 16 %)
SLACK = 3


def in_step(valid: Mask, vectors: tuple[Vector, Vector], place: Place, slack: int = SLACK) -> Mask:
    """Say which of the places `valid` lie whole steps from `place`, which may lie anywhere, give or take `slack` px.

    `vectors` in 1/256 px. Where none does, the slack grows until one does; bool, as `valid`.
    """
    points = points_in(valid.shape, vectors, place, slack)
    around = np.zeros((valid.shape[0] + 4 * slack, valid.shape[1] + 4 * slack), bool)  # 2 slacks to every side
    for i in range(2 * slack + 1):
        for j in range(2 * slack + 1):
            around[points[:, 0] + slack + i, points[:, 1] + slack + j] = True
    there = around[2 * slack : 2 * slack + valid.shape[0], 2 * slack : 2 * slack + valid.shape[1]] & valid
    return there if there.any() or not valid.any() else in_step(valid, vectors, place, 2 * slack + 1)


def points_in(shape: tuple[Any, ...], vectors: tuple[Vector, Vector], place: Place, slack: int) -> NDArray[np.int64]:
    """Return the places whole steps from `place`, in px, up to `slack` px outside of a box from (0, 0): (n, 2)."""
    (a, b), (c, d) = vectors
    area = a * d - b * c
    ends = [(y * UNIT, x * UNIT) for y in (-slack - 1, shape[0] + slack) for x in (-slack - 1, shape[1] + slack)]
    away = [(y - place[0] * UNIT, x - place[1] * UNIT) for y, x in ends]
    first, second = [(y * d - x * c) // area for y, x in away], [(x * a - y * b) // area for y, x in away]
    m, n = (np.arange(min(k) - 1, max(k) + 3, dtype=np.int64) for k in (first, second))
    y = place[0] + (m[:, None] * a + n * c + UNIT // 2) // UNIT
    x = place[1] + (m[:, None] * b + n * d + UNIT // 2) // UNIT
    inside = (y >= -slack) & (y < shape[0] + slack) & (x >= -slack) & (x < shape[1] + slack)
    return np.stack([y[inside], x[inside]], axis=1)
