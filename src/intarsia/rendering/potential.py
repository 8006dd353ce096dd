"""The potential of a point on a grid of pixels, which ends at a radius.

Added up over the divergence of a field of steps it gives a picture that has these steps, as far as a picture can, and
is as smooth as can be elsewhere. Near the point it is the exact one of the square grid, by the recurrence of McCrea and
Whipple ("Random paths in two and three dimensions", 1940), further out its logarithm; towards the radius it fades.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FINE = 14
"""Potentials are whole numbers of 2**-14: sums over them by transforms of doubles come out exact."""

_EXACT = 6  # px: so far the recurrence is used, which loses digits further out
_EULER = 0.57721566490153286


@lru_cache(maxsize=8)
def potential(radius: int) -> NDArray[np.int64]:
    """Return the potential around a point, less than `radius` px away: (2 radius - 1, 2 radius - 1), in 2**-FINE.

    Its sum of differences to the four neighbours is 1 at the point, and about 0 elsewhere near it.
    """
    near, out = _near(), np.zeros((2 * radius - 1, 2 * radius - 1), np.int64)
    end = _far(float(radius))
    for y in range(radius):
        for x in range(y, radius):
            square = y * y + x * x
            if square >= radius * radius:
                break
            fading = (1.0 - square / (radius * radius)) ** 2
            value = (near[x][y] if x <= _EXACT else _far(math.sqrt(square))) - end
            whole = round(value * fading * (1 << FINE))
            for a, b in ((y, x), (x, y)):
                for row in (radius - 1 - a, radius - 1 + a):
                    out[row, [radius - 1 - b, radius - 1 + b]] = whole
    out.flags.writeable = False
    return out


def _far(distance: float) -> float:
    return (math.log(distance) + _EULER + 1.5 * math.log(2.0)) / (2.0 * math.pi)


def _near() -> list[list[float]]:
    """The potential of a point at (0, 0) on a grid without end, in rows x >= y >= 0."""
    n = _EXACT + 1
    a = [[0.0] * (n + 1) for _ in range(n + 1)]
    for k in range(1, n + 1):  # along the diagonal, and beside it: both neighbours below are known
        a[k][k] = a[k - 1][k - 1] + 1.0 / (math.pi * (2 * k - 1))
    a[1][0] = 0.25
    for k in range(1, n):
        a[k + 1][k] = 2.0 * a[k][k] - a[k][k - 1]
    for gap in range(2, n + 1):
        for y in range(n + 1 - gap):
            x = y + gap - 1  # the pixel whose neighbours are all known but the right one
            a[x + 1][y] = 4.0 * a[x][y] - a[x - 1][y] - a[x][y + 1] - a[x][abs(y - 1)]
    return a
