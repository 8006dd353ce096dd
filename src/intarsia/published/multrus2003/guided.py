"""The search under a guide as published: a seam and what the guide asks for are added up, not their squares."""

from __future__ import annotations

import numpy as np

from ...foundation.arrays import Array
from ...search.guide import GuidedSearch


class GuidedByRoots(GuidedSearch):
    """Rank what the search finds by d + alpha g (Multrus 2003, 5.3.1); its short-list counts the squares of both."""

    def cost(self, seams: Array, labels: Array, share: float) -> Array:
        """Join squared differences (n,) of seams and of the guide: the square of a sum of roots."""
        root = np.sqrt(seams) + share * np.sqrt(labels)
        both = np.floor(root * root + 0.5).astype(np.int64)
        return np.where(labels == 0, seams, both) if share else seams
