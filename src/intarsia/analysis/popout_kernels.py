"""What takes long where it is measured what strikes: averages of whole pictures, and all distances between spots."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel


@kernel
def _beyond(n: int, length: int, wrap: bool) -> int:
    """The pixel that stands for one up to a length beyond the border: round it, or mirrored."""
    if n < 0:
        return n + length if wrap else -1 - n
    if n >= length:
        return n - length if wrap else 2 * length - 1 - n
    return n


@kernel
def average(values: Any, radius: int, wrap: bool) -> None:
    """Average pictures (C, H, W) of float64 three times over squares of 2 radius + 1 px, in place.

    Rounded down along each axis each time. Whole numbers below 2**53 in all sums: so they, and what is rounded down,
    are those of whole numbers. `radius`: below height and width.
    """
    height, width = values.shape[1:]
    count, total = 2.0 * radius + 1.0, np.empty(width)
    lines, line = np.empty((height, width)), np.empty(width)
    for picture in values:
        for _ in range(3):
            total[:] = 0.0
            for i in range(-radius, radius):
                total += picture[_beyond(i, height, wrap)]
            for i in range(height):
                new, old = picture[_beyond(i + radius, height, wrap)], picture[_beyond(i - radius, height, wrap)]
                here = lines[i]
                for j in range(width):
                    here[j] = np.floor((total[j] + new[j]) / count)
                    total[j] += new[j] - old[j]
            for i in range(height):
                here, out, sum_ = lines[i], picture[i], 0.0
                for j in range(-radius, radius + 1):
                    sum_ += here[_beyond(j, width, wrap)]
                line[0] = sum_
                for j in range(1, width):
                    sum_ += here[_beyond(j + radius, width, wrap)] - here[_beyond(j - radius - 1, width, wrap)]
                    line[j] = sum_
                for j in range(width):
                    out[j] = np.floor(line[j] / count)


@kernel
def likes_away(spots: Any, at: Any, others: Any, places: Any, apart: int, size: Any, rank: int, out: Any) -> None:
    """Write how far the like of this rank, from 0, is from every spot, rounded down; -1 where there are not so many.

    `spots` (n, C) at pixels `at` (n, 2) are compared with `others` (C, m) at `places` (m, 2), but with none nearer
    than `apart` px along both axes, round borders where a `size` is above 0. `spots` and `others` are whole numbers in
    float64.
    """
    channels, count = others.shape
    far, best = np.empty(count), np.empty(rank + 1)
    for k in range(len(spots)):
        far[:] = 0.0
        for c in range(channels):
            value, theirs = spots[k, c], others[c]
            for m in range(count):
                far[m] += (value - theirs[m]) * (value - theirs[m])
        best[:] = np.inf
        for m in range(count):
            if far[m] >= best[rank]:
                continue
            down, across = abs(at[k, 0] - places[m, 0]), abs(at[k, 1] - places[m, 1])
            down = min(down, size[0] - down) if size[0] > 0 else down
            across = min(across, size[1] - across) if size[1] > 0 else across
            if down < apart and across < apart:
                continue
            n = rank
            while n > 0 and best[n - 1] > far[m]:
                best[n] = best[n - 1]
                n -= 1
            best[n] = far[m]
        out[k] = np.int64(np.sqrt(best[rank])) if best[rank] < np.inf else -1
