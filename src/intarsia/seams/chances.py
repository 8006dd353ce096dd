"""Chances by which placements are drawn, in whole numbers, the same on every machine (Kwatra et al. 2003, 3)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..draws import draw

Array = NDArray[Any]

TINY = 1057087571  # exp(-1/64) in 2**-30
GONE = 64 * 20  # beyond, a chance is none


def drawn(chances: list[int], most: int, bits: int) -> list[int]:
    """Draw up to so many numbers, each once and in proportion to its chance, none that has none."""
    rest, total, out = list(chances), sum(chances), list[int]()
    while total and len(out) < most:
        share, k = draw(bits, len(out)) % total, 0
        while share >= rest[k]:
            share, k = share - rest[k], k + 1
        total, rest[k] = total - rest[k], 0
        out.append(k)
    return out


def likelihood(x: Array) -> Array:
    """Return 2**30 exp(-x / 64) for whole numbers x >= 0, in whole numbers, the same on every machine; (n,) int64."""
    out = np.full(len(x), 1 << 30, np.int64)
    rest, factor = x.astype(np.int64), TINY
    for _ in range(GONE.bit_length()):
        out = np.where(rest & 1 > 0, out * factor >> 30, out)
        rest, factor = rest >> 1, factor * factor >> 30
    return np.where(x >= GONE, 0, out)
