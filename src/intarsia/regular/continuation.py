"""Positions in the exemplar of mosaic blocks: whole blocks, and periods cut by the border, completed from others.

Photographs of tiles are often cut to whole periods, but not along the joints: then one row and one column of periods is
cut in two. If at least half of such a period is there, the rest is taken one or more periods away and joined along the
cheapest seam (Kwatra et al. 2003, eq. 1). If the seam costs more than those between blocks it would be visible: then
the period stays cut and is not used.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..foundation import MethodError
from ..foundation.arrays import Array, Int16, Int32, Int64, Mask, Pair
from ..foundation.geometry import UNIT
from ..kernels import shortest_paths
from ..kernels.shortest_paths import BARRED
from ..methods.near_regular import NearRegular
from .block_grid import BlockGrid, Cell, Places, block_grid, block_places, colour_distances, with_best_phase

LEAST_KNOWN = 0.5  # share of a period that must exist for it to be completed
WELL = 1.3  # a seam may cost at most so many times the average one between blocks, plus UNSEEN
UNSEEN = 4 * 16  # 1/16 of a feature unit: a seam of 4 of 1023 levels is invisible
SPARE = 2  # px added to what is missing, as positions are rounded
ASIDE = 4  # px by which a strip may exceed the exemplar; they repeat its last px
REACH = 24  # largest multiple of each vector that is tried
TRIED = 6  # continuations of least mismatch whose seams are compared
COVERED = 0.6  # share of the added part of a strip that must exist


class ContinuedExemplar(NamedTuple):
    """An exemplar's features with completed periods around it."""

    picture: Int16  # (H, W, C): the features
    usable: Mask  # (H, W): which of them exist
    source: Int32  # (H, W, 2): the exemplar's pixel at each place
    before: Pair = (0, 0)  # rows and columns added above and to the left, px

    def placed(self, grid: BlockGrid) -> BlockGrid:
        """Return the grid of the exemplar in the coordinates of the continued one."""
        y, x = grid.phase
        return replace(grid, phase=(y + self.before[0] * UNIT, x + self.before[1] * UNIT))


def continued(
    picture: Int16, usable: Mask, grid: BlockGrid, steps: tuple[float, float],
    costs: tuple[float, float], border: int,
) -> ContinuedExemplar:  # fmt: skip
    """Complete the periods at the four edges.

    `grid`: the blocks; `steps`: periods along both axes, px; `costs`: cost per px of seams between blocks for each
    axis, 1/16 of a feature unit; `border`: width in px of the band in which a seam may lie.
    """
    size = usable.shape
    out, before = ContinuedExemplar(picture, usable, np.moveaxis(np.indices(size, np.int32), 0, 2)), [0, 0]
    times = np.indices((2 * REACH + 1, 2 * REACH + 1)).reshape(2, -1).T - REACH
    moves = np.rint(times @ np.array(grid.vectors) / UNIT).astype(np.int64)
    vectors = moves[(np.abs(moves) <= size).all(axis=1)]
    for axis in (0, 1):
        phase, other = (grid.phase[axis] / UNIT) % steps[axis], (grid.columns, grid.rows)[axis]
        lean = abs(other[axis] / other[1 - axis]) * size[1 - axis]  # px that the last period lies off the first
        for end, known in ((0, phase), (1, (size[axis] - phase) % steps[axis])):
            missing = math.ceil(steps[axis] - known + lean) + SPARE if known >= LEAST_KNOWN * steps[axis] else 0
            limit = WELL * costs[axis] + UNSEEN
            wider = _longer(out, axis, end, missing, vectors, min(border, size[axis]), limit) if missing > 0 else None
            if wider is not None:
                out = wider
                before[axis] += missing if end == 0 else 0
    return out._replace(before=(before[0], before[1]))


def _longer(
    known: ContinuedExemplar, axis: int, end: int, more: int, vectors: Int64, border: int, limit: float
) -> ContinuedExemplar | None:
    """Add `more` px at one end of an axis; None if no continuation joins at a cost of at most `limit`."""
    sign = 1 if end else -1  # axes are swapped and flipped so that rows are added at the bottom
    picture, usable, source = (np.moveaxis(a, axis, 0)[::sign] for a in (known.picture, known.usable, known.source))
    moves: list[Pair] = np.unique(vectors[:, (axis, 1 - axis)] * (sign, 1), axis=0).tolist()
    strips = [s for m in moves if (s := _strip(picture, usable, m, more, border)) is not None]
    fitting = [s for s in sorted(strips, key=lambda s: (s.incomplete, s.mismatch))[:TRIED] if s.cost <= limit]
    if not fitting:
        return None
    # The one read nearest to the opposite edge: blocks of whole periods do not use that part.
    best = min(fitting, key=lambda s: (s.incomplete, int(s.y[0]), s.cost))
    rows, columns = np.indices(best.there.shape)
    own = np.zeros(rows.shape, bool)
    own[:border] = usable[-border:]
    taken = best.there & ((rows > best.path) | ~own)
    rows = np.clip(rows + len(usable) - border, 0, len(usable) - 1)
    y, x = np.where(taken, best.y[:, None], rows), np.where(taken, best.x, columns)
    parts = (picture, picture[y, x]), (usable, taken | own), (source, source[y, x])
    longer: list[Array] = [np.concatenate([a[:-border], added])[::sign] for a, added in parts]
    one, two, three = (np.ascontiguousarray(np.moveaxis(a, 0, axis)) for a in longer)
    return ContinuedExemplar(one, two, three)


class Strip(NamedTuple):
    """The last rows of a picture and those to be added below them, read at one translation."""

    y: Array  # (rows,): exemplar rows that are read
    x: Array  # (columns,): exemplar columns that are read
    there: Mask  # (rows, columns): which of these pixels exist
    path: Int64  # (columns,): the row of the cheapest seam
    incomplete: bool  # whether some of these pixels do not exist
    mismatch: float  # mean distance of the last rows from the pixels read, 1/16 of a feature unit
    cost: float  # mean cost of the seam per px


def _strip(picture: Array, usable: Array, move: Pair, more: int, border: int) -> Strip | None:
    """Read a strip at one translation; None if too little of it exists, or it begins at the opposite edge."""
    height, width = usable.shape
    y, x = np.arange(height - border, height + more) - move[0], np.arange(width) - move[1]
    if y[border] <= 0 or y[-1] >= height:
        return None
    inside, before = (x >= -ASIDE) & (x < width + ASIDE), y[:border] < 0
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    there = usable[np.ix_(y, x)] & inside
    if there[border:].mean() < COVERED:
        return None
    both = there[:border] & usable[-border:]
    apart = np.where(both, colour_distances(picture[np.ix_(y[:border], x)], picture[-border:]), 0)
    apart[before] = BARRED
    known = there[:border] & (apart < BARRED)
    path = shortest_paths.cheapest(np.ascontiguousarray(apart.T))
    seam = path, np.arange(width)
    mismatch, cost = (int(apart[at].sum()) / max(int(there[:border][at].sum()), 1) for at in (known, seam))
    return Strip(y, x, there, path, not there.all(), mismatch, cost)


class FewPlaces(MethodError):
    """The exemplar holds too few places for a mosaic; its best tile can still be repeated."""


def grid_and_places(
    settings: NearRegular, picture: Int16, usable: Mask, cell: Cell
) -> tuple[BlockGrid, ContinuedExemplar, Places]:
    """Choose the size and phase of blocks, of one period if large ones have too few places; complete cut periods.

    Return the grid in the exemplar, the continued exemplar, and the places of blocks there by parity. Raise FewPlaces
    if there are fewer than two for a block of one period.
    """
    one = block_grid(cell, 1.0, picture.shape)
    periods = one.rows[0] / UNIT, abs(one.columns[1]) / UNIT
    for wanted in (settings.block, 1.0):
        grid, costs = with_best_phase(picture, block_grid(cell, wanted, picture.shape), settings.border)
        ground = continued(picture, usable, grid, periods, costs, settings.border)
        placed = ground.placed(grid)
        places = {(i, j): block_places(placed, ground.usable, (i, j)) for i in (0, 1) for j in (0, 1)}
        if min(len(p) for p in places.values()) >= 2:
            return grid, ground, places
    raise FewPlaces("the exemplar holds fewer than two places for a block of one period; give a larger exemplar.")
