"""Image quilting: patches that match their neighbours, joined along the cheapest seam.

Efros and Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001; Robinson 2004
(see docs/sources-002.md).

Departures: the seam is the true minimum cut of the whole overlap, of whatever shape, measured between pixel pairs,
where the source joins two paths that each see single pixels; patches on a wrapped border or in a last row are matched
and cut against every neighbour; patches already used cost a little more, so that striking spots do not return too
often; where one patch continues the texture exactly, others that fit nearly as well may still be drawn, for otherwise
the exemplar would be copied on and on.

Cost: one FFT search over the reduced exemplar for each patch, about N_out / pitch^2 of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ..lazy import lazy
from ..params import AUTO, extent, param
from . import parameters
from .base import Ability

if TYPE_CHECKING:
    from .. import sourcemap
    from ..analysis import symmetry
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..patches import labelled, settings
    from ..run import Run
    from ..search import guide, sizes
else:
    labelled = lazy("intarsia.patches.labelled")
    settings = lazy("intarsia.patches.settings")
    guide = lazy("intarsia.search.guide")
    sizes = lazy("intarsia.search.sizes")
    symmetry = lazy("intarsia.analysis.symmetry")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 2002  # keeps this method's draws apart from those of others


@dataclass(frozen=True)
class ImageQuilting(parameters.CutSquares):
    """Lay overlapping patches that fit their neighbours, and cut them along the cheapest seam."""

    slug: ClassVar[str] = "image-quilting"
    paper: ClassVar[str] = "Efros and Freeman 2001; Robinson 2004"
    summary: ClassVar[str] = "matching patches joined along the cheapest seam"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.GUIDE, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    patch: int | tuple[int, int] | None = parameters.patch_side()
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width that two neighbours share; automatic: a third of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    layout: str = parameters.layout()
    tolerance: float = param(0.1, "float", "choose among patches up to this much worse than the best", low=0, high=100)
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()
    context: float = param(
        0.0, "float", "how much the surroundings of old pixels count in the search, 0 to 4", low=0, high=4
    )
    isometries: str | tuple[int, ...] = parameters.poses()
    usage: float = parameters.usage_price()
    spread: float = parameters.spread_price()
    striking: float | None = parameters.striking_share()
    min_repeat_distance: int = parameters.repeat_distance()
    search: str = parameters.search_ways()
    seam: str = parameters.cut_cost("difference")
    boundary_patch: int | None = parameters.boundary_patch()
    boundary_isometries: str | tuple[int, ...] | None = parameters.boundary_poses()
    boundary_slack: int | None = parameters.boundary_slack()

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> ImageQuilting:
        """Decide patch and overlap from the size of the texture's elements."""
        patch = sizes.default_patch(exemplars, canvas.guide) if self.patch is AUTO else self.patch
        rows, columns = extent(patch)
        isometries = symmetry.resolved_isometries(self.isometries, exemplars, (rows, columns))
        sizes.check_patch(patch, exemplars, isometries)
        if canvas.guide is not None:
            guide.check_guide(exemplars, canvas.guide, patch)
        third = (rows // 3, columns // 3) if rows != columns else rows // 3
        overlap = third if self.overlap is AUTO else self.overlap
        bounds = self.boundary_isometries
        bounds = None if bounds is None else symmetry.resolved_isometries(bounds, exemplars, (rows, columns))
        return replace(self, patch=patch, overlap=overlap, isometries=isometries, boundary_isometries=bounds)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Grow the map window by window, choosing by price and joining along the cheapest seam."""
        method = self.resolved(exemplars, canvas)
        return parameters.gone_over(
            method, exemplars, canvas, run, lambda run: method.quilted(exemplars, canvas, seed, run)
        )

    def quilted(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Fill all windows; known once all parameters are."""
        stages = labelled.Stages(self.patch_settings, exemplars, canvas, self.blend)
        for growth in stages:
            growth.fill(seed, STAGE, run, choose=self.tolerance, join=growth.cutting(self.seam))
        return stages.map

    @property
    def patch_settings(self) -> settings.PatchSettings:
        """How patches are laid; known once patch and overlap are."""
        overlap = extent(self.overlap or 0)
        return settings.PatchSettings(
            patch=self.footprint, overlap=overlap, hangs=self.hangs, weights=self.channel_weights, context=self.context,
            isometries=self.isometries, search=self.search,
            repeats=settings.Repeats(usage=self.usage, distance=self.min_repeat_distance), rim=max(overlap),
            boundaries=settings.Boundaries.of(
                self.footprint, self.boundary_patch, self.boundary_isometries, self.boundary_slack
            ),
        )  # fmt: skip
