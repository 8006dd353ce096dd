"""The slow twin of `analysis/contrast_masking.py`: pixel by pixel, in plain Python."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def visibility(
    picture: NDArray[np.int16], knee: int, usable: NDArray[np.bool_] | None = None, toroidal: bool = False
) -> NDArray[np.int16]:
    """How much a difference counts at every pixel, in 1/128: the root of a knee over the change around it."""
    height, width = picture.shape[:2]

    def inside(y: int, x: int) -> tuple[int, int] | None:
        if toroidal:
            y, x = y % height, x % width
        if not (0 <= y < height and 0 <= x < width) or (usable is not None and not usable[y, x]):
            return None
        return y, x

    def changes(y: int, x: int) -> list[int]:
        """What a pixel and its neighbours differ."""
        here, found = inside(y, x), []
        for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
            there = inside(v, u)
            if here is not None and there is not None:
                squares = sum((int(a) - int(b)) ** 2 for a, b in zip(picture[here], picture[there], strict=True))
                found.append(math.isqrt(squares))
        return found

    every = {(y, x): changes(y, x) for y in range(-2, height + 2) for x in range(-2, width + 2)}
    out = np.zeros((height, width), np.int16)
    for y, x in np.ndindex(height, width):
        near = [c for v in range(y - 2, y + 3) for u in range(x - 2, x + 3) for c in every[v, u]]
        seen = 128 * math.sqrt(knee * len(near) / max(sum(near), 1))
        out[y, x] = min(max(seen, 64), 256)
    return out
