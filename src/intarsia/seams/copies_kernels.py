"""Where a finished map shows what again, and what that costs the eye, in whole numbers.

Every STEP-th pixel of the canvas is a sample. Samples are listed by what they show (cells of STEP px of the exemplars)
and by where they lie (tiles of the canvas): copies near a pixel are looked at one by one, of those farther away only
their number is known. So a price costs the same however large the canvas is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel
from ..kernels.windows import canvas_place
from .energy_kernels import source_at, spot

STEP = 4  # px; the lists are a sixteenth of the canvas, and a cell of the exemplar is one sample each time it is shown
ONE = 256  # a copy whose surroundings are those of the pixel
LONE = 77  # one whose surroundings differ: three tenths
FAR = 128  # one that is too far away to be looked at
SELF = 3  # px: nearer, a copy is the pixel itself
FINE = 16  # prices are kept in 1/16 of what seams are counted in


class Origins(NamedTuple):
    """Which exemplar pixel every pixel of the pieces is, and how striking it is."""

    pixel: NDArray[np.int32]  # (pixels of all variants,): number of the exemplar pixel
    first: NDArray[np.int64]  # (V, 2): number of the first pixel of a variant's exemplar, and its width
    steps: NDArray[np.int64]  # (V, 4): steps of the exemplar to steps of the variant, row by row
    pose: NDArray[np.uint8]  # (V,): how a variant lies
    cell: NDArray[np.int32]  # (exemplar pixels,): number of its cell
    weight: NDArray[np.int32]  # (exemplar pixels,): how much a repeat of it is seen, 256 = usual


class Copies(NamedTuple):
    """Samples by what they show and where they lie: lists that begin at `head`, and how many show a cell."""

    shown: NDArray[np.int32]  # (H, W): number of the exemplar pixel, -1 in holes
    head: NDArray[np.int32]  # (tiles, cells): the first sample, -1: none
    next: NDArray[np.int32]  # (samples,): the one after it
    cell: NDArray[np.int32]  # (samples,): the cell that it is listed under, -1: none
    shows: NDArray[np.int32]  # (cells,): how many
    tiles: NDArray[np.int64]  # (4,): rows and columns of tiles, and a tile's rows and columns in px


class Terms(NamedTuple):
    """What repeats cost."""

    unit: int  # of a full copy of a pixel of weight 1, in 2**-24 of a sixteenth of a seam's price
    spare: int  # copies, in 1/256, that cost nothing
    near: int  # how much dearer a copy is at no distance, 256 = as much again
    reach: int  # px: where nearness ends
    around: NDArray[np.int64]  # (8, 8, 8, 2): places around a pixel in one pose, as around a copy in another, px


@kernel
def list_box(grown: Any, pieces: Any, origins: Any, copies: Any, box: Any) -> None:
    """List the samples of a box anew; `box`: first row and column, rows, columns, over borders that wrap."""
    height, width = grown.variant.shape
    columns = (width + STEP - 1) // STEP
    for i in range(box[2]):
        y = canvas_place(box[0] + i, height, grown.wrap[0])
        for j in range(box[3]):
            x = canvas_place(box[1] + j, width, grown.wrap[1])
            if y < 0 or x < 0:
                continue
            at = source_at(grown.variant, grown.yx, pieces.table, pieces.channels, y, x)
            copies.shown[y, x] = origins.pixel[at] if at >= 0 else -1
            if y % STEP or x % STEP:
                continue
            s = (y // STEP) * columns + x // STEP
            tile = (y // copies.tiles[2]) * copies.tiles[1] + x // copies.tiles[3]
            was, now = copies.cell[s], origins.cell[copies.shown[y, x]] if at >= 0 else -1
            if was == now:
                continue
            if was >= 0:
                copies.shows[was] -= 1
                if copies.head[tile, was] == s:
                    copies.head[tile, was] = copies.next[s]
                else:
                    before = copies.head[tile, was]
                    while copies.next[before] != s:
                        before = copies.next[before]
                    copies.next[before] = copies.next[s]
            copies.cell[s] = now
            if now >= 0:
                copies.shows[now] += 1
                copies.next[s] = copies.head[tile, now]
                copies.head[tile, now] = s


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
def _look_around(
    grown: Any, pieces: Any, origins: Any, copies: Any, terms: Any, box: Any, pick: Any, here: Any, mine: Any
) -> None:
    """Write into `mine` (8,) what is shown around a pixel of a box, at its row and column `here`: exemplar pixels."""
    for r in range(8):
        i, j = here[0] + terms.around[0, 0, r, 0], here[1] + terms.around[0, 0, r, 1]
        if pick[0] >= 0 and 0 <= i < box[2] and 0 <= j < box[3]:
            table, usable, torus, channels = pieces.table, pieces.usable, pieces.torus, pieces.channels
            at = spot(table, usable, torus, channels, pick[0], pick[1] + i, pick[2] + j)
            mine[r] = origins.pixel[at] if at >= 0 else -1
        else:
            mine[r] = _shown(copies.shown, grown.wrap, box[0] + i, box[1] + j)


@kernel
def _alike(shown: Any, wrap: Any, turned: Any, y: int, x: int, mine: Any) -> int:
    """How much is the same around a copy, at its place on the canvas, and around the pixel: LONE .. ONE."""
    same, known = 0, 0
    for r in range(8):
        other = _shown(shown, wrap, y + turned[r, 0], x + turned[r, 1])
        if other >= 0 and mine[r] >= 0:
            known += 1
            same += mine[r] == other
    return LONE + (ONE - LONE) * same // known if known else LONE


@kernel
def _price(
    grown: Any, origins: Any, copies: Any, terms: Any, box: Any, patch: bool, here: Any, pixel: int, mine: Any
) -> int:
    """What a pixel of a box costs that shows an exemplar pixel; `here`: its row and column in the box, its variant."""
    (height, width), wrap = grown.variant.shape, grown.wrap
    samples, (rows, columns) = (width + STEP - 1) // STEP, (copies.tiles[0], copies.tiles[1])
    y, x = canvas_place(box[0] + here[0], height, wrap[0]), canvas_place(box[1] + here[1], width, wrap[1])
    cell, first, wide = origins.cell[pixel], origins.first[here[2], 0], origins.first[here[2], 1]
    ey, ex = (pixel - first) // wide, (pixel - first) % wide
    total, close, seen, reach = 0, 0, 0, terms.reach * terms.reach
    for p in range(min(rows, 3)):
        ty = y // copies.tiles[2] - 1 + p
        ty = ty % rows if wrap[0] or rows < 3 else ty
        for q in range(min(columns, 3)):
            tx = x // copies.tiles[3] - 1 + q
            tx = tx % columns if wrap[1] or columns < 3 else tx
            if not (0 <= ty < rows and 0 <= tx < columns):
                continue
            following = copies.head[ty * columns + tx, cell]
            while following >= 0:
                s = following
                following = copies.next[s]
                seen += 1
                qy, qx = (s // samples) * STEP, (s % samples) * STEP
                if patch:
                    i = (qy - box[0]) % height if wrap[0] else qy - box[0]
                    j = (qx - box[1]) % width if wrap[1] else qx - box[1]
                    if 0 <= i < box[2] and 0 <= j < box[3]:
                        continue  # this would be replaced
                v, other = grown.variant[qy, qx], copies.shown[qy, qx] - first
                # the sample is of the cell: the copy of the pixel lies a little beside it
                dy, dx, m = ey - other // wide, ex - other % wide, origins.steps[v]
                cy, cx = qy + dy * m[0] + dx * m[2], qx + dy * m[1] + dx * m[3]
                gy, gx = _gap(cy, y, height, wrap[0]), _gap(cx, x, width, wrap[1])
                if abs(gy) < SELF and abs(gx) < SELF:
                    continue
                turned = terms.around[origins.pose[here[2]], origins.pose[v]]
                g = _alike(copies.shown, wrap, turned, cy, cx, mine)
                total += g
                far = gy * gy + gx * gx
                if far < reach:
                    rest = 16 - 16 * far // reach
                    close += g * rest * rest // 256
    total = max(total + FAR * (copies.shows[cell] - seen) - terms.spare, 0) + close * terms.near // 256
    price: int = total * origins.weight[pixel] * terms.unit >> 24
    return price


@kernel
def repeat_prices(
    grown: Any, pieces: Any, origins: Any, copies: Any, terms: Any, box: Any, pick: Any, step: int, out: Any
) -> None:
    """Write what repeats cost each pixel of a box, in 1/FINE of what seams are counted in, in blocks of `step` px.

    `pick` (variant, row, column at the first pixel): what a patch would show there; a variant below 0: what the map
    shows. What the patch would replace does not count as a copy then.
    """
    height, width = grown.variant.shape
    mine, patch = np.empty(8, np.int32), pick[0] >= 0
    for i in range(0, box[2], step):
        y = canvas_place(box[0] + i, height, grown.wrap[0])
        for j in range(0, box[3], step):
            x = canvas_place(box[1] + j, width, grown.wrap[1])
            price = 0
            if y >= 0 and x >= 0:
                v, pixel = grown.variant[y, x], copies.shown[y, x]
                if patch:
                    v, table, channels = pick[0], pieces.table, pieces.channels
                    at = spot(table, pieces.usable, pieces.torus, channels, v, pick[1] + i, pick[2] + j)
                    pixel = origins.pixel[at] if at >= 0 else -1
                if pixel >= 0:
                    _look_around(grown, pieces, origins, copies, terms, box, pick, (i, j), mine)
                    price = _price(grown, origins, copies, terms, box, patch, (i, j, v), pixel, mine)
            out[i : i + step, j : j + step] = price
