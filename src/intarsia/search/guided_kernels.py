"""Kernels of the guided patch search: how well a patch fits what is there, and what the guide wants, at once.

The cost is a square: (seam + share * apart)**2, where `seam` and `apart` are the roots of the summed squared
differences of pixels and of the guide. Roots, products and sums are single IEEE operations, the same everywhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from .fourier_kernels import FAR, NONE, insert, keep_best, patch_distances, row_spans, window_distance


@kernel
def guided_cost(seam: Any, apart: Any, share: float) -> Any:
    """Return the cost of summed squares `seam` of pixels and `apart` of the guide, which counts `share`-fold."""
    if share == 0.0 or apart == 0:
        return np.int64(seam)
    root = np.sqrt(np.float64(seam)) + share * np.sqrt(np.float64(apart))
    return np.int64(np.floor(root * root + 0.5))


@kernel
def add_guide(dist: Any, correlation: Any, own: Any, energy: int, share: float, scale: float) -> None:
    """Turn squared distances (rows, columns) int32 into costs, `scale` times as large; NONE stays.

    The guide's squared difference is own - 2 correlation + energy, as in :func:`fourier_kernels.patch_distances`.
    """
    h, w = dist.shape
    for y in range(h):
        for x in range(w):
            if dist[y, x] == NONE:
                continue
            whole = np.int32(np.floor(correlation[y, x] + 0.5))
            apart = max(own[y, x] + np.int32(energy) - np.int32(2) * whole, 0)
            root = np.sqrt(np.float64(max(dist[y, x], 0))) + share * np.sqrt(np.float64(apart))
            dist[y, x] = np.int32(min(root * root * scale, np.float64(NONE) - 2.0))


@kernel
def guided_short_list(correlated: Any, labels: Any, shares: Any, scales: Any, fee: Any, listed: Any) -> None:
    """Put the best positions of one variant into the lists, as :func:`fourier_kernels.short_list` does, under a guide.

    `labels`: the guide, correlated as the pixels are; `shares`, `scales` (n,): see :func:`add_guide`.
    """
    correlations, squares, slots, energies, valid, variant = correlated
    (penalty, weight), (best, counts, usual) = fee, listed
    dist = np.empty(valid.shape, np.int32)
    for k in range(len(slots)):
        q = patch_distances(correlations[k], squares[slots[k]], energies[k], valid, dist)
        if usual[k] < 0:
            usual[k] = q
        unit = int((weight * max(usual[k], 0) >> 8) * scales[k])
        own = labels.squares[labels.slots[k]]
        add_guide(dist, labels.values[k], own, labels.energies[k], shares[k], scales[k])
        counts[k] = keep_best(dist, penalty, unit, variant, best[k], counts[k])


@kernel
def guided_refine(
    feats: Any, known: Any, posed: Any, wanted: Any, inside: Any, labels: Any, share: float, among: Any, coarse: Any,
    factor: int, found: Any,
) -> int:  # fmt: skip
    """Follow coarse candidates to full resolution, as :func:`fourier_kernels.refine` does, by the joined cost.

    `wanted` (h, w, G) int16 and `inside` (h, w) uint8: the guide in the window, and where the canvas reaches;
    `labels`: the guide beside the exemplars, laid out as they are.
    """
    (flat, table), (guide_flat, guide_table), (valid, offsets) = posed, labels, among
    h, w = known.shape
    channels, more = feats.shape[2], wanted.shape[2]
    window, target = feats.reshape(h * w * channels), wanted.reshape(h * w * more)
    spans, reach = np.empty((h, 3), np.int64), np.empty((h, 3), np.int64)
    row_spans(known, spans)
    row_spans(inside, reach)
    count = 0
    for n in range(len(coarse)):
        v = coarse[n, 1]
        rows, columns, stride = offsets[v, 1], offsets[v, 2], table[v, 3]
        ok = valid[offsets[v, 0] : offsets[v, 0] + rows * columns]
        y, x = coarse[n, 2] * factor, coarse[n, 3] * factor
        step, least = max(factor // 2, 1), FAR
        while True:
            near, cy, cx = FAR, y, x
            for k in range(9 if factor > 1 else 1):
                u, s = y + ((k + 4) // 3 % 3 - 1) * step, x + ((k + 4) % 3 - 1) * step
                if u < 0 or s < 0 or u >= rows or s >= columns or (step == 1 and not ok[u * columns + s]):
                    continue
                at = u * stride + s
                d = window_distance(window, known, spans, flat, table[v, 0] + at * channels, stride * channels, 1, near)
                if d < near:
                    apart = np.int64(0)
                    if share > 0.0:
                        begin = guide_table[v, 0] + at * more
                        apart = window_distance(target, inside, reach, guide_flat, begin, stride * more, 1, FAR)
                    d = guided_cost(d, apart, share)
                if d < near:
                    near, cy, cx = d, u, s
            y, x, least = cy, cx, near
            if step == 1:
                break
            step //= 2
        if least < FAR:
            count = insert(found, count, int(least), v, y, x)
    return count


@kernel
def guided_refine_all(
    feats: Any, known: Any, posed: Any, wanted: Any, inside: Any, labels: Any, shares: Any, among: Any, coarse: Any,
    counts: Any, factor: int, found: Any,
) -> None:  # fmt: skip
    """Apply :func:`guided_refine` to n windows; `counts` (n,) say how many candidates there are, before and after."""
    for k in range(len(feats)):
        counts[k] = guided_refine(
            feats[k], known[k], posed, wanted[k], inside[k], labels, shares[k], among, coarse[k, : counts[k]], factor,
            found[k],
        )  # fmt: skip
