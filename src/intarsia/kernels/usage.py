"""Kernels of repetition control: where patches were taken and laid, and what that costs a candidate.

A placement is a row of int64: variant, row, column of the patch (in the variant), row, column of its window on
the canvas, exemplar (-1: nothing placed), and twice the row and column of its centre in the upright exemplar.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import kernel

ONE = 256  # a full overlap of two patches


@kernel
def add_use(counts: Any, cy: int, cx: int, height: int, width: int, weight: Any) -> None:
    """Add to `counts` (rows, columns) int32 how much a patch there shares with one at (cy, cx).

    A full overlap adds ONE, falling linearly to 0 at `height`, `width`; `weight` (rows, columns) int32, 256 = 1.
    """
    rows, columns = counts.shape
    x0, x1 = max(0, cx - width + 1), min(columns, cx + width)
    across = np.empty(max(x1 - x0, 0), np.int32)
    for x in range(x0, x1):
        across[x - x0] = ONE * (width - abs(x - cx)) // width
    for y in range(max(0, cy - height + 1), min(rows, cy + height)):
        down = np.int32(ONE * (height - abs(y - cy)) // height)
        target, w = counts[y, x0:x1], weight[y, x0:x1]
        for k in range(len(across)):
            target[k] += ((across[k] * down) >> 8) * w[k] >> 8


@kernel
def shared(a: Any, b: Any, h: int, w: int) -> Any:
    """How much of two patches is the same part of the exemplar, 0 .. ONE; rows 5..7 of placements."""
    if a[5] != b[5]:
        return 0
    dy, dx = abs(a[6] - b[6]), abs(a[7] - b[7])
    if dy >= 2 * h or dx >= 2 * w:
        return 0
    return ONE * (2 * h - dy) * (2 * w - dx) // (4 * h * w)


@kernel
def apart(a: int, b: int, length: int, wrap: int) -> int:
    """Distance of two canvas coordinates along one axis, the short way round if it wraps."""
    d = abs(a - b)
    if wrap:
        d %= length  # exemplar coordinates are in it, too: it may be longer than the canvas
        return min(d, length - d)
    return d


@kernel
def returns_too_near(a: Any, b: Any, h: int, w: int, canvas: Any, torus: Any, distance: int) -> bool:
    """True where two patches would show the same exemplar pixel twice within `distance` px of the output.

    `torus` (2,): height and width of the variant of `a` where its exemplar is toroidal, else 0.
    """
    if a[5] != b[5]:
        return False
    if a[0] == b[0]:
        turns = (torus[0] > 0) * (2 + h // max(torus[0], 1)), (torus[1] > 0) * (2 + w // max(torus[1], 1))
        for i in range(-turns[0], turns[0] + 1):
            down = a[1] - b[1] + i * torus[0]
            if abs(down) >= h:
                continue
            for j in range(-turns[1], turns[1] + 1):
                right = a[2] - b[2] + j * torus[1]
                if abs(right) >= w:
                    continue
                dy = apart(a[3] - down, b[3], canvas[0], canvas[2])
                dx = apart(a[4] - right, b[4], canvas[1], canvas[3])
                if dy * dy + dx * dx < distance * distance and (dy != 0 or dx != 0):
                    return True
        return False
    reach = max(h, w)
    if torus[0] == 0 and (abs(a[6] - b[6]) >= 2 * reach or abs(a[7] - b[7]) >= 2 * reach):
        return False
    # Poses differ: a pixel may lie anywhere in both, so the patches themselves are kept apart.
    dy = max(apart(a[3], b[3], canvas[0], canvas[2]) - reach, 0)
    dx = max(apart(a[4], b[4], canvas[1], canvas[3]) - reach, 0)
    return dy * dy + dx * dx < distance * distance


@kernel
def placement(frames: Any, shape: Any, v: int, u: int, s: int, y: int, x: int, out: Any) -> None:
    """Write the placement row of the patch of variant `v` at (u, s) in the window at (y, x).

    `frames` (V, 9): exemplar, first exemplar row and column shown, J, row by row, and height and width of the
    variant if it is toroidal, else 0.
    """
    f = frames[v]
    a, b = 2 * u + shape[0] - 1, 2 * s + shape[1] - 1
    out[0], out[1], out[2], out[3], out[4], out[5] = v, u, s, y, x, f[0]
    out[6] = 2 * f[1] + f[3] * a + f[4] * b
    out[7] = 2 * f[2] + f[5] * a + f[6] * b


@kernel
def note(
    frames: Any, shape: Any, pick: Any, at: Any, place: Any, offsets: Any, factor: int, counts: Any, striking: Any,
    counter: bool,
) -> None:  # fmt: skip
    """Note that patch `pick` (variant, row, column) is laid at `at`: write its placement, count its use.

    `counts`, `striking`: flat tables over the coarse positions (cells of `factor` px) of all variants, that of
    variant v at ``offsets[v, 0]`` with ``offsets[v, 1:3]`` rows and columns. All variants of the exemplar count.
    With `counter` every patch that touches this one counts ONE more (S0-40), otherwise as much as it shares.
    """
    placement(frames, shape, pick[0], pick[1], pick[2], at[0], at[1], place)
    height, width = shape[0] // factor, shape[1] // factor
    for v in range(len(frames)):
        f = frames[v]
        if f[0] != place[5]:
            continue
        dy, dx = place[6] - 2 * f[1], place[7] - 2 * f[2]  # the inverse of an isometry is its transpose
        y = ((f[3] * dy + f[5] * dx - shape[0] + 1) // 2) // factor
        x = ((f[4] * dy + f[6] * dx - shape[1] + 1) // 2) // factor
        rows, columns = offsets[v, 1], offsets[v, 2]
        cells = slice(offsets[v, 0], offsets[v, 0] + rows * columns)
        weight = striking[cells].reshape(rows, columns)
        if counter:
            y0, x0 = max(0, y - height + 1), max(0, x - width + 1)
            counts[cells].reshape(rows, columns)[y0 : max(0, y + height), x0 : max(0, x + width)] += ONE
        else:
            add_use(counts[cells].reshape(rows, columns), y, x, height, width, weight)


@kernel
def around(at: int, reach: int, count: int, wrap: int) -> Any:
    """First window, and one past the last, within `reach` of window `at`; each once, also around a torus."""
    if wrap:
        return at - reach, min(at + reach + 1, at - reach + count)
    return max(at - reach, 0), min(at + reach + 1, count)


@kernel
def prices(
    found: Any, grid: Any, row: int, column: int, at: Any, reach: int, shape: Any, canvas: Any, frames: Any,
    counts: Any, striking: Any, offsets: Any, factor: int, multiply: bool, steady: int, unit: int, distance: int,
    out: Any,
) -> None:  # fmt: skip
    """Price of every candidate: its distance, plus what repetition costs; -1 where it is forbidden.

    `found` (n, 4): distance, variant, row, column. `grid` (rows, columns, 8): the placements, looked at
    within `reach` windows of (row, column). `at` (2,): first pixel of the window;
    `shape` (2,): patch; `canvas` (4,):
    height, width, wraps. `counts`, `striking`: flat tables over the coarse positions of all variants, that of
    variant v at ``offsets[v, 0]`` with ``offsets[v, 1:3]`` rows and columns. `steady`: the price of a count of
    ONE; `unit`: the additional price of a full repeat at the same place. With `multiply` the price is instead
    the squared distance times (1 + count)**2, so that distances are multiplied by 1 + count (S0-41).
    """
    h, w = shape[0], shape[1]
    area = 9 * h * w // 2  # 2 sigma**2 with sigma = 1.5 patches
    rows, columns = grid.shape[0], grid.shape[1]
    near_rows, near_columns = around(row, reach, rows, canvas[2]), around(column, reach, columns, canvas[3])
    others, n = np.empty(((near_rows[1] - near_rows[0]) * (near_columns[1] - near_columns[0]), 8), np.int64), 0
    for i in range(near_rows[0], near_rows[1]):
        for j in range(near_columns[0], near_columns[1]):
            if grid[i % rows, j % columns, 5] >= 0:
                others[n] = grid[i % rows, j % columns]
                n += 1
    mine = np.empty(8, np.int64)
    for k in range(found.shape[0]):
        v = found[k, 1]
        placement(frames, shape, v, found[k, 2], found[k, 3], at[0], at[1], mine)
        cell = offsets[v, 0] + min(found[k, 2] // factor, offsets[v, 1] - 1) * offsets[v, 2]
        cell += min(found[k, 3] // factor, offsets[v, 2] - 1)
        total = np.int64(0)
        for other in others[:n]:
            if distance > 0 and returns_too_near(mine, other, h, w, canvas, frames[v, 7:9], distance):
                total = np.int64(-1)
                break
            share = shared(mine, other, h, w)
            if share:
                dy = apart(mine[3], other[3], canvas[0], canvas[2])
                dx = apart(mine[4], other[4], canvas[1], canvas[3])
                near = (np.int64(area) << 8) // (area + dy * dy + dx * dx)  # whole numbers in place of exp
                total += (share * near * near) >> 16
        price = (counts[cell] * steady + ((total * striking[cell]) >> 8) * unit) >> 8
        if multiply:
            price = (found[k, 0] * (ONE + counts[cell]) ** 2 >> 16) - found[k, 0]
        out[k] = -1 if total < 0 else found[k, 0] + price


@kernel
def pick(prices: Any, tolerance: float, floor: int, bits: int) -> int:
    """Choose among the candidates whose price is within the tolerance of the best; -1 if all are forbidden.

    The tolerance applies to the best price, or to `floor` if that is more: a perfect match leaves a choice, too.
    `bits`: 32 drawn bits.
    """
    best = -1
    for p in prices:
        if p >= 0 and (best < 0 or p < best):
            best = p
    if best < 0:
        return -1
    limit = best + int(tolerance * (best if best > floor else floor))
    n = 0
    for p in prices:
        n += 0 <= p <= limit
    skip = (bits * n) >> 32
    for k in range(len(prices)):
        if 0 <= prices[k] <= limit:
            if skip == 0:
                return k
            skip -= 1
    return -1


@kernel
def pick_all(
    found: Any, counts: Any, usual: Any, windows: Any, at: Any, bits: Any, tolerance: float, match: float,
    strength: float, steady: float, grid: Any, reach: int, shape: Any, canvas: Any, frames: Any, priced: Any,
    uses: Any, striking: Any, offsets: Any, factor: int, distance: int, first: int, picks: Any,
) -> int:  # fmt: skip
    """Choose for windows `first` and later of a wave, one after the other, and note each; see :func:`pick`.

    `found` (n, K, 4), `counts` (n,), `usual` (n,): the candidates; `windows`, `at` (n, 2): number and first pixel
    of the windows; `bits` (n,): drawn bits. Writes `picks` (n, 3); returns the number of the first window for
    which there is no choice, or n.
    """
    price = np.empty(found.shape[1], np.int64)
    for n in range(first, len(windows)):
        if counts[n] < 1:
            return n
        rows = found[n, : counts[n]]
        row, column = windows[n, 0], windows[n, 1]
        prices(
            rows, grid, row, column, at[n], reach, shape, canvas, frames, priced, striking, offsets, factor, False,
            int(steady * usual[n]), int(strength * usual[n]), distance, price,
        )  # fmt: skip
        k = pick(price[: counts[n]], tolerance, int(match * usual[n]), bits[n])
        if k < 0:
            return n
        picks[n] = rows[k, 1:]
        note(
            frames, shape, picks[n], at[n], grid[row, column], offsets, factor, uses, striking, False
        )  # fmt: skip
    return len(windows)
