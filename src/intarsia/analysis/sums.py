"""Sums over windows of a picture, by running sums: each costs four readings, however large the window."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def running_sums(values: Array, kind: Any = np.int64) -> Array:
    """Return the sums above and to the left of every corner of pixels: (H, W, ...) -> (H + 1, W + 1, ...) of a kind."""
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1, *values.shape[2:]), kind)
    np.cumsum(np.cumsum(values, axis=0, dtype=kind), axis=1, out=total[1:, 1:])
    return total


def window_sums(values: Array, size: tuple[int, int], kind: Any = np.int64) -> Array:
    """Return the sums over all windows of (rows, columns) that lie inside a picture (H, W): by their first pixels."""
    (h, w), total = size, running_sums(values, kind)
    return np.asarray(total[h:, w:] - total[:-h, w:] - total[h:, :-w] + total[:-h, :-w])


def moving_sums(values: Array, axis: int, radius: int, mode: Literal["constant", "symmetric", "wrap"]) -> Array:
    """Return the sums over 2 radius + 1 px around every pixel along an axis, beyond whose ends `mode` pads."""
    pad = [(radius + 1, radius) if a == axis else (0, 0) for a in range(values.ndim)]
    sums = np.moveaxis(np.cumsum(np.pad(values, pad, mode=mode), axis=axis), axis, 0)
    return np.moveaxis(sums[2 * radius + 1 :] - sums[: values.shape[axis]], 0, axis)
