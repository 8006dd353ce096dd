"""The pyramid search under a guide: labels and seams count together at every level (source 000, figure 5.6)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import guided, pyramid
from .guidance import Guidance
from .guided_search import Guided
from .pyramid import LEVELS, PyramidSearch, scaled
from .search import Candidates, Prices

Array = NDArray[Any]


class GuidedPyramid(Guided[PyramidSearch]):
    """Search patches for windows that a guide tells what to hold, from coarse to fine."""

    def __init__(self, search: PyramidSearch, guidance: Guidance, unit: int) -> None:
        super().__init__(search, guidance, unit)
        self.guide = PyramidSearch(guidance.pictures, guidance.layout.patch, search.seam, search.smoothing)

    def _weighed(self, search: PyramidSearch, variant: Array, yx: Array, at: Array, prices: Prices) -> list[Candidates]:
        """Where patches differ in what the guide says, count that too: d + alpha g (S0-63), squared."""
        n, guide = len(at), self.guide
        stack = search.stack(variant, yx, at, self.guidance.layout.wraps)
        beside = guide.whole_stack(*self.guidance.wanted(at))
        sums = np.array([known.sum(axis=(1, 2), dtype=np.int64) for _, known in stack])
        usual = np.full(n, -1, np.int64)
        best, found = np.empty((n, 0, 4), np.int64), np.full(n, -1, np.int64)
        for number in range(LEVELS, -1, -1):
            (feats, known), (wanted, inside) = stack[number], beside[number]
            level, labels = search.levels[number], guide.levels[number]
            shares = self._shares(known, inside)
            here = usual if number == LEVELS else scaled(usual, sums, number)
            kept, many = best, found
            best = np.empty((n, (search.kept if number else search.listed) + 1, 4), np.int64)
            found = np.zeros(n, np.int64)
            for v, allowed in enumerate(level.allowed):
                if allowed.any():
                    pyramid.search_guided(
                        feats, known, level.flat, level.table[v], wanted, inside, labels.flat, labels.table[v],
                        shares, allowed, kept, many, level.reach, prices.counts[v], number, prices.weight,
                        prices.multiply, v, best, found, here,
                    )  # fmt: skip
        rows = np.empty((n, search.listed, 4), np.int64)
        guided.refine_all(
            feats, known, level.flat, search.variants.table, wanted, inside, labels.flat, guide.variants.table, shares,
            search.flat_valid, search.offsets, np.ascontiguousarray(best[:, : search.listed]), found, 1, rows,
        )  # fmt: skip
        usual = np.maximum(scaled(usual, sums, 0), 0)
        return [
            Candidates(rows[k, :c], u, feats[k], known[k])
            for k, (c, u) in enumerate(zip(found.tolist(), usual.tolist(), strict=True))
        ]
