"""Windows, their nearest, and what changes between them, pixel by pixel and in plain numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from intarsia.testing import noise

SIDE, FINE = 8, 64

ORDERS = [(k, j) for k in range(4) for j in range(4) if k + j < 4]


def cosine(k: int, i: int) -> float:
    return math.cos(math.pi * k * (2 * i + 1) / (2 * SIDE)) * (1.0 if k else math.sqrt(0.5))


def waves(window: NDArray[Any], middle: NDArray[Any], shorten: int) -> list[int]:
    """The ten lowest cosines of every channel of a window (8, 8, C)."""
    out = []
    for c in range(window.shape[2]):
        for k, j in ORDERS:
            total = 0
            for y in range(SIDE):
                for x in range(SIDE):
                    weight = round(cosine(k, y) * cosine(j, x) * FINE / (SIDE / 2))
                    total += (int(window[y, x, c]) - int(middle[c])) * weight
            out.append(int(np.rint(np.float32(total) / np.float32(FINE * shorten))))
    return out


def smaller(picture: NDArray[Any], factor: int) -> NDArray[np.int64]:
    high, wide = picture.shape[0] // factor, picture.shape[1] // factor
    out = np.empty((high, wide, picture.shape[2]), np.int64)
    for y in range(high):
        for x in range(wide):
            block = picture[y * factor : (y + 1) * factor, x * factor : (x + 1) * factor].astype(int)
            out[y, x] = block.sum(axis=(0, 1)) // factor**2
    return out


def distance(a: list[int], b: list[int]) -> int:
    """In sixteenths."""
    return round(16 * math.sqrt(sum((p - q) ** 2 for p, q in zip(a, b, strict=True))))


Waves = dict[tuple[int, int], list[int]]


def all_windows(picture: NDArray[Any], factor: int, middle: NDArray[Any], shorten: int) -> Waves:
    """The windows of a picture by their first pixel, in the reduced picture."""
    small = smaller(picture, factor)
    return {
        (y, x): waves(small[y : y + SIDE, x : x + SIDE], middle, shorten)
        for y in range(small.shape[0] - SIDE + 1)
        for x in range(small.shape[1] - SIDE + 1)
    }


def blobs(height: int, width: int, seed: int, most: int = 1023) -> NDArray[np.int16]:
    """Blobs of 4 px and speckle, three channels."""
    coarse = noise(height // 4 + 1, width // 4 + 1, seed) % np.uint64(most)
    wide = np.kron(coarse.astype(np.int64), np.ones((4, 4), np.int64))[:height, :width]
    grain = (noise(height, width, seed + 1) % np.uint64(40)).astype(np.int64)
    return np.stack([wide // 2 + grain, wide, most - wide], axis=2).clip(0, most).astype(np.int16)
