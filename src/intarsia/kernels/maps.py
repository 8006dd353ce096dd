"""Kernels on maps: reading windows of a partial map, pasting patches by a minimum cut, connected pieces.

A window is given by its first pixel; on wrapped axes it may reach over the border.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int16, Int32, Int64, UInt8
from ..foundation.geometry import ISOMETRIES
from .cuts import find_root, min_cut, seam_costs
from .jit import kernel
from .maxflow import FREE, NEW, OLD

HOLE = 255  # the variant of a pixel that is not filled: the last name of a uint8


class PartialMap(NamedTuple):
    """A partial map."""

    variant: UInt8  # (H, W): number of the exemplar in an isometry, HOLE where nothing is known
    yx: Int32  # (H, W, 2): the source pixel, row and column
    wrap: tuple[bool, bool]  # whether rows and columns wrap


class OrientedExemplars(NamedTuple):
    """The exemplars in their isometries, end to end; a toroidal one is followed by its own beginning."""

    flat: Int16  # (numbers,): features, channel by channel of each pixel
    table: Int64  # (V, 4): where each begins in flat, height, width and stride, px


@kernel
def canvas_place(at: int, length: int, wrap: bool) -> int:
    """Return the canvas coordinate, modulo the length if the axis wraps; -1 outside."""
    if 0 <= at < length:
        return at
    return at % length if wrap else -1


@kernel
def gather_window(grown: Any, posed: Any, y0: int, x0: int, feats: Any, known: Any) -> int:
    """Read the features under a window into `feats` (h, w, C), and into `known` (h, w) which pixels have any.

    Return the number of known pixels.
    """
    (variant, yx, wrap), (flat, table) = grown, posed
    height, width = variant.shape
    h, w, channels = feats.shape
    count = 0
    for i in range(h):
        row, there = canvas_place(y0 + i, height, wrap[0]), known[i]
        line = feats[i].reshape(w * channels)
        for j in range(w):
            x = canvas_place(x0 + j, width, wrap[1])
            v = variant[row, x] if row >= 0 and x >= 0 else np.uint8(HOLE)
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
def gather_all(grown: Any, posed: Any, at: Any, feats: Any, known: Any) -> None:
    """Apply :func:`gather_window` to the windows that begin at `at` (n, 2)."""
    for k in range(len(at)):
        gather_window(grown, posed, at[k, 0], at[k, 1], feats[k], known[k])


@kernel
def known_beside(variant: Any, y0: int, x0: int, wrap: Any, i: int, j: int, h: int, w: int, k: int) -> bool:
    """Return whether side `k` of pixel (i, j) of a window is the window's edge, with a known pixel beyond it."""
    height, width = variant.shape
    a, b = i + (k == 0) - (k == 1), j + (k == 2) - (k == 3)
    if 0 <= a < h and 0 <= b < w:
        return False
    if (h == height and not 0 <= a < h) or (w == width and not 0 <= b < w):
        return False  # the window is as long as the canvas: its opposite edges meet
    y, x = canvas_place(y0 + a, height, wrap[0]), canvas_place(x0 + b, width, wrap[1])
    return y >= 0 and x >= 0 and variant[y, x] != HOLE


@kernel
def write_constraints(grown: Any, locked: Any, y0: int, x0: int, known: Any, state: Any) -> None:
    """Write the constraint of every pixel of a window: OLD, FREE or NEW.

    OLD if it is locked, or lies on the window's edge next to a known pixel outside: the cut then
    runs inside the window, where both sides are known. NEW if it is not known, or touches such a pixel, for the
    same reason.
    """
    variant, wrap = grown.variant, grown.wrap
    height, width = variant.shape
    h, w = known.shape
    for i in range(h):
        above, here, below = known[max(i - 1, 0)], known[i], known[min(i + 1, h - 1)]
        for j in range(1, w - 1):
            near = here[j - 1] & here[j + 1] & above[j] & below[j]
            state[i, j] = FREE if here[j] & near else NEW
        for j in (0, w - 1):
            near = here[max(j - 1, 0)] & here[min(j + 1, w - 1)] & above[j] & below[j]
            state[i, j] = FREE if here[j] & near else NEW
        row = canvas_place(y0 + i, height, wrap[0])
        if row >= 0 and 0 <= x0 <= width - w:
            line, given = state[i], locked[row, x0 : x0 + w]
            for j in range(w):
                line[j] = OLD if here[j] & given[j] else line[j]
        else:
            for j in range(w):
                if here[j] and locked[row, canvas_place(x0 + j, width, wrap[1])]:
                    state[i, j] = OLD
        for k, j in ((2, w - 1), (3, 0)):
            if here[j] and known_beside(variant, y0, x0, wrap, i, j, h, w, k):
                state[i, j] = OLD
    for k, i in ((0, h - 1), (1, 0)):
        for j in range(w):
            if known[i, j] and known_beside(variant, y0, x0, wrap, i, j, h, w, k):
                state[i, j] = OLD


@kernel
def cut_in_middle(grown: Any, locked: Any, y0: int, x0: int, known: Any, seam: Any, take: Any) -> None:
    """Cut straight through the middle of the overlap: old pixels stay in its outer half (Multrus 2003, B.1.4).

    `seam` (2,): rows and columns of the overlap. An old pixel stays if it is locked, or lies within half an overlap
    of an edge of the window beyond which something is known. Of an odd overlap the half at the top and left is the
    larger one: the cut is the same whichever of two windows is placed first. At the upper right corner
    only the top counts, as in a raster scan, where nothing lies to the right.
    """
    variant, wrap = grown.variant, grown.wrap
    height, width = variant.shape
    h, w = known.shape
    rows, columns = (seam[0] + 1) // 2, (seam[1] + 1) // 2
    below, right = seam[0] // 2, seam[1] // 2
    for i in range(h):
        for j in range(w):
            take[i, j] = 1
            if known[i, j] == 0:
                continue
            stays = locked[canvas_place(y0 + i, height, wrap[0]), canvas_place(x0 + j, width, wrap[1])]
            stays = stays or (i < rows and known_beside(variant, y0, x0, wrap, 0, j, h, w, 1))
            stays = stays or (i >= h - below and known_beside(variant, y0, x0, wrap, h - 1, j, h, w, 0))
            stays = stays or (j < columns and known_beside(variant, y0, x0, wrap, i, 0, h, w, 3))
            if i >= seam[0] or not known_beside(variant, y0, x0, wrap, 0, j, h, w, 1):  # corners are the top's
                stays = stays or (j >= w - right and known_beside(variant, y0, x0, wrap, i, w - 1, h, w, 2))
            take[i, j] = not stays


@kernel
def write_patch(grown: Any, posed: Any, y0: int, x0: int, v: int, u: int, s: int, take: Any) -> None:
    """Write the patch of variant `v` at (u, s) into the window, where `take` is set and inside the canvas."""
    (variant, yx, wrap), table = grown, posed.table
    height, width = variant.shape
    rows, columns = table[v, 1], table[v, 2]
    for i in range(take.shape[0]):
        y = canvas_place(y0 + i, height, wrap[0])
        row = (u + i) % rows
        if y < 0:
            continue
        if 0 <= x0 <= width - take.shape[1] and s + take.shape[1] <= columns:
            here, line, at = take[i], variant[y, x0 : x0 + take.shape[1]], yx[y, x0 : x0 + take.shape[1]]
            for j in range(np.uint64(take.shape[1])):
                if here[j]:
                    line[j], at[j, 0], at[j, 1] = v, row, s + j
            continue
        for j in range(take.shape[1]):
            if not take[i, j]:
                continue
            x = canvas_place(x0 + j, width, wrap[1])
            if x >= 0:
                variant[y, x] = v
                yx[y, x, 0] = row
                yx[y, x, 1] = s + j if s + j < columns else (s + j) % columns


@kernel
def paste(
    grown: Any, locked: Any, posed: Any, y0: int, x0: int, v: int, u: int, s: int, feats: Any, known: Any,
    price: Any,
) -> None:  # fmt: skip
    """Paste the patch of variant `v` at (u, s) into the window at (y0, x0) along a minimum cut.

    `feats` (h, w, C) and `known` (h, w) are those of :func:`gather_window`; unknown `feats` are filled in.
    `locked` (H, W): the pixels of the map that must stay.
    """
    flat, table = posed
    h, w, channels = feats.shape
    take = np.ones((h, w), np.uint8)
    state = np.empty((h, w), np.uint8)
    write_constraints(grown, locked, y0, x0, known, state)
    if known.any():
        new = np.empty((h, w, channels), np.int16)
        for i in range(h):
            k = table[v, 0] + ((u + i) * table[v, 3] + s) * channels
            line, patch = new[i].reshape(w * channels), flat[k : k + w * channels]
            for j in range(np.uint64(w * channels)):
                line[j] = patch[j]
            for j in range(w):
                if not known[i, j]:  # nothing to differ from
                    for c in range(channels):
                        feats[i, j, c] = new[i, j, c]
        right, down = seam_costs(feats, new, price)
        min_cut(state, right, down, take)
    write_patch(grown, posed, y0, x0, v, u, s, take)


@kernel
def overlay(
    grown: Any, locked: Any, posed: Any, y0: int, x0: int, v: int, u: int, s: int, known: Any, seam: Any
) -> None:
    """Paste the patch of variant `v` at (u, s) into the window, cut straight in the middle of the overlaps."""
    take = np.empty(known.shape, np.uint8)
    cut_in_middle(grown, locked, y0, x0, known, seam, take)
    write_patch(grown, posed, y0, x0, v, u, s, take)


J = np.array([isometry.j for isometry in ISOMETRIES], dtype=np.int64).reshape(8, 4)
"""The matrices of the eight isometries, (a, b, c, d) each: rows move by a y + b x, columns by c y + d x."""

# Columns of the tables of pieces and groups; TOP .. RIGHT is the box of the pixels themselves, half open.
WHICH, POSE, OY, OX, TOP, LEFT, BOTTOM, RIGHT = range(8)

@kernel
def _first_pass(
    yx: Int32,
    which: UInt8,
    pose: UInt8,
    labels: Int32,
    parent: Int32,
) -> int:
    """Join every pixel to its left and upper neighbour where the exemplar continues."""
    height, width = which.shape
    count = 0
    for y in range(height):
        for x in range(width):
            w, p = which[y, x], pose[y, x]
            label = -1
            if x > 0 and which[y, x - 1] == w:
                same = pose[y, x - 1] == p
                same &= yx[y, x, 0] - yx[y, x - 1, 0] == J[p, 1] and yx[y, x, 1] - yx[y, x - 1, 1] == J[p, 3]
                if same or w == HOLE:
                    label = find_root(parent, labels[y, x - 1])
            if y > 0 and which[y - 1, x] == w:
                same = pose[y - 1, x] == p
                same &= yx[y, x, 0] - yx[y - 1, x, 0] == J[p, 0] and yx[y, x, 1] - yx[y - 1, x, 1] == J[p, 2]
                if same or w == HOLE:
                    other = find_root(parent, labels[y - 1, x])
                    if label < 0:
                        label = other
                    elif label != other:  # the smaller number stays the root, so roots come first in the raster
                        parent[max(label, other)] = min(label, other)
                        label = min(label, other)
            if label < 0:
                label = count
                parent[count] = count
                count += 1
            labels[y, x] = label
    return count


@kernel
def label_pieces(
    yx: Int32, which: UInt8, pose: UInt8
) -> tuple[Int32, Int64]:
    """Number the connected pieces of a map in the order of their first pixels.

    Four-neighbours belong together when exemplar and pose are equal and the exemplar continues from one to
    the other; holes are a class of their own. Returns the numbers (H, W) and a table (n, 8): exemplar, pose,
    offset ``S(q) - J q`` (row, column), box (top, left, bottom, right).
    """
    height, width = which.shape
    labels = np.empty((height, width), np.int32)
    parent = np.empty(height * width, np.int32)
    count = _first_pass(yx, which, pose, labels, parent)
    number = np.empty(count, np.int32)
    pieces = 0
    for k in range(count):
        if parent[k] == k:
            number[k] = pieces
            pieces += 1
        else:
            number[k] = number[find_root(parent, k)]
    table = np.empty((pieces, 8), np.int64)
    table[:, TOP] = -1
    for y in range(height):
        for x in range(width):
            n = number[labels[y, x]]
            labels[y, x] = n
            row = table[n]
            if row[TOP] < 0:
                p = pose[y, x]
                row[WHICH], row[POSE] = which[y, x], p
                row[OY] = yx[y, x, 0] - J[p, 0] * y - J[p, 1] * x
                row[OX] = yx[y, x, 1] - J[p, 2] * y - J[p, 3] * x
                row[TOP], row[LEFT], row[RIGHT] = y, x, x + 1
            row[BOTTOM] = y + 1
            row[LEFT] = min(row[LEFT], x)
            row[RIGHT] = max(row[RIGHT], x + 1)
    return labels, table
