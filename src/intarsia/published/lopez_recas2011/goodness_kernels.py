"""Kernels of lattice goodness: how much of a tile an overlap shows, and the best pair of correlation peaks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...foundation.arrays import Pair
from ...kernels.jit import kernel

MILLION = 1_000_000  # correlations are kept in millionths
ALPHA = 1.12  # above 1: of equal means the one of more points, the smaller tile, wins


@kernel
def hermite(v1y: int, v1x: int, v2y: int, v2x: int) -> tuple[int, int, int]:
    """Return (a, b, c): the lattice is also spanned by (dx, dy) = (a, 0) and (b, c), 0 <= b < a, 0 < c."""
    y, x, r, s = v1y, v1x, v2y, v2x
    while r != 0:
        t = y // r
        y, x, r, s = r, s, y - t * r, x - t * s
    if y < 0:
        y, x = -y, -x
    a = abs(s)
    return a, x % a, y


@kernel
def union_length(a: int, b: int, width: int, count: int) -> int:
    """Return the length of the union of the circular intervals [-b i, -b i + width) mod a, i < count."""
    if count <= 0:
        return 0
    if width >= a:
        return a
    at = np.empty(min(count, a), np.int64)
    for i in range(len(at)):
        at[i] = (-b * i) % a
    at.sort()
    total = min(width, a - at[-1] + at[0])
    for i in range(len(at) - 1):
        total += min(width, at[i + 1] - at[i])
    return int(total)


@kernel
def tile_pixels(a: int, b: int, c: int, height: int, width: int) -> int:
    """Return how many different pixels of the tile of the lattice (a, 0), (b, c) a rectangle shows.

    Rows c apart show the same row of the tile, shifted by b.
    """
    full, rest = height // c, height % c
    total = (c - rest) * union_length(a, b, width, full)
    if rest > 0:
        total += rest * union_length(a, b, width, full + 1)
    return total


@kernel
def significant_sum(values: Any, v: Any, w: Any, height: int, width: int) -> Pair:
    """Return sum and number of the map's values at the significant lattice points (right half plane) of a reduced pair.

    Significant: the overlap of the picture (height x width) with itself shows 85 % of the tile or more.
    """
    a, b, c = hermite(v[0], v[1], w[0], w[1])
    high, wide = values.shape[0] >> 1, values.shape[1] >> 1
    square, along, reach = v[0] * v[0] + v[1] * v[1], v[0] * w[0] + v[1] * w[1], float(high * high + wide * wide)
    rows, beside = int(math.sqrt(reach * square) / (a * c)) + 1, int(math.sqrt(reach / square)) + 2
    total, count = 0, 0
    for n in range(-rows, rows + 1):
        middle = -n * along // square
        for m in range(middle - beside, middle + beside + 1):
            y, x = m * v[0] + n * w[0], m * v[1] + n * w[1]
            if abs(y) > high or x > wide or x < 0 or (x == 0 and y <= 0):
                continue
            shown = height - abs(y), width - x
            if 100 * shown[0] * shown[1] >= 85 * a * c and 100 * tile_pixels(a, b, c, *shown) >= 85 * a * c:
                total += values[y + high, x + wide]
                count += 1
    return total, count


@kernel
def highest_by_overlap(values: Any, height: int, width: int) -> Any:
    """Return, for every n, the highest value of the map, its middle excepted, where the overlap has n px or more."""
    high, wide = values.shape[0] >> 1, values.shape[1] >> 1
    most = np.zeros(height * width + 1, np.int64)
    for y in range(-high, high + 1):
        for x in range(0 if y > 0 else 1, wide + 1):
            shown = (height - abs(y)) * (width - x)
            most[shown] = max(most[shown], values[y + high, x + wide])
    for n in range(len(most) - 2, -1, -1):
        most[n] = max(most[n], most[n + 1])
    return most


@kernel
def best_pair(values: Any, peaks: Any, height: int, width: int) -> tuple[Any, int]:
    """Pair every peak with every longer one, reduced by it, each pair once; return the best pair and its goodness."""
    best, found = 0, np.zeros((2, 2), np.int64)
    most = highest_by_overlap(values, height, width)
    reach = math.hypot(values.shape[0] >> 1, values.shape[1] >> 1)
    far = int(reach) + 1
    seen = np.full((2 * far + 1, far + 1), -1, np.int64)  # the peak that an offset was last paired with
    for i in range(len(peaks)):
        vy, vx = peaks[i]
        square = vy * vy + vx * vx
        for j in range(i + 1, len(peaks)):
            wy, wx = peaks[j]
            times = (2 * (vy * wy + vx * wx) + square) // (2 * square)  # halves are rounded up
            wy, wx = wy - times * vy, wx - times * vx
            if wx < 0 or (wx == 0 and wy < 0):
                wy, wx = -wy, -wx
            flat, short = vy * wx == vx * wy, wy * wy + wx * wx < square
            if flat or short or seen[wy + far, wx] == i:
                continue
            seen[wy + far, wx] = i
            tile = abs(vy * wx - vx * wy)
            least = (85 * tile + 99) // 100
            if least >= len(most) or most[least] <= 0:
                continue
            points = (2 * reach / math.sqrt(square) + 1) * (2 * reach * math.sqrt(square) / tile + 1) / 2
            if MILLION * (most[least] / MILLION) ** ALPHA * points ** (ALPHA - 1) < best:
                continue  # eq. 3.23: not even if all points were as high as the highest
            total, count = significant_sum(values, (vy, vx), (wy, wx), height, width)
            good = int(np.rint(MILLION * (max(total, 0) / MILLION) ** ALPHA / max(count, 1)))
            if good > best:
                best = good
                found[0], found[1] = (vy, vx), (wy, wx)
    return found, best
