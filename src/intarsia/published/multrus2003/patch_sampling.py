"""Patch-based sampling: patches with matching boundary zones, blended by feathering.

Liang, Liu, Xu, Guo and Shum, "Real-time texture synthesis by patch-based sampling", ACM Transactions on Graphics
2001; Multrus 2003 (see docs/sources-000.md).

Departures: the search compares with the unblended pieces, so the map does not depend on the feather (it differs
at the corners of seams); patches may be joined along the cheapest seam instead, which Multrus names as future
work.

Cost: one FFT search over the exemplar for each patch, about N_out / pitch^2 of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ... import methods
from ...foundation.blend import Blend
from ...foundation.params import AUTO, extent, param
from ...methods import Ability, MethodBase


@dataclass(frozen=True)
class PatchSampling(MethodBase):
    """Place patches whose seams match their neighbours, and feather the seams."""

    slug: ClassVar[str] = "patch-sampling"
    paper: ClassVar[str] = "Liang et al. 2001; Multrus 2003"
    summary: ClassVar[str] = "patches with matching seams, feathered"
    engine: ClassVar[str] = "intarsia.published.multrus2003.engine"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.GUIDE, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    patch: int | tuple[int, int] | None = param(
        AUTO, "extent", "side of a patch without its seams; automatic: so that with them it spans an element",
        low=1, high=1 << 16, unit="px",
    )  # fmt: skip
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width of the seam, which two neighbours share; automatic: a fifth of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    bound: str = param(
        "best", "choice", "what may be chosen: the best few, or all within epsilon of black",
        choices=("best", "epsilon"),
    )  # fmt: skip
    candidates: int = param(5, "int", "with bound=best: how many may be chosen", low=1, high=99_999)
    epsilon: float = param(0.1, "float", "with bound=epsilon: share of the brightness", low=0, high=100)
    join: str = param(
        "feather", "choice", "how patches meet: feathered, cut in the middle of the seam, or along the cheapest seam",
        choices=("feather", "middle", "cut"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = methods.channel_weights()
    isometries: str | tuple[int, ...] = methods.poses()
    repetition: str = param(
        "prices", "choice", "what a repeat costs: our prices, the source's counter or marks, or nothing",
        choices=("prices", "counter", "marks", "none"),
    )  # fmt: skip
    repeat_penalty: float = methods.repeat_penalty()
    search: str = methods.search_ways()
    pyramid: str = param(
        "off", "choice", "search from coarse to fine, and what is averaged before every second pixel is dropped",
        choices=("off", "mean", "gaussian", "none"),
    )  # fmt: skip
    pyramid_kept: int = param(
        8, "int", "in a pyramid: the best places of a level, from which the next is searched", low=1, high=64
    )
    pyramid_draws: str = param(
        "finest", "choice", "in a pyramid: draw at the finest level, or at every one and follow that place alone, as "
        "published",
        choices=("finest", "every"),
    )  # fmt: skip
    boundary_patch: int | None = methods.boundary_patch()
    boundary_isometries: str | tuple[int, ...] | None = methods.boundary_poses()
    boundary_tolerance: int | None = methods.boundary_tolerance()
    boundary_candidates: int = param(
        1, "int", "how many may be chosen where a patch holds a boundary of painted labels", low=1, high=64
    )
    boundary_join: str = param(
        "cut", "choice", "how such patches meet: along the cheapest seam, or like all others", choices=("cut", "same")
    )

    @property
    def blend(self) -> Blend:
        """Feather as wide as the seam."""
        return Blend(max(extent(self.overlap or 0)) if self.join == "feather" else 0)

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; valid once patch and overlap are resolved."""
        patch, overlap = extent(self.patch or 0), extent(self.overlap or 0)
        return patch[0] + overlap[0], patch[1] + overlap[1]

    @property
    def hangs(self) -> int:
        """Patches begin one seam before the border, and keep their pitch."""
        return 1

    @property
    def footprint(self) -> tuple[int, int]:
        """Rows and columns of the exemplar that a patch needs, its seams included."""
        patch, overlap = extent(self.patch or 0), extent(self.overlap or 0)
        return patch[0] + 2 * overlap[0], patch[1] + 2 * overlap[1]
