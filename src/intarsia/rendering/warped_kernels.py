"""Kernels of drawing maps whose pieces are scaled, rotated or warped: interpolated reading.

The map pixel at p is read at u = S(p), which includes its fraction of a pixel, with any matrix J.

A *reading* of the exemplar at a position u is a short list of pixels and weights: 4 x 4 by Catmull-Rom (Catmull and Rom
1974; Keys 1981, a = -1/2), 2 x 2 bilinear over the usable ones if one of these is masked. If a step of
one px in the output is longer than one px in the exemplar, several readings spread over the pixel's footprint are
averaged. Sums are of differences to the first pixel read, so that uniform areas stay exact.

Colours and data are read by Catmull-Rom, colours in linear light with opacity premultiplied, and clamped to the range
of the pixels read; normals too, then turned by the frame and normalised; labels are those of the nearest pixel. A
masked pixel is never read: if all around are masked, the map pixel's own source is read. If a position falls on a
pixel, and the frame is an isometry or none, the copy is exact. Such pieces are not blended: there is no feather.
"""

from __future__ import annotations

from math import ceil, floor, sqrt
from typing import NamedTuple

import numpy as np

from ..foundation.arrays import Array, Floats, Int32, Int64, Mask, Pair, UInt8
from ..kernels.jit import kernel
from ..kernels.maps import J
from .vote_kernels import Reach

MOST = 4
"""Largest number of readings along each axis of a footprint."""

SLACK = 1 / 64
"""Px: steps longer than one px by at most this count as one px, such as those of a rotation."""


@kernel
def exemplar_of(table: Int64, which: int) -> tuple[int, int, int, int]:
    """Return the number of an exemplar's first pixel, its height, its width, and 1 if it is toroidal.

    They are numbers, as views of the table would be reference counted.
    """
    return table[which, 0], table[which, 1], table[which, 2], table[which, 3]


@kernel
def _pixel(row: tuple[int, int, int, int], y: int, x: int) -> int:
    """Return the index of a pixel; beyond the border that of the nearest one, or modulo the sides of a torus."""
    height, width = row[1], row[2]
    if not (0 <= y < height and 0 <= x < width):
        if row[3] != 0:
            y, x = y % height, x % width
        else:
            y, x = min(max(y, 0), height - 1), min(max(x, 0), width - 1)
    number: int = row[0] + y * width + x
    return number


@kernel
def nearest_pixel(row: tuple[int, int, int, int], free: Mask, uy: float, ux: float, own: Pair) -> int:
    """Return the index of the pixel nearest to a position; if it is masked, that of the pixel `own` (row, column)."""
    k = _pixel(row, floor(uy + 0.5), floor(ux + 0.5))
    return _pixel(row, own[0], own[1]) if free.size > 0 and not free[k] else k


@kernel
def _cubic(f: float, w: Array, begin: int) -> None:
    w[2, begin] = ((1.0 - 0.5 * f) * f - 0.5) * f
    w[2, begin + 1] = (1.5 * f - 2.5) * f * f + 1.0
    w[2, begin + 2] = ((2.0 - 1.5 * f) * f + 0.5) * f
    w[2, begin + 3] = (0.5 * f - 0.5) * f * f


@kernel
def taps(
    row: tuple[int, int, int, int], free: Mask, uy: float, ux: float, at: Int64, w: Array
) -> int:
    """List the pixels of a reading, at most 16, their weights in w[0], and the bilinear weights of the 2 x 2 in w[1].

    Return how many; 0 if all four around are masked. `free` as in :class:`Reach`; w[2] is scratch space.
    """
    y, x = floor(uy), floor(ux)
    fy, fx = uy - y, ux - x
    _cubic(fy, w, 0)
    _cubic(fx, w, 4)
    n, smooth, total = 0, True, 0.0
    for i in range(4):
        for k in range(4):
            weight = w[2, i] * w[2, 4 + k]
            if w[2, i] == 0.0 or w[2, 4 + k] == 0.0:
                continue
            at[n] = _pixel(row, y + i - 1, x + k - 1)
            if free.size > 0 and not free[at[n]]:
                smooth = False
                continue
            w[0, n], w[1, n] = weight, 0.0
            if 1 <= i <= 2 and 1 <= k <= 2:
                w[1, n] = (fy if i == 2 else 1.0 - fy) * (fx if k == 2 else 1.0 - fx)
                total += w[1, n]
            n += 1
    if smooth:
        return n
    kept = 0
    for k in range(n):
        if w[1, k] > 0.0:
            at[kept] = at[k]
            w[0, kept] = w[1, kept] = w[1, k] / total
            kept += 1
    return kept


@kernel
def footprint(down: float, across: float) -> tuple[int, float]:
    """Return the number of readings along an axis, and the part of its step (down, across) over which they spread.

    One reading if a step of the output is at most one px of the exemplar. For longer steps the part increases from 0 to
    1 at two px, so that sharpness changes continuously; there are at most MOST readings.
    """
    length = sqrt(down * down + across * across)
    if length <= 1.0 + SLACK:
        return 1, 0.0
    return min(ceil(length - SLACK), MOST), min(1.0, 2.0 - 2.0 / length)


class Part(NamedTuple):
    """A cell of the map, in px of the plane, as `cut_window` writes it."""

    yx: Int32  # (h, w, 2): the source pixel
    which: UInt8  # (h, w): the exemplar
    pose: UInt8  # (h, w): the isometry
    at: Floats  # (h, w, 2): the position in the exemplar
    j: Floats  # (h, w, 4): the frame, as the rows of J


@kernel
def read_pixel(
    part: Part, reach: Reach, y: int, x: int, k: int, prints: tuple[int, float, int, float], at: Int64, w: Array
) -> int:
    """List the pixels and weights of reading `k` of pixel (y, x) of a cell as :func:`taps` does; return how many.

    `prints`: the footprints along both axes. The nearest pixel, where all around are masked.
    """
    row, u, v = exemplar_of(reach.table, part.which[y, x]), part.at[y, x, 0], part.at[y, x, 1]
    jyy, jyx, jxy, jxx = part.j[y, x, 0], part.j[y, x, 1], part.j[y, x, 2], part.j[y, x, 3]
    ny, sy, nx, sx = prints
    oy, ox = ((k // nx + 0.5) / ny - 0.5) * sy, ((k % nx + 0.5) / nx - 0.5) * sx
    n = taps(row, reach.free, u + (jyy * oy + jyx * ox), v + (jxy * oy + jxx * ox), at, w)
    if n == 0:
        at[0] = nearest_pixel(row, reach.free, u, v, (part.yx[y, x, 0], part.yx[y, x, 1]))
        w[0, 0], w[1, 0], n = 1.0, 1.0, 1
    return n


@kernel
def footprints(part: Part, y: int, x: int) -> tuple[int, float, int, float]:
    """Return :func:`footprint` along both axes at a pixel of a cell."""
    j = part.j[y, x]
    ny, sy = footprint(j[0], j[2])
    nx, sx = footprint(j[1], j[3])
    return ny, sy, nx, sx


@kernel
def read_light(part: Part, reach: Reach, light: Array, alpha: bool, first: Int64, away: Floats) -> None:
    """Write the light of every pixel of a cell less that of the first pixel read, `first` (h, w), into `away`.

    ``away`` (h, w, C). With `alpha` colours are weighted by opacity, where there is any.
    """
    at, w, added = np.empty(16, np.int64), np.empty((3, 16)), np.zeros((2, light.shape[1]))
    last = light.shape[1] - 1
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            opaque, prints = 0.0, footprints(part, y, x)
            added[:] = 0.0
            for k in range(prints[0] * prints[2]):
                n = read_pixel(part, reach, y, x, k, prints, at, w)
                if k == 0:
                    first[y, x] = at[0]
                opaque += _add(light, alpha, at, n, w, 1.0 / (prints[0] * prints[2]), first[y, x], added)
            for c in range(last + 1):
                away[y, x, c] = added[0, c] / opaque if c < last and opaque > 0.0 else added[1, c]


@kernel
def _add(
    light: Array, alpha: bool, at: Int64, n: int, w: Array, share: float, first: int, added: Array
) -> float:
    """Add a reading of `n` pixels, clamped to their range; return its opacity.

    ``added`` (2, C): sums weighted by opacity, and not.

    Without clamping, the overshoot of Catmull-Rom in linear light gives dark stones black rims next to bright ones. If
    opacity varies, colours are read bilinearly, as negative weights give false colours where opacity is small.
    """
    last, mixed, opaque = light.shape[1] - 1, False, 0.0
    if alpha:
        for k in range(1, n):
            mixed = mixed or light[at[k], last] != light[at[0], last]
        for k in range(n):
            opaque += share * w[1 if mixed else 0, k] * max(np.float64(light[at[k], last]), 0.0)
    for c in range(last + 1):
        line = 1 if mixed and c < last else 0
        value, low, high, part = 0.0, np.inf, -np.inf, 0.0
        for k in range(n):
            away = np.float64(light[at[k], c]) - np.float64(light[first, c])
            low, high = min(low, away), max(high, away)
            value += w[line, k] * away
            if mixed:
                part += w[1, k] * max(np.float64(light[at[k], last]), 0.0) * away
        value = min(max(value, low), high)
        added[1, c] += share * value
        if alpha and c < last:
            added[0, c] += share * part if mixed else opaque * value
    return opaque


@kernel
def _pose_of(j: Floats) -> int:
    """Return the number of the isometry that a frame equals, or -1."""
    for p in range(8):
        if j[0] == J[p, 0] and j[1] == J[p, 1] and j[2] == J[p, 2] and j[3] == J[p, 3]:
            return p
    return -1


@kernel
def _turn(j: Floats, cross: int, keep: bool, v: Floats) -> None:
    """Turn a vector with its piece: n_yx' = J^T n_yx; `cross` is -1 if green is up, else 1.

    Its length is restored, so that scaling does not change the weight of a vote; not if `keep`, for isometries.
    """
    x, y = v[0], v[1]
    v[0], v[1] = j[3] * x + cross * j[1] * y, j[0] * y + cross * j[2] * x
    if not keep:
        before, after = (x * x + y * y) + v[2] * v[2], (v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]
        if after > 0.0:
            ratio = sqrt(before / after)
            v[0] *= ratio
            v[1] *= ratio
            v[2] *= ratio


@kernel
def read_vectors(part: Part, reach: Reach, vectors: Array, cross: int, first: Int64, out: Floats) -> None:
    """Write the vector read for every pixel of a cell, turned with its piece, into `out` (h, w, 3).

    Zeros where it is a copy, turned by an isometry. `first` (h, w): 8 times the first pixel read, and its isometry.
    """
    at, w, away, v = np.empty(16, np.int64), np.empty((3, 16)), np.zeros(3), np.empty(3)
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            prints, lead, equal = footprints(part, y, x), -1, True
            away[:] = 0.0
            for k in range(prints[0] * prints[2]):
                n = read_pixel(part, reach, y, x, k, prints, at, w)
                lead = at[0] if lead < 0 else lead
                for i in range(n):
                    for c in range(3):
                        step = np.float64(vectors[at[i], c]) - np.float64(vectors[lead, c])
                        equal = equal and step == 0.0
                        away[c] += w[0, i] * step
            for c in range(3):
                v[c] = np.float64(vectors[lead, c]) + away[c] / (prints[0] * prints[2])
            pose = _pose_of(part.j[y, x])
            _turn(part.j[y, x], cross, pose >= 0, v)
            first[y, x] = 8 * lead + max(pose, 0)
            for c in range(3):
                out[y, x, c] = 0.0 if equal and pose >= 0 else v[c]


@kernel
def read_labels(part: Part, reach: Reach, ranks: Int32, out: Int32) -> None:
    """Write the label of every pixel of a cell: that of the nearest pixel."""
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            row, own = exemplar_of(reach.table, part.which[y, x]), (part.yx[y, x, 0], part.yx[y, x, 1])
            out[y, x] = ranks[nearest_pixel(row, reach.free, part.at[y, x, 0], part.at[y, x, 1], own)]
