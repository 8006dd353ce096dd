"""Patches that lie in step with what is there: whole steps of a lattice beside it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import ISOMETRIES
from ..patches.growth import Growth, Pick
from ..search.candidates import Candidates
from ..search.fourier import PatchSearch
from . import lattice_kernels

Array = NDArray[Any]
Lattice = tuple[tuple[float, float], ...]

SLACK = 1  # px: how far a patch may leave the lattice, whose vectors are fractions
FINE = 256  # vectors are rounded to 1/256 px, so that sums of them are the same everywhere


def in_step(growth: Growth, lattice: Lattice, at: tuple[int, int], shown: Pick, most: int) -> Candidates:
    """Return the `most` best patches for the window at `at` that lie whole steps from the one that has `shown` there.

    `lattice`: one vector or two (dx, dy), px of the exemplar. A middle that was made a hole does not count.
    """
    valid, torus = growth.variants.valid[shown[0]], bool(growth.variants.toroidal[shown[0]])
    j = np.array(ISOMETRIES[int(growth.variants.pose[shown[0]])].j, np.int64)
    steps = np.array([(round(dy * FINE), round(dx * FINE)) for dx, dy in lattice], np.int64) @ j
    side = int(growth.variants.table[shown[0], 1:3].max())
    most_steps = np.array([2 * side * FINE // max(int(np.abs(step).max()), FINE) + 1 for step in steps], np.int64)
    there = np.zeros(valid.shape, np.uint8)
    lattice_kernels.mark_steps(steps, most_steps, shown[1:], torus, (FINE, SLACK), valid.view(np.uint8), there)
    places = np.flatnonzero(there)
    grown = growth.growing
    assert isinstance(growth.finder, PatchSearch)
    feats, known = growth.finder.windows(grown.variant, grown.yx, np.array([at], np.int64), growth.layout.wraps)
    rows = np.empty((len(places), 4), np.int64)
    rows[:, 1], rows[:, 2], rows[:, 3] = shown[0], *np.divmod(places, valid.shape[1])
    lattice_kernels.measure_best(feats[0], known[0], growth.variants.posed, most, rows)
    return Candidates(rows[np.argsort(rows[:, 0], kind="stable")[:most]], 0, feats[0], known[0])
