"""A mosaic of lattice blocks: random ones on the black fields of a chessboard, fitting ones on the white.

Which block lies where depends only on its place and the seed: any window of the endless mosaic can be made alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..draws import below, draw
from ..exemplar import Exemplar
from ..kernels import bend, blocks
from ..run import Run
from .blockgrid import UNIT, BlockGrid
from .cell import cell_of
from .closing import closed_grid
from .features import features
from .held import Held
from .mosaic_places import BORDER, grid_and_places, nearest, thinned
from .mosaic_settings import Settings
from .posed_sheet import Sheet, lattice_poses, posed_places, sheet_of
from .sizes import elements

STAGE = 2011
KEPT = 12  # best shifts for a gap among which one is drawn
CHOICE = 0.15  # those within this share of the way from the best to the median
APART = 0.5  # the same, where all of them repeat a neighbour
Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Mosaic:
    """An endless mosaic.

    Attributes
    ----------
    picture, usable : int16 array (H, W, C), bool array (H, W)
        The exemplar's features and usable pixels, in all poses.
    source, canvas : BlockGrid
        The grid in the exemplar, and as it lies on the canvas (strained a little where that wraps).
    places : dict of int64 arrays (n, 2)
        Where blocks may be read, 1/256 px, by the parity of their row and column.
    sparse : dict of int64 arrays (n, 2)
        Of places closer together than the slack, one; for gaps, which look around each.
    around : (rows, columns)
        Blocks around a wrapped canvas along each axis, 0 where it does not wrap.
    lengths : (rows, columns)
        Size of the canvas, px.
    half : float
        Half the width of the zone in which gaps are cut, px.
    slack : int
        How far a gap's block may leave the lattice, px.
    bend : int
        How far parts of a gap's block may move so that lines meet, px.
    seed : int
        What the draws follow from.
    nearest : int array (2, H, W) or None
        For every pixel the nearest usable one; None where all are usable.
    sheet : Sheet
        The poses, one below the other, that blocks are read in.
    held : Held or None
        What is on the canvas already, and must be continued.
    orders, fitted : dicts
        Shuffled places, kept for squares of blocks that were asked for, and places that continue what is there.
    """

    picture: NDArray[np.int16]
    usable: NDArray[np.bool_]
    source: BlockGrid
    canvas: BlockGrid
    places: dict[tuple[int, int], NDArray[np.int64]]
    sparse: dict[tuple[int, int], NDArray[np.int64]]
    around: tuple[int, int]
    lengths: tuple[int, int]
    half: float
    slack: int
    bend: int
    seed: int
    nearest: NDArray[np.intp] | None
    sheet: Sheet
    held: Held | None = None
    orders: dict[tuple[int, int, int], list[int]] = field(default_factory=dict, repr=False)
    fitted: dict[tuple[int, int], Array | None] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls, method: Settings, exemplar: Exemplar, canvas: Canvas, seed: int, held: Held | None = None
    ) -> Mosaic:
        """Choose blocks, phase and places for an exemplar; FewPlaces where it holds too little."""
        feats = features([exemplar], method.channel_weights)
        picture = feats.pictures[0]
        usable = np.ones(picture.shape[:2], bool) if exemplar.usable is None else np.asarray(exemplar.usable)
        cell = cell_of(method.lattice, picture.shape[:2])
        grid, places = grid_and_places(method, picture, usable, cell, float(elements(exemplar).size))
        laid, around = closed_grid(grid, canvas)
        half = (method.border or BORDER) / 2
        poses = lattice_poses(method.isometries, cell, exemplar, feats)
        sheet = sheet_of(feats, usable, poses, 2 * math.ceil(half) + 8)
        if len(poses) > 1:
            places = posed_places(sheet, feats, grid, places)
        sparse = {kind: thinned(found, method.slack) for kind, found in places.items()}
        return cls(
            sheet.picture, sheet.usable, grid, laid, places, sparse, around, (canvas.height, canvas.width),
            half, method.slack, method.bend, seed, nearest(sheet.usable), sheet, held,
        )  # fmt: skip

    def window(self, y0: int, x0: int, height: int, width: int, run: Run | None = None) -> NDArray[np.int32]:
        """The pixels of the sheet (height, width, 2) that a window of the mosaic shows."""
        out = np.zeros((height, width, 2), np.int32)
        reach = math.ceil(self.half) + 1
        corners = [
            self.canvas.block_of(y, x)
            for y in (y0 - reach, y0 + height + reach)
            for x in (x0 - reach, x0 + width + reach)
        ]
        rows = range(min(c[0] for c in corners) - 1, max(c[0] for c in corners) + 2)
        columns = range(min(c[1] for c in corners) - 1, max(c[1] for c in corners) + 2)
        fields = [(i, j) for i in rows for j in columns if self._touches(i, j, y0, x0, height, width)]
        run = run or Run()
        done = 0
        with run.pool() as each:
            for parity in (0, 1):  # gaps are cut into the random blocks; no two gaps meet
                part = [f for f in fields if (f[0] + f[1]) % 2 == parity]
                for begin in range(0, len(part), 64):
                    run.tick(done, len(fields))
                    some = part[begin : begin + 64]
                    made: list[tuple[Array, ...]] = [()] * len(some)

                    def make(k: int, some: Any = some, made: Any = made) -> None:
                        made[k] = self._block(*some[k])

                    each(make, range(len(some)))
                    for block in made:  # in turn: what is written never depends on which thread was first
                        self._write(block, out, y0, x0)
                    done += len(some)
        run.tick(done, len(fields))
        return out

    def _block(self, i: int, j: int) -> tuple[Array, ...]:
        """Canvas rows and columns of the pixels that a block decides, and the exemplar's it shows there."""
        at, sides, core = self._ring(i, j)
        if (i + j) % 2 == 0:
            ty, tx = self._shift(i, j, self._place(i, j))
            y, x = np.nonzero(core)
            return y + at[0], x + at[1], y + at[0] + ty, x + at[1] + tx
        own, sy, sx = self._gap(i, j, at, sides, core)
        y, x = np.nonzero(own)
        return y + at[0], x + at[1], sy, sx

    def _write(self, block: tuple[Array, ...], out: Array, y0: int, x0: int) -> None:
        """Write what of a block lies in a window."""
        y, x = block[0] - y0, block[1] - x0
        inside = (y >= 0) & (y < out.shape[0]) & (x >= 0) & (x < out.shape[1])
        height, width = self.usable.shape
        sy, sx = np.clip(block[2][inside], 0, height - 1), np.clip(block[3][inside], 0, width - 1)
        if self.nearest is not None:
            sy, sx = self.nearest[0][sy, sx], self.nearest[1][sy, sx]
        out[y[inside], x[inside], 0], out[y[inside], x[inside], 1] = sy, sx

    def _gap(self, i: int, j: int, at: tuple[int, int], sides: Array, core: Array) -> tuple[Array, Array, Array]:
        near = ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
        places = np.array([self._place(a, b) for a, b in near])
        t = np.array([self._shift(a, b, place) for (a, b), place in zip(near, places, strict=True)], np.int64) + at
        equal = (places - self._origin(i, j) + UNIT // 2) // UNIT + at
        y, x = np.nonzero(sides >= 0)
        zone = np.stack([y, x, sides[y, x]], axis=1).astype(np.int64)
        if self.held is not None:  # what is there is a fifth neighbour, which shows the exemplar where it lies
            there = self.held.zone(at, (core > 0) | (sides >= 0), len(near))
            free = np.full(core.shape, True)
            free[there[:, 0], there[:, 1]] = False
            zone, t = np.concatenate([zone[free[y, x]], there]), np.concatenate([t, [at]])
        shifts = self._shifts(i, j) + at
        found = np.empty((KEPT, 3), np.int64)
        count = blocks.rank(self.picture, self.usable, core, zone, t, shifts, self.slack, KEPT, found)
        ty, tx = self._choose(i, j, found[:count], t, equal) if count else (int(shifts[0, 0]), int(shifts[0, 1]))
        owner = np.empty(core.shape, np.uint8)
        sy, sx = np.empty(core.shape, np.int64), np.empty(core.shape, np.int64)
        shift = self._bent(zone, t, (ty, tx), core)
        blocks.fill_gap(self.picture, self.usable, sides, core, t, shift, owner, sy, sx)
        own = owner.astype(bool)
        return own, sy[own], sx[own]

    def _bent(self, zone: Array, t: Array, whole: tuple[int, int], core: Array) -> Array:
        """A gap's shift, pixel by pixel: that of the whole block, bent so that lines meet the neighbours'."""
        shift = np.empty((*core.shape, 2), np.int64)
        shift[:] = whole
        if self.bend:
            spacing = max(round(2 * self.half), 4)
            places, values = blocks.shown(self.picture, self.usable, zone, t, 1)
            bend.bend(self.picture, self.usable, places, values, self.bend, spacing, core, shift)
        return shift

    def _choose(self, i: int, j: int, found: Array, t: Array, equal: Array) -> tuple[int, int]:
        """Draw among the good shifts: one that shows neither what a neighbour shows, nor what lies beside it.

        `t`: the neighbours' shifts, which would continue them; `equal`: those that would repeat them.
        """
        median = found[len(found) // 2, 0]
        near = [found[:, 0] <= found[0, 0] + share * (median - found[0, 0]) for share in (CHOICE, APART)]
        new, other = (np.abs(found[:, None, 1:] - n).sum(axis=2).min(axis=1) > 2 * self.slack for n in (t, equal))
        choices = (near[0] & new & other, near[1] & new & other, near[0] & new, near[0])
        good = found[next(some for some in choices if some.any())]
        row = good[below(len(good), draw(self.seed, STAGE, 1, *self._name(i, j)))]
        return int(row[1]), int(row[2])

    def _random(self, i: int, j: int) -> int:
        """The place that a random block is read from: every place once in each square of blocks, shuffled."""
        i, j = self._name(i, j)
        places = self._places(i, j)
        side = 2 * math.ceil(math.sqrt(len(places) / 2))
        square, cell = (i // side, j // side), ((i % side) * side + j % side) // 2
        order = self._order(*square, len(places))
        return order[cell % len(order)]

    def _order(self, row: int, column: int, count: int) -> list[int]:
        """The numbers below `count`, shuffled for a square of blocks."""
        key = row, column, count
        known = self.orders.get(key)
        if known is None:
            order = list(range(count))
            for k in range(count - 1, 0, -1):
                other = below(k + 1, draw(self.seed, STAGE, 2 + k, row, column))
                order[k], order[other] = order[other], order[k]
            if len(self.orders) > 256:  # an endless mosaic must not fill the memory
                self.orders.clear()
            known = self.orders[key] = order[::-1]
        return known

    def _place(self, i: int, j: int) -> Array:
        """The place that a block which is no gap is read from: what continues the canvas's start, or any."""
        if self.held is not None:
            if (i, j) not in self.fitted:
                self.fitted[i, j] = self._fitting(i, j, self.held)
            known = self.fitted[i, j]
            if known is not None:
                return known
        place: Array = self._places(i, j)[self._random(i, j)]
        return place

    def _fitting(self, i: int, j: int, held: Held) -> Array | None:
        """The place that best continues what is there; None where nothing is, or no place reaches so far."""
        at, sides, core = self._ring(i, j)
        zone = held.zone(at, (core > 0) | (sides >= 0), 0)
        if not len(zone):
            return None
        found, there = np.empty((KEPT, 3), np.int64), np.array([at], np.int64)
        count = blocks.rank(
            self.picture, self.usable, core, zone, there, self._shifts(i, j) + at, self.slack, KEPT, found
        )
        return np.asarray(np.add(self._origin(i, j), (found[0, 1:] - at) * UNIT)) if count else None

    def _shift(self, i: int, j: int, place: Array) -> tuple[int, int]:
        """What to add to canvas px of block (i, j) to read the block at a place."""
        y, x = self._origin(i, j)
        py, px = place
        return (int(py) - y + UNIT // 2) // UNIT, (int(px) - x + UNIT // 2) // UNIT

    def _shifts(self, i: int, j: int) -> NDArray[np.int64]:
        y, x = self._origin(i, j)
        return (self.sparse[i % 2, j % 2] - (y, x) + UNIT // 2) // UNIT

    def _places(self, i: int, j: int) -> NDArray[np.int64]:
        return self.places[i % 2, j % 2]

    def _origin(self, i: int, j: int) -> tuple[int, int]:
        """First corner of a block, 1/256 px; around a wrapped canvas the last one ends where the first begins."""
        y, x = self.canvas.origin(i, j)
        if self.around[0]:
            y += i * self.lengths[0] * UNIT // self.around[0] - i * self.canvas.rows[0]
        if self.around[1]:
            x += j * self.lengths[1] * UNIT // self.around[1] - j * self.canvas.columns[1]
        return y, x

    def _name(self, i: int, j: int) -> tuple[int, int]:
        """Number of a block; around a wrapped canvas the numbers return."""
        rows, columns = self.around
        return (i % rows if rows else i), (j % columns if columns else j)

    def _ring(self, i: int, j: int) -> tuple[tuple[int, int], Array, Array]:
        """First pixel of a block's window, the neighbour that each of its pixels lies towards, and the block."""
        at, shape = self._box(i, j)
        sides, core = np.empty(shape, np.int8), np.empty(shape, np.uint8)
        blocks.ring(self._frame(i, j, at), np.zeros(2, np.int64), self.half, sides, core)
        return at, sides, core

    def _box(self, i: int, j: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """First pixel and shape of the window around a block, its seam zone included."""
        y, x = self._origin(i, j)
        reach = math.ceil(self.half) + 1
        before, shape = self.canvas.before(), self.canvas.extent()
        at = (y // UNIT + before[0] - reach, x // UNIT + before[1] - reach)
        return at, (shape[0] + 2 * reach + 1, shape[1] + 2 * reach + 1)

    def _frame(self, i: int, j: int, at: tuple[int, int]) -> NDArray[np.int64]:
        y, x = self._origin(i, j)
        return np.array((*self.canvas.rows, *self.canvas.columns, y - at[0] * UNIT, x - at[1] * UNIT), np.int64)

    def _touches(self, i: int, j: int, y0: int, x0: int, height: int, width: int) -> bool:
        at, shape = self._box(i, j)
        return at[0] < y0 + height and at[1] < x0 + width and at[0] + shape[0] > y0 and at[1] + shape[1] > x0
