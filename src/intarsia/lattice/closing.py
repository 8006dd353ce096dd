"""Lengths of which a lattice goes into itself: a whole number of periods along an axis.

Source: no paper; a definition. Around an axis of n px the lattice closes where one of its vectors is (n, 0); how far
the nearest one is from that is the misfit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from .candidates import UNIT

Vector = tuple[int, int]

NEAR = 0.05  # of the shortest vector: 2 px on tiles of 40 px, which a joint hides
LEAST = 1.5  # px: no finer misfit is seen, rounding to whole px makes half of it, and photographs bend by as much


def misfit(vectors: Sequence[Vector], length: int, axis: int) -> float:
    """Return how far, px, a lattice is from closing around `length` px of an axis (0: rows, 1: columns).

    `vectors`: one or two of (rows, columns) in 1/256 px. Of rows alone only their pitch must close.
    """
    goal = (length * UNIT, 0) if axis == 0 else (0, length * UNIT)
    if len(vectors) == 1:
        y, x = vectors[0]
        pitch = math.hypot(y, x)
        along = (goal[0] * y + goal[1] * x) / pitch
        return abs(along - pitch * round(along / pitch)) / UNIT
    (a, b), (c, d) = vectors
    area = a * d - b * c
    m, n = (goal[0] * d - goal[1] * c) // area, (goal[1] * a - goal[0] * b) // area
    steps = [(s, t) for s in range(m - 1, m + 3) for t in range(n - 1, n + 3)]
    points = [(s * a + t * c, s * b + t * d) for s, t in steps if (s, t) != (0, 0)]
    return min(math.dist(point, goal) for point in points) / UNIT


def allowed(vectors: Sequence[Vector]) -> float:
    """Return the misfit, px, below which a lattice is taken to close."""
    return max(LEAST, NEAR * min(math.hypot(*v) for v in vectors) / UNIT)


def closing_length(vectors: Sequence[Vector], length: int, axis: int, unit: int = 1) -> int | None:
    """Return the largest multiple of `unit` up to `length` px, at least half of it, around which a lattice closes.

    Of neighbouring lengths that do the one that fits best; `length` itself where it does, or where it runs along rows
    that nearly keep to the axis. None: there is none.
    """
    most = allowed(vectors)
    if len(vectors) == 1 and length * UNIT * abs(vectors[0][axis]) < math.hypot(*vectors[0]) ** 2:
        return length
    if misfit(vectors, length, axis) <= most:
        return length
    fitting = [n for n in range(length - length % unit, (length - 1) // 2, -unit) if misfit(vectors, n, axis) <= most]
    if not fitting:
        return None
    first = [n for k, n in enumerate(fitting) if fitting[0] - n == k * unit]
    return min(first, key=lambda n: misfit(vectors, n, axis))
