"""Appearance vectors: neighbourhoods on few axes, the tables that corrections compare with, and jumps."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel


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
def sample_neighbourhoods(planes: Any, h: int, every: int, out: Any) -> None:
    """Read the 5 x 5 neighbourhoods at spacing `h` of every so many-th pixel: out (N, 25 C) float64, tap by tap."""
    channels, width = planes.shape[0], planes.shape[2] - 4 * h
    for n in range(len(out)):
        y, x = n * every // width, n * every % width
        for k in range(25):
            for c in range(channels):
                out[n, k * channels + c] = planes[c, y + k // 5 * h, x + k % 5 * h]


@kernel
def project_rows(rows: Any, whole: Any, out: Any) -> None:
    """Project whole vectors (N, n) int16 on axes (D, n) int32, in 1 / 4096 and of length 1: out (N, D) int32."""
    n = np.uint64(rows.shape[1])
    flat, axes = rows.reshape(rows.size), whole.reshape(whole.size)
    for i in range(len(rows)):
        for d in range(len(whole)):
            total, at, to = np.int32(0), np.uint64(i) * n, np.uint64(d) * n
            for k in range(n):
                total = np.int32(total + np.int32(flat[at + k]) * axes[to + k])
            out[i, d] = total >> 12


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
def colour_table(padded: Any, h: int, border: int, roots: Any, table: Any) -> None:
    """Write the 5 x 5 colours at spacing `h` of each pixel inside the border, 2 h at least: (positions, n)."""
    height, width, channels = padded.shape
    for y in range(border, height - border):
        for x in range(border, width - border):
            row = table[y * width + x]
            for k in range(25):
                for c in range(channels):
                    row[k * channels + c] = (padded[y + (k // 5 - 2) * h, x + (k % 5 - 2) * h, c] * roots[k]) >> 8


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
