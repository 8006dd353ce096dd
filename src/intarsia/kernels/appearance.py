"""Appearance vectors: colour neighbourhoods projected on few axes, and the tables that corrections compare with."""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel


@kernel
def project(planes: Any, h: int, whole: Any, out: Any) -> None:
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
def sample(planes: Any, h: int, ys: Any, xs: Any, out: Any) -> None:
    """Read the 5 x 5 neighbourhoods of pixels (ys, xs) into `out` (N, 25 * C)."""
    channels = planes.shape[0]
    for n in range(len(ys)):
        for tap in range(25):
            for c in range(channels):
                out[n, tap * channels + c] = planes[c, ys[n] + tap // 5 * h, xs[n] + tap % 5 * h]


@kernel
def diagonal_table(padded: Any, h: int, table: Any) -> None:
    """Write three times the features of the four diagonal neighbours: padded (H + 2 h, W + 2 h, 8) -> (H * W, 32)."""
    height, width = padded.shape[0] - 2 * h, padded.shape[1] - 2 * h
    for y in range(height):
        for x in range(width):
            row = table[y * width + x]
            for j in range(4):
                value = padded[y + h + h * ((j & 2) - 1), x + h + h * (2 * (j & 1) - 1)]
                for d in range(8):
                    row[8 * j + d] = 3 * value[d]


@kernel
def colour_table(padded: Any, h: int, mask: Any, table: Any) -> None:
    """Write the weighted 5 x 5 colours at spacing `h`: padded (H + 4 h, W + 4 h, C) -> (H * W, 25 * C)."""
    height, width, channels = padded.shape[0] - 4 * h, padded.shape[1] - 4 * h, padded.shape[2]
    for y in range(height):
        for x in range(width):
            row = table[y * width + x]
            for k in range(25):
                for c in range(channels):
                    row[k * channels + c] = (padded[y + k // 5 * h, x + k % 5 * h, c] * mask[k]) >> 8
