"""Bend a gap's block a little, so that lines meet those of its neighbours."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel

STIFF, PULL = 10, 4  # of unlike neighbours, and of a displacement, per px squared, in units of WEIGHT
WORTH = 20  # per cent of the misfit that bending must take away, else the block stays stiff: fine stripes would jag
WEIGHT = 256  # what a node's data weigh, on the average
SWEEPS = 8


@kernel
def node_costs(
    picture: Any, usable: Any, places: Any, values: Any, ty: int, tx: int, reach: int, spacing: int, cost: Any
) -> None:
    """Add up, around every node, the squared differences of the neighbours and the block displaced by up to `reach`.

    `places` (n, 2), `values` (n, C): what the neighbours show in the seam zone; (ty, tx): the block's shift; `cost`
    (rows, columns, 2 reach + 1, 2 reach + 1): the node (i, j) stands at (i, j) * spacing. Every pixel counts at the
    four nodes around it.
    """
    height, width, channels = picture.shape
    side = 2 * reach + 1
    for k in range(len(places)):
        y, x = places[k, 0] + ty, places[k, 1] + tx
        if y < reach or x < reach or y >= height - reach or x >= width - reach or not usable[y, x]:
            continue
        i, j = places[k, 0] // spacing, places[k, 1] // spacing
        for a in range(side):
            for b in range(side):
                d = np.int64(0)
                for c in range(channels):
                    e = np.int64(picture[y + a - reach, x + b - reach, c]) - values[k, c]
                    d += e * e
                cost[i, j, a, b] += d
                cost[i + 1, j, a, b] += d
                cost[i, j + 1, a, b] += d
                cost[i + 1, j + 1, a, b] += d


@kernel
def choose_moves(cost: Any, stiff: int, pull: int, moves: Any) -> None:
    """Choose a displacement for every node: one that fits, like its neighbours', and small; (rows, columns, 2).

    Minimises data + stiff * |difference of neighbours|**2 + pull * |displacement|**2, the data scaled so that the
    average node has a contrast of WEIGHT, node by node until little can change (iterated conditional modes).
    """
    rows, columns, side, _ = cost.shape
    reach = side // 2
    contrast, nodes = np.int64(0), 0
    for i in range(rows):
        for j in range(columns):
            least = cost[i, j].min()
            mean = cost[i, j].sum() // (side * side)
            if mean > 0:
                contrast += mean - least
                nodes += 1
    moves[:] = 0
    if nodes == 0 or contrast == 0:
        return
    scale = max(contrast // nodes, 1)
    for _ in range(SWEEPS):
        for i in range(rows):
            for j in range(columns):
                best = np.int64(1) << 62
                by, bx = 0, 0
                for a in range(side):
                    for b in range(side):
                        dy, dx = a - reach, b - reach
                        e = cost[i, j, a, b] * WEIGHT // scale + pull * (dy * dy + dx * dx)
                        for k in range(4):
                            u, v = i + (k == 0) - (k == 1), j + (k == 2) - (k == 3)
                            if 0 <= u < rows and 0 <= v < columns:
                                e += stiff * ((dy - moves[u, v, 0]) ** 2 + (dx - moves[u, v, 1]) ** 2)
                        if e < best or (e == best and dy * dy + dx * dx < by * by + bx * bx):
                            best, by, bx = e, dy, dx
                moves[i, j, 0], moves[i, j, 1] = by, bx


@kernel
def spread_moves(moves: Any, spacing: int, field: Any) -> None:
    """Interpolate the nodes' displacements (rows, columns, 2) for every pixel, `field` (h, w, 2), in whole px."""
    area = spacing * spacing
    for y in range(field.shape[0]):
        i, down = y // spacing, y % spacing
        for x in range(field.shape[1]):
            j, right = x // spacing, x % spacing
            for c in range(2):
                top = moves[i, j, c] * (spacing - right) + moves[i, j + 1, c] * right
                low = moves[i + 1, j, c] * (spacing - right) + moves[i + 1, j + 1, c] * right
                field[y, x, c] = (2 * (top * (spacing - down) + low * down) + area) // (2 * area)


@kernel
def bend(picture: Any, usable: Any, places: Any, values: Any, reach: int, spacing: int, core: Any, shift: Any) -> None:
    """Bend a block where that pays: `shift` (h, w, 2), that of the whole block, is changed by at most `reach` px.

    Parts that would leave the usable exemplar, of those that `core` says the block must fill, stay as they are.
    """
    h, w = core.shape
    side = 2 * reach + 1
    ty, tx = shift[0, 0, 0], shift[0, 0, 1]
    cost = np.zeros((h // spacing + 2, w // spacing + 2, side, side), np.int64)
    node_costs(picture, usable, places, values, ty, tx, reach, spacing, cost)
    moves = np.zeros((*cost.shape[:2], 2), np.int64)
    choose_moves(cost, STIFF, PULL, moves)
    stiff, bent = np.int64(0), np.int64(0)
    for i in range(cost.shape[0]):
        for j in range(cost.shape[1]):
            stiff += cost[i, j, reach, reach]
            bent += cost[i, j, reach + moves[i, j, 0], reach + moves[i, j, 1]]
    if 100 * bent > (100 - WORTH) * stiff:
        return
    field = np.empty((h, w, 2), np.int64)
    spread_moves(moves, spacing, field)
    height, width = usable.shape
    for y in range(h):
        for x in range(w):
            u, v = y + ty + field[y, x, 0], x + tx + field[y, x, 1]
            if not core[y, x] or (0 <= u < height and 0 <= v < width and usable[u, v]):
                shift[y, x, 0] += field[y, x, 0]
                shift[y, x, 1] += field[y, x, 1]
