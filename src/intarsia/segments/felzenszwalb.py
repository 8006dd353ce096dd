"""Graph-based image segmentation of Felzenszwalb and Huttenlocher.

Felzenszwalb and Huttenlocher, "Efficient Graph-Based Image Segmentation", IJCV 2004, which the segment-based
fragments (docs/sources-003.md) name.
Colours are whole numbers, edges are sorted stably and by whole weights: ties end the same way on every machine.
"""

from __future__ import annotations

import math

import numpy as np

from ..analysis import scaled_variances
from ..foundation import ndimage
from ..foundation.arrays import Array, Int32, Mask
from .felzenszwalb_kernels import join_edges

# Halved and doubled on 24 textures (docs/design/012): how many sizes of elements differ by a tenth.
DEVIATION = 256  # steps of an even colour for each standard deviation of a channel: a unit; either way 11, by rounding
FAINT = 0.35  # a channel with less than this share of the strongest contrast is not lifted to it; 3 and 8
LEAST_PIXELS = 12  # smaller segments join a neighbour; 4 and 8; and smaller elements do not count; 3 and 8
NOWHERE = -1  # the segment of pixels that do not count


def even_colours(colours: Array, usable: Mask | None) -> Int32 | None:
    """Return colours in which every channel counts by its own contrast, 256 for a standard deviation.

    Pixels that do not count become 0, the mean. None where all colours are equal.
    """
    chosen = colours.reshape(-1, colours.shape[2]) if usable is None else colours[usable]
    n, total, spread = len(chosen), chosen.sum(axis=0, dtype=np.int64), scaled_variances(chosen)
    if not n or max(spread) == 0:
        return None
    deviation = np.array([math.sqrt(v) for v in spread])  # n times the standard deviation
    deviation = np.maximum(deviation, FAINT * deviation.max())
    even: Int32 = np.rint((colours.astype(np.int64) * n - total) / deviation * DEVIATION).astype(np.int32)
    if usable is not None:
        even[~usable] = 0
    return even


def smoothed(colours: Int32, passes: int) -> Int32:
    """Return colours blurred by (1, 2, 1) / 4 along both axes, `passes` times: a Gaussian of sigma sqrt(passes / 2)."""
    for axis in (0, 1) * passes:
        colours = (ndimage.correlate1d(colours, (1, 2, 1), axis, mode="nearest") + 2) >> 2
    return colours


class PixelGraph:
    """The edges between neighbouring pixels (8 of them) of a picture, lightest first.

    Parameters
    ----------
    colours : int32 array, shape (H, W, C)
        As :func:`even_colours` gives them; the weight of an edge is the distance of its two colours.
    usable : bool array, shape (H, W), optional
        No edge leads to a pixel that does not count.
    """

    def __init__(self, colours: Int32, usable: Mask | None = None) -> None:
        self.shape = height, width = colours.shape[:2]
        self.usable = usable
        number = np.arange(height * width, dtype=np.int32).reshape(height, width)
        first, second, weight = [], [], []
        for a, b in (
            (np.s_[:, :-1], np.s_[:, 1:]),
            (np.s_[:-1], np.s_[1:]),
            (np.s_[:-1, :-1], np.s_[1:, 1:]),
            (np.s_[:-1, 1:], np.s_[1:, :-1]),
        ):
            step = colours[a].astype(np.int64) - colours[b]
            distance = np.sqrt(np.einsum("ijk,ijk->ij", step, step).astype(np.float64))
            kept = np.s_[:] if usable is None else usable[a] & usable[b]
            first.append(number[a][kept].ravel())
            second.append(number[b][kept].ravel())
            weight.append(np.minimum(distance, 65535).astype(np.uint16)[kept].ravel())
        order = np.argsort(np.concatenate(weight), kind="stable")
        self.first, self.second, self.weight = (np.concatenate(p)[order] for p in (first, second, weight))

    def segments(self, slack: int, least: int = LEAST_PIXELS) -> Int32:
        """Return the number of the segment of every pixel, in raster order of first pixels; -1: does not count.

        `slack` is the source's k in steps of the colours: the larger, the larger the segments.
        """
        parent = np.empty(self.shape[0] * self.shape[1], np.int32)
        join_edges(self.first, self.second, self.weight, slack, least, parent)
        if self.usable is not None:
            parent[~self.usable.ravel()] = NOWHERE
        return numbered(parent).reshape(self.shape)


def numbered(names: Array) -> Int32:
    """Return names renumbered 0, 1, ... in their order; negative ones become -1."""
    found, number = np.unique(names, return_inverse=True)
    return np.asarray(np.maximum(number.reshape(names.shape) - np.count_nonzero(found < 0), NOWHERE), np.int32)
