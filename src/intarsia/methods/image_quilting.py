"""Image quilting: overlapping patches that match their neighbours, joined along minimum cuts.

Efros and Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001; Robinson 2004
(see docs/sources-002.md).

Departures: the seam is the minimum cut of the whole overlap region, of any shape, with costs between pixel pairs, where
the source joins two paths with costs of single pixels; patches on a periodic border or in a last row are matched and
cut against every neighbour; patches already used cost a little more, so that salient spots do not recur too often; if
one patch continues the texture exactly, others that fit nearly as well may still be drawn, as otherwise the exemplar
would be copied verbatim.

Cost: one FFT search over the reduced exemplar for each patch, about N_out / pitch^2 of them.
"""

from __future__ import annotations

from dataclasses import dataclass

from .. import methods
from ..foundation.params import AUTO, Extent, Poses, Weights, param


@dataclass(frozen=True)
class ImageQuilting(methods.CutSquares):
    """Image quilting: place overlapping patches that fit their neighbours, cut along the cheapest seam.

    Parameters
    ----------
    patch : int or (rows, columns), px, optional
        Side of the copied square, overlaps included; default: the size of the texture's elements.
    overlap : int or (rows, columns), px, optional
        Width that two neighbours share; default: a third of the patch.
    layout : {"spread", "raster"}
        Overlaps widen evenly so that patches end at the border (default), or patches are cropped there.
    tolerance : float
        Choose among patches up to this much worse than the best, 0 to 100, default 0.1.
    channel_weights : tuple of float, optional
        How much each channel counts; default: 0.3, 0.59, 0.11 for red, green, blue.
    isometries : str or tuple of int
        Which mirrored and rotated patches may be used, default "none".
    repeat_penalty : float
        Price of using a patch again, in usual distances, 0 to 100, default 0.05.
    search : {"fast", "exact"}
        Short-list candidates at reduced (default) or at full resolution.
    seam : {"difference", "gradient", "sharp"}
        Cost of a cut, default "difference".
    boundary_patch, boundary_isometries, boundary_tolerance : optional
        With labels: side of the patches along their boundaries, px; further isometries of them; how far a label may
        reach over a boundary, px. Default: half a patch, all of a square, half a patch.

    Raises
    ------
    ParameterError
        for a value out of range, or an overlap that is not below the patch.
    """

    slug = "image-quilting"
    paper = "Efros and Freeman 2001; Robinson 2004"
    summary = "matching patches joined along the cheapest seam"
    engine = "intarsia.patches.quilting"
    supports = methods.abilities("wrap", "start", "mask", "guide", "isometries", "several")

    patch: Extent = methods.patch_side()
    overlap: Extent = param(
        AUTO, "extent", "width that two neighbours share; automatic: a third of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    layout: str = methods.layout()
    tolerance: float = param(0.1, "float", "choose among patches up to this much worse than the best", low=0, high=100)
    channel_weights: Weights = methods.channel_weights()
    isometries: Poses = methods.poses()
    repeat_penalty: float = methods.repeat_penalty()
    search: str = methods.search_ways()
    seam: str = methods.cut_cost("difference")
    boundary_patch: int | None = methods.boundary_patch()
    boundary_isometries: Poses | None = methods.boundary_poses()
    boundary_tolerance: int | None = methods.boundary_tolerance()
