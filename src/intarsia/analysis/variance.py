"""How much colours or pixels vary, and along which directions most."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def spreads(vectors: Array) -> list[int]:
    """Return n**2 times the variance of every channel of whole numbers (n, C): whole, so the same on every machine."""
    return [len(vectors) * int((c * c).sum()) - int(c.sum()) ** 2 for c in vectors.astype(np.int64, copy=False).T]


def variance(picture: Array, usable: Array | None = None) -> int:
    """Return the sum of the variances of all channels of a picture (H, W, C) over its usable pixels, rounded down."""
    pixels = picture.reshape(-1, picture.shape[2]) if usable is None else picture[usable]
    return sum(spreads(pixels)) // max(len(pixels), 1) ** 2


def principal_axes(covariance: Array, count: int) -> tuple[float, Array]:
    """Return the variance along the `count` strongest axes, and the axes (count, C), the same on every machine.

    Libraries return the axes of equal variances in any order, and each axis in either direction. Therefore a small ramp
    on the diagonal parts equal variances, and each axis is turned so that its largest entry is positive.
    """
    ramp = 1e-5 * max(float(np.trace(covariance)) / len(covariance), 1e-9)
    values, vectors = np.linalg.eigh(covariance + np.diag(ramp * np.arange(len(covariance))))
    axes = vectors[:, ::-1].T[:count]
    signs = np.sign(axes[np.arange(count), np.abs(axes).argmax(axis=1)])
    return float(values[::-1][:count].sum()), axes * signs[:, None]
