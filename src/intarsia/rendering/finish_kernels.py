"""How much a neighbourhood of a picture is darker or lighter than the exemplar says it should be."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from ..kernels.pieces_of_maps import J
from .cell_kernels import Map

Array = NDArray[Any]


class Sums(NamedTuple):
    """Sums over the pixels above and left of every corner of some pictures, laid end to end.

    Sums may overflow: what is taken from them are sums over boxes, which fit, and whole numbers of 64 bits come
    out right around any overflow.
    """

    values: NDArray[np.int64]  # (corners, C): of weight x value
    weights: NDArray[np.int64]  # (corners, 1), or (0, 1) where every pixel weighs 1
    table: NDArray[np.int64]  # (n, 4): number of the first corner, height, width, 1 if toroidal


@kernel
def add_up(values: Array, weight: NDArray[np.int64], sums: NDArray[np.int64]) -> None:
    """Fill the sums (h + 1, w + 1, C) of whole numbers (h, w, C); `weight` (h, w) may be empty: all weigh 1."""
    height, width, channels = values.shape
    sums[0] = 0
    for y in range(height):
        for c in range(channels):
            sums[y + 1, 0, c] = 0
        for c in range(channels):
            row = np.int64(0)
            for x in range(width):
                row += values[y, x, c] * weight[y, x] if weight.size > 0 else np.int64(values[y, x, c])
                sums[y + 1, x + 1, c] = sums[y, x + 1, c] + row


@kernel
def take_off(values: NDArray[np.int64], part: Map, table: NDArray[np.int64], smooth: NDArray[np.int64]) -> None:
    """Subtract from every pixel (h, w, C) what is `smooth` (pixels, C) at the exemplar pixel that it shows."""
    yx, which, _ = part
    for y in range(values.shape[0]):
        for x in range(values.shape[1]):
            w = which[y, x]
            u = table[w, 0] + yx[y, x, 0] * table[w, 2] + yx[y, x, 1]
            for c in range(values.shape[2]):
                values[y, x, c] -= smooth[u, c]


@kernel
def _corner(sums: NDArray[np.int64], at: NDArray[np.int64], y: int, x: int, c: int) -> int:
    """Sum all above row y and left of column x, where rows and columns go on around the picture."""
    first, height, width = at[0], at[1], at[2]
    stride = width + 1
    above, rows = y // height, y % height
    left, columns = x // width, x % width
    total: int = above * left * sums[first + height * stride + width, c] + sums[first + rows * stride + columns, c]
    total += above * sums[first + height * stride + columns, c] + left * sums[first + rows * stride + width, c]
    return total


@kernel
def _box_sum(sums: NDArray[np.int64], at: NDArray[np.int64], box: tuple[int, int, int, int], c: int) -> int:
    """Sum over rows top .. bottom - 1 and columns left .. right - 1 of a picture that goes on around itself."""
    top, left, bottom, right = box
    total: int = _corner(sums, at, bottom, right, c) - _corner(sums, at, bottom, left, c)
    return total - _corner(sums, at, top, right, c) + _corner(sums, at, top, left, c)


@kernel
def add_means(sums: Sums, radius: int, smooth: NDArray[np.int64]) -> None:
    """Add to every pixel of all pictures (pixels, C) the mean over the box around it, rounded down."""
    u = 0
    for n in range(sums.table.shape[0]):
        at = sums.table[n]
        for y in range(at[1]):
            for x in range(at[2]):
                box = (y - radius, x - radius, y + radius + 1, x + radius + 1)
                if at[3] == 0:
                    box = (max(box[0], 0), max(box[1], 0), min(box[2], at[1]), min(box[3], at[2]))
                weight = (box[2] - box[0]) * (box[3] - box[1])
                if sums.weights.size > 0:
                    weight = _box_sum(sums.weights, at, box, 0)
                if weight > 0:
                    for c in range(smooth.shape[1]):
                        smooth[u, c] += _box_sum(sums.values, at, box, c) // weight
                u += 1


@kernel
def _less(total: int, n: int, other: int, m: int) -> float:
    """Return total / n - other / m, exactly 0 where both are equal whole numbers; 0 where either has no weight."""
    if n <= 0 or m <= 0:
        return 0.0
    if n == m:
        return float(total - other) / float(n)
    i, j = total // n, other // m
    return float(i - j) + (float(total - i * n) / float(n) - float(other - j * m) / float(m))


@kernel
def step_sizes(
    part: Map, own: Sums, theirs: Sums, corner: tuple[int, int], radius: int, out: NDArray[np.float64]
) -> None:
    """Add how much lighter the surroundings of every pixel are than those of the exemplar pixel that it shows.

    `part` is the map of a cell (yx, which, pose), `own` holds the picture around it, in which the cell begins at
    `corner`, `theirs` the exemplars. `out` (h, w, C) grows by mean of the picture - mean of the exemplar. The box of
    the picture ends at its border, and the exemplar's ends there, too, so that inside a piece both means are of the
    same pixels, and differ by exactly 0. Where the exemplar ends its box is cut, too, but not the picture's: there
    is a seam, and what lies beyond has to be heard.
    """
    yx, which, pose = part
    here = own.table[0]
    stride = here[2] + 1
    for y in range(out.shape[0]):
        row = corner[0] + y
        top, bottom = max(-radius, -row), min(radius, here[1] - 1 - row)
        for x in range(out.shape[1]):
            column = corner[1] + x
            left, right = max(-radius, -column), min(radius, here[2] - 1 - column)
            p, at = pose[y, x], theirs.table[which[y, x]]
            i, j = yx[y, x, 0], yx[y, x, 1]
            u0, u1, v0, v1 = i + top, i + bottom + 1, j + left, j + right + 1
            if p != 0:
                a, b, c, d = J[p, 0], J[p, 1], J[p, 2], J[p, 3]
                u0 = i + min(a * top, a * bottom) + min(b * left, b * right)
                u1 = i + max(a * top, a * bottom) + max(b * left, b * right) + 1
                v0 = j + min(c * top, c * bottom) + min(d * left, d * right)
                v1 = j + max(c * top, c * bottom) + max(d * left, d * right) + 1
            if at[3] == 0:
                u0, u1, v0, v1 = max(u0, 0), min(u1, at[1]), max(v0, 0), min(v1, at[2])
            # Corners of both boxes: upper left, upper right, lower left, lower right.
            e = (row + top) * stride + column + left
            f, g = e + right - left + 1, e + (bottom - top + 1) * stride
            h = f + g - e
            q = at[0] + u0 * (at[2] + 1) + v0
            r, s = q + v1 - v0, q + (u1 - u0) * (at[2] + 1)
            t = r + s - q
            inside = u0 >= 0 and u1 <= at[1] and v0 >= 0 and v1 <= at[2]
            n, m = (bottom - top + 1) * (right - left + 1), (u1 - u0) * (v1 - v0)
            if own.weights.size > 0:
                n = own.weights[h, 0] - own.weights[g, 0] - own.weights[f, 0] + own.weights[e, 0]
            if theirs.weights.size > 0:
                if inside:
                    m = theirs.weights[t, 0] - theirs.weights[s, 0] - theirs.weights[r, 0] + theirs.weights[q, 0]
                else:
                    m = _box_sum(theirs.weights, at, (u0, v0, u1, v1), 0)
            for k in range(out.shape[2]):
                shown = own.values[h, k] - own.values[g, k] - own.values[f, k] + own.values[e, k]
                if inside:
                    meant = theirs.values[t, k] - theirs.values[s, k] - theirs.values[r, k] + theirs.values[q, k]
                else:
                    meant = _box_sum(theirs.values, at, (u0, v0, u1, v1), k)
                out[y, x, k] += _less(shown, n, meant, m)


@kernel
def move_codes(codes: Array, steps: NDArray[np.float64], factor: float, spread: NDArray[np.float64]) -> None:
    """Add `factor` times steps to integer codes (h, w, C), within the range `spread` (C, 2) of the exemplars."""
    for y in range(codes.shape[0]):
        for x in range(codes.shape[1]):
            for c in range(codes.shape[2]):
                if steps[y, x, c] != 0:
                    own = float(codes[y, x, c])
                    wanted = own + factor * steps[y, x, c]
                    kept = min(max(wanted, min(spread[c, 0], own)), max(spread[c, 1], own))
                    codes[y, x, c] = np.int64(np.floor(kept + 0.5))
