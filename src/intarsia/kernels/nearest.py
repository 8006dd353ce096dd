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
