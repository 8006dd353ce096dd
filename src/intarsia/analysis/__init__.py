"""What is known of an exemplar: features, element size, rarity, and the search for patches in it."""

from .features import Features, features, pose_array
from .growth import Growth, Laying
from .mosaic import Mosaic
from .patchwork import Patchwork, random_patch, waves
from .repetition import Layout, Repetition, Rule, striking
from .search import Candidates, PatchSearch
from .sizes import check_patch, default_patch
from .variants import Variants, isometry_ids, variants

__all__ = [
    "Candidates",
    "Features",
    "Growth",
    "Laying",
    "Layout",
    "Mosaic",
    "PatchSearch",
    "Patchwork",
    "Repetition",
    "Rule",
    "Variants",
    "check_patch",
    "default_patch",
    "features",
    "isometry_ids",
    "pose_array",
    "random_patch",
    "striking",
    "variants",
    "waves",
]
