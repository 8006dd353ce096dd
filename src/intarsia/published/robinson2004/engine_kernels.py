"""Kernels of raster quilting: norms of pixel differences, and their sums over an overlap for every place."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.jit import kernel

PARTS = 16.0  # norms are counted in parts of a step of the features
TURNS = 16  # places of which one is looked at first; 1: twice as long


@kernel
def norms(shown: Any, patch: Any) -> Any:
    """Return the norm of the difference of every pixel (h, w, C), in 1/16: (h, w) int64."""
    height, width, channels = shown.shape
    out = np.zeros((height, width), np.int64)
    for i in range(height):
        for j in range(width):
            total = np.int64(0)
            for c in range(channels):
                d = np.int64(shown[i, j, c]) - np.int64(patch[i, j, c])
                total += d * d
            out[i, j] = np.int64(np.sqrt(np.float64(total)) * PARTS)
    return out


@kernel
def overlap_sums(picture: Any, valid: Any, shown: Any, known: Any, tolerance: float) -> Any:
    """Return for every place the sum of norms over the `known` pixels (h, w) of a window: (rows, columns) int64.

    -1 where no patch may begin, and where it is clear that the sum is beyond the tolerance of the least.
    """
    channels, wide = picture.shape[2], picture.shape[1]
    rows, columns = np.nonzero(known)
    spread = np.argsort(np.arange(len(rows)) * 40503 % 65536, kind="mergesort")  # well apart: poor fits show early
    steps = ((rows * wide + columns) * channels)[spread]
    values = np.empty((len(rows), channels), np.int64)
    for k in range(len(rows)):
        values[k] = shown[rows[spread[k]], columns[spread[k]]]
    flat, out, limit = picture.reshape(picture.size), np.full(valid.shape, -1, np.int64), np.int64(1) << 60
    for turn in range(TURNS):  # a few places all over first: the others then end early
        for place in range(turn, valid.size, TURNS):
            y, x = place // valid.shape[1], place % valid.shape[1]
            if not valid[y, x]:
                continue
            whole, at = np.int64(0), (y * wide + x) * channels
            for k in range(len(steps)):
                total = np.int64(0)
                for c in range(channels):
                    d = values[k, c] - flat[at + steps[k] + c]
                    total += d * d
                whole += np.int64(np.sqrt(np.float64(total)) * PARTS)
                if whole > limit:
                    break
            if whole <= limit:
                out[y, x] = whole
                limit = min(limit, np.int64(np.ceil((1.0 + tolerance) * whole)))
    return out
