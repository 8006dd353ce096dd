"""The correction operation on a coordinate map: each pixel becomes the exemplar pixel whose neighbourhood matches best.

Lefebvre and Hoppe 2005 and 2006; a memorandum of 2008 on their correction operation (docs/sources-004.md). A coordinate
map (H, W, 2) holds an exemplar pixel (y, x) for each output pixel. Neighbouring output pixels stand for exemplar pixels
that are `h` px apart.

All numbers are integer: features int16, distances int32, times the factor of jumps int64.

The candidates and colours of the memorandum (method correction-2008) are branches of :func:`correct`: a second kernel
would repeat continuations, choice and factor, and be compiled in addition.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int32, Int64
from ..kernels.jit import kernel
from ..kernels.random_numbers import STEP, mixed

UNIT = 12  # fractional bits of a frame (the Jacobian J of the map)
UPRIGHT = 1 << UNIT  # 1 in a frame
AROUND = 3  # px to each side of a pixel whose predictions are averaged
CLOSE, ONE_PX = 6144, 4096  # 1.5 px and 1 px, in 1 / 4096 px
TOROIDAL = 2  # index in the size of a domain


@kernel
def stepped(first: Any, second: Any, oy: Any, ox: Any) -> Any:
    """Return one row of J times an offset, rounded to whole px."""
    return (first * oy + second * ox + 2048) >> UNIT


@kernel
def warped_direction(yy: Any, yx: Any, xy: Any, xx: Any, dy: Any, dx: Any) -> Any:
    """Return the offset of the output neighbour nearest to the exemplar's direction (dy, dx): phi(D) of 2006, sec. 5.

    `yy`, `yx`, `xy`, `xx`: the frame.
    """
    vy, vx = xx * dy - yx * dx, yy * dx - xy * dy
    oy = (1 if vy > 0 else -1) if 3 * vy * vy >= vx * vx else 0
    ox = (1 if vx > 0 else -1) if 3 * vx * vx >= vy * vy else 0
    return oy, ox


@kernel
def warped_offsets(yy: Any, yx: Any, xy: Any, xx: Any, h: Any, strides: Any, reach: Any, moves: Any) -> None:
    """Write offsets of output neighbours, and from their exemplar pixels to what they predict: (12 + 9 or 25, 2).

    The first twelve predict the four diagonal points, three each; the others the pixel itself, from the neighbours
    within `reach`. All are offsets in flat arrays; ``strides``: row lengths of output and exemplar; `h`: px spacing.
    """
    wide, long = strides
    for n in range(12 + (2 * reach + 1) ** 2):
        if n < 12:
            dy, dx, r = ((n // 3) & 2) - 1, 2 * ((n // 3) & 1) - 1, n % 3
            oy, ox = warped_direction(yy, yx, xy, xx, dy, dx)
            if r:
                ey, ex = warped_direction(yy, yx, xy, xx, dy * (r == 1), dx * (r == 2))
                oy, ox = oy + ey, ox + ex
        else:
            dy, dx = 0, 0
            oy, ox = (n - 12) // (2 * reach + 1) - reach, (n - 12) % (2 * reach + 1) - reach
        moves[n, 0] = oy * wide + ox
        moves[n, 1] = (h * dy - stepped(yy, yx, h * oy, h * ox)) * long + h * dx - stepped(xy, xx, h * oy, h * ox)


@kernel
def subpixel_offsets(coords: Any, frame: Any, size: Any, out: Any) -> None:
    """Write the offset of each pixel's exact exemplar position from its whole coordinates, (H, W, 2) in 1 / 4096 px.

    Coordinates (H + 6, W + 6, 2) are rounded to px if the texture is rotated or scaled. The exact position is the mean
    of the predictions by the 7 x 7 pixels around that agree within 1.5 px; the offset is clamped to 1 px.
    """
    off, total = np.empty(2, np.int64), np.empty(2, np.int64)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            total[:], count = 0, 0
            for oy in range(-AROUND, AROUND + 1):
                for ox in range(-AROUND, AROUND + 1):
                    for a in range(2):
                        d = np.int64(coords[i + AROUND + oy, j + AROUND + ox, a]) - coords[i + AROUND, j + AROUND, a]
                        if size[TOROIDAL]:
                            d = (d + size[a] // 2) % size[a] - size[a] // 2
                        off[a] = (d << UNIT) - frame[i, j, 2 * a] * oy - frame[i, j, 2 * a + 1] * ox
                    if max(abs(off[0]), abs(off[1])) <= CLOSE:
                        total += off
                        count += 1
            for a in range(2):
                out[i, j, a] = min(max(total[a] // count, -ONE_PX), ONE_PX)


REACH, LOOKUP_FIRST, FACTOR = range(3)  # indices in a rule
ONE = 256  # unit of FACTOR, which multiplies the squared distance of a jump
FINE = 12  # fractional bits of a jitter
MIDDLE = 1023  # middle of packed appearance values, which run from 0 to 2046
SCATTER_REACH = 2  # neighbouring pieces on each side that are considered when large pieces are scattered
SCATTER_CLASSES = 4  # parity classes of rows and columns, processed one after the other
SHARE, FAR = 1024, 16  # units per side of a piece of overlaps, and of distances


class CoordinateDomain(NamedTuple):
    """The set of exemplar coordinates of a map."""

    size: Int64  # (3,): height, width, 1 if toroidal
    home: Int32  # (H * W,): for each exemplar pixel the nearest usable one, or empty
    lattice: Int64  # (2, 2): vectors (y, x), 1/256 px, by which coordinates may move; or empty


@kernel
def nearest_lattice_vector(dy: Any, dx: Any, lattice: Any) -> Any:
    """Return the lattice vector nearest to an offset, in px: T round(T^-1 d) (2005, section 5)."""
    ay, ax, by, bx = lattice[0, 0], lattice[0, 1], lattice[1, 0], lattice[1, 1]
    det = ay * bx - ax * by
    m = (2 * 256 * (dy * bx - dx * by) + det) // (2 * det)
    n = (2 * 256 * (ay * dx - ax * dy) + det) // (2 * det)
    return (m * ay + n * by + 128) >> 8, (m * ax + n * bx + 128) >> 8


@kernel
def wrapped_by_lattice(y: Any, x: Any, by: Any, bx: Any, room: Any) -> Any:
    """Return (y, x) moved into the exemplar, by lattice vectors from (by, bx) if a nearby lattice point is inside."""
    height, width = room.size[0], room.size[1]
    wy, wx = y % height, x % width
    if len(room.lattice) == 0:
        return wy, wx
    dy, dx = nearest_lattice_vector(wy - by, wx - bx, room.lattice)
    for m in range(3):
        for n in range(3):
            i, j = (m + 1) % 3 - 1, (n + 1) % 3 - 1  # 0, 1, -1
            vy = by + dy + ((i * room.lattice[0, 0] + j * room.lattice[1, 0] + 128) >> 8)
            vx = bx + dx + ((i * room.lattice[0, 1] + j * room.lattice[1, 1] + 128) >> 8)
            if 0 <= vy < height and 0 <= vx < width:
                return vy, vx
    return wy, wx


@kernel
def jittered(coords: Any, rows: Any, cols: Any, state: Any, spread: Any, free: bool, room: Any, out: Any) -> None:
    """Jitter coordinates by random numbers keyed by (rows, cols), and move them back into the exemplar.

    S[p] = coords + floor(h r H(p) + 1/2), H(p) in [-1, 1) (2005, equations 1 and 2). ``state``: of the random
    numbers before rows and columns are mixed in (uint64); ``spread``: h r in 1 / 4096 px, (H, W) or (1, 1) for all;
    ``free``: jitter may move pixels by any offset, else by lattice vectors, if there is a lattice.
    """
    height, width = room.size[0], room.size[1]
    everywhere, half, home = spread.size == 1, np.int64(1) << (FINE + 30), room.home
    for i in range(out.shape[0]):
        z = mixed((state ^ np.uint64(rows[i])) + STEP)
        for j in range(out.shape[1]):
            by, bx = np.int64(coords[i, j, 0]), np.int64(coords[i, j, 1])
            y, x = by, bx
            r = np.int64(spread[0, 0] if everywhere else spread[i, j])
            if r:
                bits = mixed((z ^ np.uint64(cols[j])) + STEP)
                low, high = np.int64(bits & np.uint64(0xFFFFFFFF)), np.int64(bits >> np.uint64(32))
                y += (r * (high - 2147483648) + half) >> (FINE + 31)
                x += (r * (low - 2147483648) + half) >> (FINE + 31)
                if free:
                    by, bx = y, x
            if y != by or x != bx or y < 0 or y >= height or x < 0 or x >= width:
                y, x = wrapped_by_lattice(y, x, by, bx, room)
            if len(home):
                flat = np.int64(home[y * width + x])
                y, x = flat // width, flat % width
            out[i, j, 0], out[i, j, 1] = y, x


@kernel
def colours_here(work: Any, at: Any, stride: Any, level: Any, here: Any) -> None:
    """Write the 5 x 5 colours around the pixel `at`, multiplied by the square roots of their weights."""
    channels = level.values.shape[1]
    for k in range(25):
        u = work[at + (k // 5 - 2) * stride + k % 5 - 2]
        for c in range(channels):
            here[k * channels + c] = (level.values[u, c] * level.roots[k]) >> 8


@kernel
def published_jumps(work: Any, at: Any, stride: Any, level: Any, reach: Any, found: Any, count: int) -> int:
    """Append the jumps of 2005, similar pixels of a neighbour's pixel, then shifted: C_i(S[p + D]) - h D.

    Return the new number of candidates in `found`.
    """
    below, across = level.h * level.stride, level.h
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            v = work[at + dy * stride + dx]
            for i in range(level.jumps.shape[1]):
                u = np.int64(level.jumps[v, i])
                if u >= 0:
                    u = np.int64(level.inner[u - dy * below - dx * across])
                fresh = u >= 0
                for m in range(count):
                    fresh = fresh and found[m] != u
                if fresh:
                    found[count] = u
                    count += 1
    return count


@kernel
def correct(
    coords: Any, rows: Any, cols: Any, low: int, high: int, level: Any, rule: Any, frame: Any, out: Any
) -> None:
    """Write corrected positions for the pixels (rows[low:high], cols) of a map (H, W) into `out` (rows, cols).

    Candidates are the distinct continuations of the neighbours, S[p + o] - h J(p) o, and jumps to similar pixels, whose
    squared distance is multiplied by rule[FACTOR] / 256 (no jumps if that is negative). The least distance wins; ties
    go to the first, the pixel's own continuation before others, continuations before jumps; where no candidate is open
    the pixel stays. The map is only read: the caller writes the results when all pixels of the subpass are done. The
    squared difference between the guide at a candidate and the target at the pixel is added; it is not multiplied by
    the factor of jumps. ``frame``: J of every pixel (H, W, 4), or None if all are upright.

    The appearance around a pixel is that of four diagonal points, each the sum of three predictions (2006, section 4):
    see :func:`warped_offsets`. A word holds four values of 16 bits; three of at most 2046 add up without carry.
    """
    # One function, as calls with array arguments would count references for every pixel, contended between threads.
    # It is compiled separately for frames and for None.
    stride, factor, reach, first = np.int64(coords.shape[1]), rule[FACTOR], rule[REACH], rule[LOOKUP_FIRST]
    h, long, work = np.int64(level.h), np.int64(level.stride), coords.reshape(coords.size)
    packed, table, inner, may, jumps = level.packed, level.table, level.inner, level.open, level.jumps
    appearance, more, n = len(packed) > 0, jumps.shape[1], np.int64(len(table) // len(inner))
    shown, asked, guides = level.shown, level.asked, np.int64(len(level.shown) // len(inner))
    words, last = np.zeros((n + 3) // 4, np.uint64), 12 + (2 * reach + 1) ** 2
    here = words.view(np.int16)[:n]
    found, moves = np.empty((last - 12) * (1 + more), np.int64), np.empty((last, 2), np.int64)
    warped_offsets(UPRIGHT, 0, 0, UPRIGHT, h, (stride, long), reach, moves)
    three, next_row = np.uint64(3), np.uint64(long)  # negative differences become large unsigned ones
    old_y, old_x, old_z = np.int64(UPRIGHT), np.int64(0), np.int64(UPRIGHT)
    for i in range(low, high):
        for j in range(len(cols)):
            at = rows[i] * stride + cols[j]
            if frame is not None:
                yy, yx = np.int64(frame[rows[i], cols[j], 0]), np.int64(frame[rows[i], cols[j], 1])
                xy, xx = np.int64(frame[rows[i], cols[j], 2]), np.int64(frame[rows[i], cols[j], 3])
                if yy != old_y or yx != old_x or xx != old_z:
                    warped_offsets(yy, yx, xy, xx, h, (stride, long), reach, moves)
                    old_y, old_x, old_z = yy, yx, xx
            if appearance:
                for q in range(4):
                    r0 = np.uint64(work[np.uint64(at + moves[3 * q, 0])] + moves[3 * q, 1])
                    r1 = np.uint64(work[np.uint64(at + moves[3 * q + 1, 0])] + moves[3 * q + 1, 1])
                    r2 = np.uint64(work[np.uint64(at + moves[3 * q + 2, 0])] + moves[3 * q + 2, 1])
                    words[2 * q] = packed[r0, 0] + packed[r1, 0] + packed[r2, 0]
                    words[2 * q + 1] = packed[r0, 1] + packed[r1, 1] + packed[r2, 1]
            else:
                colours_here(work, at, stride, level, here)
            own = np.int64(work[np.uint64(at)])
            found[0], near = own, 1
            for c in range(12, last):
                v = np.int64(work[np.uint64(at + moves[c, 0])]) + moves[c, 1]
                if v != own:
                    u = np.int64(inner[np.uint64(v)])
                    m = 0
                    while m < near and found[m] != u:
                        m += 1
                    if u >= 0 and m == near:
                        found[near] = u
                        near += 1
            best, kept, count, price, begin = np.int64(1) << 62, own, near, np.int64(ONE), 0
            for kind in range(2):
                if kind:
                    if factor < 0 or best == 0:
                        break
                    begin, price = near, factor
                    if first:
                        count = published_jumps(work, at, stride, level, reach, found, near)
                    for c in range(0 if first else near):
                        alone = True  # continuations that differ by rounding lead to the same jumps
                        if frame is not None:
                            m = 0
                            while alone and m < c:
                                on = np.uint64(found[c] - found[m] + long + 1)
                                alone = not (on < three or on - next_row < three or on - next_row - next_row < three)
                                m += 1
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
def weighted_overlap(ay: Any, ax: Any, by: Any, bx: Any, di: int, dj: int, h: Any, size: Any) -> Any:
    """Return the overlap in the exemplar of two pieces of h x h px, at (ay, ax) and (by, bx), weighted by nearness.

    The second lies `di`, `dj` pieces from the first in the output. The weight is 1 / (1 + d^2), d the distance between
    the overlapping parts in the output in 1/16 pieces. Pieces wrap around the exemplar, so that they may overlap twice
    along either axis.
    """
    high, wide = (by - ay) % size[0], (bx - ax) % size[1]
    total = 0 * h
    for _ in range(2):
        across = wide
        for _ in range(2):
            oy, ox = h - abs(high), h - abs(across)
            if oy > 0 and ox > 0:
                sy, sx = (di * h - high) * FAR // h, (dj * h - across) * FAR // h
                total += ((oy * SHARE // h) * (ox * SHARE // h) << 16) // (sy * sy + sx * sx + 1)
            across -= size[1]
        high -= size[0]
    return total


@kernel
def spread_large_pieces(choices: Any, rows: Any, cols: Any, h: Any, size: Any, out: Any) -> None:
    """Choose for each pixel of a level one of K places, `choices` (K, H, W, 2), that overlaps least with those around.

    ``rows``, ``cols``: absolute coordinates, whose parities give the class of a pixel. Classes are processed in turn,
    and a pixel considers pixels of earlier classes only, so that it depends on SCATTER_REACH (SCATTER_CLASSES - 1) px
    to each side. Ties go to the first place. ``out`` (H, W, 2): exemplar pixels (y, x).
    """
    height, width = out.shape[:2]
    for turn in range(SCATTER_CLASSES):
        for i in range(height):
            for j in range(width):
                if 2 * (rows[i] & 1) + (cols[j] & 1) != turn:
                    continue
                best, kept = 0 * h, -1
                for k in range(choices.shape[0]):
                    y, x = choices[k, i, j, 0], choices[k, i, j, 1]
                    total = 0 * h
                    for di in range(-min(SCATTER_REACH, i), min(SCATTER_REACH, height - 1 - i) + 1):
                        for dj in range(-min(SCATTER_REACH, j), min(SCATTER_REACH, width - 1 - j) + 1):
                            if 2 * (rows[i + di] & 1) + (cols[j + dj] & 1) < turn:
                                oy, ox = out[i + di, j + dj, 0], out[i + di, j + dj, 1]
                                total += weighted_overlap(y, x, oy, ox, di, dj, h, size)
                    if kept < 0 or total < best:
                        best, kept = total, k
                out[i, j, 0], out[i, j, 1] = choices[kept, i, j, 0], choices[kept, i, j, 1]
