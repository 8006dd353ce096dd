"""Patch-based sampling as Multrus 2003 tells it, slow and obvious: raster order, every block measured, n best.

Only the draws are those of the package, so that the map must be the same.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from naive import all_distances, posed
from numpy.typing import NDArray

from intarsia.foundation.run import below, draw
from intarsia.model import Exemplar

STAGE = 2003


class NaivePatchSampling:
    """The method of Multrus 2003: patches of w_b px with seams of w_e px all around, joined in the seams' middle."""

    def __init__(
        self, exemplars: Sequence[Exemplar], size: tuple[int, int], wb: int, we: int, n: int, seed: int,
        isometries: Sequence[int] = (0,),
    ) -> None:  # fmt: skip
        self.size, self.wb, self.we, self.n, self.seed = size, wb, we, n, seed
        self.block = wb + 2 * we
        self.variants = posed(exemplars, isometries)
        self.places = [(v, y, x) for v, p in enumerate(self.variants) for y, x, _ in p.windows((self.block,) * 2)]
        self.known = np.zeros(size, bool)
        self.feats = np.zeros((*size, self.variants[0].picture.shape[2]), np.int64)
        self.shown = np.full((*size, 4), -1)  # exemplar, isometry, row, column

    def run(self) -> NDArray[np.int_]:
        """Return exemplar, isometry, row and column of every output pixel."""
        step = self.wb + self.we
        rows, columns = (-(-n // step) for n in self.size)
        for r in range(rows):
            for c in range(columns):
                pick = self.choose(r * step - self.we, c * step - self.we, draw(self.seed, STAGE, 0, r, c))
                self.lay(r * step - self.we, c * step - self.we, pick)
        return self.shown

    def choose(self, y: int, x: int, bits: int) -> tuple[int, int, int]:
        """Draw among the n best; the first block of all is any."""
        window = np.zeros((self.block, self.block, self.feats.shape[2]), np.int64)
        known = np.zeros((self.block, self.block), bool)
        for i in range(self.block):
            for j in range(self.block):
                if 0 <= y + i < self.size[0] and 0 <= x + j < self.size[1]:
                    window[i, j], known[i, j] = self.feats[y + i, x + j], self.known[y + i, x + j]
        if not known.any():
            return self.places[below(len(self.places), bits)]
        found = all_distances(window.astype(np.int16), known, self.variants)
        best = [f[-3:] for f in sorted(found)[: self.n]]
        return best[below(len(best), bits)]

    def lay(self, y: int, x: int, pick: tuple[int, int, int]) -> None:
        """Copy the block; of a seam that is there the outer half stays, the larger half of an odd one."""
        v, u, s = pick
        keep = (self.we + 1) // 2
        for i in range(keep if y > 0 else 0, self.block):
            for j in range(keep if x > 0 else 0, self.block):
                if 0 <= y + i < self.size[0] and 0 <= x + j < self.size[1]:
                    variant = self.variants[v]
                    self.known[y + i, x + j] = True
                    self.feats[y + i, x + j] = variant.picture[u + i, s + j]
                    self.shown[y + i, x + j] = variant.number, variant.isometry, *variant.pixel(u + i, s + j)
