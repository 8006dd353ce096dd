"""Analysis of exemplars before synthesis: features, element size, illumination, symmetry, saliency.

This module: sums over windows and blocks of pictures, reduced copies, variances, principal axes, valid windows.

All in whole numbers, except the axes of a covariance, so that results are equal on every machine.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation import MethodError, ndimage
from ..foundation.arrays import Array, Int16, Int64, Mask, Pair

WORK_SIDE = 512  # px: longest side of the reduced copies on which slow measurements are made
LEAST_SHORT = 64  # px: shorter side below which no copy is reduced, even if the longer side exceeds WORK_SIDE
FINE = 16  # mean colours are kept in 1/FINE of a feature unit


def factor_for(size: tuple[int, ...], side: int = WORK_SIDE, least: int = LEAST_SHORT) -> int:
    """Return the factor that reduces a picture to at most `side` px, its shorter side to no less than `least`."""
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
    for y in range(1, factor):  # three times as fast as one sum over both axes
        bands += parts[:, y]
    sums = bands[:, :, 0].copy()
    for x in range(1, factor):
        sums += bands[:, :, x]
    return sums


def enlarged(values: Array, shape: tuple[int, ...], factor: int) -> Array:
    """Return values (rows, columns) repeated in blocks of factor x factor px, to a picture of this `shape`."""
    rows, columns = (np.minimum(np.arange(n) // factor, m - 1) for n, m in zip(shape, values.shape, strict=False))
    return np.asarray(values[rows[:, None], columns])


def reduced(features: Int16, usable: Mask | None, factor: int) -> tuple[Int64, Mask | None]:
    """Return the means of blocks of features (H, W, C), in 1/FINE, and which blocks are at least half usable.

    The mean of a block is that of its usable pixels. The mask is None if `usable` is.
    """
    if factor == 1:
        return features.astype(np.int64) * FINE, usable
    if usable is None:
        return FINE * block_sums(features, factor) // (factor * factor), None
    count = block_sums(usable, factor)
    total = block_sums(features * usable[..., None], factor)
    return FINE * total // np.maximum(count, 1)[..., None], 2 * count >= factor * factor


def scaled_variances(vectors: Array) -> list[int]:
    """Return n**2 times the variance of every channel of whole numbers (n, C), which is a whole number."""
    return [len(vectors) * int((c * c).sum()) - int(c.sum()) ** 2 for c in vectors.astype(np.int64, copy=False).T]


def variance(picture: Array, usable: Array | None = None) -> int:
    """Return the sum of the variances of all channels of a picture (H, W, C) over its usable pixels, rounded down."""
    pixels = picture.reshape(-1, picture.shape[2]) if usable is None else picture[usable]
    return sum(scaled_variances(pixels)) // max(len(pixels), 1) ** 2


def principal_axes(covariance: Array, count: int) -> tuple[float, Array]:
    """Return the sum of the variances along the `count` strongest axes of a covariance, and these axes (count, C).

    Libraries return eigenvectors of equal eigenvalues in any order, and each in either direction. Therefore a small
    ramp is added to the diagonal, and the signs are chosen so that the largest entry of each axis is positive.
    """
    ramp = 1e-5 * max(float(np.trace(covariance)) / len(covariance), 1e-9)
    values, vectors = np.linalg.eigh(covariance + np.diag(ramp * np.arange(len(covariance))))
    axes = vectors[:, ::-1].T[:count]
    signs = np.sign(axes[np.arange(count), np.abs(axes).argmax(axis=1)])
    return float(values[::-1][:count].sum()), axes * signs[:, None]


def nearest(usable: Mask) -> NDArray[np.intp] | None:
    """Return row and column of the nearest usable pixel of every pixel, (2, H, W); None if all are usable."""
    if usable.all():
        return None
    return np.asarray(ndimage.distance_transform_edt(~usable, return_distances=False, return_indices=True), np.intp)


def valid_windows(shape: tuple[int, ...], usable: Mask | None, toroidal: bool, patch: Pair) -> Mask:
    """Return a mask of the first pixels of windows of `patch` px inside a picture that hold usable pixels only.

    `shape`: of the picture, which a toroidal exemplar exceeds by `patch` - 1; `usable`: of the exemplar.
    """
    rows, columns = shape[0] - patch[0] + 1, shape[1] - patch[1] + 1
    if rows < 1 or columns < 1:
        return np.zeros((max(rows, 0), max(columns, 0)), bool)
    if usable is None:
        return np.ones((rows, columns), bool)
    if toroidal:
        usable = np.pad(usable, ((0, patch[0] - 1), (0, patch[1] - 1)), mode="wrap")
    return np.asarray(window_sums(~usable, patch) == 0)


def without_patch(patch: Pair) -> MethodError:
    """Return the exception which says that no patch of (rows, columns) px is free of masked pixels."""
    return MethodError(
        f"no {patch[1]}x{patch[0]} px patch of the exemplar is free of masked pixels; "
        "choose a smaller patch, or mask less."
    )


def running_sums(values: Array, kind: Any = np.int64) -> Array:
    """Return the summed-area table of a picture (H, W, ...), of shape (H + 1, W + 1, ...) and dtype `kind`."""
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1, *values.shape[2:]), kind)
    np.cumsum(np.cumsum(values, axis=0, dtype=kind), axis=1, out=total[1:, 1:])
    return total


def window_sums(values: Array, size: Pair, kind: Any = np.int64) -> Array:
    """Return the sums over all windows of (rows, columns) inside a picture (H, W), indexed by their first pixels."""
    (h, w), total = size, running_sums(values, kind)
    return np.asarray(total[h:, w:] - total[:-h, w:] - total[h:, :-w] + total[:-h, :-w])
