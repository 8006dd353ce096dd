"""By which shift a picture differs least from itself, at full resolution; and where tops lie between pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel


@kernel
def top_of(before: float, here: float, after: float) -> float:
    """Return where the parabola through three neighbours has its top, px from the middle one; 0 where it has none."""
    bend = 2.0 * here - before - after
    return 0.5 * (after - before) / bend if bend > 0 else 0.0


@kernel
def best_shift(
    picture: NDArray[np.int16],
    usable: NDArray[np.bool_],
    near: NDArray[np.int64],
    radius: int,
    window: int,
    found: NDArray[np.float64],
) -> bool:
    """Find the shift near `near` by which a picture differs least from itself; False where none stands out.

    The same px, at most window x window around the middle of the overlap, are compared for every shift, in
    whole numbers; a constant difference of light does not count. `usable` of one px means that all are.
    """
    height, width, channels = picture.shape
    top, left = max(0, radius - near[0]), max(0, radius - near[1])
    bottom, right = min(height, height - near[0] - radius), min(width, width - near[1] - radius)
    if bottom - top > window:
        top = (top + bottom - window) // 2
        bottom = top + window
    if right - left > window:
        left = (left + right - window) // 2
        right = left + window
    if bottom - top < 8 or right - left < 8:
        return False
    masked = usable.size > 1
    side = 2 * radius + 1
    cost = np.zeros((side, side))
    for i in range(side):
        for j in range(side):
            dy, dx = near[0] + i - radius, near[1] + j - radius
            total = 0.0
            for c in range(channels):
                square, plain, count = 0, 0, 0
                for y in range(top, bottom):
                    for x in range(left, right):
                        if masked and not (usable[y, x] and usable[y + dy, x + dx]):
                            continue
                        d = np.int64(picture[y + dy, x + dx, c]) - picture[y, x, c]
                        square += d * d
                        plain += d
                        count += 1
                if count < 64:
                    return False
                total += (square - plain * plain / count) / count
            cost[i, j] = total
    bi, bj = 0, 0
    for i in range(side):
        for j in range(side):
            if cost[i, j] < cost[bi, bj]:
                bi, bj = i, j
    if bi == 0 or bj == 0 or bi == side - 1 or bj == side - 1:
        return False
    here = cost[bi, bj]
    found[0] = near[0] + bi - radius + top_of(-cost[bi - 1, bj], -here, -cost[bi + 1, bj])
    found[1] = near[1] + bj - radius + top_of(-cost[bi, bj - 1], -here, -cost[bi, bj + 1])
    return True
