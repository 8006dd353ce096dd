"""Contrast masking: the visibility of a step at every pixel, by the local contrast that hides it.

The detection threshold of a contrast rises with the contrast around it (Legge and Foley, "Contrast masking in human
vision", J. Opt. Soc. Am. 70, 1980). A seam that is invisible in gravel is visible in a cloud, or on a smooth stone.
"""

from __future__ import annotations

import numpy as np

from ..foundation.arrays import Int16, Mask
from ..foundation.filters import moving_sums

FULL = 128  # the weight 1, where neighbours differ on average by the threshold (knee) of seam costs
MOST = 2  # weights are the root of the threshold over that difference, limited to 1 / MOST .. MOST
RADIUS = 2  # px: the mean is taken over squares of 2 * RADIUS + 1 px around every pixel


def visibility(picture: Int16, knee: int, usable: Mask | None = None, toroidal: bool = False) -> Int16:
    """Return the weight of a feature difference at every pixel of an exemplar: less where local contrast is high.

    `knee`: threshold of the truncated quadratic seam cost, in units of the features. Other arguments as for
    :func:`intarsia.analysis.saliency.saliency_map`.

    Returns
    -------
    int16 array, shape (H, W)
        In 1/128: from 64, at high local contrast, to 256, at none.
    """
    counts = np.ones(picture.shape[:2], bool) if usable is None else usable
    planes = np.moveaxis(picture.astype(np.int64), 2, 0)
    found = np.zeros((2, *counts.shape), np.int64)  # sums of differences at every pixel, and numbers of pairs
    for axis in range(2):
        both = counts & np.roll(counts, -1, axis)
        if not toroidal:
            np.moveaxis(both, axis, 0)[-1] = False
        squares = sum((plane - np.roll(plane, -1, axis)) ** 2 for plane in planes)
        pairs = np.stack([np.sqrt(squares).astype(np.int64) * both, both])
        found += pairs + np.roll(pairs, 1, axis + 1)
    for axis in (1, 2):
        found = moving_sums(found, axis, RADIUS, "wrap" if toroidal else "constant")
    times = np.clip(np.sqrt(knee * found[1] / np.maximum(found[0], 1)), 1 / MOST, MOST)
    return np.asarray(FULL * times, np.int16)
