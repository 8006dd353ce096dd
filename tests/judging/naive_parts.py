"""Periods, repeats and segments of an output in plain loops."""

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


def looks(labels: NDArray[Any], colours: NDArray[Any], number: int) -> list[int]:
    """What is known of one segment, in 1/64: area, outline, how long, how slanted, colours, unevenness."""
    spots = [(y, x) for y, x in np.ndindex(labels.shape) if labels[y, x] == number]
    rim = 0
    for y, x in spots:
        near = ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1))
        inside = [(i, j) for i, j in near if 0 <= i < labels.shape[0] and 0 <= j < labels.shape[1]]
        rim += any(labels[i, j] != number for i, j in inside)
    n = len(spots)
    my, mx = sum(y for y, _ in spots) / n, sum(x for _, x in spots) / n
    high = sum((y - my) ** 2 for y, _ in spots) / n
    wide = sum((x - mx) ** 2 for _, x in spots) / n
    slant = sum((y - my) * (x - mx) for y, x in spots) / n
    channels = colours.shape[2]
    root = 256 * math.sqrt(channels)
    means = [sum(int(colours[y, x, c]) for y, x in spots) / n for c in range(channels)]
    uneven = sum(sum((int(colours[y, x, c]) - means[c]) ** 2 for y, x in spots) / n for c in range(channels))
    size = high + wide + 0.3
    found = [
        math.log2(n), 0.5 * rim / math.sqrt(n), 1.5 * (high - wide) / size, 3 * slant / size,
        *(1.2 * m / root for m in means), 1.5 * math.sqrt(uneven) / root,
    ]  # fmt: skip
    return [round(64 * v) for v in found]
