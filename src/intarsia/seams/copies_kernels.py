"""Where a finished map shows what again, and what that costs the eye, in whole numbers.

Every STEP-th pixel of the canvas is a sample. Samples are listed by what they show (cells of STEP px of the exemplars)
and by where they lie (tiles of the canvas): copies near a pixel are looked at one by one, of those farther away only
their number is known. So a price costs the same however large the canvas is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..arrays import Int32, Int64, Mask, Pair, UInt8
from ..kernels.jit import kernel
from ..kernels.windows import HOLE, Grown, canvas_place

STEP = 4  # px; the lists are a sixteenth of the canvas, and a cell of the exemplar is one sample each time it is shown
ONE = 256  # a copy whose surroundings are those of the pixel
LONE = 77  # one whose surroundings differ: three tenths
FAR = 128  # one that is too far away to be looked at
UNLIKE = -2  # stands for what is not known around a pixel: like no other
SELF = 3  # px: nearer, a copy is the pixel itself
FINE = 16  # prices are kept in 1/16 of what seams are counted in


class Origins(NamedTuple):
    """Which exemplar pixel every pixel of the pieces is, and how striking it is."""

    pixel: Int32  # (pixels of all variants,): number of the exemplar pixel
    laid: Int32  # the same; -1 where it must not be shown
    frames: Int64  # (V, 4): where a variant begins in these, rows, columns and stride
    torus: Mask  # (V,): whether it continues in itself
    steps: Int64  # (V, 4): steps of the exemplar to steps of the variant, row by row
    pose: UInt8  # (V,): how a variant lies
    place: Int32  # (exemplar pixels, 2): row and column
    cell: Int32  # (exemplar pixels,): number of its cell
    weight: Int32  # (exemplar pixels,): how much a repeat of it is seen, 256 = usual


class Copies(NamedTuple):
    """Samples by what they show and where they lie: lists that begin at `head`, and how many show a cell."""

    shown: Int32  # (H, W): number of the exemplar pixel, -1 in holes
    head: Int32  # (cells, tiles): the first sample, -1: none
    next: Int32  # (samples,): the one after it
    cell: Int32  # (samples,): the cell that it is listed under, -1: none
    lies: Int32  # (samples, 5): row and column, those at which it would show pixel 0, 0; its variant
    shows: Int32  # (cells,): how many
    tiles: Int64  # (4,): rows and columns of tiles, and a tile's rows and columns in px


class Terms(NamedTuple):
    """What repeats cost."""

    unit: int  # of a full copy of a pixel of weight 1, in 2**-24 of a sixteenth of a seam's price
    spare: int  # copies, in 1/256, that cost nothing
    near: int  # how much dearer a copy is at no distance, 256 = as much again
    reach: int  # px: where nearness ends
    around: Int64  # (8, 8, 8, 3): places around a pixel in one pose, as around a copy in another: rows,
    # columns, and so many pixels of the canvas


class Repeats(NamedTuple):
    """A map, all that its repeats are known by, and what they cost."""

    grown: Grown
    origins: Origins
    copies: Copies
    terms: Terms


@kernel
def list_box(grown: Any, pieces: Any, origins: Any, copies: Any, box: Any) -> None:
    """List the samples of a box anew; `box`: first row and column, rows, columns, over borders that wrap."""
    variant, yx, wrap = grown
    height, width = variant.shape
    columns = (width + STEP - 1) // STEP
    for i in range(box[2]):
        y = canvas_place(box[0] + i, height, wrap[0])
        for j in range(box[3]):
            x = canvas_place(box[1] + j, width, wrap[1])
            if y < 0 or x < 0:
                continue
            v, pixel = variant[y, x], -1
            if v != HOLE:
                pixel = origins.pixel[origins.frames[v, 0] + yx[y, x, 0] * pieces.table[v, 3] + yx[y, x, 1]]
            copies.shown[y, x] = pixel
            if y % STEP or x % STEP:
                continue
            s = (y // STEP) * columns + x // STEP
            tile = (y // copies.tiles[2]) * copies.tiles[1] + x // copies.tiles[3]
            if pixel >= 0:
                (ey, ex), m, lies = origins.place[pixel], origins.steps[v], copies.lies[s]
                lies[0], lies[1], lies[4] = y, x, v
                lies[2], lies[3] = y - ey * m[0] - ex * m[2], x - ey * m[1] - ex * m[3]
            _list_sample(copies, s, tile, origins.cell[pixel] if pixel >= 0 else -1)


@kernel
def _list_sample(copies: Any, s: int, tile: int, now: int) -> None:
    """Move a sample from the list of what it showed to that of what it shows."""
    was = copies.cell[s]
    if was == now:
        return
    if was >= 0:
        copies.shows[was] -= 1
        if copies.head[was, tile] == s:
            copies.head[was, tile] = copies.next[s]
        else:
            before = copies.head[was, tile]
            while copies.next[before] != s:
                before = copies.next[before]
            copies.next[before] = copies.next[s]
    copies.cell[s] = now
    if now >= 0:
        copies.shows[now] += 1
        copies.next[s] = copies.head[now, tile]
        copies.head[now, tile] = s


@kernel
def _gap(a: int, b: int, length: int, wrap: bool) -> int:
    """Signed px from b to a, the short way round where the axis wraps."""
    gap = a - b
    if wrap:
        gap = (gap + length // 2) % length - length // 2
    return gap


@kernel
def _shown(shown: Any, wrap: Any, y: int, x: int) -> int:
    """The exemplar pixel at a place of the canvas, -1 outside and in holes."""
    height, width = shown.shape
    if not 0 <= y < height:
        if not wrap[0]:
            return -1
        y %= height
    if not 0 <= x < width:
        if not wrap[1]:
            return -1
        x %= width
    found: int = shown[y, x]
    return found


@kernel
def _laid(laid: Any, frames: Any, torus: bool, v: int, y: int, x: int) -> int:
    """The exemplar pixel that a variant shows at a place, -1 where there is none or it must not be shown."""
    if not (0 <= y < frames[v, 1] and 0 <= x < frames[v, 2]):
        if not torus:
            return -1
        y, x = y % frames[v, 1], x % frames[v, 2]
    found: int = laid[frames[v, 0] + y * frames[v, 3] + x]
    return found


@kernel
def _unfolded(around: Any) -> Any:
    """Places around a pixel, pair of poses by pair of poses, in one row each: rows, columns, pixels of the canvas."""
    down, right, away = np.empty(512, np.int64), np.empty(512, np.int64), np.empty(512, np.int64)
    for n in range(512):
        row = around[n // 64, n // 8 % 8, n % 8]
        down[n], right[n], away[n] = row[0], row[1], row[2]
    return down, right, away


@kernel
def block_prices(repeats: Any, box: Any, pick: Any, step: int, out: Any) -> None:
    """Write what repeats cost the first pixel of every block of step x step px of a box, in 1/FINE of seams' prices.

    `pick` (variant, row, column at the box's first pixel): what a patch would show there; a variant below 0: what the
    map shows. What the patch would replace does not count as a copy then. `out` (rows, columns) of blocks.
    """
    (variant, _, wrap), origins, copies, terms = repeats  # all by names of their own: tuples are dear to hand on
    shown, head, following, lies, shows = copies.shown, copies.head, copies.next, copies.lies, copies.shows
    places, steps, poses, frames = origins.place, origins.steps, origins.pose, origins.frames
    cells, weights, laid = origins.cell, origins.weight, origins.laid
    around, reach = terms.around, terms.reach * terms.reach
    (height, width), (rows, columns, tall, wide) = shown.shape, copies.tiles
    every = shown.reshape(height * width)
    mine, patch, (down, right, away) = np.empty(8, np.int32), pick[0] >= 0, _unfolded(around)
    edge = around[0, 0, 0, 0]  # straight down: no place around a pixel is farther away along an axis
    torus = patch and origins.torus[pick[0]]
    for a in range(out.shape[0]):
        y = canvas_place(box[0] + a * step, height, wrap[0])
        for b in range(out.shape[1]):
            x = canvas_place(box[1] + b * step, width, wrap[1])
            out[a, b] = 0
            if y < 0 or x < 0:
                continue
            v, pixel = variant[y, x], shown[y, x]
            if patch:
                v = pick[0]
                pixel = _laid(laid, frames, torus, v, pick[1] + a * step, pick[2] + b * step)
            if pixel < 0:
                continue
            for r in range(8):
                i, j = a * step + around[0, 0, r, 0], b * step + around[0, 0, r, 1]
                if patch and 0 <= i < box[2] and 0 <= j < box[3]:
                    mine[r] = _laid(laid, frames, torus, pick[0], pick[1] + i, pick[2] + j)
                else:
                    mine[r] = _shown(shown, wrap, box[0] + i, box[1] + j)
                mine[r] = mine[r] if mine[r] >= 0 else UNLIKE
            cell, ey, ex = cells[pixel], places[pixel, 0], places[pixel, 1]
            total, close, seen, own_row, own_column = 0, 0, 0, y // tall, x // wide
            for p in range(min(rows, 3)):
                ty = own_row - 1 + p
                if wrap[0] or rows < 3:
                    ty = ty + rows if ty < 0 else (ty - rows if ty >= rows else ty)
                for q in range(min(columns, 3)):
                    tx = own_column - 1 + q
                    if wrap[1] or columns < 3:
                        tx = tx + columns if tx < 0 else (tx - columns if tx >= columns else tx)
                    if not (0 <= ty < rows and 0 <= tx < columns):
                        continue
                    s = head[cell, ty * columns + tx]
                    while s >= 0:
                        k, u = s, lies[s, 4]
                        s = following[k]
                        seen += 1
                        if patch:
                            i, j = lies[k, 0] - box[0], lies[k, 1] - box[1]
                            i, j = i % height if wrap[0] else i, j % width if wrap[1] else j
                            if 0 <= i < box[2] and 0 <= j < box[3]:
                                continue  # this would be replaced
                        # the sample is of the cell: the copy of the pixel lies a little beside it
                        cy = lies[k, 2] + ey * steps[u, 0] + ex * steps[u, 2]
                        cx = lies[k, 3] + ey * steps[u, 1] + ex * steps[u, 3]
                        gy, gx = _gap(cy, y, height, wrap[0]), _gap(cx, x, width, wrap[1])
                        if abs(gy) < SELF and abs(gx) < SELF:
                            continue
                        # how much is the same around the copy and around the pixel: LONE .. ONE
                        first, begin, same, known = (poses[v] * 8 + poses[u]) * 8, cy * width + cx, 0, 0
                        inside = edge <= cy < height - edge and edge <= cx < width - edge
                        for r in range(8):
                            n = np.uint64(first + r)
                            if inside:
                                other = every[np.uint64(begin + away[n])]
                            else:
                                other = _shown(shown, wrap, cy + down[n], cx + right[n])
                            known += (other | mine[r]) >= 0
                            same += mine[r] == other
                        g = LONE + (ONE - LONE) * same // known if known else LONE
                        total += g
                        far = gy * gy + gx * gx
                        if far < reach:
                            rest = 16 - int(np.float64(16 * far) / np.float64(reach))  # rounded down all the same
                            close += g * rest * rest // 256
            total = max(total + FAR * (shows[cell] - seen) - terms.spare, 0) + close * terms.near // 256
            out[a, b] = total * weights[pixel] * terms.unit >> 24


@kernel
def savings(old: Any, new: Any, width: int, saved: Any) -> None:
    """Write what staying at the `old` prices of blocks costs each pixel of a box more than the `new` ones would.

    In what seams are counted in, rounded down; from the edges on it rises to what it is over `width` px.
    """
    h, w = saved.shape
    whole = np.float64(width * FINE)  # a quotient of whole numbers below 2**53, rounded down: that of whole numbers
    for a in range(old.shape[0]):
        for b in range(old.shape[1]):
            gain = max(old[a, b] - new[a, b], 0)
            for i in range(a * STEP, min(a * STEP + STEP, h)):
                for j in range(b * STEP, min(b * STEP + STEP, w)):
                    part = min(i, h - 1 - i, j, w - 1 - j, width)
                    saved[i, j] = np.int32(np.float64(gain * part) / whole) if gain > 0 else 0


@kernel
def taken_sums(old: Any, new: Any, take: Any) -> Pair:
    """Add up old and new prices of blocks over the pixels that are taken."""
    h, w = take.shape
    paid, left = 0, 0
    for a in range(old.shape[0]):
        for b in range(old.shape[1]):
            count = 0
            for i in range(a * STEP, min(a * STEP + STEP, h)):
                for j in range(b * STEP, min(b * STEP + STEP, w)):
                    count += take[i, j]
            paid += count * old[a, b]
            left += count * new[a, b]
    return paid, left
