"""Analysis of exemplars before synthesis: features, element size, illumination, symmetry, saliency.

Here: sums over windows and blocks of pictures, reduced copies, variances, principal axes, valid windows.

All in whole numbers, except the axes of a covariance: equal on every machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation import MethodError, ndimage
from ..foundation.arrays import Array, Int16, Int64, Mask, Pair

WORK_SIDE = 512  # px: slow measurements are made on copies no larger,
LEAST_SHORT = 64  # px: but a long thin exemplar is not reduced below this
FINE = 16  # mean colours are kept in 1/16 of a feature unit


def factor_for(size: tuple[int, ...], side: int = WORK_SIDE, least: int = LEAST_SHORT) -> int:
    """Return the factor that reduces a picture to at most `side` px a side, the shorter one to at least `least`."""
    return max(1, min(-(-max(size[:2]) // side), min(size[:2]) // least))


def blocks(picture: Array, factor: int) -> Array:
    """Return a view of the whole blocks (rows, factor, columns, factor, ...) of a picture (H, W, ...)."""
    rows, columns = (n // factor for n in picture.shape[:2])
    whole = picture[: rows * factor, : columns * factor]
    return whole.reshape(rows, factor, columns, factor, *picture.shape[2:])


def block_sums(picture: Array, factor: int) -> Int64:
    """Return the sums of the blocks of factor x factor px of a picture (H, W, ...): (rows, columns, ...)."""
    parts = blocks(picture, factor)
    bands = parts[:, 0].astype(np.int64)
    for y in range(1, factor):  # one array after the other: three times as fast as a sum over both axes
        bands += parts[:, y]
    sums = bands[:, :, 0].copy()
    for x in range(1, factor):
        sums += bands[:, :, x]
    return sums


def enlarged(values: Array, shape: tuple[int, ...], factor: int) -> Array:
    """Return values enlarged to blocks of factor x factor px, of the size of the picture before reduction."""
    rows, columns = (np.minimum(np.arange(n) // factor, m - 1) for n, m in zip(shape, values.shape, strict=False))
    return np.asarray(values[rows[:, None], columns])


def reduced(features: Int16, usable: Mask | None, factor: int) -> tuple[Int64, Mask | None]:
    """Return the means of blocks of features (H, W, C) in 1/16, and which blocks count: at least half usable."""
    if factor == 1:
        return features.astype(np.int64) * FINE, usable
    if usable is None:
        return FINE * block_sums(features, factor) // (factor * factor), None
    count = block_sums(usable, factor)
    total = block_sums(features * usable[..., None], factor)
    return FINE * total // np.maximum(count, 1)[..., None], 2 * count >= factor * factor


def scaled_variances(vectors: Array) -> list[int]:
    """Return n**2 times the variance of every channel of whole numbers (n, C): whole, so equal on every machine."""
    return [len(vectors) * int((c * c).sum()) - int(c.sum()) ** 2 for c in vectors.astype(np.int64, copy=False).T]


def variance(picture: Array, usable: Array | None = None) -> int:
    """Return the sum of the variances of all channels of a picture (H, W, C) over its usable pixels, rounded down."""
    pixels = picture.reshape(-1, picture.shape[2]) if usable is None else picture[usable]
    return sum(scaled_variances(pixels)) // max(len(pixels), 1) ** 2


def principal_axes(covariance: Array, count: int) -> tuple[float, Array]:
    """Return the variance along the `count` strongest axes, and the axes (count, C), equal on every machine.

    Libraries return the axes of equal variances in any order, and each axis in either direction. Therefore a small ramp
    on the diagonal separates equal variances, and each axis is turned so that its largest entry is positive.
    """
    ramp = 1e-5 * max(float(np.trace(covariance)) / len(covariance), 1e-9)
    values, vectors = np.linalg.eigh(covariance + np.diag(ramp * np.arange(len(covariance))))
    axes = vectors[:, ::-1].T[:count]
    signs = np.sign(axes[np.arange(count), np.abs(axes).argmax(axis=1)])
    return float(values[::-1][:count].sum()), axes * signs[:, None]


def nearest(usable: Mask) -> NDArray[np.intp] | None:
    """Return the nearest usable pixel of every pixel (2, H, W); None if all are usable."""
    if usable.all():
        return None
    return np.asarray(ndimage.distance_transform_edt(~usable, return_distances=False, return_indices=True), np.intp)


def valid_windows(shape: tuple[int, ...], usable: Mask | None, toroidal: bool, patch: Pair) -> Mask:
    """Return the first pixels of windows of the patch size that lie inside the picture and hold usable pixels only."""
    rows, columns = shape[0] - patch[0] + 1, shape[1] - patch[1] + 1
    if rows < 1 or columns < 1:
        return np.zeros((max(rows, 0), max(columns, 0)), bool)
    if usable is None:
        return np.ones((rows, columns), bool)
    if toroidal:
        usable = np.pad(usable, ((0, patch[0] - 1), (0, patch[1] - 1)), mode="wrap")
    return np.asarray(window_sums(~usable, patch) == 0)


def without_patch(patch: Pair) -> MethodError:
    """Return the error that no patch of (rows, columns) px is free of masked pixels."""
    return MethodError(
        f"no {patch[1]}x{patch[0]} px patch of the exemplar is free of masked pixels; "
        "choose a smaller patch, or mask less."
    )


def running_sums(values: Array, kind: Any = np.int64) -> Array:
    """Return the summed-area table of a picture: (H, W, ...) -> (H + 1, W + 1, ...), of a dtype."""
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1, *values.shape[2:]), kind)
    np.cumsum(np.cumsum(values, axis=0, dtype=kind), axis=1, out=total[1:, 1:])
    return total


def window_sums(values: Array, size: Pair, kind: Any = np.int64) -> Array:
    """Return the sums over all windows of (rows, columns) inside a picture (H, W), indexed by their first pixels."""
    (h, w), total = size, running_sums(values, kind)
    return np.asarray(total[h:, w:] - total[:-h, w:] - total[h:, :-w] + total[:-h, :-w])
