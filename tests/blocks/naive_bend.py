"""Bending a block, pixel by pixel and node by node."""

from __future__ import annotations

import itertools

import numpy as np


def node_costs(picture, usable, places, values, shift, reach, spacing, shape):
    """What the displacements of every node cost, (rows, columns, 2 reach + 1, 2 reach + 1)."""
    side = 2 * reach + 1
    cost = np.zeros((shape[0] // spacing + 2, shape[1] // spacing + 2, side, side), np.int64)
    height, width, _ = picture.shape
    for (py, px), value in zip(places, values, strict=True):
        y, x = py + shift[0], px + shift[1]
        if not (reach <= y < height - reach and reach <= x < width - reach and usable[y, x]):
            continue
        around = picture[y - reach : y + reach + 1, x - reach : x + reach + 1].astype(np.int64)
        squares = ((around - value) ** 2).sum(axis=2)
        for i, j in itertools.product((0, 1), (0, 1)):
            cost[py // spacing + i, px // spacing + j] += squares
    return cost


def energy(cost, moves, stiff, pull, scale, unit):
    """What a choice of displacements costs in all, (rows, columns, 2)."""
    reach = cost.shape[2] // 2
    total = 0
    rows, columns = cost.shape[:2]
    for i, j in itertools.product(range(rows), range(columns)):
        dy, dx = moves[i, j]
        total += cost[i, j, dy + reach, dx + reach] * unit // scale + pull * (dy * dy + dx * dx)
        for u, v in ((i + 1, j), (i, j + 1)):
            if u < rows and v < columns:
                total += stiff * int(((moves[i, j] - moves[u, v]) ** 2).sum())
    return total


def field_of(moves, spacing, shape):
    """The displacement of every pixel: between four nodes, rounded, halves upwards."""
    out = np.zeros((*shape, 2), np.int64)
    for y, x in np.ndindex(*shape):
        i, j, a, b = y // spacing, x // spacing, y % spacing, x % spacing
        mixed = (
            (spacing - a) * (spacing - b) * moves[i, j] + (spacing - a) * b * moves[i, j + 1]
            + a * (spacing - b) * moves[i + 1, j] + a * b * moves[i + 1, j + 1]
        )  # fmt: skip
        out[y, x] = np.floor(mixed / spacing**2 + 0.5)
    return out
