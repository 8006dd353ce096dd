"""The correction operation: every pixel of a coordinate map becomes the exemplar pixel whose surroundings fit best.

Lefebvre and Hoppe 2005 and 2006; the memo of source 004. A coordinate map (H, W, 2) holds an exemplar pixel (y, x) for
each output pixel. Neighbouring output pixels stand for exemplar pixels that are `h` px apart.

All numbers are whole: features int16, distances int32, with the price of a jump int64.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .hashes import STEP, mixed
from .jit import kernel

HEIGHT, WIDTH, SPACING, PAD, STRIDE, SHIFT, TORUS = range(7)
REACH, LOOKUP_FIRST, FACTOR = range(3)
ONE = 256  # what FACTOR counts in: the squared price of a jump
FINE = 12  # bits after the point of a jitter
MIDDLE = 1023  # of packed appearance values, which run from 0 to 2046


class Site(NamedTuple):
    """One level of the exemplar, ready to be compared with.

    ``shape``: height, width, spacing h, border of the packed features, their row length, log2 of the step of the jump
    sets, 1 if toroidal. Of ``packed`` and ``values`` one is empty, which says what is compared.
    """

    shape: NDArray[np.int64]
    packed: NDArray[np.uint64]  # (rows * stride, 2): eight 16-bit appearance values of each pixel, all at least 0
    values: NDArray[np.int16]  # (H * W, C): colours
    mask: NDArray[np.int64]  # (25,): weights of the 5 x 5 colours, 256 = 1
    table: NDArray[np.int16]  # (H * W, n): the neighbourhood of each exemplar pixel
    open: NDArray[np.uint8]  # (H * W,): 1 where a candidate may lie
    jumps: NDArray[np.int32]  # (rows, columns, k - 1, 2): similar pixels of every step-th pixel, -1 where none is


class Axis(NamedTuple):
    """How the pixels of a level follow from those above them, along one axis."""

    parent: NDArray[np.int64]  # position in the coarser map
    step: NDArray[np.int64]  # exemplar px from the parent
    at: NDArray[np.int64]  # absolute coordinate, which draws belong to


@kernel
def descend(parents: Any, rows: Any, cols: Any, state: Any, spread: Any, home: Any, size: Any, out: Any) -> None:
    """Hand coordinates down to the next finer level, and jitter them by draws that belong to places.

    S[p] = S_coarse[parent] + step + floor(h r H(p) + 1/2), H(p) in [-1, 1) (2005, equations 1 and 2). ``state``: of the
    draws before the place is mixed in (uint64); ``spread`` (H, W): h r in 1 / 4096 px, over `out` or a single number
    for all; ``home``: for each exemplar pixel the one to use in its place, or empty; ``size``: of the exemplar.
    """
    height, width = size[0], size[1]
    everywhere, half = spread.size == 1, np.int64(1) << (FINE + 30)
    for i in range(out.shape[0]):
        z = mixed((state ^ np.uint64(rows.at[i])) + STEP)
        py, dy = rows.parent[i], rows.step[i]
        for j in range(out.shape[1]):
            px = cols.parent[j]
            y, x = parents[py, px, 0] + dy, parents[py, px, 1] + cols.step[j]
            r = np.int64(spread[0, 0] if everywhere else spread[i, j])
            if r:
                bits = mixed((z ^ np.uint64(cols.at[j])) + STEP)
                low, high = np.int64(bits & np.uint64(0xFFFFFFFF)), np.int64(bits >> np.uint64(32))
                y += (r * (high - 2147483648) + half) >> (FINE + 31)
                x += (r * (low - 2147483648) + half) >> (FINE + 31)
            if y < 0 or y >= height:
                y %= height
            if x < 0 or x >= width:
                x %= width
            if len(home):
                flat = np.int64(home[y * width + x])
                y, x = flat // width, flat % width
            out[i, j, 0], out[i, j, 1] = y, x


@kernel
def appearance_here(coords: Any, y: int, x: int, site: Any, words: Any) -> None:
    """Write the neighbourhood of output pixel (y, x): four diagonal points, each foretold three times and added.

    Plainly, for D in (+-1, +-1): the sum of F[S[p + D + D'] - h D'] over D' in 0, (D_y, 0), (0, D_x) (2006, section 4).
    Four 16-bit values lie in one word; three of at most 2046 add up without reaching the next.
    """
    h, pad, stride = site.shape[SPACING], site.shape[PAD], site.shape[STRIDE]
    for j in range(4):
        dy, dx = (j & 2) - 1, 2 * (j & 1) - 1
        qy, qx = y + dy, x + dx
        a = np.uint64((coords[qy, qx, 0] + pad) * stride + coords[qy, qx, 1] + pad)
        b = np.uint64((coords[qy + dy, qx, 0] + pad - h * dy) * stride + coords[qy + dy, qx, 1] + pad)
        c = np.uint64((coords[qy, qx + dx, 0] + pad) * stride + coords[qy, qx + dx, 1] + pad - h * dx)
        p = site.packed
        words[2 * j] = p[a, 0] + p[b, 0] + p[c, 0]
        words[2 * j + 1] = p[a, 1] + p[b, 1] + p[c, 1]


@kernel
def colours_here(coords: Any, y: int, x: int, site: Any, here: Any) -> None:
    """Write the 5 x 5 colours around output pixel (y, x), weighted by the mask."""
    width, channels = site.shape[WIDTH], site.values.shape[1]
    for k in range(25):
        qy, qx = y + k // 5 - 2, x + k % 5 - 2
        u = np.int64(coords[qy, qx, 0]) * width + coords[qy, qx, 1]
        for c in range(channels):
            here[k * channels + c] = (site.values[u, c] * site.mask[k]) >> 8


@kernel
def moved(y: Any, x: Any, site: Any) -> int:
    """Return the position of exemplar pixel (y, x), across the border of a toroidal exemplar, or -1 outside."""
    height, width = site.shape[HEIGHT], site.shape[WIDTH]
    if site.shape[TORUS]:
        y += height if y < 0 else -height if y >= height else 0
        x += width if x < 0 else -width if x >= width else 0
    elif y < 0 or x < 0 or y >= height or x >= width:
        return -1
    return np.int64(y) * width + x


@kernel
def jump(y: Any, x: Any, i: int, dy: int, dx: int, site: Any) -> int:
    """Return the position of the i-th pixel similar to (y, x), moved by (dy, dx); -1 if there is none."""
    shift = site.shape[SHIFT]
    cell = site.jumps[y >> shift, x >> shift, i]
    if cell[0] < 0:
        return -1
    rest = (np.int64(1) << shift) - 1
    return moved(cell[0] + (y & rest) + dy, cell[1] + (x & rest) + dx, site)


@kernel
def continuations(coords: Any, y: int, x: int, site: Any, reach: int, found: Any) -> int:
    """List the different exemplar pixels that continue what lies around (y, x): S[p + D] - h D; return how many."""
    h, count = site.shape[SPACING], 0
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            u = moved(coords[y + dy, x + dx, 0] - h * dy, coords[y + dy, x + dx, 1] - h * dx, site)
            if u >= 0 and not listed(found, count, u):
                found[count] = u
                count += 1
    return count


@kernel
def listed(found: Any, count: int, u: int) -> bool:
    """Say whether a position is among the first `count`."""
    for c in range(count):
        if found[c] == u:
            return True
    return False


@kernel
def looked_up(coords: Any, y: int, x: int, site: Any, reach: int, found: Any, count: int) -> int:
    """Append the jumps of 2005: what is similar to a neighbour's pixel, then shifted: C_i(S[p + D]) - h D."""
    h = site.shape[SPACING]
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            for i in range(site.jumps.shape[2]):
                u = jump(coords[y + dy, x + dx, 0], coords[y + dy, x + dx, 1], i, -h * dy, -h * dx, site)
                if u >= 0 and not listed(found, count, u):
                    found[count] = u
                    count += 1
    return count


@kernel
def shifted(site: Any, found: Any, count: int) -> int:
    """Append the jumps of the memo: what is similar to each of the `count` continuations."""
    width, known = site.shape[WIDTH], count
    for c in range(known):
        y, x = found[c] // width, found[c] % width
        for i in range(site.jumps.shape[2]):
            u = jump(y, x, i, 0, 0, site)
            if u >= 0 and not listed(found, count, u):
                found[count] = u
                count += 1
    return count


@kernel
def difference(here: Any, table: Any, u: int) -> Any:
    """Return the sum of squared differences between a neighbourhood and that of exemplar pixel `u`."""
    total, row = np.int32(0), np.uint64(u)
    for i in range(len(here)):
        d = np.int16(here[i] - table[row, i])
        total = np.int32(total + np.int32(d) * np.int32(d))
    return total


@kernel
def correct(coords: Any, rows: Any, cols: Any, low: int, high: int, site: Any, rule: Any, out: Any) -> None:
    """Find better coordinates for the pixels (rows[low:high], cols) of a map, into `out` (rows, cols, 2).

    The candidates are continuations of what lies around, and jumps to similar places, whose squared distance is
    multiplied by rule[FACTOR] / 256 (none if it is negative). The nearest wins; of equal ones the first, continuations
    before jumps; where no candidate may be used the pixel stays. The map is only read: what is found goes into it when
    all pixels of the subpass are done.
    """
    n, width, factor = site.table.shape[1], site.shape[WIDTH], rule[FACTOR]
    words = np.zeros((n + 3) // 4, np.uint64)
    here = words.view(np.int16)[:n]
    side = 2 * rule[REACH] + 1
    found = np.empty(side * side * (1 + site.jumps.shape[2]), np.int64)
    for i in range(low, high):
        y = rows[i]
        for j in range(len(cols)):
            x = cols[j]
            if len(site.packed):
                appearance_here(coords, y, x, site, words)
            else:
                colours_here(coords, y, x, site, here)
            near = continuations(coords, y, x, site, rule[REACH], found)
            best, at = np.int64(1) << 62, np.int64(-1)
            for c in range(near):
                if site.open[found[c]]:
                    d = np.int64(difference(here, site.table, found[c])) * ONE
                    if d < best:
                        best, at = d, found[c]
            if factor >= 0 and best > 0:
                if rule[LOOKUP_FIRST]:
                    count = looked_up(coords, y, x, site, rule[REACH], found, near)
                else:
                    count = shifted(site, found, near)
                for c in range(near, count):
                    if site.open[found[c]]:
                        d = np.int64(difference(here, site.table, found[c])) * factor
                        if d < best:
                            best, at = d, found[c]
            if at < 0:
                out[i, j, 0], out[i, j, 1] = coords[y, x, 0], coords[y, x, 1]
            else:
                out[i, j, 0], out[i, j, 1] = at // width, at % width


@kernel
def put(coords: Any, rows: Any, cols: Any, found: Any) -> None:
    """Write what a subpass found into the map."""
    for i in range(len(rows)):
        for j in range(len(cols)):
            coords[rows[i], cols[j], 0], coords[rows[i], cols[j], 1] = found[i, j, 0], found[i, j, 1]
