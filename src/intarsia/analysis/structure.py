"""Direction of the edges of a texture, and continuity across its borders."""

from __future__ import annotations

import math

import numpy as np

from ..foundation.arrays import Int16, Mask


def edge_coherence(picture: Int16, usable: Mask | None) -> float:
    """Return how far all edges of a picture (H, W, C) have one direction: 0 to 1; 0 without edges.

    From the eigenvalues l1 >= l2 of the structure tensor of the sum of all channels, as (l1 - l2) / (l1 + l2).
    """
    total = picture.sum(axis=2, dtype=np.int64)
    if min(total.shape) < 3:
        return 0.0
    down, right = total[2:, 1:-1] - total[:-2, 1:-1], total[1:-1, 2:] - total[1:-1, :-2]
    if usable is not None:
        free = usable[2:, 1:-1] & usable[:-2, 1:-1] & usable[1:-1, 2:] & usable[1:-1, :-2]
        down, right = down[free], right[free]
    yy, xx, xy = (int((a * b).sum()) for a, b in ((down, down), (right, right), (down, right)))
    return math.hypot(xx - yy, 2 * xy) / (xx + yy) if yy + xx else 0.0


def border_steps(picture: Int16, usable: Mask | None) -> tuple[float, float]:
    """Return the mean difference across the borders, relative to that of neighbours along the axis.

    From the bottom row to the top row, and from the last column to the first; inf if it is not known. A difference is
    summed over channels. `picture` (H, W, C); `usable` (H, W): pixels to compare.
    """
    return _step_over(picture, usable, 0), _step_over(picture, usable, 1)


def _step_over(picture: Int16, usable: Mask | None, axis: int) -> float:
    p = np.moveaxis(picture, axis, 0).astype(np.int64)
    free = np.ones(p.shape[:2], bool) if usable is None else np.moveaxis(usable, axis, 0)
    if len(p) < 4:
        return math.inf
    steps = np.abs(p[1:] - p[:-1]).sum(axis=2)
    inside = free[1:] & free[:-1]
    over = np.abs(p[0] - p[-1]).sum(axis=1)[free[0] & free[-1]]
    usual = int(steps[inside].sum()) / max(int(inside.sum()), 1)
    return float(over.sum()) / len(over) / usual if len(over) and usual else math.inf
