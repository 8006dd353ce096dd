"""Detection of remains of a defect at the edge of the hole that should remove it, as outliers of pixel values.

A mask drawn a little too small leaves a rim of the defect: pixels at the edge of the hole whose values are rare in the
rest of the picture. They are found by their values alone (channels, differences of channels, and the range of their sum
within 3x3 px), so a rim that looks like other parts of the picture is not found.
"""

from __future__ import annotations

import numpy as np

from ..foundation import ndimage
from ..foundation.arrays import Array, Int16, Mask

# Measured on 24 textures with painted and darkened discs: of 288 rims of 2 to 9 px width 167 are found and covered, on
# average by 6 px more than needed, and none is reported at 96 holes without a defect. Numbers of rims covered with
# other values, and the excess where it differs:
REACH = 24  # px around holes within which a rim is searched; what extends farther is no rim; halved: 117, doubled: 170
RARE = 0.0002  # share of the other pixels beyond a rare value, at either end; a tenth: 160, tenfold: 184
UNUSUAL = 0.002  # the same of pixels that count if they adjoin a rim; halved: 172, 5 px, doubled: 154, 9 px; x10: 7
LEAST = 30  # px: smallest area of a rim; halved: 171, doubled: 164
TIMES = 2  # smallest area relative to the largest spot of rare values not at the hole; 0: 171, doubled: 164
TOUCHING = 4  # pixels of a rim that must adjoin the hole; 1: 168, 16: 163
ELSEWHERE = 0.2  # share of the picture beyond REACH that is needed to know common values; 0 to 0.4: same, 0.8: 156
GAP = 2  # px: unusual pixels this near to a rim belong to it, as at soft edges; 0: 172, 3 px, 4: 143
MARGIN = 2  # px added to the depth of the rim; halved: 166, doubled: 167, 8 px
FAR_UP = 1 << 20  # above any feature


def defect_rim(picture: Int16, hole: Mask, usable: Mask | None = None) -> int:
    """Return by how many px a hole must grow to cover a rim of the defect; 0 if none is found.

    `picture` (H, W, C): features; `hole` (H, W): True where pixels are to be filled; `usable` (H, W): pixels whose
    values count as common.
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
    """Return measures of pixels, (H, W) each: channels, differences of the first three, range of the sum in 3x3 px."""
    channels = [picture[:, :, c].astype(np.int32) for c in range(picture.shape[2])]
    total = np.sum(channels, axis=0, dtype=np.int32)
    high = ndimage.maximum_filter(np.where(hole, -FAR_UP, total), 3)
    low = ndimage.minimum_filter(np.where(hole, FAR_UP, total), 3)
    differences = [channels[0] - channels[2], channels[0] + channels[2] - 2 * channels[1]] if len(channels) > 2 else []
    return [*channels, *differences, high - low]


def _beyond(measures: list[Array], rest: Mask, share: float) -> Mask:
    """Return which pixels lie outside the quantiles `share` and 1 - `share` of the pixels in `rest`, by any measure."""
    out = np.zeros(rest.shape, bool)
    for values in measures:
        there = values[rest]
        last = there.size - 1
        low, high = int(share * last), last - int(share * last)
        there.partition((low, high))
        out |= (values < there[low]) | (values > there[high])
    return out
