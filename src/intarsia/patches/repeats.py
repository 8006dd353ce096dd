"""The least distance of repeats: which patches may still be laid at a place, and the best of them.

No exemplar pixel may be shown twice within so many px of the output. Every patch laid forbids a few rectangles of the
exemplar to the windows around it. Where all patches of a short-list are forbidden, these rectangles are marked in a
picture of the exemplar, and the best patch outside them is found by the correlations that were computed already. What
the windows of one wave forbid one another is known only once they are filled; such a window is searched again. Of small
exemplars every patch that is still allowed is measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..search import fourier_kernels
from ..search.candidates import SHORT_LIST, Candidates, Prices, nearest
from ..search.fourier import PatchSearch
from ..search.fourier_kernels import FAR
from ..search.posed import in_one_row

CHUNK = 4096  # patches measured between two looks at whether to go on
LITTLE = 1 << 22  # so many px of patches are measured, rather than searched


class Table:
    """Where patches begin at all, of every variant: one flat uint8 table, and where each variant lies in it."""

    def __init__(self, valid: Sequence[Array]) -> None:
        self.flat, self.offsets = in_one_row(valid)

    def rows(self, mask: Array) -> Array:
        """Return the patches that are 1 in `mask`, a table like ``flat``, as candidates not measured yet: (n, 4)."""
        at = np.flatnonzero(mask)
        rows = np.zeros((len(at), 4), np.int64)
        rows[:, 1] = np.searchsorted(self.offsets[:, 0], at, side="right") - 1
        begins, _, widths = self.offsets[rows[:, 1]].T
        rows[:, 2], rows[:, 3] = np.divmod(at - begins, widths)
        return rows


def best_given(
    search: PatchSearch, found: Candidates, table: Table, mask: Array, prices: Prices,
    check: Callable[[], None],
) -> Candidates:  # fmt: skip
    """Return the best patches of a mask of a table for a window: of a search among them, or if that finds none, of all.

    `check` is called between parts of the work, and ends it by raising.
    """
    if found.free:
        return replace(found, rows=table.rows(mask), permitted=True)
    check()
    again = replace(found, rows=found.rows[:0])
    if not is_little(mask, search.patch):
        (again,) = search.search(found.feats[None], found.known[None], prices, lambda *_: mask)
    if not len(again.rows):
        rows, best = table.rows(mask), np.empty((0, 4), np.int64)
        for first in range(0, len(rows), CHUNK):
            check()
            part = rows[first : first + CHUNK]
            part[:, 0] = best[-1, 0] if len(best) == SHORT_LIST else FAR
            fourier_kernels.measure(found.feats, found.known, search.variants.posed, part)
            best = nearest(np.concatenate([best, part]))[:SHORT_LIST]
        again = replace(found, rows=best)
    return replace(again, usual=found.usual, permitted=True)


def is_little(mask: Array, patch: tuple[int, int]) -> bool:
    """True where all patches of a table are so few and small that they are soon measured."""
    return mask.size * math.prod(patch) <= LITTLE

