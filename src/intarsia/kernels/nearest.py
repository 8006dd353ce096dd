"""The exact search among given patches: every one is measured, where the short-list does not do."""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel
from .match import FAR, distance, insert, row_spans


@kernel
def best_of(feats: Any, known: Any, flat: Any, table: Any, rows: Any, found: Any) -> int:
    """Measure patches, `rows` (n, 4) as in `found`, exactly; put the nearest into `found`, return how many."""
    h, w = known.shape
    channels = feats.shape[2]
    window = feats.reshape(h * w * channels)
    spans = np.empty((h, 3), np.int64)
    row_spans(known, spans)
    count, size = 0, len(found)
    for k in range(len(rows)):
        v, u, s = rows[k, 1], rows[k, 2], rows[k, 3]
        stride = table[v, 3] * channels
        worst = FAR if count < size else found[size - 1, 0]
        d = distance(window, known, spans, flat, table[v, 0] + u * stride + s * channels, stride, 1, worst)
        if d < worst:
            count = insert(found, min(count, size - 1), d, v, u, s)
    return count


@kernel
def complete(
    correlations: Any, squares: Any, slots: Any, energies: Any, valid: Any, variant: int, axes: int, scale: float,
    feats: Any, known: Any, flat: Any, table: Any, found: Any, counts: Any,
) -> None:  # fmt: skip
    """Measure what the short-lists of n windows may have missed, so that the best of one variant is among `found`.

    The reduced pictures are rounded to whole numbers along `axes` directions: the true distance, times `scale`,
    is at least that of the reduced pictures less 1 for every known cell and axis (as norms). Positions that may
    be nearer than the best found are measured exactly. `found` (n, K, 4) stays sorted.
    """
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
        limit = np.float32((np.sqrt(float(best)) * scale + doubt) ** 2 + 1.0 - energies[k])
        for y in range(valid.shape[0]):
            cor, own, ok = correlations[k, y], squares[slots[k], y], valid[y]
            least = np.float32(3e38)
            for x in range(valid.shape[1]):
                least = min(least, np.float32(own[x]) - np.float32(2.0) * np.float32(cor[x]))
            if least > limit:
                continue
            for x in range(valid.shape[1]):
                if np.float32(own[x]) - np.float32(2.0) * np.float32(cor[x]) > limit or not ok[x]:
                    continue
                start = table[variant, 0] + y * stride + x * channels
                d = distance(window, known[k], spans, flat, start, stride, 1, best)
                if d < best:
                    counts[k] = insert(found[k], min(counts[k], found.shape[1] - 1), d, variant, y, x)
                    best = d
                    limit = np.float32((np.sqrt(float(best)) * scale + doubt) ** 2 + 1.0 - energies[k])
