"""Kernels of blending by votes for maps whose pieces are scaled, rotated or warped: interpolated reading.

The map pixel at q votes for the pixel at p with u = S(q) + J(q) (p - q), as in ``render.py``; here S(q) includes its
fraction of a pixel, and J is any matrix.

A *reading* of the exemplar at a position u is a short list of pixels and weights: 4 x 4 by Catmull-Rom (Catmull and Rom
1974; Keys 1981, a = -1/2), 2 x 2 bilinear over the usable ones if one of these is masked. If a step of
one px in the output is longer than one px in the exemplar, several readings spread over the pixel's footprint are
averaged. Votes are added in raster order. Sums are of differences to the first pixel read, so that uniform areas stay
exact.

Colours and data are read by Catmull-Rom, colours in linear light with opacity premultiplied, and clamped to the range
of the pixels read; normals too, then turned by the frame and normalised; labels are those of the nearest pixel. A
masked pixel is never read: if all around are masked, the map pixel's own source is read. If a position falls on a
pixel, and the frame is an isometry or none, the copy is exact.
"""

from __future__ import annotations

from math import ceil, floor, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.arrays import Array, Floats, Int32, Int64, Mask, Pair, UInt8
from ..kernels.jit import kernel
from ..kernels.maps import HOLE, J
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
def share_of(row: tuple[int, int, int, int], near: NDArray[np.uint16], uy: float, ux: float) -> int:
    """Return the weight of a vote for a position: `near` of its nearest pixel, 0 outside of the exemplar."""
    y, x = floor(uy + 0.5), floor(ux + 0.5)
    if row[3] == 0 and not (0 <= y < row[1] and 0 <= x < row[2]):
        return 0
    return int(near[_pixel(row, y, x)])


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


ALIKE = 1 / 1024
"""Px of position, and entries of a frame, by which merged votes may differ; within a piece they differ by less."""

KEPT = 8
"""Number of first positions that later votes are compared with; in strongly warped fields few votes are merged."""


class Part(NamedTuple):
    """A cell of the map with a halo, in px of the plane, as `cut_window` writes it."""

    yx: Int32  # (h, w, 2): the source pixel
    which: UInt8  # (h, w): the exemplar
    pose: UInt8  # (h, w): the isometry
    at: Floats  # (h, w, 2): the position in the exemplar
    j: Floats  # (h, w, 4): the frame, as the rows of J

    def size(self, feather: int) -> Pair:
        """Height and width of the cell, without its halo."""
        return self.which.shape[0] - feather, self.which.shape[1] - feather


@kernel
def collect_votes(
    part: Part, reach: Reach, feather: int, y: int, x: int, places: Floats, votes: Int64
) -> int:
    """List the positions that the map pixels around pixel (y, x) of a cell vote for, in raster order; return how many.

    `places` (n, 2): positions; `votes` (n, 3): row and column of the map pixel, and its weight. Votes with equal
    position and frame are merged, if the earlier one is among the first KEPT.
    """
    n, f = 0, feather
    for qy in range(y, y + f + 1):
        for qx in range(x, x + f + 1):
            w = part.which[qy, qx]
            if w == HOLE:
                continue
            j = part.j[qy, qx]
            dy, dx = y + f // 2 - qy, x + f // 2 - qx
            uy = part.at[qy, qx, 0] + (j[0] * dy + j[1] * dx)
            ux = part.at[qy, qx, 1] + (j[2] * dy + j[3] * dx)
            vote = 1 if f == 0 else share_of(exemplar_of(reach.table, w), reach.near, uy, ux)
            if vote == 0:
                continue
            k = 0
            while k < min(n, KEPT):
                same = abs(places[k, 0] - uy) <= ALIKE and abs(places[k, 1] - ux) <= ALIKE
                if same and part.which[votes[k, 0], votes[k, 1]] == w and _alike(part.j[votes[k, 0], votes[k, 1]], j):
                    break
                k += 1
            if k < min(n, KEPT):
                votes[k, 2] += vote
                continue
            places[n, 0], places[n, 1] = uy, ux
            votes[n, 0], votes[n, 1], votes[n, 2] = qy, qx, vote
            n += 1
    return n


@kernel
def _alike(a: Floats, b: Floats) -> bool:
    away = max(max(abs(a[0] - b[0]), abs(a[1] - b[1])), max(abs(a[2] - b[2]), abs(a[3] - b[3])))
    return bool(away <= ALIKE)


@kernel
def read_light(
    part: Part, reach: Reach, feather: int, light: Array, alpha: bool,
    sums: tuple[Floats, Floats], first: Int64,
    weights: tuple[Floats, Floats],
) -> None:  # fmt: skip
    """Add up w (light - light of the first pixel read) for every pixel of a cell.

    `sums` (h, w, C) are weighted by opacity, and not; without `alpha` only the second are filled. `first` (h, w) is
    that pixel, -1 at the start; `weights` (h, w) are the sums of w times opacity, and of w.
    """
    at, w, added = np.empty(16, np.int64), np.empty((3, 16)), np.zeros((2, light.shape[1]))
    room, free = (feather + 1) * (feather + 1), reach.free
    places, votes = np.empty((room, 2)), np.empty((room, 3), np.int64)
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            base, opaque = -1, 0.0
            added[:] = 0.0
            if feather > 0:
                heard = collect_votes(part, reach, feather, y, x, places, votes)
            else:  # only the pixel's own vote: the same as above, faster
                heard = 1 if part.which[y, x] != HOLE else 0
                places[0, 0], places[0, 1] = part.at[y, x, 0], part.at[y, x, 1]
                votes[0, 0], votes[0, 1], votes[0, 2] = y, x, 1
            for vote in range(heard):
                qy, qx, count = votes[vote, 0], votes[vote, 1], votes[vote, 2]
                row, own = exemplar_of(reach.table, part.which[qy, qx]), (part.yx[qy, qx, 0], part.yx[qy, qx, 1])
                jyy, jyx, jxy, jxx = part.j[qy, qx, 0], part.j[qy, qx, 1], part.j[qy, qx, 2], part.j[qy, qx, 3]
                uy, ux = places[vote, 0], places[vote, 1]
                weights[1][y, x] += count
                (ny, sy), (nx, sx) = footprint(jyy, jxy), footprint(jyx, jxx)
                for k in range(ny * nx):
                    oy, ox = ((k // nx + 0.5) / ny - 0.5) * sy, ((k % nx + 0.5) / nx - 0.5) * sx
                    n = taps(row, free, uy + (jyy * oy + jyx * ox), ux + (jxy * oy + jxx * ox), at, w)
                    if n == 0:
                        at[0], w[0, 0], w[1, 0], n = nearest_pixel(row, free, uy, ux, own), 1.0, 1.0, 1
                    base = at[0] if base < 0 else base
                    opaque += _add(light, alpha, at, n, w, count / (ny * nx), base, added)
            first[y, x] = base
            weights[0][y, x] = opaque
            for c in range(light.shape[1]):
                sums[1][y, x, c] = added[1, c]
                if alpha:
                    sums[0][y, x, c] = added[0, c]


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
def _vector(
    row: tuple[int, int, int, int], reach: Reach, j: Floats, u: tuple[float, float], own: Pair,
    vectors: Array, read: Floats,
) -> tuple[int, bool]:  # fmt: skip
    """Read a vector (x, y, z) at a position; return the first pixel read, and whether all pixels read are equal."""
    at, w = np.empty(16, np.int64), np.empty((3, 16))
    (ny, sy), (nx, sx) = footprint(j[0], j[2]), footprint(j[1], j[3])
    first, equal = -1, True
    away = np.zeros(3)
    for k in range(ny * nx):
        oy, ox = ((k // nx + 0.5) / ny - 0.5) * sy, ((k % nx + 0.5) / nx - 0.5) * sx
        n = taps(row, reach.free, u[0] + (j[0] * oy + j[1] * ox), u[1] + (j[2] * oy + j[3] * ox), at, w)
        if n == 0:
            at[0], w[0, 0], n = nearest_pixel(row, reach.free, u[0], u[1], own), 1.0, 1
        if first < 0:
            first = at[0]
        for i in range(n):
            for c in range(3):
                step = np.float64(vectors[at[i], c]) - np.float64(vectors[first, c])
                equal = equal and step == 0.0
                away[c] += w[0, i] * step
    for c in range(3):
        read[c] = np.float64(vectors[first, c]) + away[c] / (ny * nx)
    return first, equal


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
def read_vectors(
    part: Part, reach: Reach, feather: int, vectors: Array, cross: int, first: Int64,
    sums: tuple[Floats, Floats], weight: Floats,
) -> None:  # fmt: skip
    """Add up the vectors read for every pixel of a cell, each turned with its piece.

    `first` (h, w): 8 times the first pixel read, and its isometry; less than 0 unless all were copies, turned by an
    isometry. `sums` (h, w, 3): the first vector, and the sum of w (vector - first).
    """
    lead, total = sums
    v, room = np.empty(3), (feather + 1) * (feather + 1)
    places, votes = np.empty((room, 2)), np.empty((room, 3), np.int64)
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            first[y, x] = 0
            for k in range(collect_votes(part, reach, feather, y, x, places, votes)):
                qy, qx, vote = votes[k]
                row, own = exemplar_of(reach.table, part.which[qy, qx]), (part.yx[qy, qx, 0], part.yx[qy, qx, 1])
                j, u = part.j[qy, qx], (places[k, 0], places[k, 1])
                pixel, equal = _vector(row, reach, j, u, own, vectors, v)
                pose = _pose_of(j)
                _turn(j, cross, pose >= 0, v)
                if weight[y, x] == 0.0:
                    lead[y, x] = v
                    first[y, x] = 8 * pixel + max(pose, 0)
                if first[y, x] >= 0 and not (equal and pose >= 0):
                    first[y, x] = -1 - first[y, x]
                weight[y, x] += vote
                for c in range(3):
                    total[y, x, c] += vote * (v[c] - lead[y, x, c])


@kernel
def read_labels(
    part: Part, reach: Reach, feather: int, ranks: Int32, out: Int32, weight: Int64
) -> None:
    """Write the label of every pixel of a cell: the largest weight of nearest pixels, the smallest label of equals."""
    room = (feather + 1) * (feather + 1)
    heard, share = np.empty(room, np.int32), np.empty(room, np.int64)
    places, votes = np.empty((room, 2)), np.empty((room, 3), np.int64)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            n, most = 0, 0
            for i in range(collect_votes(part, reach, feather, y, x, places, votes)):
                qy, qx, vote = votes[i]
                row, own = exemplar_of(reach.table, part.which[qy, qx]), (part.yx[qy, qx, 0], part.yx[qy, qx, 1])
                rank = ranks[nearest_pixel(row, reach.free, places[i, 0], places[i, 1], own)]
                weight[y, x] += vote
                k = 0
                while k < n and heard[k] != rank:
                    k += 1
                if k == n:
                    heard[n], share[n] = rank, 0
                    n += 1
                share[k] += vote
                if share[k] > most or (share[k] == most and rank < out[y, x]):
                    most, out[y, x] = share[k], rank
