"""Kernels of the appearance space: projected neighbourhoods, and jump sets by a kd-tree and propagation.

A kd-tree is queried for every fourth pixel. The others take the continuations of their neighbours' results, the pixels
at the same offset from these as they have from the neighbour, which are likely to be similar (k-coherence, Ashikhmin
2001; propagation, Barnes et al. 2009). A quarter of the queries, which may be shallower, find more similar pixels than
one query per pixel.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int16, Int64, Mask
from ..kernels.jit import kernel
from ..kernels.kd_tree import FAR, asking_room, pixels_apart, query_apart

BESIDE = np.int64(1) << 40  # added to the distance of pixels too near another jump
KEPT = 4  # results per jump that a queried pixel passes to its neighbours; doubled: 1 % nearer, 1.25 times the time


class Similar(NamedTuple):
    """The pixels among which similar ones are searched, those of a grid, row by row; numbers count them."""

    vectors: Int16  # (N * n,): their neighbourhoods
    length: np.uint64  # n
    places: Int64  # (N, 2): row and column in the exemplar
    free: Mask  # (N,): whether it may be jumped to
    limits: tuple[int, int, int, int, int]  # height, width, 1 if toroidal, least distance in px, leaves searched


@kernel
def moved(number: Any, dy: Any, dx: Any, shape: Any, torus: Any) -> Any:
    """Return the pixel at offset (dy, dx) from another on the grid; -1 beyond the border, or if `number` is -1.

    `shape`: of the grid; `torus`: it wraps.
    """
    rows, columns, _ = shape
    y, x = number // columns + dy, number % columns + dx
    if torus:
        y, x = y % rows, x % columns
    if number < 0 or y < 0 or x < 0 or y >= rows or x >= columns:
        return np.int64(-1)
    return y * columns + x


@kernel
def choose(known: Any, q: Any, offered: Any, n: Any, exact: Any, count: int, out: Any, at: Any) -> None:
    """Write the numbers of the most similar of `n` candidates `offered` to `q` into ``out[at]``, ties to the lowest.

    Candidates within ``limits[3]`` px of `q` are left out. The first `count` written are at least ``limits[3]`` px from
    one another, -1 where there are no more; the rest of ``out[at]`` is filled with the nearest others. ``exact`` (n,)
    is overwritten.
    """
    flat, length, places, limits = known.vectors, known.length, known.places, known.limits
    for c in range(n):
        j, total = offered[c], np.int32(0)
        exact[c] = FAR
        if j < 0 or not known.free[j]:
            continue
        if pixels_apart(places[q, 0], places[q, 1], places[j, 0], places[j, 1], limits) < limits[3]:
            continue
        a, b = np.uint64(q) * length, np.uint64(j) * length
        for i in range(length):  # inlined: a function call would count references
            gap = np.int16(flat[a + i] - flat[b + i])
            total = np.int32(total + np.int32(gap) * np.int32(gap))
        exact[c] = total
    for m in range(out.shape[1]):
        least, which = BESIDE if m < count else FAR, np.int64(-1)
        for c in range(n):
            if exact[c] < least or (exact[c] == least and offered[c] < which):
                least, which = exact[c], offered[c]
        out[at, m] = which
        for c in range(n if which >= 0 and m + 1 < out.shape[1] else 0):
            j = offered[c]
            gap = pixels_apart(places[which, 0], places[which, 1], places[j, 0], places[j, 1], limits)
            if j == which:
                exact[c] = FAR
            elif m + 1 < count and exact[c] < BESIDE and gap < limits[3]:
                exact[c] += BESIDE


@kernel
def ask_some(tree: Any, queries: Any, known: Any, asked: int, out: Any) -> Any:
    """Return for every second pixel of every second row its most similar pixels: (rows / 2 * columns / 2, M).

    They are the best by full neighbourhoods of `asked` candidates from the tree, as :func:`choose` orders them.
    """
    rows, columns, count = out.shape
    wide = (columns + 1) // 2
    cells = np.full(((rows + 1) // 2 * wide, KEPT * count), -1, np.int32)
    near, number = np.empty(asked, np.int64), np.empty(asked, np.int64)
    exact, own, room = np.empty(asked, np.int64), np.flatnonzero(known.free), asking_room(queries.shape[1])
    targets = known.places[own]
    for q in np.concatenate((own[tree.order], np.flatnonzero(~known.free))):  # in the order of leaves, for the cache
        y, x = q // columns, q % columns
        if y % 2 == 0 and x % 2 == 0:
            at = known.places[q, 0], known.places[q, 1]
            n = query_apart(tree, queries[q], targets, at, known.limits, near, number, room)
            for c in range(n):
                number[c] = own[number[c]]
            choose(known, q, number, n, exact, count, cells, y // 2 * wide + x // 2)
    return cells


@kernel
def jump_sets(tree: Any, queries: Any, known: Any, asked: int, out: Any) -> None:
    """Write for each pixel of a grid its k - 1 most similar pixels: numbers, or -1, in `out` (rows, columns, k - 1).

    They are at least ``known.limits[3]`` px from one another and from the pixel. ``queries`` (N, D): points of the
    tree, of which `asked` are ranked per query. First each pixel takes the best continuations of the results of up to
    four queried pixels around it, then, in one forward and one backward scan, of those of its two predecessors.
    """
    rows, columns, count = out.shape
    cells, torus, flat = ask_some(tree, queries, known, asked, out), known.limits[2], out.reshape(rows * columns, count)
    offered, exact = np.empty(4 * cells.shape[1], np.int64), np.empty(4 * cells.shape[1], np.int64)
    high, wide = (rows + 1) // 2, (columns + 1) // 2
    for y in range(rows):
        for x in range(columns):
            n = 0
            for a in range(y // 2, min((y + 1) // 2 + 1, high)):
                for b in range(x // 2, min((x + 1) // 2 + 1, wide)):
                    for c in range(cells.shape[1]):
                        offered[n] = moved(np.int64(cells[a * wide + b, c]), y - 2 * a, x - 2 * b, out.shape, torus)
                        n += 1
            choose(known, y * columns + x, offered, n, exact, count, flat, y * columns + x)
    for step in (1, -1):
        for i in range(rows * columns):
            q = i if step > 0 else rows * columns - 1 - i
            y, x, n = q // columns, q % columns, count
            for dy, dx in ((step, 0), (0, step)):
                if 0 <= y - dy < rows and 0 <= x - dx < columns:
                    for c in range(count):
                        j = moved(np.int64(flat[q - dy * columns - dx, c]), dy, dx, out.shape, torus)
                        fresh = j >= 0
                        for m in range(count):
                            fresh = fresh and flat[q, m] != j
                        if fresh:
                            offered[n] = j
                            n += 1
            if n > count:
                for m in range(count):
                    offered[m] = flat[q, m]
                choose(known, q, offered, n, exact, count, flat, q)


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
