"""Slow and obvious truth of the correlations: every offset with its own pixels, no transform, no running sum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def overlaps(f, g, usable_f=None, usable_g=None):
    """Yield (row, column, pixels of f, pixels of g) for every offset; the pixels as arrays (n, C)."""
    f, g = f.reshape(*f.shape[:2], -1).astype(float), g.reshape(*g.shape[:2], -1).astype(float)
    mf = np.ones(f.shape[:2], bool) if usable_f is None else usable_f
    mg = np.ones(g.shape[:2], bool) if usable_g is None else usable_g
    for y in range(1 - g.shape[0], f.shape[0]):
        for x in range(1 - g.shape[1], f.shape[1]):
            a, b = [], []
            for i in range(g.shape[0]):
                for j in range(g.shape[1]):
                    inside = 0 <= y + i < f.shape[0] and 0 <= x + j < f.shape[1]
                    if inside and mf[y + i, x + j] and mg[i, j]:
                        a.append(f[y + i, x + j])
                        b.append(g[i, j])
            yield y + g.shape[0] - 1, x + g.shape[1] - 1, np.array(a), np.array(b)


def gncc(f, g, usable_f=None, usable_g=None) -> NDArray:
    """Eq. 3.2 of every channel, weighted by the product of its deviations (eq. 3.10)."""
    result = np.zeros((f.shape[0] + g.shape[0] - 1, f.shape[1] + g.shape[1] - 1))
    for y, x, a, b in overlaps(f, g, usable_f, usable_g):
        if not len(a):
            continue
        a, b = a - a.mean(axis=0), b - b.mean(axis=0)
        below = np.sqrt((a * a).sum(axis=0) * (b * b).sum(axis=0)).sum()
        if below > 1e-6:
            result[y, x] = (a * b).sum() / below
    return result
