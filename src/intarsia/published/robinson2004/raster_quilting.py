"""Image quilting in raster order: patches cropped at the border, cut along two one-way minimum error paths.

Robinson, "An Implementation of the Efros and Freeman Image Quilting Algorithm", project report, Computer Science 766,
2004 (see docs/sources-002.md).

Departures: norms are whole numbers, in 1/16 of a step of the features, so that every machine draws the same patches;
masked pixels are not copied.

Cost: for every patch all places of the exemplar are compared, most of them only in a part of the overlap.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ... import methods
from ...foundation.params import AUTO, param
from ...methods import Ability


@dataclass(frozen=True)
class RasterQuilting(methods.CutSquares):
    """Place overlapping patches row by row, each cut along the two paths of the report of 2004."""

    slug: ClassVar[str] = "raster-quilting"
    paper: ClassVar[str] = "Robinson 2004"
    summary: ClassVar[str] = "quilting as published: row by row, cut along two one-way paths"
    engine: ClassVar[str] = "intarsia.published.robinson2004.engine"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.MASK})

    patch: int | tuple[int, int] | None = methods.patch_side()
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width that two neighbours share; automatic: a sixth of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    tolerance: float = param(0.1, "float", "choose among patches up to this much worse than the best", low=0, high=100)
    turning: str = param(
        "program", "choice", "where the two paths meet: where their sum is least, as in the report's program, or, as "
        "in its text, their sum less the pixel that both count",
        choices=("program", "text"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = methods.channel_weights()

    @property
    def hangs(self) -> int:
        """0: from the first corner on, at their pitch."""
        return 0
