"""Draw maps whose pieces are scaled, turned or bent: votes that are read between the pixels of the exemplar.

The entry at q, asked for the pixel at p, reads u = S(q) + J(q) (p - q), as all votes do; S(q) has its fraction of a
pixel. Taps are added one by one, in the order of the raster. All that is added up is the difference to the first pixel
read, so that what is uniform stays as it is.
"""

from __future__ import annotations

from math import floor, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .between import Reach, footprint, nearest, share_of, taps
from .jit import kernel
from .votes import HOLE, J

Array = NDArray[Any]


class Field(NamedTuple):
    """The arrays of a map; what it leaves out has no pixels, but `which` is always there."""

    yx: NDArray[np.int32]
    which: NDArray[np.uint8]
    pose: NDArray[np.uint8]
    frame: NDArray[np.float32]  # (H, W, 2, 2)
    sub: NDArray[np.float32]  # (H, W, 2)


class Part(NamedTuple):
    """A cell with a halo, in px of the plane."""

    which: NDArray[np.uint8]  # (h, w)
    at: NDArray[np.float64]  # (h, w, 2): the place in the exemplar
    j: NDArray[np.float64]  # (h, w, 4): the frame, as the rows of J
    own: NDArray[np.int64]  # (h, w): the pixel that the map names, as a number among all exemplars


@kernel
def lay_part(
    field: Field, origin: tuple[int, int], scale: int, wrap: tuple[bool, bool], table: NDArray[np.int64], part: Part
) -> bool:
    """Cut a box out of a map that is `scale` times enlarged, as `cut_window` does; outside the canvas are holes.

    Returns False where the map points outside its exemplars.
    """
    rows, columns = field.which.shape
    for i in range(part.which.shape[0]):
        my = (origin[0] + i) // scale
        dy = origin[0] + i - my * scale
        if wrap[0]:
            my %= rows
        for k in range(part.which.shape[1]):
            mx = (origin[1] + k) // scale
            dx = origin[1] + k - mx * scale
            if wrap[1]:
                mx %= columns
            part.which[i, k] = HOLE
            if not (0 <= my < rows and 0 <= mx < columns) or field.which[my, mx] == HOLE:
                continue
            w, y, x = field.which[my, mx], field.yx[my, mx, 0], field.yx[my, mx, 1]
            if w >= table.shape[0] or not (0 <= y * scale < table[w, 1] and 0 <= x * scale < table[w, 2]):
                return False
            j = part.j[i, k]
            if field.frame.shape[0] > 0:
                j[0], j[1] = field.frame[my, mx, 0, 0], field.frame[my, mx, 0, 1]
                j[2], j[3] = field.frame[my, mx, 1, 0], field.frame[my, mx, 1, 1]
            else:
                p = np.uint8(0)
                if field.pose.shape[0] > 0:
                    p = field.pose[my, mx]
                if p > 7:
                    return False
                j[:] = J[p]
            ty, tx = 2 * dy - (scale - 1), 2 * dx - (scale - 1)
            # S' = s S + (J (2 d - (s - 1)) + (s - 1)) / 2, and s times the fraction of a pixel
            offset_y = (j[0] * ty + j[1] * tx + (scale - 1)) / 2
            offset_x = (j[2] * ty + j[3] * tx + (scale - 1)) / 2
            # The pixel of the plane that stands for the entry lies within the pixel of the map.
            own_y = y * scale + min(max(int(floor(offset_y + 0.5)), 0), scale - 1)
            own_x = x * scale + min(max(int(floor(offset_x + 0.5)), 0), scale - 1)
            if field.sub.shape[0] > 0:
                offset_y += scale * np.float64(field.sub[my, mx, 0])
                offset_x += scale * np.float64(field.sub[my, mx, 1])
            part.which[i, k] = w
            part.at[i, k, 0], part.at[i, k, 1] = scale * y + offset_y, scale * x + offset_x
            part.own[i, k] = table[w, 0] + own_y * table[w, 2] + own_x
    return True


@kernel
def _asked(part: Part, reach: Reach, feather: int, y: int, x: int, tap: int) -> tuple[int, int, int, float, float]:
    """Ask an entry around pixel (y, x) of a cell: how much its vote counts, where it stands, and what place it reads."""
    f = feather
    qy, qx = y + tap // (f + 1), x + tap % (f + 1)
    if part.which[qy, qx] == HOLE:
        return 0, qy, qx, 0.0, 0.0
    dy, dx = f // 2 - (qy - y), f // 2 - (qx - x)
    j = part.j[qy, qx]
    uy = part.at[qy, qx, 0] + (j[0] * dy + j[1] * dx)
    ux = part.at[qy, qx, 1] + (j[2] * dy + j[3] * dx)
    vote = 1 if f == 0 else share_of(reach.table[part.which[qy, qx]], reach, uy, ux)
    return vote, qy, qx, uy, ux


@kernel
def read_light(
    part: Part,
    reach: Reach,
    feather: int,
    light: Array,
    alpha: bool,
    sums: tuple[NDArray[np.float64], NDArray[np.float64]],
    first: NDArray[np.int64],
    weights: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> None:
    """Add up what is read for every pixel of a cell: w (light - light of the first pixel read).

    `sums` (h, w, C) are those of colours that count by their opacity, and of all alike; without `alpha` the second is
    all. `first` (h, w) is that pixel, -1 at the start; `weights` (h, w) are the sums of w times opacity, and of w.
    """
    at, w = np.empty(16, np.int64), np.empty((2, 16))
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            for tap in range((feather + 1) * (feather + 1)):
                vote, qy, qx, uy, ux = _asked(part, reach, feather, y, x, tap)
                if vote == 0:
                    continue
                row, j = reach.table[part.which[qy, qx]], part.j[qy, qx]
                weights[1][y, x] += vote
                (ny, sy), (nx, sx) = footprint(j, 0), footprint(j, 1)
                share = vote / (ny * nx)
                for k in range(ny * nx):
                    oy, ox = ((k // nx + 0.5) / ny - 0.5) * sy, ((k % nx + 0.5) / nx - 0.5) * sx
                    ry, rx = uy + (j[0] * oy + j[1] * ox), ux + (j[2] * oy + j[3] * ox)
                    n = taps(row, reach, ry, rx, at, w)
                    if n == 0:
                        at[0], w[0, 0], w[1, 0], n = nearest(row, reach, uy, ux, part.own[qy, qx]), 1.0, 1.0, 1
                    if first[y, x] < 0:
                        first[y, x] = at[0]
                    seen = _add(light, alpha, at[:n], w, share, first[y, x], sums[0][y, x], sums[1][y, x])
                    weights[0][y, x] += seen


@kernel
def _varies(light: Array, at: NDArray[np.int64]) -> bool:
    """Say whether opacity is not the same in all pixels of a reading."""
    last = light.shape[1] - 1
    for k in range(1, at.size):
        if light[at[k], last] != light[at[0], last]:
            return True
    return False


@kernel
def _add(
    light: Array,
    alpha: bool,
    at: NDArray[np.int64],
    w: Array,
    share: float,
    first: int,
    seen: NDArray[np.float64],
    plain: NDArray[np.float64],
) -> float:
    """Add a reading; returns how much of it is seen.

    Where opacity varies, colours come from the 2 x 2 around: with their weights, never negative, no colour is made up
    where hardly anything is seen.
    """
    last = light.shape[1] - 1
    line = 1 if alpha and _varies(light, at) else 0
    opaque = 0.0
    for k in range(at.size):
        a = 0.0
        if alpha:
            a = share * w[line, k] * max(np.float64(light[at[k], last]), 0.0)
            opaque += a
        for c in range(last + 1):
            away = np.float64(light[at[k], c]) - np.float64(light[first, c])
            if alpha and c < last:
                seen[c] += a * away
                plain[c] += share * w[line, k] * away
            else:
                plain[c] += share * w[0, k] * away
    return opaque


@kernel
def _pose_of(j: NDArray[np.float64]) -> int:
    """Return the number of the isometry that a frame is, -1 where it is none."""
    for p in range(8):
        if j[0] == J[p, 0] and j[1] == J[p, 1] and j[2] == J[p, 2] and j[3] == J[p, 3]:
            return p
    return -1


@kernel
def _vector(
    row: NDArray[np.int64], reach: Reach, j: NDArray[np.float64], u: tuple[float, float], own: int,
    vectors: Array, read: NDArray[np.float64],
) -> tuple[int, bool]:  # fmt: skip
    """Read a vector (x, y, z) at a place; returns the first pixel read, and whether all that were read are equal."""
    at, w = np.empty(16, np.int64), np.empty((2, 16))
    (ny, sy), (nx, sx) = footprint(j, 0), footprint(j, 1)
    first, equal = -1, True
    away = np.zeros(3)
    for k in range(ny * nx):
        oy, ox = ((k // nx + 0.5) / ny - 0.5) * sy, ((k % nx + 0.5) / nx - 0.5) * sx
        n = taps(row, reach, u[0] + (j[0] * oy + j[1] * ox), u[1] + (j[2] * oy + j[3] * ox), at, w)
        if n == 0:
            at[0], w[0, 0], n = nearest(row, reach, u[0], u[1], own), 1.0, 1
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
def _turn(j: NDArray[np.float64], cross: int, keep: bool, v: NDArray[np.float64]) -> None:
    """Turn a vector with its piece: slopes pull back, n_yx' = J^T n_yx; `cross` is -1 where green is up, else 1.

    Its length stays, so that no vote is louder for being scaled; `keep`: it stays by itself.
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
    part: Part,
    reach: Reach,
    feather: int,
    vectors: Array,
    cross: int,
    first: NDArray[np.int64],
    sums: tuple[NDArray[np.float64], NDArray[np.float64]],
    weight: NDArray[np.float64],
) -> None:
    """Add up the vectors read for every pixel of a cell, each turned with its piece.

    `first` (h, w): 8 times the first pixel read, and its isometry; less than 0 where anything was no copy, turned by an
    isometry. `sums` (h, w, 3): the first vector, and the sum of w (vector - first).
    """
    lead, total = sums
    v = np.empty(3)
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            first[y, x] = 0
            for tap in range((feather + 1) * (feather + 1)):
                vote, qy, qx, uy, ux = _asked(part, reach, feather, y, x, tap)
                if vote == 0:
                    continue
                row, j = reach.table[part.which[qy, qx]], part.j[qy, qx]
                pixel, equal = _vector(row, reach, j, (uy, ux), part.own[qy, qx], vectors, v)
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
    part: Part,
    reach: Reach,
    feather: int,
    ranks: NDArray[np.int32],
    out: NDArray[np.int32],
    weight: NDArray[np.int64],
) -> None:
    """Choose for every pixel of a cell the label with the largest share of the nearest pixels, the smallest of equals."""
    room = (feather + 1) * (feather + 1)
    heard, share = np.empty(room, np.int32), np.empty(room, np.int64)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            n = 0
            for tap in range(room):
                vote, qy, qx, uy, ux = _asked(part, reach, feather, y, x, tap)
                if vote == 0:
                    continue
                rank = ranks[nearest(reach.table[part.which[qy, qx]], reach, uy, ux, part.own[qy, qx])]
                weight[y, x] += vote
                k = 0
                while k < n and heard[k] != rank:
                    k += 1
                if k == n:
                    heard[n], share[n] = rank, 0
                    n += 1
                share[k] += vote
            best = -1
            for k in range(n):
                if best < 0 or share[k] > share[best] or (share[k] == share[best] and heard[k] < heard[best]):
                    best = k
            if best >= 0:
                out[y, x] = heard[best]
