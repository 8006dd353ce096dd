"""The slow twin of patches in step: every place against every step."""

from __future__ import annotations

from itertools import product

import numpy as np


def in_step(
    valid: np.ndarray, vectors: tuple[tuple[int, int], tuple[int, int]], place: tuple[int, int], slack: int
) -> np.ndarray:
    """Say which places lie within `slack` px of whole steps from one, by trying all; more slack where none does."""
    (a, b), (c, d) = vectors
    many = 2 + 256 * (abs(place[0]) + abs(place[1]) + sum(valid.shape)) * 6000 * 2 // abs(a * d - b * c)
    points = set()
    for m, n in product(range(-many, many + 1), repeat=2):
        y, x = place[0] + round_half_up(m * a + n * c), place[1] + round_half_up(m * b + n * d)
        if -50 <= y <= 90 and -50 <= x <= 90:
            points.add((y, x))
    out = np.zeros_like(valid)
    while valid.any() and not out.any():
        for y, x in np.argwhere(valid).tolist():
            out[y, x] = any(abs(y - p) <= slack and abs(x - q) <= slack for p, q in points)
        slack = 2 * slack + 1
    return out


def round_half_up(parts: int) -> int:
    """A length of 1/256 px in px."""
    return int(np.floor(parts / 256 + 0.5))
