"""Windows of a growing map: what is known in them, and how a patch is cut into them.

A growing map is two arrays: ``variant`` (H, W) uint8, HOLE where nothing is known, and ``yx`` (H, W, 2) int32,
the pixel of that variant. A window is named by its first pixel; on wrapped axes it may reach over the border.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .cuts import min_cut, seam_costs
from .jit import kernel

HOLE = 255
OLD, FREE, NEW = 0, 1, 2


@kernel
def gather(variant: Any, yx: Any, flat: Any, table: Any, y0: int, x0: int, feats: Any, known: Any) -> int:
    """Read the features under a window into `feats` (h, w, C), and into `known` where there are any.

    Returns the number of known pixels.
    """
    height, width = variant.shape
    h, w, channels = feats.shape
    count = 0
    for i in range(h):
        row, there = (y0 + i) % height, known[i]
        line = feats[i].reshape(w * channels)
        for j in range(w):
            x = x0 + j if x0 + j < width else x0 + j - width
            v = variant[row, x]
            if v == HOLE:
                there[j] = 0
                for c in range(channels):
                    line[j * channels + c] = 0
                continue
            there[j] = 1
            count += 1
            at = table[v, 0] + (yx[row, x, 0] * table[v, 3] + yx[row, x, 1]) * channels
            for c in range(channels):
                line[j * channels + c] = flat[at + c]
    return count


@kernel
def gather_all(variant: Any, yx: Any, flat: Any, table: Any, at: Any, feats: Any, known: Any) -> None:
    """Apply :func:`gather` to the windows that begin at `at` (n, 2)."""
    for k in range(len(at)):
        gather(variant, yx, flat, table, at[k, 0], at[k, 1], feats[k], known[k])


@kernel
def mark(variant: Any, locked: Any, y0: int, x0: int, wrap_y: bool, wrap_x: bool, known: Any, state: Any) -> None:
    """Say of every pixel of a window whether it must stay, must be new, or may be either.

    It must stay where it is locked, or lies on the window's edge beside a known pixel outside: the cut then
    runs inside the window, where both sides are known. It must be new where nothing is known, or where it
    touches such a pixel, for the same reason.
    """
    height, width = variant.shape
    h, w = known.shape
    for i in range(h):
        for j in range(w):
            if known[i, j] == 0:
                state[i, j] = NEW
                continue
            if locked[(y0 + i) % height, (x0 + j) % width]:
                state[i, j] = OLD
                continue
            state[i, j] = FREE
            for k in range(4):
                a, b = i + (k == 0) - (k == 1), j + (k == 2) - (k == 3)
                if a < 0 or a >= h or b < 0 or b >= w:
                    y, x = y0 + a, x0 + b
                    outside = (not wrap_y and (y < 0 or y >= height)) or (not wrap_x and (x < 0 or x >= width))
                    around = (h == height and (a < 0 or a >= h)) or (w == width and (b < 0 or b >= w))
                    if not outside and not around and variant[y % height, x % width] != HOLE:
                        state[i, j] = OLD
                        break
                elif known[a, b] == 0:
                    state[i, j] = NEW


@kernel
def write(variant: Any, yx: Any, table: Any, y0: int, x0: int, v: int, u: int, s: int, take: Any) -> None:
    """Write the patch of variant `v` at (u, s) into the window, wherever `take` says so."""
    height, width = variant.shape
    rows, columns = table[v, 1], table[v, 2]
    for i in range(take.shape[0]):
        y = (y0 + i) % height
        row = (u + i) % rows
        for j in range(take.shape[1]):
            if take[i, j]:
                x = x0 + j if x0 + j < width else x0 + j - width
                variant[y, x] = v
                yx[y, x, 0] = row
                yx[y, x, 1] = s + j if s + j < columns else (s + j) % columns


@kernel
def paste(
    variant: Any, yx: Any, locked: Any, flat: Any, table: Any, y0: int, x0: int, v: int, u: int, s: int,
    feats: Any, known: Any, wrap_y: bool, wrap_x: bool, gradient: bool,
) -> None:  # fmt: skip
    """Cut the patch of variant `v` at (u, s) into the window at (y0, x0) along the cheapest seam.

    `feats` (h, w, C) and `known` (h, w) are what :func:`gather` read there; `feats` is filled up.
    """
    h, w, channels = feats.shape
    take = np.ones((h, w), np.uint8)
    state = np.empty((h, w), np.uint8)
    mark(variant, locked, y0, x0, wrap_y, wrap_x, known, state)
    if known.any():
        stride = table[v, 3] * channels
        new = np.empty((h, w, channels), np.int16)
        for i in range(h):
            k = table[v, 0] + (u + i) * stride + s * channels
            for j in range(w):
                for c in range(channels):
                    new[i, j, c] = flat[k]
                    if not known[i, j]:
                        feats[i, j, c] = flat[k]  # nothing to differ from
                    k += 1
        right, down = seam_costs(feats, new, gradient)
        min_cut(state, right, down, take)
    write(variant, yx, table, y0, x0, v, u, s, take)


@kernel
def overlay(
    variant: Any, yx: Any, locked: Any, table: Any, y0: int, x0: int, v: int, u: int, s: int, shape: Any
) -> None:
    """Lay the patch of variant `v` at (u, s) over all of the window that is not locked."""
    take = np.empty((shape[0], shape[1]), np.uint8)
    for i in range(shape[0]):
        for j in range(shape[1]):
            take[i, j] = not locked[(y0 + i) % locked.shape[0], (x0 + j) % locked.shape[1]]
    write(variant, yx, table, y0, x0, v, u, s, take)
