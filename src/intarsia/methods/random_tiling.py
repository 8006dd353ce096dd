"""Random tiling: patches drawn blindly and laid side by side; the baseline that every other method must beat.

The left-hand comparison of Efros and Freeman 2001, figure 2a, and of Robinson 2004. No departures.

Cost: none to speak of.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .. import methods
from ..foundation.params import extent
from . import Ability, MethodBase


@dataclass(frozen=True)
class RandomTiling(MethodBase):
    """Lay patches drawn at random side by side, matching nothing."""

    slug: ClassVar[str] = "random-tiling"
    paper: ClassVar[str] = "Efros and Freeman 2001, figure 2a; Robinson 2004"
    summary: ClassVar[str] = "random patches side by side, the baseline"
    engine: ClassVar[str] = "intarsia.patches.random_tiling"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    patch: int | tuple[int, int] | None = methods.patch_side()
    isometries: str | tuple[int, ...] = methods.poses()

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; known once the patch is."""
        return extent(self.patch or 0)

    @property
    def footprint(self) -> tuple[int, int]:
        """Rows and columns of the exemplar that a patch needs."""
        return extent(self.patch or 0)
