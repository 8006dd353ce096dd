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
    """Random tiling: place random patches side by side, without matching.

    Parameters
    ----------
    patch : int or (rows, columns), px, optional
        Side of a patch; default: the size of the texture's elements.
    isometries : str or tuple of int
        Which mirrored and rotated patches may be used, default "none".

    Raises
    ------
    ParameterError
        for a value out of range.
    """

    slug = "random-tiling"
    paper = "Efros and Freeman 2001, figure 2a; Robinson 2004"
    summary = "random patches side by side, the baseline"
    engine = "intarsia.patches.random_tiling"
    supports = methods.abilities("wrap", "start", "mask", "isometries", "several")

    patch: Extent = methods.patch_side()
    isometries: Poses = methods.poses()

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; meaningful once the patch is decided."""
        return extent(self.patch or 0)

    footprint = pitch
