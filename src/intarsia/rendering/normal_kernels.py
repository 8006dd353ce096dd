"""Turn and settle the vectors of normal maps of whole numbers; those of floats are few, and left to numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel

Array = NDArray[Any]
Turn = tuple[NDArray[np.int64], NDArray[np.int64]]
"""(channel, sign), (8, 3) each: what a pose makes of the components."""


@kernel
def turn_codes(codes: Array, pose: NDArray[np.integer[Any]], turn: Turn, top: int, out: Array) -> None:
    """Turn codes (h, w, 3) by their poses; the opposite of a code v is top - v."""
    channel, sign = turn
    for y in range(pose.shape[0]):
        for x in range(pose.shape[1]):
            p = pose[y, x]
            for c in range(3):
                v = codes[y, x, channel[p, c]]
                out[y, x, c] = top - v if sign[p, c] < 0 else v


@kernel
def settle_vectors(
    samples: Array, turn: Turn, total: Array, first: NDArray[np.int64], weight: NDArray[np.int64], top: int,
    out: Array,
) -> None:  # fmt: skip
    """Return votes as codes of vectors of length 1, rounded half up; where all agree, that of the first voter.

    `total` (h, w, 3) is relative to the first voter (8 u + pose), see `vote_relative`. Where votes cancel the weight
    becomes 0.
    """
    channel, sign = turn
    for y in range(weight.shape[0]):
        for x in range(weight.shape[1]):
            if weight[y, x] == 0:
                continue
            u, p = first[y, x] >> 3, first[y, x] & 7
            for c in range(3):
                v = samples[u, channel[p, c]]
                out[y, x, c] = top - v if sign[p, c] < 0 else v
            if total[y, x, 0] == 0 and total[y, x, 1] == 0 and total[y, x, 2] == 0:
                continue
            w = weight[y, x]
            a = float((2 * np.int64(out[y, x, 0]) - top) * w + total[y, x, 0])
            b = float((2 * np.int64(out[y, x, 1]) - top) * w + total[y, x, 1])
            z = float((2 * np.int64(out[y, x, 2]) - top) * w + total[y, x, 2])
            length = np.sqrt((a * a + b * b) + z * z)
            if length == 0.0:
                weight[y, x] = 0
                continue
            for c, n in enumerate((a, b, z)):
                out[y, x, c] = np.int64(np.floor(min(max((n / length + 1.0) / 2.0, 0.0), 1.0) * top + 0.5))
