"""Sets that are joined step by step, each known by one of its members (union and find; Tarjan 1975)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .jit import kernel


@kernel
def find_root(parent: NDArray[np.int32], v: int) -> int:
    """Follow parents to the member that names its set, halving the way for the next one who asks."""
    while parent[v] != v:
        parent[v] = parent[parent[v]]
        v = parent[v]
    return v
