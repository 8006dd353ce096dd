"""Where the texture lies turned and scaled: where neighbours lie (Lefebvre and Hoppe 2006, section 5).

A frame (H, W, 4) int32 holds for every output pixel the matrix J, in 1 / 4096, by which a step (dy, dx) of the output
is a step J d of the exemplar: J_yy, J_yx, J_xy, J_xx. Its determinant is positive.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel

UNIT = 12  # bits after the point of a frame
UPRIGHT = 1 << UNIT
AROUND = 3  # px that tell what whole coordinates leave out
CLOSE, ONE_PX = 6144, 4096  # a pixel and a half
HEIGHT, WIDTH, TOROIDAL = range(3)


@kernel
def stepped(first: Any, second: Any, oy: Any, ox: Any) -> Any:
    """Return one row of J times a step, rounded to whole px."""
    return (first * oy + second * ox + 2048) >> UNIT


@kernel
def toward(yy: Any, yx: Any, xy: Any, xx: Any, dy: Any, dx: Any) -> Any:
    """Return which of the eight neighbours lies where the exemplar's direction (dy, dx) leads: phi(D) of 2006."""
    vy, vx = xx * dy - yx * dx, yy * dx - xy * dy
    oy = (1 if vy > 0 else -1) if 3 * vy * vy >= vx * vx else 0
    ox = (1 if vx > 0 else -1) if 3 * vx * vx >= vy * vy else 0
    return oy, ox


@kernel
def handed_down(parents: Any, rows: Any, cols: Any, frame: Any, out: Any) -> None:
    """Write the coordinates of a level from those of the coarser one: S[p] = S_coarse[parent] + J(p) step.

    ``out`` (H, W, 2) int64, not yet brought into the exemplar.
    """
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            y, x = rows.parent[i], cols.parent[j]
            for axis in range(2):
                a, b = np.int64(frame[i, j, 2 * axis]), np.int64(frame[i, j, 2 * axis + 1])
                out[i, j, axis] = parents[y, x, axis] + stepped(a, b, rows.step[i], cols.step[j])


@kernel
def turned_moves(yy: Any, yx: Any, xy: Any, xx: Any, h: Any, strides: Any, reach: Any, moves: Any) -> None:
    """Write where neighbours lie in the output, and how far on in the exemplar what they foretell: (12 + 9 or 25, 2).

    The first twelve foretell the four diagonal points, three each; the others the pixel itself. ``strides``: of the
    output and of the exemplar.
    """
    wide, long = strides
    for n in range(12 + (2 * reach + 1) ** 2):
        if n < 12:
            dy, dx, r = ((n // 3) & 2) - 1, 2 * ((n // 3) & 1) - 1, n % 3
            oy, ox = toward(yy, yx, xy, xx, dy, dx)
            if r:
                ey, ex = toward(yy, yx, xy, xx, dy * (r == 1), dx * (r == 2))
                oy, ox = oy + ey, ox + ex
        else:
            dy, dx = 0, 0
            oy, ox = (n - 12) // (2 * reach + 1) - reach, (n - 12) % (2 * reach + 1) - reach
        moves[n, 0] = oy * wide + ox
        moves[n, 1] = (h * dy - stepped(yy, yx, h * oy, h * ox)) * long + h * dx - stepped(xy, xx, h * oy, h * ox)


@kernel
def remainders(coords: Any, frame: Any, size: Any, out: Any) -> None:
    """Write by how much each pixel lies beside its place, as what its neighbours within 2 px foretell has it.

    Coordinates (H + 4, W + 4, 2) are whole; where a piece lies turned or scaled they are rounded. The mean of all that
    continue to within a pixel and a half, (H, W, 2) in 1 / 4096 px, takes most of that off.
    """
    torus, height, width = size[TOROIDAL], size[HEIGHT], size[WIDTH]
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            yy, yx = np.int64(frame[i, j, 0]), np.int64(frame[i, j, 1])
            xy, xx = np.int64(frame[i, j, 2]), np.int64(frame[i, j, 3])
            total_y, total_x, count = np.int64(0), np.int64(0), np.int64(0)
            for oy in range(-AROUND, AROUND + 1):
                for ox in range(-AROUND, AROUND + 1):
                    dy = np.int64(coords[i + AROUND + oy, j + AROUND + ox, 0]) - coords[i + AROUND, j + AROUND, 0]
                    dx = np.int64(coords[i + AROUND + oy, j + AROUND + ox, 1]) - coords[i + AROUND, j + AROUND, 1]
                    if torus:
                        dy = (dy + height // 2) % height - height // 2
                        dx = (dx + width // 2) % width - width // 2
                    y, x = (dy << UNIT) - yy * oy - yx * ox, (dx << UNIT) - xy * oy - xx * ox
                    if max(abs(y), abs(x)) <= CLOSE:
                        total_y, total_x, count = total_y + y, total_x + x, count + 1
            out[i, j, 0] = min(max(total_y // count, -ONE_PX), ONE_PX)
            out[i, j, 1] = min(max(total_x // count, -ONE_PX), ONE_PX)
