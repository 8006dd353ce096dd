"""Kernels of the least distance of repeats: where a patch may begin so that none of its pixels returns too near."""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel


@kernel
def axis_distance(a: int, b: int, length: int, wrap: int) -> int:
    """Distance of two canvas coordinates along one axis, the short way round if it wraps."""
    d = abs(a - b)
    if wrap:
        d %= length  # exemplar coordinates are in it, too: it may be longer than the canvas
        return min(d, length - d)
    return d


@kernel
def forbid(
    others: Any, y: int, x: int, shape: Any, canvas: Any, frames: Any, offsets: Any, distance: int, mask: Any
) -> None:
    """Clear in `mask` the patches that, laid at (y, x), would return too near to any of `others` (n, 8).

    `mask`: a flat uint8 table over the first pixels of all variants, that of variant v at ``offsets[v, 0]`` with
    ``offsets[v, 1:3]`` rows and columns. Plainly: what `returns_too_near` of repetition_kernels says of every patch and
    every other, painted as one rectangle for each.
    """
    h, w = shape[0], shape[1]
    reach = max(h, w)
    for v in range(len(frames)):
        rows, columns = offsets[v, 1], offsets[v, 2]
        begin = mask[offsets[v, 0] : offsets[v, 0] + rows * columns]
        if not len(begin):
            continue
        table, f = begin.reshape(rows, columns), frames[v]
        for b in others:
            if b[5] != f[0]:
                continue
            if b[0] == v:
                forbid_alike(table, b, y, x, h, w, canvas, f[7], f[8], distance)
                continue
            dy = max(axis_distance(y, b[3], canvas[0], canvas[2]) - reach, 0)
            dx = max(axis_distance(x, b[4], canvas[1], canvas[3]) - reach, 0)
            if dy * dy + dx * dx >= distance * distance:
                continue
            if f[7] > 0:
                table[:] = 0
                continue
            # Centres less than a side apart: twice those of the candidates are 2 f + J (2 u + h - 1, 2 s + w - 1).
            p, q = b[6] - 2 * f[1], b[7] - 2 * f[2]  # the inverse of an isometry is its transpose
            u, s = f[3] * p + f[5] * q - h + 1, f[4] * p + f[6] * q - w + 1
            u0, u1 = max((u - 2 * reach) // 2 + 1, 0), min((u + 2 * reach + 1) // 2, rows)
            s0, s1 = max((s - 2 * reach) // 2 + 1, 0), min((s + 2 * reach + 1) // 2, columns)
            for i in range(u0, u1 if s0 < s1 else u0):
                first = np.uint64(i * columns + s0)  # unsigned: the loop becomes one filling of memory
                for j in range(np.uint64(s1 - s0)):
                    begin[first + j] = 0


@kernel
def forbid_alike(
    table: Any, b: Any, y: int, x: int, h: int, w: int, canvas: Any, tall: int, wide: int, distance: int
) -> None:
    """Clear the patches of b's own variant that share pixels with it and would show one too near.

    A patch that begins (down, right) beside b shows b's pixels moved by its window's place less (down, right).
    `tall`, `wide`: the size of a toroidal exemplar, else 0.
    """
    rows, columns = table.shape
    i0, i1 = (-(h // tall) - 2, h // tall + 2) if tall else (0, 0)
    j0, j1 = (-(w // wide) - 2, w // wide + 2) if wide else (0, 0)
    for i in range(i0, i1 + 1):
        first = b[1] - i * tall
        for u in range(max(first - h + 1, 0), min(first + h, rows)):
            dy = axis_distance(y - (u - first), b[3], canvas[0], canvas[2])
            room = distance * distance - dy * dy
            if room <= 0:
                continue
            for j in range(j0, j1 + 1):
                left = b[2] - j * wide
                for s in range(max(left - w + 1, 0), min(left + w, columns)):
                    dx = axis_distance(x - (s - left), b[4], canvas[1], canvas[3])
                    if dx * dx < room and (dy != 0 or dx != 0):
                        table[u, s] = 0
