"""Patches that lie in step with what is there: whole steps of a lattice beside it."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import ISOMETRIES
from ..patches.growth import Growth, Pick
from ..search.candidates import Candidates
from ..search.fourier import PatchSearch
from . import copies_kernels

Array = NDArray[Any]
Lattice = tuple[tuple[float, float], ...]

SLACK = 1  # px: how far a patch may leave the lattice, whose vectors are fractions
FINE = 256  # vectors are rounded to 1/256 px, so that sums of them are the same everywhere


def in_step(growth: Growth, lattice: Lattice, at: tuple[int, int], shown: Pick, most: int) -> Candidates:
    """Return the `most` best patches for the window at `at` that lie whole steps from the one that has `shown` there.

    `lattice`: one vector or two (dx, dy), px of the exemplar. A middle that was made a hole does not count.
    """
    table, posed = growth.variants.table[shown[0]], growth.variants.posed
    j = np.array(ISOMETRIES[int(growth.variants.pose[shown[0]])].j, np.int64)
    steps = np.array([(round(dy * FINE), round(dx * FINE)) for dx, dy in lattice], np.int64) @ j
    valid = growth.variants.valid[shown[0]]
    most_steps = [2 * int(max(table[1], table[2])) * FINE // max(int(np.abs(step).max()), FINE) + 1 for step in steps]
    counts = np.stack(np.meshgrid(*(np.arange(-n, n + 1) for n in most_steps), indexing="ij"), -1)
    near = np.array(list(product(range(-SLACK, SLACK + 1), repeat=2)), np.int64)
    away = (counts.reshape(-1, len(steps)) @ steps + FINE // 2) // FINE
    places = (np.array(shown[1:], np.int64) + away)[:, None] + near
    places = places.reshape(-1, 2)
    if growth.variants.toroidal[shown[0]]:
        places %= table[1:3]
    inside = ((places >= 0) & (places < valid.shape)).all(axis=1)
    places = np.unique(places[inside], axis=0)
    places = places[valid[places[:, 0], places[:, 1]]]
    grown = growth.growing
    assert isinstance(growth.finder, PatchSearch)
    feats, known = growth.finder.windows(grown.variant, grown.yx, np.array([at], np.int64), growth.layout.wraps)
    rows = np.zeros((len(places), 4), np.int64)
    rows[:, 1], rows[:, 2:] = shown[0], places
    copies_kernels.measure_rows(feats[0], known[0], posed, rows)
    return Candidates(rows[np.argsort(rows[:, 0], kind="stable")[:most]], 0, feats[0], known[0])
