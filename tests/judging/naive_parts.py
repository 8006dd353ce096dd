"""Periods and repeats of an output in plain loops."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = tuple[float, float]


def off_lattice(move: Vector, vectors: list[Vector]) -> float:
    """How far a move, in px, is from the nearest whole number of periods, along the worse axis; of rows across them."""
    if len(vectors) == 1:
        (a, b) = vectors[0]
        length = math.hypot(a, b)
        along = (move[0] * a + move[1] * b) / length
        return min(abs(along - k * length) for k in range(-60, 61))
    (a, b), (c, d) = vectors
    return min(
        max(abs(move[0] - i * a - j * c), abs(move[1] - i * b - j * d)) for i, j in product(range(-30, 31), repeat=2)
    )


def unlike_itself(picture: NDArray[Any], shift: tuple[int, int]) -> float:
    """Mean squared difference of all pairs so far apart, of twice the variance."""
    height, width, channels = picture.shape
    values = picture.astype(int)
    total = count = 0
    for y in range(height):
        for x in range(width):
            i, j = y + shift[0], x + shift[1]
            if 0 <= i < height and 0 <= j < width:
                total += sum((int(values[y, x, c]) - int(values[i, j, c])) ** 2 for c in range(channels))
                count += 1
    variance = sum(float(np.var(picture[..., c].astype(float))) for c in range(channels))
    return total / count / (2 * variance)


def shown_again(at: NDArray[Any], reach: int) -> NDArray[np.bool_]:
    """Windows (rows, columns, 2) that show a place within 2 px of what another window shows, and so do most around."""
    rows, columns = at.shape[:2]
    out = np.zeros((rows, columns), bool)

    def same(y: int, x: int, i: int, j: int) -> bool:
        inside = 0 <= y < rows and 0 <= x < columns and 0 <= i < rows and 0 <= j < columns
        return inside and int(np.abs(at[y, x].astype(int) - at[i, j]).max()) <= 2

    for y, x in product(range(rows), range(columns)):
        for i, j in product(range(y - reach, y + reach + 1), range(x - reach, x + reach + 1)):
            if max(abs(i - y), abs(j - x)) < 3 or not (0 <= i < rows and 0 <= j < columns):
                continue
            around = product(range(-2, 3), repeat=2)
            out[y, x] |= sum(same(y + a, x + b, i + a, j + b) for a, b in around) >= 14
    return out
