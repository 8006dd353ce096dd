"""Cut a window out of a map, as large as a plane needs it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from ..kernels.pieces_of_maps import HOLE, J

Map = tuple[NDArray[np.int32], NDArray[np.uint8], NDArray[np.uint8]]
"""What a map shows: pixels (H, W, 2), exemplars (H, W) and poses (H, W)."""


@kernel
def cut_window(
    full: Map, origin: tuple[int, int], scale: int, wrap: tuple[bool, bool], exemplars: NDArray[np.int64], part: Map
) -> bool:
    """Cut a box out of a map that is `scale` times enlarged; outside the canvas there are holes.

    `origin` is the first pixel in enlarged px, `part` receives (yx, which, pose). Enlarging turns the s x s
    sub-pixels of a pixel with its pose: S' = s S + (J (2 d - (s - 1)) + (s - 1)) / 2. Returns False where the
    map points outside its exemplars.
    """
    yx, which, pose = full
    out, out_which, out_pose = part
    rows, columns = which.shape
    for i in range(out_which.shape[0]):
        my = (origin[0] + i) // scale
        ty = 2 * (origin[0] + i - my * scale) - (scale - 1)
        if wrap[0]:
            my %= rows
        for j in range(out_which.shape[1]):
            mx = (origin[1] + j) // scale
            tx = 2 * (origin[1] + j - mx * scale) - (scale - 1)
            if wrap[1]:
                mx %= columns
            out_which[i, j] = HOLE
            out_pose[i, j] = 0
            out[i, j, 0] = out[i, j, 1] = 0
            if not (0 <= my < rows and 0 <= mx < columns) or which[my, mx] == HOLE:
                continue
            w, p = which[my, mx], pose[my, mx]
            if w >= exemplars.shape[0] or p > 7:
                return False
            u = scale * yx[my, mx, 0] + (J[p, 0] * ty + J[p, 1] * tx + scale - 1) // 2
            v = scale * yx[my, mx, 1] + (J[p, 2] * ty + J[p, 3] * tx + scale - 1) // 2
            if not (0 <= u < exemplars[w, 1] and 0 <= v < exemplars[w, 2]):
                return False
            out[i, j, 0], out[i, j, 1] = u, v
            out_which[i, j], out_pose[i, j] = w, p
    return True
