"""The correction operation where the texture lies turned and scaled (Lefebvre and Hoppe 2006, section 5).

A frame (H, W, 4) int32 holds for every output pixel the matrix J, in 1 / 4096, by which a step (dy, dx) of the output
is a step J d of the exemplar: J_yy, J_yx, J_xy, J_xx. Its determinant is positive.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from .correction_kernels import FACTOR, ONE, REACH, SPACING

UNIT = 12  # bits after the point of a frame
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
def around(yy: Any, yx: Any, xy: Any, xx: Any, h: Any, strides: Any, reach: Any, moves: Any) -> None:
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
def correct_framed(
    coords: Any, rows: Any, cols: Any, low: int, high: int, site: Any, rule: Any, frame: Any, long: int, out: Any
) -> None:
    """Find better positions for the pixels (rows[low:high], cols) of a map (H, W), as :func:`correct` does.

    A neighbour at p + o foretells S[p + o] - h J(p) o; the appearance around p is that of its four diagonal points in
    the exemplar, each foretold by the three neighbours that lie there in the output. ``long``: of the exemplar's rows.
    """
    # In one piece, and its end that of `correct` once more: calls that take arrays would count references.
    stride, factor, reach, h = np.int64(coords.shape[1]), rule[FACTOR], rule[REACH], site.steps[SPACING]
    work, packed, table, inner, may, jumps = (
        coords.reshape(coords.size), site.packed, site.table, site.inner, site.open, site.jumps
    )  # fmt: skip
    shown, asked, guides = site.shown, site.asked, np.int64(len(site.shown) // len(inner))
    more, n, last = jumps.shape[1], np.int64(32), 12 + (2 * reach + 1) ** 2
    words = np.zeros(8, np.uint64)
    here = words.view(np.int16)
    found, moves = np.empty((last - 12) * (1 + more), np.int64), np.empty((last, 2), np.int64)
    old_y, old_x, old_z = np.int64(0), np.int64(0), np.int64(0)
    for i in range(low, high):
        for j in range(len(cols)):
            at = rows[i] * stride + cols[j]
            yy, yx = np.int64(frame[rows[i], cols[j], 0]), np.int64(frame[rows[i], cols[j], 1])
            xy, xx = np.int64(frame[rows[i], cols[j], 2]), np.int64(frame[rows[i], cols[j], 3])
            if yy != old_y or yx != old_x or xx != old_z:
                around(yy, yx, xy, xx, h, (stride, long), reach, moves)
                old_y, old_x, old_z = yy, yx, xx
            for q in range(4):
                r0 = np.uint64(work[np.uint64(at + moves[3 * q, 0])] + moves[3 * q, 1])
                r1 = np.uint64(work[np.uint64(at + moves[3 * q + 1, 0])] + moves[3 * q + 1, 1])
                r2 = np.uint64(work[np.uint64(at + moves[3 * q + 2, 0])] + moves[3 * q + 2, 1])
                words[2 * q] = packed[r0, 0] + packed[r1, 0] + packed[r2, 0]
                words[2 * q + 1] = packed[r0, 1] + packed[r1, 1] + packed[r2, 1]
            own = np.int64(work[np.uint64(at)])
            found[0], near = own, 1
            for c in range(12, last):
                v = np.int64(work[np.uint64(at + moves[c, 0])]) + moves[c, 1]
                if v != own:
                    u = np.int64(inner[np.uint64(v)])
                    fresh = u >= 0
                    for m in range(near):
                        fresh = fresh and found[m] != u
                    if fresh:
                        found[near] = u
                        near += 1
            best, kept, count, price, begin = np.int64(1) << 62, own, near, np.int64(ONE), 0
            for kind in range(2):
                if kind:
                    if factor < 0 or best == 0:
                        break
                    begin, price = near, factor
                    for c in range(near):
                        alone = True  # what differs by the rounding of a pixel leads to the same places
                        for m in range(c):
                            e = found[c] - found[m] + long + 1
                            beside = 0 <= e < 3 or long <= e < long + 3 or 2 * long <= e < 2 * long + 3
                            alone = alone and not beside
                        for k in range(more if alone else 0):
                            u = np.int64(jumps[np.uint64(found[c]), k])
                            fresh = u >= 0
                            for m in range(count):
                                fresh = fresh and found[m] != u
                            if fresh:
                                found[count] = u
                                count += 1
                for c in range(begin, count):
                    u = found[c]
                    if may[np.uint64(u)]:
                        total, row = np.int32(0), np.uint64(u * n)
                        for k in range(n):
                            d = np.int16(here[k] - table[row + np.uint64(k)])
                            total = np.int32(total + np.int32(d) * np.int32(d))
                        cost = np.int64(total) * price
                        for k in range(guides):
                            e = np.int64(shown[u * guides + k]) - np.int64(asked[at * guides + k])
                            cost += ONE * e * e
                        if cost < best:
                            best, kept = cost, u
            out[i, j] = kept


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
