"""Kernel of the pyramid search: filtering and decimation by two of partly known pictures (Multrus 2003, 4.3)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.jit import kernel

UNKNOWN, KNOWN, OUTSIDE = 0, 1, 2


@kernel
def decimate(feats: Any, state: Any, weights: Any, loose: Any, out: Any, out_state: Any) -> None:
    """Filter n pictures with 3 x 3 `weights` and keep every second pixel.

    `state` (n, h, w): KNOWN, UNKNOWN, or OUTSIDE the canvas, which is left out of averages. A pixel of `out` is known
    if all nine around its centre are; where `loose` (n,): if any is. A seam of n px thus keeps floor(n / 2).
    """
    count, rows, columns, channels = out.shape
    height, width = state.shape[1:]
    total = np.empty(channels, np.int64)
    for k in range(count):
        for y in range(rows):
            for x in range(columns):
                total[:] = 0
                n, missing = np.int64(0), False
                for i in range(max(2 * y - 1, 0), min(2 * y + 2, height)):
                    for j in range(max(2 * x - 1, 0), min(2 * x + 2, width)):
                        missing = missing or state[k, i, j] == UNKNOWN
                        if state[k, i, j] == KNOWN:
                            share = weights[i - 2 * y + 1, j - 2 * x + 1]
                            n += share
                            for c in range(channels):
                                total[c] += share * feats[k, i, j, c]
                there = KNOWN
                if state[k, 2 * y, 2 * x] == OUTSIDE:
                    there = OUTSIDE
                elif n == 0 or (missing and not loose[k]):
                    there = UNKNOWN
                out_state[k, y, x] = there
                for c in range(channels):
                    out[k, y, x, c] = (2 * total[c] + n) // (2 * n) if there == KNOWN else 0
