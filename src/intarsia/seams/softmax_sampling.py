"""Softmax sampling in fixed point, the same on every machine: weights exp(-x / 64), and sampling without replacement.

Placements are drawn with it by their cost C (Kwatra et al. 2003, section 3.2: probability exp(-C / (k sigma**2))).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..foundation.arrays import Array
from ..foundation.run import draw

STEP = 1057087571  # about exp(-1/64), in 2**-30, too small by 7 millionths: weights at x = 640 by half a per cent
CUTOFF = 64 * 20  # from here on a weight is 0


def weighted_sample(weights: list[int], count: int, bits: int) -> list[int]:
    """Draw up to `count` indices without replacement, in proportion to their weights; none of weight 0.

    Fewer where fewer weights are positive. `bits`: 64 random bits, from which all draws are derived.
    """
    rest, total, out = list(weights), sum(weights), list[int]()
    while total and len(out) < count:
        share, k = draw(bits, len(out)) % total, 0
        while share >= rest[k]:
            share, k = share - rest[k], k + 1
        total, rest[k] = total - rest[k], 0
        out.append(k)
    return out


@cache
def _table() -> Array:
    """Return about 2**30 exp(-x / 64) for x = 0 .. CUTOFF."""
    x = np.arange(CUTOFF + 1)
    out, factor = np.full(len(x), 1 << 30, np.int64), STEP
    for bit in range(CUTOFF.bit_length()):
        out = np.where(x >> bit & 1 > 0, out * factor >> 30, out)
        factor = factor * factor >> 30
    out[CUTOFF] = 0
    return out


def boltzmann_weights(x: Array) -> Array:
    """Return about 2**30 exp(-x / 64) for whole numbers x >= 0: (n,) int64."""
    return _table()[np.minimum(x, CUTOFF)]
