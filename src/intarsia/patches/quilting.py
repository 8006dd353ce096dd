"""Image quilting: patches chosen by distance and price of repeats, joined along the cheapest seam.

Source: Efros and Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001.
"""

from __future__ import annotations

from dataclasses import replace

from ..foundation.params import extent
from ..foundation.run import Run
from ..methods.image_quilting import ImageQuilting
from ..model import Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from ..search import default_patch, resolved_isometries
from .patch_synthesis import Boundaries, PatchSettings, Stages, decided

STAGE = 2002  # keeps this method's draws apart from those of others


def resolved(method: ImageQuilting, exemplars: Exemplars, canvas: Canvas) -> ImageQuilting:
    """Return the method with patch, overlap and isometries set, where they are automatic."""
    made: ImageQuilting = decided(method, exemplars, canvas.guide, lambda: default_patch(exemplars))
    bounds = resolved_isometries(method.boundary_isometries, exemplars, made.footprint)
    return replace(made, boundary_isometries=bounds)


def synthesize(
    method: ImageQuilting, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> SourceMap:
    """Fill the windows in batches, choosing patches by price and joining them along the cheapest seam."""
    stages = Stages(settings_of(method), exemplars, canvas, method.blend)
    for growth in stages:
        growth.fill(seed, STAGE, run, choose=method.tolerance, join=growth.cutting(method.seam))
    return stages.map


def settings_of(method: ImageQuilting) -> PatchSettings:
    """Return the parameters of patch-based synthesis; patch and overlap of the method must be set."""
    overlap = extent(method.overlap or 0)
    return PatchSettings(
        patch=method.footprint, overlap=overlap, hangs=method.hangs, weights=method.channel_weights,
        isometries=method.isometries, search=method.search,
        usage=method.repeat_penalty, rim=max(overlap),
        boundaries=Boundaries.of(
            method.footprint, method.boundary_patch, method.boundary_isometries, method.boundary_tolerance
        ),
    )  # fmt: skip
