"""The same neighbours again: what is shown together with what lies around it more than once within sight.

A place of the exemplar may return; one that returns with its surroundings is seen to, as a leaf with the same three
beside it, or in a grid where that happens again and again.

Source: ours; of numbers read off a map this kind agreed best with people on which of two outputs repeats itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.sums import moving_sums
from ..arrays import Array
from .sources import STEP, Sources

REACH = 25  # windows of the output, 200 px: so far two places are seen together; 128 px: fewer pairs are told apart
NEAR = 3  # windows: nearer ones overlap
AROUND = 2  # windows on every side are surroundings, so 5 x 5, and
MOST = 14  # of them, over half, must be the same; 3 x 3 or 7 x 7 of them name the better as often
SAME = 2  # px of the reduced picture: so near sources are the same


def again(sources: Sources, sides: Sequence[int]) -> float:
    """The share of windows that are shown again with their surroundings within 3/4 of the shorter side, in percent.

    `sides`: the shorter sides of the exemplars, px.
    """
    return 100 * float(shown_again(sources, min(REACH, max(sides) * 3 // 4 // STEP)).mean())


def shown_again(sources: Sources, reach: int) -> NDArray[np.bool_]:
    """Which windows return within `reach` windows together with most of the 5 x 5 around them."""
    windows = sources.level.windows
    at = (windows.at[sources.number] * windows.stride).astype(np.int16)
    y, x = (np.ascontiguousarray(at[..., k]) for k in (0, 1))
    rows, columns = y.shape
    out = np.zeros(y.shape, bool)
    for down in range(min(reach, rows - 1) + 1):
        for right in range(-min(reach, columns - 1), min(reach, columns - 1) + 1):
            if max(down, abs(right)) < NEAR or (down == 0 and right < 0):
                continue
            one = np.s_[down:, max(right, 0) : columns + min(right, 0)]
            other = np.s_[: rows - down, max(-right, 0) : columns - max(right, 0)]
            same = (np.abs(y[one] - y[other]) <= SAME) & (np.abs(x[one] - x[other]) <= SAME)
            if np.count_nonzero(same) >= MOST:
                both = _most(same)
                out[one] |= both
                out[other] |= both
    return out


def _most(same: Array) -> NDArray[np.bool_]:
    """Where most of the 5 x 5 around are the same; what lies outside is not."""
    counts = moving_sums(moving_sums(same.astype(np.int64), 0, AROUND, "constant"), 1, AROUND, "constant")
    return np.asarray(counts >= MOST)
