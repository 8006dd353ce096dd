"""Patches that lie in step with what is there: whole steps of a lattice beside it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import ISOMETRIES
from ..lattice.vectors import UNIT
from ..patches.growth import Growth, Pick
from ..seams.placement_kernels import mark_steps
from ..search.candidates import Candidates
from ..search.fourier import PatchSearch
from . import lattice_kernels

Array = NDArray[Any]
Lattice = tuple[tuple[float, float], ...]

SLACK = 1  # px: how far a patch may leave the lattice, whose vectors are fractions


def in_step(growth: Growth, lattice: Lattice, at: tuple[int, int], shown: Pick, most: int) -> Candidates:
    """Return the `most` best patches for the window at `at` that lie whole steps from the one that has `shown` there.

    `lattice`: one vector or two (dx, dy), px of the exemplar. A middle that was made a hole does not count.
    """
    valid, torus = growth.variants.valid[shown[0]], bool(growth.variants.toroidal[shown[0]])
    j = np.array(ISOMETRIES[int(growth.variants.pose[shown[0]])].j, np.int64)
    side = 2 * int(growth.variants.table[shown[0], 1:3].max())
    steps, ends = np.zeros((2, 2), np.int64), np.array([(0, 1), (0, 1)], np.int64)  # of one vector the second is still
    for k, (dx, dy) in enumerate(lattice):
        steps[k] = (round(dy * UNIT), round(dx * UNIT)) @ j
        far = side * UNIT // max(int(np.abs(steps[k]).max()), UNIT) + 1
        ends[k] = -far, far + 1
    there = np.zeros(valid.shape, np.uint8)
    mark_steps(steps, ends, shown[1:], torus, (UNIT, SLACK), valid.view(np.uint8), there)
    places = np.flatnonzero(there)
    grown = growth.growing
    assert isinstance(growth.finder, PatchSearch)
    feats, known = growth.finder.windows(grown.variant, grown.yx, np.array([at], np.int64), growth.layout.wraps)
    rows = np.empty((len(places), 4), np.int64)
    rows[:, 1], rows[:, 2], rows[:, 3] = shown[0], *np.divmod(places, valid.shape[1])
    lattice_kernels.measure_best(feats[0], known[0], growth.variants.posed, most, rows)
    return Candidates(rows[np.argsort(rows[:, 0], kind="stable")[:most]], 0, feats[0], known[0])
