"""Smaller copies of pictures, block by block, in whole numbers: the same on every machine."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Mask = NDArray[np.bool_]

WORK_SIDE = 512  # px: what is slow is looked at on copies no larger,
LEAST_SHORT = 64  # px: but a long thin exemplar is not reduced below this
FINE = 16  # mean colours are kept in 1/16 of a feature unit


def factor_for(size: tuple[int, ...], side: int = WORK_SIDE, least: int = LEAST_SHORT) -> int:
    """Return by what to reduce a picture to at most `side` px a side, while the shorter one keeps at least `least`."""
    return max(1, min(-(-max(size[:2]) // side), min(size[:2]) // least))


def blocks(picture: Array, factor: int) -> Array:
    """View a picture (H, W, ...) as its whole blocks (rows, factor, columns, factor, ...); the rest is left out."""
    rows, columns = (n // factor for n in picture.shape[:2])
    whole = picture[: rows * factor, : columns * factor]
    return whole.reshape(rows, factor, columns, factor, *picture.shape[2:])


def block_sums(picture: Array, factor: int) -> NDArray[np.int64]:
    """Add up the blocks of factor x factor px of a picture (H, W, ...): (rows, columns, ...)."""
    parts = blocks(picture, factor)
    bands = parts[:, 0].astype(np.int64)
    for y in range(1, factor):  # one array after the other: three times as fast as a sum over both axes
        bands += parts[:, y]
    sums = bands[:, :, 0].copy()
    for x in range(1, factor):
        sums += bands[:, :, x]
    return sums


def reduced(features: NDArray[np.int16], usable: Mask | None, factor: int) -> tuple[NDArray[np.int64], Mask | None]:
    """Average blocks of features (H, W, C): colours in 1/16, and which count, those of which half is usable."""
    if factor == 1:
        return features.astype(np.int64) * FINE, usable
    if usable is None:
        return FINE * block_sums(features, factor) // (factor * factor), None
    count = block_sums(usable, factor)
    total = block_sums(features * usable[..., None], factor)
    return FINE * total // np.maximum(count, 1)[..., None], 2 * count >= factor * factor
