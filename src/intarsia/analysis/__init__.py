"""What is known of an exemplar: features, element size, rarity, and the search for patches in it.

What only some methods need is imported when it is asked for, so that the others start sooner.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .boundary import boundary_poses, grown, slack_of
from .features import Features, contrast, features, pose_array
from .growth import Growth, Laying, Pick
from .guidance import Guidance, check_guide
from .guided_search import GuidedSearch
from .patchwork import Patchwork, Window, random_patch, waves
from .pixels import Layer, check_window, choices, default_window, ground, layers
from .pyramid import PyramidSearch, check_pyramid
from .repetition import Layout, Repetition, Rule, striking
from .scan import Scan, scan_reach
from .seams import seam_total
from .search import Candidates, PatchSearch, Prices, Search
from .segment_overlay import segment_overlay
from .segments import Segments, SizeRule, segments
from .sizes import check_patch, default_patch, fitting, large_patch
from .symmetry import allowed_isometries, settled_isometries
from .trees import similar_pixels, tree_of
from .variants import Variants, isometry_ids, variants

if TYPE_CHECKING:
    from .cell import check_lattice, lattice_of
    from .courses import Courses
    from .footing import Footing, footing_of
    from .held import Held
    from .mosaic import Mosaic
    from .mosaic_places import FewPlaces
    from .posed_sheet import settled_poses
    from .rim import rim_of
    from .rsgf import Sampling
    from .segment_search import SegmentSearch
    from .stitching import Stitch, Stitching
    from .tiling import Tiling

_LATER = {
    "Courses": "courses",
    "FewPlaces": "mosaic_places",
    "Footing": "footing",
    "Held": "held",
    "Mosaic": "mosaic",
    "Sampling": "rsgf",
    "SegmentSearch": "segment_search",
    "Stitch": "stitching",
    "Stitching": "stitching",
    "Tiling": "tiling",
    "check_lattice": "cell",
    "footing_of": "footing",
    "lattice_of": "cell",
    "rim_of": "rim",
    "settled_poses": "posed_sheet",
}

__all__ = [
    "Candidates",
    "Courses",
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
    "Mosaic",
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
    "Stitch",
    "Stitching",
    "Tiling",
    "Variants",
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
    "features",
    "fitting",
    "footing_of",
    "ground",
    "grown",
    "isometry_ids",
    "large_patch",
    "lattice_of",
    "layers",
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
    "slack_of",
    "striking",
    "tree_of",
    "variants",
    "waves",
]


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return getattr(importlib.import_module(f".{_LATER[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
