"""What is known of an exemplar: features, element size, rarity, and the search for patches in it."""

from .features import Features, features, pose_array
from .growth import Growth, Laying
from .patchwork import Patchwork, random_patch, waves
from .pixels import Layer, check_window, choices, default_window, ground, layers
from .repetition import Layout, Repetition, Rule, striking
from .scan import Scan, scan_reach
from .search import Candidates, PatchSearch
from .sizes import check_patch, default_patch
from .trees import similar_pixels, tree_of
from .variants import Variants, isometry_ids, variants

__all__ = [
    "Candidates",
    "Features",
    "Growth",
    "Layer",
    "Laying",
    "Layout",
    "PatchSearch",
    "Patchwork",
    "Repetition",
    "Rule",
    "Scan",
    "Variants",
    "check_patch",
    "check_window",
    "choices",
    "default_patch",
    "default_window",
    "features",
    "ground",
    "isometry_ids",
    "layers",
    "pose_array",
    "random_patch",
    "scan_reach",
    "similar_pixels",
    "striking",
    "tree_of",
    "variants",
    "waves",
]
