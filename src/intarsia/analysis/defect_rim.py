"""Detection of remains of a defect at the edge of the hole that should remove it, as outliers of pixel values.

A mask drawn a little too small leaves a rim: pixels at the edge of the hole whose values are rare elsewhere in the
picture. They are found by their values alone (channels, their differences, and their range within 3x3
px), so a rim that looks like other parts of the picture is not found.
"""

from __future__ import annotations

import numpy as np

from ..foundation import ndimage
from ..foundation.arrays import Array, Int16, Mask

# Halved and doubled on 24 textures with painted and darkened discs: of 288 rims of 2 to 9 px 167 are seen and covered,
# by 6 px too many, and none is reported at 96 holes without a defect.
REACH = 24  # px around holes where a rim may lie; what goes on beyond is part of the picture; halved: 117, doubled: 170
RARE = 0.0002  # share of the pixels elsewhere beyond these values, at either end; a tenth: 160, tenfold: 184
UNUSUAL = 0.002  # and beyond these, so near; halved: 172, by 5 px too many, doubled: 154, by 9, tenfold: 7
LEAST = 30  # px of a rim; halved: 171, doubled: 164
TIMES = 2  # as many px as in the largest spot of rare values elsewhere; 0: 171, doubled: 164
TOUCHING = 4  # px of a rim that lie at the hole; 1: 168, 16: 163
ELSEWHERE = 0.2  # of the picture must lie beyond the reach: what is usual must be known; 0 to 0.4: the same, 0.8: 156
GAP = 2  # px: what lies so close to a rim belongs to it: soft edges; 0: 172, by 3 px too many, 4: 143
MARGIN = 2  # px that are covered besides; halved: 166, doubled: 167, by 8 px too many
FAR_UP = 1 << 20  # above any feature


def defect_rim(picture: Int16, hole: Mask, usable: Mask | None = None) -> int:
    """Return by how many px a hole must grow to cover a rim of the defect; 0 if none is found.

    `picture` (H, W, C) features; `hole` (H, W), True where it is filled; `usable` (H, W): pixels to compare with.
    """
    depth = ndimage.distance_transform_cdt(~hole, metric="chessboard")
    rest = depth > REACH
    if usable is not None and usable.any():
        rest &= usable
    if np.count_nonzero(rest) < ELSEWHERE * rest.size:
        return 0
    measures = _measures(picture, hole)
    spots, count = ndimage.label(_beyond(measures, rest, RARE) & ~hole, np.ones((3, 3)))
    size = np.bincount(spots.ravel(), minlength=count + 1)
    touching = np.bincount(spots[depth == 1], minlength=count + 1)
    elsewhere = size[1:][touching[1:] == 0].max(initial=0)
    found = np.flatnonzero((size >= max(LEAST, TIMES * elsewhere)) & (touching >= TOUCHING))
    found = found[found > 0]
    if not len(found):
        return 0
    rim = np.isin(spots, found)
    unusual = rim | (_beyond(measures, rest, UNUSUAL) & ~hole)  # what lies within GAP px of a rim is part of it
    pieces, _ = ndimage.label(ndimage.maximum_filter(unusual, 2 * (GAP // 2) + 1), np.ones((3, 3)))
    deepest = int(depth[np.isin(pieces, np.unique(pieces[rim])) & unusual].max())
    return deepest + MARGIN if deepest < REACH else 0  # what extends beyond the reach is no rim


def _measures(picture: Int16, hole: Mask) -> list[Array]:
    """Return the measures of pixels: channels, differences of the first three, range of the sum in 3x3 px."""
    channels = [picture[:, :, c].astype(np.int32) for c in range(picture.shape[2])]
    total = np.sum(channels, axis=0, dtype=np.int32)
    high = ndimage.maximum_filter(np.where(hole, -FAR_UP, total), 3)
    low = ndimage.minimum_filter(np.where(hole, FAR_UP, total), 3)
    differences = [channels[0] - channels[2], channels[0] + channels[2] - 2 * channels[1]] if len(channels) > 2 else []
    return [*channels, *differences, high - low]


def _beyond(measures: list[Array], rest: Mask, share: float) -> Mask:
    """Return which pixels have values beyond all but a `share` of those elsewhere."""
    out = np.zeros(rest.shape, bool)
    for values in measures:
        there = values[rest]
        last = there.size - 1
        low, high = int(share * last), last - int(share * last)
        there.partition((low, high))
        out |= (values < there[low]) | (values > there[high])
    return out
