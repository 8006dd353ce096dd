"""What is known of an exemplar: features, element size, rarity, and the search for patches in it."""

from .features import Features, features, pose_array
from .growth import Growth, Laying, Pick
from .patchwork import Patchwork, Window, random_patch, waves
from .pyramid import PyramidSearch, check_pyramid
from .repetition import Layout, Repetition, Rule, striking
from .search import Candidates, PatchSearch, Prices, Search
from .sizes import check_patch, default_patch
from .symmetry import allowed_isometries, settled_isometries
from .variants import Variants, isometry_ids, variants

__all__ = [
    "Candidates",
    "Features",
    "Growth",
    "Laying",
    "Layout",
    "PatchSearch",
    "Patchwork",
    "Pick",
    "Prices",
    "PyramidSearch",
    "Repetition",
    "Rule",
    "Search",
    "Variants",
    "Window",
    "allowed_isometries",
    "check_patch",
    "check_pyramid",
    "default_patch",
    "features",
    "isometry_ids",
    "pose_array",
    "random_patch",
    "settled_isometries",
    "striking",
    "variants",
    "waves",
]
