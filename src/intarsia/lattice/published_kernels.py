"""How much of a lattice's tile a rectangle shows, counted exactly, and the plain goodness that needs it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel


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
    """Length of the union of the circular intervals [-b i, -b i + width) mod a, i < count."""
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
    """Count the different pixels of the tile of the lattice (a, 0), (b, c) that a rectangle shows.

    Rows c apart show the same row of the tile, shifted by b.
    """
    full, rest = height // c, height % c
    total = (c - rest) * union_length(a, b, width, full)
    if rest > 0:
        total += rest * union_length(a, b, width, full + 1)
    return total


@kernel
def significant_sums(
    values: NDArray[np.int32],
    lattices: NDArray[np.int64],
    height: int,
    width: int,
    total: NDArray[np.int64],
    count: NDArray[np.int64],
) -> None:
    """Add up the map at the significant points of the right half plane of every lattice, in whole px.

    Significant: the overlap of the picture (height x width) with itself shows 85 % of the tile or more.
    """
    high, wide = values.shape[0] >> 1, values.shape[1] >> 1
    for k in range(len(lattices)):
        a, b, c = hermite(lattices[k, 0, 0], lattices[k, 0, 1], lattices[k, 1, 0], lattices[k, 1, 1])
        total[k], count[k] = 0, 0
        for m in range(-(high // c), high // c + 1):
            y = m * c
            least = 0 if y > 0 else 1
            x = (m * b - least) % a + least
            while x <= wide:
                h, w = height - abs(y), width - x
                if 100 * h * w >= 85 * a * c and 100 * tile_pixels(a, b, c, h, w) >= 85 * a * c:
                    total[k] += values[y + high, x + wide]
                    count[k] += 1
                x += a
