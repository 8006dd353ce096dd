"""Image quilting at work: windows filled one after another, chosen by price, joined along the cheapest seam."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..foundation import lazy
from ..foundation.params import AUTO, extent
from ..foundation.run import Run
from ..methods.image_quilting import ImageQuilting
from ..model import Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from ..search import check_patch, default_patch, resolved_isometries
from .growth import Boundaries, PatchSettings, Repeats, Stages

if TYPE_CHECKING:
    from ..search import guide as guiding
else:  # where labels are asked for
    guiding = lazy("intarsia.search.guide")

STAGE = 2002  # keeps this method's draws apart from those of others


def resolved(method: ImageQuilting, exemplars: Exemplars, canvas: Canvas) -> ImageQuilting:
    """Decide patch and overlap from the size of the texture's elements."""
    guide, patch = canvas.guide, method.patch
    if patch is AUTO:
        patch = default_patch(exemplars) if guide is None else guiding.guided_patch(exemplars, guide)
    rows, columns = extent(patch)
    isometries = resolved_isometries(method.isometries, exemplars, (rows, columns))
    check_patch(patch, exemplars, isometries)
    if guide is not None:
        guiding.check_guide(exemplars, guide, patch)
    third = (rows // 3, columns // 3) if rows != columns else rows // 3
    overlap = third if method.overlap is AUTO else method.overlap
    bounds = resolved_isometries(method.boundary_isometries, exemplars, (rows, columns))
    return replace(method, patch=patch, overlap=overlap, isometries=isometries, boundary_isometries=bounds)


def synthesize(
    method: ImageQuilting, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> SourceMap:
    """Grow the map window by window, choosing by price and joining along the cheapest seam."""
    stages = Stages(settings_of(method), exemplars, canvas, method.blend)
    for growth in stages:
        growth.fill(seed, STAGE, run, choose=method.tolerance, join=growth.cutting(method.seam))
    return stages.map


def settings_of(method: ImageQuilting) -> PatchSettings:
    """How patches are laid; known once patch and overlap are."""
    overlap = extent(method.overlap or 0)
    return PatchSettings(
        patch=method.footprint, overlap=overlap, hangs=method.hangs, weights=method.channel_weights,
        isometries=method.isometries, search=method.search,
        repeats=Repeats(usage=method.usage, distance=method.min_repeat_distance), rim=max(overlap),
        boundaries=Boundaries.of(
            method.footprint, method.boundary_patch, method.boundary_isometries, method.boundary_slack
        ),
    )  # fmt: skip
