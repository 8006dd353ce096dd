"""Principal axes: the directions along which colours or pixels vary most."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def principal_axes(covariance: Array, count: int) -> tuple[float, Array]:
    """Return the variance along the `count` strongest axes, and the axes (count, C), the same on every machine.

    A ramp on the diagonal parts equal eigenvalues, and the largest entry of every axis is positive (DESIGN 4).
    """
    ramp = 1e-5 * max(float(np.trace(covariance)) / len(covariance), 1e-9)
    values, vectors = np.linalg.eigh(covariance + np.diag(ramp * np.arange(len(covariance))))
    axes = vectors[:, ::-1].T[:count]
    signs = np.sign(axes[np.arange(count), np.abs(axes).argmax(axis=1)])
    return float(values[::-1][:count].sum()), axes * signs[:, None]
