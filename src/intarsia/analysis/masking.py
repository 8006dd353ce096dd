"""How plainly a step of tone is seen at every pixel: what changes there anyway hides it (contrast masking).

A contrast is seen beside another one only from a threshold on that rises with the other (Legge and Foley, "Contrast
masking in human vision", J. Opt. Soc. Am. 70, 1980). So a step that gravel hides parts a cloud, or a smooth stone.
"""

from __future__ import annotations

import numpy as np

from ..foundation.arrays import Int16, Mask
from ..foundation.filters import moving_sums

ONCE = 128  # a step counts as what it differs, where neighbours differ by a knee on average,
MOST = 2  # up to so many times and down to one so many-th of it, by the root of how much less or more they differ
RADIUS = 2  # px around every pixel in which changes hide a step


def visibility(picture: Int16, knee: int, usable: Mask | None = None, toroidal: bool = False) -> Int16:
    """Tell how much a difference counts at every pixel of an exemplar, by the changes from px to px around it.

    `knee`: of the price of seams, in units of the features. Other arguments as for
    :func:`intarsia.analysis.popout.popout`.

    Returns
    -------
    int16 array, shape (H, W)
        In 1/128: from 64, where all changes, to 256, where nothing does.
    """
    counts = np.ones(picture.shape[:2], bool) if usable is None else usable
    planes = np.moveaxis(picture.astype(np.int64), 2, 0)
    found = np.zeros((2, *counts.shape), np.int64)  # how much changes at every pixel, and in how many pairs
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
    return np.asarray(ONCE * times, np.int16)
