"""Draw cells of maps whose pieces are scaled, turned or bent: add up what is read between pixels of the exemplar.

Votes are added in the order of the raster. All that is added up is the difference to the first pixel read, so that what
is uniform stays as it is.
"""

from __future__ import annotations

from math import floor, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from ..kernels.pieces_of_maps import HOLE, J
from .catmull_rom_kernels import Reach, exemplar_of, footprint, nearest_pixel, taps
from .warped_kernels import Part, hear

Array = NDArray[Any]


@kernel
def read_light(
    part: Part, reach: Reach, feather: int, light: Array, alpha: bool,
    sums: tuple[NDArray[np.float64], NDArray[np.float64]], first: NDArray[np.int64],
    weights: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> None:  # fmt: skip
    """Add up what is read for every pixel of a cell: w (light - light of the first pixel read).

    `sums` (h, w, C) are those of colours that count by their opacity, and of all alike; without `alpha` the second is
    all. `first` (h, w) is that pixel, -1 at the start; `weights` (h, w) are the sums of w times opacity, and of w.
    """
    at, w, added = np.empty(16, np.int64), np.empty((3, 16)), np.zeros((2, light.shape[1]))
    room, free = (feather + 1) * (feather + 1), reach.free
    places, votes = np.empty((room, 2)), np.empty((room, 3), np.int64)
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            base, opaque = -1, 0.0
            added[:] = 0.0
            if feather > 0:
                heard = hear(part, reach, feather, y, x, places, votes)
            else:  # the pixel itself, or nobody: plainly as above
                heard = 1 if part.which[y, x] != HOLE else 0
                places[0, 0], places[0, 1] = part.at[y, x, 0], part.at[y, x, 1]
                votes[0, 0], votes[0, 1], votes[0, 2] = y, x, 1
            for vote in range(heard):
                qy, qx, count = votes[vote, 0], votes[vote, 1], votes[vote, 2]
                row, own = exemplar_of(reach.table, part.which[qy, qx]), part.own[qy, qx]
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
def _varies(light: Array, at: NDArray[np.int64], n: int) -> bool:
    """Say whether opacity is not the same in all pixels of a reading."""
    last, varied = light.shape[1] - 1, False
    for k in range(1, n):
        varied = varied or light[at[k], last] != light[at[0], last]
    return varied


@kernel
def _add(
    light: Array, alpha: bool, at: NDArray[np.int64], n: int, w: Array, share: float, first: int, added: Array
) -> float:
    """Add a reading of `n` pixels, which never leaves their range; returns how much of it is seen.

    ``added`` (2, C): what is added up of colours by their opacity, and of all.

    In linear light, where Catmull-Rom shoots beyond an edge, dark stones would get black rims beside bright ones.
    Where opacity varies, colours come from the 2 x 2 around: with their weights, never negative, no colour is made up
    where hardly anything is seen.
    """
    last = light.shape[1] - 1
    mixed = alpha and _varies(light, at, n)
    opaque = 0.0
    if alpha:
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
def settle_light(
    plain: NDArray[np.float64], weight: NDArray[np.float64], first: NDArray[np.int64], light: Array, samples: Array,
    coding: tuple[NDArray[np.int32], NDArray[np.int32], int], out: Array,
) -> None:  # fmt: skip
    """Write the codes (h, w, C) of what was read of opaque colours; where it is the first pixel's light, its own code.

    ``coding``: lights at which codes begin, and a shelf of starting points that shortens the walk to them.
    """
    steps, shelf, shift = coding
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            base = max(first[y, x], 0)
            for c in range(out.shape[2]):
                away = plain[y, x, c] / max(weight[y, x], 1.0)
                if away == 0.0:
                    out[y, x, c] = samples[base, c]
                    continue
                value = floor(light[base, c] + away)
                code = np.int64(shelf[value >> shift])
                while code < steps.size and steps[code] <= value:
                    code += 1
                out[y, x, c] = code


@kernel
def _pose_of(j: NDArray[np.float64]) -> int:
    """Return the number of the isometry that a frame is, -1 where it is none."""
    for p in range(8):
        if j[0] == J[p, 0] and j[1] == J[p, 1] and j[2] == J[p, 2] and j[3] == J[p, 3]:
            return p
    return -1


@kernel
def _vector(
    row: tuple[int, int, int, int], reach: Reach, j: NDArray[np.float64], u: tuple[float, float], own: int,
    vectors: Array, read: NDArray[np.float64],
) -> tuple[int, bool]:  # fmt: skip
    """Read a vector (x, y, z) at a place; returns the first pixel read, and whether all that were read are equal."""
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
    part: Part, reach: Reach, feather: int, vectors: Array, cross: int, first: NDArray[np.int64],
    sums: tuple[NDArray[np.float64], NDArray[np.float64]], weight: NDArray[np.float64],
) -> None:  # fmt: skip
    """Add up the vectors read for every pixel of a cell, each turned with its piece.

    `first` (h, w): 8 times the first pixel read, and its isometry; less than 0 where anything was no copy, turned by an
    isometry. `sums` (h, w, 3): the first vector, and the sum of w (vector - first).
    """
    lead, total = sums
    v, room = np.empty(3), (feather + 1) * (feather + 1)
    places, votes = np.empty((room, 2)), np.empty((room, 3), np.int64)
    for y in range(first.shape[0]):
        for x in range(first.shape[1]):
            first[y, x] = 0
            for k in range(hear(part, reach, feather, y, x, places, votes)):
                qy, qx, vote = votes[k]
                row, j, u = exemplar_of(reach.table, part.which[qy, qx]), part.j[qy, qx], (places[k, 0], places[k, 1])
                pixel, equal = _vector(row, reach, j, u, part.own[qy, qx], vectors, v)
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
    part: Part, reach: Reach, feather: int, ranks: NDArray[np.int32], out: NDArray[np.int32], weight: NDArray[np.int64]
) -> None:
    """Choose for every pixel of a cell the label of the most nearest pixels by weight, the smallest of equals."""
    room = (feather + 1) * (feather + 1)
    heard, share = np.empty(room, np.int32), np.empty(room, np.int64)
    places, votes = np.empty((room, 2)), np.empty((room, 3), np.int64)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            n = 0
            for i in range(hear(part, reach, feather, y, x, places, votes)):
                qy, qx, vote = votes[i]
                row, own = exemplar_of(reach.table, part.which[qy, qx]), part.own[qy, qx]
                rank = ranks[nearest_pixel(row, reach.free, places[i, 0], places[i, 1], own)]
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
