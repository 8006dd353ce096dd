"""The exact search among given patches: every one is measured, where the short-list does not do."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from .fourier_kernels import insert, row_spans, window_distance


@kernel
def measure(feats: Any, known: Any, posed: Any, rows: Any) -> None:
    """Write the squared distance of every patch into its row of `rows` (n, 4), which are as candidates.

    In place of the distance stands what is far enough: of a patch farther off no more is known than that it is.
    """
    flat, table = posed
    h, w = known.shape
    channels = feats.shape[2]
    window = feats.reshape(h * w * channels)
    spans = np.empty((h, 3), np.int64)
    row_spans(known, spans)
    for k in range(len(rows)):
        v, stride = rows[k, 1], table[rows[k, 1], 3] * channels
        start = table[v, 0] + rows[k, 2] * stride + rows[k, 3] * channels
        rows[k, 0] = window_distance(window, known, spans, flat, start, stride, 1, rows[k, 0])


@kernel
def complete(
    correlated: Any, axes: int, scale: float, feats: Any, known: Any, posed: Any, found: Any, counts: Any
) -> None:
    """Measure what the short-lists of n windows may have missed, so that the best of one variant is among `found`.

    The reduced pictures are rounded to whole numbers along `axes` directions: the true distance, times `scale`,
    is at least that of the reduced pictures less 1 for every known cell and axis (as norms). Positions that may
    be nearer than the best found are measured exactly. `found` (n, K, 4) stays sorted.
    """
    correlations, squares, slots, energies, valid, variant = correlated
    flat, table = posed
    h, w = known.shape[1:]
    channels = feats.shape[3]
    spans = np.empty((h, 3), np.int64)
    stride = table[variant, 3] * channels
    for k in range(len(slots)):
        if counts[k] < 1:
            continue
        window = feats[k].reshape(h * w * channels)
        row_spans(known[k], spans)
        doubt = np.sqrt(float(known[k].sum()) * axes)
        best = found[k, 0, 0]
        more = 2.0 - energies[k]  # correlations round to whole numbers, so distances are wrong by less than 1
        limit = (np.sqrt(float(best)) * scale + doubt) ** 2 + more
        for y in range(valid.shape[0]):
            cor, own, ok = correlations[k, y], squares[slots[k], y], valid[y]
            for x in range(valid.shape[1]):  # in doubles: sums of large patches are beyond what floats hold
                if np.float64(own[x]) - 2.0 * np.float64(cor[x]) > limit or not ok[x]:
                    continue
                start = table[variant, 0] + y * stride + x * channels
                d = window_distance(window, known[k], spans, flat, start, stride, 1, best)
                if d < best:
                    counts[k] = insert(found[k], min(counts[k], found.shape[1] - 1), d, variant, y, x)
                    best = d
                    limit = (np.sqrt(float(best)) * scale + doubt) ** 2 + more
