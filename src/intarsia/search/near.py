"""The short-list of the exact search: correlated in single precision, and in whole numbers where that leaves doubt.

Correlations in single precision are wrong by what is proven (:meth:`Correlator.near`). That decides about all but a few
positions, which are correlated again, one by one. Windows of which it decides about too few are done in doubles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from . import exhaustive_kernels, fourier_kernels, near_kernels
from .candidates import Prices, Reduced, ReducedSearch
from .reduce_kernels import Listed
from .transforms import FITS


@dataclass(frozen=True, eq=False)
class Near:
    """Correlations of n windows with one variant, and by what distances by them may be wrong: 0 if they round right."""

    values: Array
    slacks: Array

    def __getitem__(self, one: slice) -> Near:
        return Near(self.values[one], self.slacks[one])


def correlate_near(search: ReducedSearch, reduced: Reduced) -> dict[int, Near]:
    """Correlate windows with all variants that have any patch, in the floats of their spectra."""
    found, norms = {}, np.sqrt(reduced.energies.astype(np.float64))
    for v, valid in enumerate(search.valid):
        if valid.size:
            values, wrong = search.correlator.near(v, reduced.spectra, valid.shape[0], norms)
            slacks = np.where(wrong < FITS, 0, np.ceil(2.0 * wrong) + 2)  # of distances by rounded ones
            found[v] = Near(values, slacks.astype(np.int64))
    return found


def rank(
    search: ReducedSearch, feats: Array, known: Array, reduced: Reduced, correlations: dict[int, Near], prices: Prices,
    out: tuple[Array, ...],
) -> None:  # fmt: skip
    """Short-list positions, measure them, and with them all that may be nearer: into (best, counts, usual, found)."""
    again = np.flatnonzero(_rank(search, feats, known, reduced, correlations, prices, out, near_kernels.AGAIN))
    if len(again):
        mine = reduced.only(again)
        mine = replace(mine, spectra=search.correlator.spectra(mine.templates.astype(np.float64)))
        some = tuple(table[again] for table in out)
        _rank(search, feats[again], known[again], mine, correlate_near(search, mine), prices, some, near_kernels.ALL)
        for whole, done in zip(out, some, strict=True):
            whole[again] = done


def _rank(
    search: ReducedSearch, feats: Array, known: Array, reduced: Reduced, correlations: dict[int, Near], prices: Prices,
    out: tuple[Array, ...], most: int,
) -> Array:  # fmt: skip
    """Do what :func:`rank` does; return which windows it leaves, as more than `most` products would be needed."""
    best, counts, usual, found = out
    listed, posed = Listed(best, counts, usual), search.variants.posed
    # distances are below this
    room = int(fourier_kernels.NONE) - 4 * len(search.axes) * math.prod(search.cells) * search.clip**2
    doubtful = np.zeros(len(feats), np.uint8)
    for one in correlations.values():
        doubtful |= 2 * one.slacks >= room
    templates, least = reduced.templates.astype(np.int16), {}
    for v, one in correlations.items():
        if search.valid[v].size:
            least[v] = np.empty((len(feats), len(search.valid[v])), np.int64)
            mine = reduced.correlated(v, one.values, search.valid[v])
            near_kernels.near_short_list(
                mine, one.slacks, search.wholes[v], templates, reduced.masks, prices.of(v), listed, least[v], doubtful,
                most,
            )  # fmt: skip
    counts[doubtful > 0] = 0
    among = fourier_kernels.Among(search.flat_valid, search.offsets)
    fourier_kernels.refine_all(feats, known, posed, among, best, counts, search.factor, found)
    for v, rows in least.items():
        one = correlations[v]
        exhaustive_kernels.complete(
            reduced.correlated(v, one.values, search.valid[v]), len(search.axes), search.scale, feats, known, posed,
            found, counts, one.slacks, rows,
        )  # fmt: skip
    return doubtful
