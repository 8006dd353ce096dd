"""Guided patch search with the published cost: seam and guide distances are added, not their squares."""

from __future__ import annotations

import numpy as np

from ...foundation.arrays import Array
from ...search.guide import GuidedSearch


class GuidedPatchSearch(GuidedSearch):
    """Rank candidates by d + alpha g (Multrus 2003, 5.3.1); the short-list uses the sum of both squares."""

    def cost(self, seams: Array, labels: Array, share: float) -> Array:
        """Return the costs of squared differences (n,) of seams and of the guide: the square of the sum of roots."""
        root = np.sqrt(seams) + share * np.sqrt(labels)
        both = np.floor(root * root + 0.5).astype(np.int64)
        return np.where(labels == 0, seams, both) if share else seams
