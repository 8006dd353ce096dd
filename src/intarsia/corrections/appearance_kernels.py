"""Appearance vectors: neighbourhoods on few axes, the tables that corrections compare with, and what looks alike."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel
from ..kernels.kd_tree import _insert, ask_apart, asking_room, pixels_apart


@kernel
def project_neighbourhoods(planes: Any, h: int, whole: Any, out: Any) -> None:
    """Project the 5 x 5 neighbourhoods at spacing `h`: planes (C, H + 4 h, W + 4 h) int32 -> out (H, W, D) int32.

    ``whole`` (D, 25, C): axes in 1 / 16384. All sums stay below 2**31, because the axes have length 1.
    """
    channels, width = planes.shape[0], out.shape[1]
    sums = np.empty(width, np.int32)
    for y in range(out.shape[0]):
        for d in range(whole.shape[0]):
            sums[:] = 8192
            for tap in range(25):
                for c in range(channels):
                    weight = np.int32(whole[d, tap, c])
                    row = planes[c, y + tap // 5 * h]
                    start = tap % 5 * h
                    read = row[start : start + width]
                    for x in range(width):
                        sums[x] = np.int32(sums[x] + weight * read[x])
            for x in range(width):
                out[y, x, d] = sums[x] >> 14


@kernel
def diagonal_table(padded: Any, h: int, border: int, table: Any) -> None:
    """Write three times the features of the four diagonal neighbours of each pixel inside the border: (positions, 32).

    ``padded`` (rows, columns, 8), the border included, which is at least `h` wide.
    """
    height, width = padded.shape[0], padded.shape[1]
    for y in range(border, height - border):
        for x in range(border, width - border):
            row = table[y * width + x]
            for j in range(4):
                value = padded[y + h * ((j & 2) - 1), x + h * (2 * (j & 1) - 1)]
                for d in range(8):
                    row[8 * j + d] = 3 * value[d]


@kernel
def colour_table(padded: Any, h: int, border: int, mask: Any, table: Any) -> None:
    """Write the weighted 5 x 5 colours at spacing `h` of each pixel inside the border, 2 h at least: (positions, n)."""
    height, width, channels = padded.shape
    for y in range(border, height - border):
        for x in range(border, width - border):
            row = table[y * width + x]
            for k in range(25):
                for c in range(channels):
                    row[k * channels + c] = (padded[y + (k // 5 - 2) * h, x + (k % 5 - 2) * h, c] * mask[k]) >> 8


@kernel
def jump_sets(tree: Any, queries: Any, vectors: Any, free: Any, limits: Any, asked: int, out: Any) -> None:
    """Write for each query its most similar targets, apart from it and from one another, (N, k - 1, 2).

    ``queries`` (N, 2 + D): pixel and point; ``vectors`` (N, n): the same as whole neighbourhoods, by which those that
    the tree names are ranked, equal ones by their number; ``free`` (M,): which queries are the tree's points.
    -1 where there are no more. One leaf comes after the other, so that what they look into stays in the nearest cache.
    """
    near, number = np.empty(asked, np.int64), np.empty(asked, np.int64)
    exact, ranked = np.empty(asked, np.int64), np.empty(asked, np.int64)
    targets, room, length = queries[free, :2], asking_room(queries.shape[1] - 2), np.uint64(vectors.shape[1])
    others, flat = np.ones(len(queries), np.bool_), vectors.reshape(vectors.size)
    others[free] = False
    for q in np.concatenate((free[tree.order], np.flatnonzero(others))):
        count = ask_apart(tree, queries[q, 2:], targets, (queries[q, 0], queries[q, 1]), limits, near, number, room)
        for c in range(count):
            total, a, b = np.int32(0), np.uint64(q) * length, np.uint64(free[number[c]]) * length
            for i in range(length):  # as corrections add up
                gap = np.int16(flat[a + i] - flat[b + i])
                total = np.int32(total + np.int32(gap) * np.int32(gap))
            _insert(exact, ranked, c + 1, total, number[c])
        kept = 0
        for c in range(count):
            at = targets[ranked[c]]
            clear = kept < out.shape[1]
            for m in range(kept):
                clear = clear and pixels_apart(at[0], at[1], out[q, m, 0], out[q, m, 1], limits) >= limits[3]
            if clear:
                out[q, kept, 0], out[q, kept, 1] = at[0], at[1]
                kept += 1


@kernel
def spread_jumps(cells: Any, step: int, border: int, inner: Any, jumps: Any) -> None:
    """Hand the jumps of every step-th pixel (rows, columns, k - 1, 2) to all pixels, as positions (positions, k - 1).

    ``inner`` (rows, columns), the border included: the pixel that lies there, or -1 outside. A pixel between takes what
    lies beside the jump; where that is outside there is none.
    """
    height, width = inner.shape
    for y in range(height - 2 * border):
        for x in range(width - 2 * border):
            for i in range(cells.shape[2]):
                to, at = cells[y // step, x // step, i], (y + border) * width + x + border
                jumps[at, i] = -1
                if to[0] >= 0:
                    jumps[at, i] = inner[to[0] + y % step + border, to[1] + x % step + border]
