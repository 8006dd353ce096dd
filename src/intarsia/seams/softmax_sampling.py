"""Fixed-point softmax sampling, the same on every machine."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..foundation.arrays import Array
from ..foundation.run import draw

TINY = 1057087571  # exp(-1/64) in 2**-30
GONE = 64 * 20  # beyond, a chance is none


def sample(chances: list[int], most: int, bits: int) -> list[int]:
    """Draw up to `most` indices without replacement, in proportion to their weights; none of weight 0."""
    rest, total, out = list(chances), sum(chances), list[int]()
    while total and len(out) < most:
        share, k = draw(bits, len(out)) % total, 0
        while share >= rest[k]:
            share, k = share - rest[k], k + 1
        total, rest[k] = total - rest[k], 0
        out.append(k)
    return out


@cache
def _likelihoods() -> Array:
    """Return 2**30 exp(-x / 64) for x = 0 .. GONE, in whole numbers."""
    x = np.arange(GONE + 1)
    out, factor = np.full(len(x), 1 << 30, np.int64), TINY
    for bit in range(GONE.bit_length()):
        out = np.where(x >> bit & 1 > 0, out * factor >> 30, out)
        factor = factor * factor >> 30
    out[GONE] = 0
    return out


def weights(x: Array) -> Array:
    """Return 2**30 exp(-x / 64) for whole numbers x >= 0, in whole numbers, the same on every machine; (n,) int64."""
    return _likelihoods()[np.minimum(x, GONE)]
