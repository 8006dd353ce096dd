"""Random tiling: random patches placed side by side without matching; the baseline for all other methods.

The left-hand comparison of Efros and Freeman 2001, figure 2a, and of Robinson 2004. No departures.

Cost: negligible.
"""

from __future__ import annotations

from dataclasses import dataclass

from .. import methods
from ..foundation.params import Extent, Poses, extent


@dataclass(frozen=True)
class RandomTiling(methods.MethodBase):
    """Place random patches side by side, without matching."""

    slug = "random-tiling"
    paper = "Efros and Freeman 2001, figure 2a; Robinson 2004"
    summary = "random patches side by side, the baseline"
    engine = "intarsia.patches.random_tiling"
    supports = methods.abilities("wrap", "start", "mask", "isometries", "several")

    patch: Extent = methods.patch_side()
    isometries: Poses = methods.poses()

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; known once the patch is."""
        return extent(self.patch or 0)

    footprint = pitch
