"""Seam costs of a map (Kwatra et al. 2003, eq. 1 and 3): pieces are continued in their exemplar beyond each seam.

The pixels of all variants (exemplars in their isometries) are numbered consecutively. `grown` is the map, a
:class:`~intarsia.kernels.maps.PartialMap`; `price` a :class:`~intarsia.kernels.cuts.SeamPrice`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int16, Int64, Mask, UInt8
from ..kernels.cuts import FLAT, GRADIENT_UNIT, truncated_quadratic
from ..kernels.jit import kernel
from ..kernels.maps import HOLE, canvas_place

TWICE = 8  # bits by which a product with two visibilities is shifted: 2 ** 8 is twice FULL, the visibility 1


class Pieces(NamedTuple):
    """The posed exemplars of a map, end to end, and which of their pixels may be used."""

    flat: Int16  # (pixels * channels,): features, pixel by pixel
    table: Int64  # (V, 4): where each begins in `flat`, height, width and stride, px
    usable: UInt8  # (pixels,): 1 where a pixel may be shown
    torus: Mask  # (V,): whether the exemplar is toroidal
    channels: int  # that seam costs compare
    visible: Int16  # (pixels,): visibility, the weight of a difference at each pixel, in 1/128


@kernel
def feature_distance(flat: Any, channels: int, a: int, b: int) -> int:
    """Return the Euclidean distance of the features of two pixels of `flat`, rounded up.

    Rounded up, distances keep the triangle inequality; a and b are numbers of pixels.
    """
    total = 0
    for c in range(channels):
        difference = int(flat[a * channels + c]) - int(flat[b * channels + c])
        total += difference * difference
    if total == 0:
        return 0
    root = int(np.sqrt(np.float64(total)))
    return root + 1 if root * root < total else root


@kernel
def seen_distance(pieces: Any, a: int, b: int) -> int:
    """Return the feature distance of two pixels, weighted by their visibility (`analysis/contrast_masking.py`)."""
    visible = np.int64(pieces.visible[a]) + np.int64(pieces.visible[b])
    return int(feature_distance(pieces.flat, pieces.channels, a, b) * visible >> TWICE)


@kernel
def spot(pieces: Any, v: int, y: int, x: int) -> int:
    """Return the number of pixel (y, x) of variant `v`, -1 where there is none or it is not usable."""
    table = pieces.table
    rows, columns = table[v, 1], table[v, 2]
    if not (0 <= y < rows and 0 <= x < columns):
        if not pieces.torus[v]:
            return -1
        y, x = y % rows, x % columns
    at = table[v, 0] // pieces.channels + y * table[v, 3] + x
    if not pieces.usable[at]:
        at = -1
    found: int = at
    return found


@kernel
def meeting(pieces: Any, a: Any, b: Any, price: Any) -> int:
    """Return the cost of a seam between piece `a` at one pixel and piece `b` at the next.

    `a` and `b` are pairs of pixel numbers: what each piece shows, or would show, at the one and at the next place. The
    cost is the sum of their distances at both places (Kwatra et al. 2003, eq. 1). With ``price.gradient`` it is
    multiplied by GRADIENT_UNIT and divided by FLAT plus the change of both pieces from one place to the next (eq. 3),
    rounded down; with a positive ``price.threshold`` it is the :func:`truncated_quadratic`.
    """
    flat, channels = pieces.flat, pieces.channels
    cost = seen_distance(pieces, a[0], b[0]) + seen_distance(pieces, a[1], b[1])
    if price.threshold > 0:
        return int(truncated_quadratic(cost, price.threshold))
    if price.gradient and cost > 0:
        change = feature_distance(flat, channels, a[0], a[1]) + feature_distance(flat, channels, b[0], b[1])
        cost = cost * GRADIENT_UNIT // (FLAT + change)
    return cost


@kernel
def source_at(grown: Any, pieces: Any, y: int, x: int) -> int:
    """Return the number of the pixel that the map shows at a place of the canvas, -1 in holes."""
    v, table = grown.variant[y, x], pieces.table
    if v == HOLE:
        return -1
    at: int = table[v, 0] // pieces.channels + grown.yx[y, x, 0] * table[v, 3] + grown.yx[y, x, 1]
    return at


@kernel
def beyond(pieces: Any, shown: Any, way: Any, here: Any) -> Any:
    """Return the number of the pixel that continues the piece at pixel `here`.

    `here` itself where the exemplar ends, -1 in holes.

    `shown`: variant, row and column of `here`; `way`: the displacement in rows and columns.
    """
    found = np.int64(-1)
    if here >= 0:
        found = np.int64(spot(pieces, shown[0], shown[1] + way[0], shown[2] + way[1]))
    return found if found >= 0 else here


@kernel
def seam_prices(grown: Any, pieces: Any, box: Any, price: Any, prices: Any) -> None:
    """Write into `prices` (H, W, 2) the seam cost between each pixel of a box and its right and lower neighbour.

    `box`: first row, first column, rows and columns; it may extend over borders. 0 where the piece continues, next to
    holes, and at borders that do not wrap.
    """
    variant, yx, wrap = grown
    height, width = variant.shape
    columns = np.empty(box[3] + 1, np.int64)
    for j in range(box[3] + 1):
        columns[j] = canvas_place(box[1] + j, width, wrap[1])
    for i in range(box[2]):
        y, below = canvas_place(box[0] + i, height, wrap[0]), canvas_place(box[0] + i + 1, height, wrap[0])
        for j in range(box[3] if y >= 0 else 0):
            x, right = columns[j], columns[j + 1]
            if x < 0:
                continue
            v, row, column, here = variant[y, x], yx[y, x, 0], yx[y, x, 1], -1
            prices[y, x, 0], prices[y, x, 1] = 0, 0
            for k in range(2 if v != HOLE else 0):
                ny, nx = (below, x) if k else (y, right)
                if ny < 0 or nx < 0 or variant[ny, nx] == HOLE:
                    continue
                if v == variant[ny, nx] and row + k == yx[ny, nx, 0] and column + 1 - k == yx[ny, nx, 1]:
                    continue
                here = source_at(grown, pieces, y, x) if here < 0 else here
                there = source_at(grown, pieces, ny, nx)
                on = beyond(pieces, (v, row, column), (k, 1 - k), here)
                if on == there:
                    continue
                back = beyond(pieces, (variant[ny, nx], yx[ny, nx, 0], yx[ny, nx, 1]), (-k, k - 1), there)
                prices[y, x, k] = meeting(pieces, (here, on), (back, there), price)
