"""Cells of maps whose pieces are scaled, turned or bent, and who votes for a pixel of them.

The entry at q, asked for the pixel at p, reads u = S(q) + J(q) (p - q), as all votes do; here S(q) has its fraction of
a pixel, and J is any matrix.
"""

from __future__ import annotations

from math import floor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from ..kernels.pieces_of_maps import HOLE, J
from .catmull_rom_kernels import Reach, exemplar_of, share_of

ALIKE = 1 / 1024
"""Px, and parts of a frame, by which votes may differ and still be read together; those of one piece do by less."""

KEPT = 8
"""Places that later votes are compared with; where fields bend strongly, every vote reads its own."""


class WarpField(NamedTuple):
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
    field: WarpField, origin: tuple[int, int], scale: int, wrap: tuple[bool, bool], table: NDArray[np.int64], part: Part
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
            own_y = y * scale + min(max(floor(offset_y + 0.5), 0), scale - 1)
            own_x = x * scale + min(max(floor(offset_x + 0.5), 0), scale - 1)
            if field.sub.shape[0] > 0:
                offset_y += scale * np.float64(field.sub[my, mx, 0])
                offset_x += scale * np.float64(field.sub[my, mx, 1])
            part.which[i, k] = w
            part.at[i, k, 0], part.at[i, k, 1] = scale * y + offset_y, scale * x + offset_x
            part.own[i, k] = table[w, 0] + own_y * table[w, 2] + own_x
    return True


@kernel
def hear(
    part: Part, reach: Reach, feather: int, y: int, x: int, places: NDArray[np.float64], votes: NDArray[np.int64]
) -> int:
    """List what the entries around pixel (y, x) of a cell read, in the order of the raster; returns how many.

    `places` (n, 2): where; `votes` (n, 3): row and column of the entry, and how much it counts. Those that read one
    place by one frame are one, as far as they are among the first.
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
def _alike(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    away = max(max(abs(a[0] - b[0]), abs(a[1] - b[1])), max(abs(a[2] - b[2]), abs(a[3] - b[3])))
    return bool(away <= ALIKE)
