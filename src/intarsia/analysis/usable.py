"""Which pixels of an exemplar may be used, where windows of them lie, and where the nearest of them are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import MethodError
from ..lazy import ndimage
from .sums import window_sums

Mask = NDArray[np.bool_]


def nearest(usable: Mask) -> NDArray[np.intp] | None:
    """For every pixel the nearest usable one (2, H, W); None where all are usable."""
    if usable.all():
        return None
    return np.asarray(ndimage.distance_transform_edt(~usable, return_distances=False, return_indices=True), np.intp)


def valid_windows(shape: tuple[int, ...], usable: Mask | None, toroidal: bool, patch: tuple[int, int]) -> Mask:
    """Where windows of the patch size lie inside the picture and hold usable pixels only."""
    rows, columns = shape[0] - patch[0] + 1, shape[1] - patch[1] + 1
    if rows < 1 or columns < 1:
        return np.zeros((max(rows, 0), max(columns, 0)), bool)
    if usable is None:
        return np.ones((rows, columns), bool)
    if toroidal:
        usable = np.pad(usable, ((0, patch[0] - 1), (0, patch[1] - 1)), mode="wrap")
    return np.asarray(window_sums(~usable, patch) == 0)


def without_patch(patch: tuple[int, int]) -> MethodError:
    """Say that no patch of (rows, columns) px is free of masked pixels."""
    return MethodError(
        f"no {patch[1]}x{patch[0]} px patch of the exemplar is free of masked pixels; "
        "choose a smaller patch, or mask less."
    )
