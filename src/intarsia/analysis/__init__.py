"""What is known of an exemplar: features, element size, rarity, and the search for patches in it.

Most is imported when it is asked for, so that a method starts without what only others need.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .features import Features, contrast, features, pose_array
from .variants import Variants, isometry_ids, variants

if TYPE_CHECKING:
    from .boundary import boundary_poses, grown, slack_of
    from .cell import check_lattice, has_lattice, lattice_of
    from .courses import Courses
    from .footing import Footing, footing_of
    from .growth import Growth, Laying, Pick
    from .guidance import Guidance, check_guide
    from .guided_search import GuidedSearch
    from .held import Held
    from .mosaic import Mosaic
    from .mosaic_places import FewPlaces
    from .outlines import Outlines, marked
    from .parallel import Corrections, Descent
    from .patchwork import Patchwork, Window, random_patch, waves
    from .pixels import Layer, check_window, choices, default_window, ground, layers
    from .posed_sheet import settled_poses
    from .pyramid import PyramidSearch, check_pyramid
    from .repetition import Layout, Repetition, Rule, striking
    from .rim import rim_of
    from .rsgf import Sampling
    from .scan import Scan, scan_reach
    from .seams import seam_total
    from .search import Candidates, PatchSearch, Prices, Search
    from .segment_drawing import segment_overlay
    from .segment_search import SegmentSearch
    from .segmentation import Segments, SizeRule, segments
    from .sites import Look, is_cloudy, levels_within, sites_of
    from .sizes import check_patch, default_patch, element_patch, fitting, large_patch, supplied
    from .spans import Span
    from .stitching import Stitch, Stitching
    from .symmetry import allowed_isometries, settled_isometries
    from .tiling import Tiling
    from .trees import similar_pixels, tree_of
    from .wanted import Wanted

_MODULES = {
    "Candidates": "search",
    "Corrections": "parallel",
    "Courses": "courses",
    "Descent": "parallel",
    "FewPlaces": "mosaic_places",
    "Footing": "footing",
    "Growth": "growth",
    "Guidance": "guidance",
    "GuidedSearch": "guided_search",
    "Layer": "pixels",
    "Laying": "growth",
    "Layout": "repetition",
    "Held": "held",
    "Look": "sites",
    "Mosaic": "mosaic",
    "Outlines": "outlines",
    "PatchSearch": "search",
    "Patchwork": "patchwork",
    "Pick": "growth",
    "Prices": "search",
    "PyramidSearch": "pyramid",
    "Repetition": "repetition",
    "Rule": "repetition",
    "Sampling": "rsgf",
    "Scan": "scan",
    "Search": "search",
    "SegmentSearch": "segment_search",
    "Segments": "segmentation",
    "SizeRule": "segmentation",
    "Span": "spans",
    "Stitch": "stitching",
    "Stitching": "stitching",
    "Tiling": "tiling",
    "Wanted": "wanted",
    "Window": "patchwork",
    "allowed_isometries": "symmetry",
    "boundary_poses": "boundary",
    "check_guide": "guidance",
    "check_lattice": "cell",
    "check_patch": "sizes",
    "check_pyramid": "pyramid",
    "check_window": "pixels",
    "choices": "pixels",
    "default_patch": "sizes",
    "element_patch": "sizes",
    "default_window": "pixels",
    "fitting": "sizes",
    "footing_of": "footing",
    "ground": "pixels",
    "has_lattice": "cell",
    "grown": "boundary",
    "large_patch": "sizes",
    "lattice_of": "cell",
    "layers": "pixels",
    "is_cloudy": "sites",
    "levels_within": "sites",
    "marked": "outlines",
    "random_patch": "patchwork",
    "rim_of": "rim",
    "scan_reach": "scan",
    "seam_total": "seams",
    "segment_overlay": "segment_drawing",
    "segments": "segmentation",
    "settled_isometries": "symmetry",
    "settled_poses": "posed_sheet",
    "similar_pixels": "trees",
    "sites_of": "sites",
    "slack_of": "boundary",
    "striking": "repetition",
    "supplied": "sizes",
    "tree_of": "trees",
    "waves": "patchwork",
}

__all__ = [
    "Candidates",
    "Corrections",
    "Courses",
    "Descent",
    "Features",
    "FewPlaces",
    "Footing",
    "Growth",
    "Guidance",
    "GuidedSearch",
    "Held",
    "Layer",
    "Laying",
    "Layout",
    "Look",
    "Mosaic",
    "Outlines",
    "PatchSearch",
    "Patchwork",
    "Pick",
    "Prices",
    "PyramidSearch",
    "Repetition",
    "Rule",
    "Sampling",
    "Scan",
    "Search",
    "SegmentSearch",
    "Segments",
    "SizeRule",
    "Span",
    "Stitch",
    "Stitching",
    "Tiling",
    "Variants",
    "Wanted",
    "Window",
    "allowed_isometries",
    "boundary_poses",
    "check_guide",
    "check_lattice",
    "check_patch",
    "check_pyramid",
    "check_window",
    "choices",
    "contrast",
    "default_patch",
    "default_window",
    "element_patch",
    "features",
    "fitting",
    "footing_of",
    "ground",
    "grown",
    "has_lattice",
    "is_cloudy",
    "isometry_ids",
    "large_patch",
    "lattice_of",
    "layers",
    "levels_within",
    "marked",
    "pose_array",
    "random_patch",
    "rim_of",
    "scan_reach",
    "seam_total",
    "segment_overlay",
    "segments",
    "settled_isometries",
    "settled_poses",
    "similar_pixels",
    "sites_of",
    "slack_of",
    "striking",
    "supplied",
    "tree_of",
    "variants",
    "waves",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return getattr(importlib.import_module(f".{_MODULES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
