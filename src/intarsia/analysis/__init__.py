"""What is known of an exemplar: features, element size, rarity, and the search for patches in it."""

from .boundary import boundary_poses, grown, slack_of
from .features import Features, features, pose_array
from .growth import Growth, Laying
from .guidance import Guidance, check_guide
from .guided_search import GuidedSearch
from .patchwork import Patchwork, random_patch, waves
from .repetition import Layout, Repetition, Rule, striking
from .search import Candidates, PatchSearch
from .sizes import check_patch, default_patch
from .variants import Variants, isometry_ids, variants

__all__ = [
    "Candidates",
    "Features",
    "Growth",
    "Guidance",
    "GuidedSearch",
    "Laying",
    "Layout",
    "PatchSearch",
    "Patchwork",
    "Repetition",
    "Rule",
    "Variants",
    "boundary_poses",
    "check_guide",
    "check_patch",
    "default_patch",
    "features",
    "grown",
    "isometry_ids",
    "pose_array",
    "random_patch",
    "slack_of",
    "striking",
    "variants",
    "waves",
]
