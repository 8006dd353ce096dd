"""Which pixels of an exemplar may be used, and where the nearest of them are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt


def nearest(usable: NDArray[np.bool_]) -> NDArray[np.intp] | None:
    """For every pixel the nearest usable one (2, H, W); None where all are usable."""
    if usable.all():
        return None
    return np.asarray(distance_transform_edt(~usable, return_distances=False, return_indices=True), np.intp)
