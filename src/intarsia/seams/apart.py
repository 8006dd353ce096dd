"""Which placements would lay something down beside itself in another pose: it fits by itself, and is seen at once.

Whatever lies at a mirror goes on in its own picture without a seam, and what is turned by half goes on in itself around
a point. So such placements are the cheapest of all, and look like wings and rosettes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..kernels.windows import Grown
from ..patches.growth import Pick
from ..search.candidates import Candidates
from . import placement_kernels
from .energy_kernels import Pieces

Box = tuple[int, int, int, int]

STEP = 4  # px from one to the next where it is looked
MOST = 32  # at most 1 / MOST of a window may lie beside itself


@dataclass(frozen=True, eq=False)
class Apart:
    """What a map shows, and where that lies in other poses (`PosedExemplars.turns`)."""

    grown: Grown
    pieces: Pieces
    turns: Array

    def of_rows(self, box: Box, found: Candidates) -> Candidates:
        """The candidates for a window that show next to nothing beside itself; all of them where each does."""
        if not self.turns.any() or not len(found.rows):
            return found
        good = self._good(box, found.rows)
        return replace(found, rows=found.rows[good]) if good.any() else found

    def of_picks(self, box: Box, picks: Sequence[Pick]) -> list[Pick]:
        """The placements in a window that show next to nothing beside itself."""
        if not self.turns.any() or not picks:
            return list(picks)
        good = self._good(box, np.pad(np.array(picks, np.int64), ((0, 0), (1, 0))))
        return [pick for pick, apart in zip(picks, good.tolist(), strict=True) if apart]

    def _good(self, box: Box, rows: Array) -> Array:
        count = np.empty(len(rows), np.int64)
        placement_kernels.twins(self.grown, self.pieces, self.turns, box, rows, STEP, count)
        return np.asarray(count * MOST <= box[2] * box[3])
