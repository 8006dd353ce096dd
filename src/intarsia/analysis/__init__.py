"""What is known of an exemplar: features, element size, rarity, and the search for patches in it."""

from .boundary import boundary_poses, grown, slack_of
from .cell import check_lattice, lattice_of
from .features import Features, features, pose_array
from .growth import Growth, Laying, Pick
from .guidance import Guidance, check_guide
from .guided_search import GuidedSearch
from .mosaic import FewPlaces, Mosaic
from .patchwork import Patchwork, Window, random_patch, waves
from .pixels import Layer, check_window, choices, default_window, ground, layers
from .pyramid import PyramidSearch, check_pyramid
from .repetition import Layout, Repetition, Rule, striking
from .scan import Scan, scan_reach
from .seams import seam_total
from .search import Candidates, PatchSearch, Prices, Search
from .sizes import check_patch, default_patch, large_patch
from .stitching import Stitch, Stitching
from .symmetry import allowed_isometries, settled_isometries
from .tiling import Tiling
from .trees import similar_pixels, tree_of
from .variants import Variants, isometry_ids, variants

__all__ = [
    "Candidates",
    "Features",
    "FewPlaces",
    "Growth",
    "Guidance",
    "GuidedSearch",
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
    "Scan",
    "Search",
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
    "default_patch",
    "default_window",
    "features",
    "ground",
    "grown",
    "isometry_ids",
    "large_patch",
    "lattice_of",
    "layers",
    "pose_array",
    "random_patch",
    "scan_reach",
    "seam_total",
    "settled_isometries",
    "similar_pixels",
    "slack_of",
    "striking",
    "tree_of",
    "variants",
    "waves",
]
