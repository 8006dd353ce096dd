"""A mosaic of lattice blocks: random ones on the black fields of a chessboard, fitting ones on the white.

Which block lies where depends only on its place and the seed: any window of the endless mosaic can be made alone.

Source: Lopez Recas 2011, 4.2. Departures: the block grid begins where cuts are cheapest, in the joints; blocks are
parallelograms of whole periods, upright where the lattice allows it; positions are rounded from exact multiples of the
real lattice vectors; periods that the exemplar's border cuts are completed from others; every position is used about
equally often; gaps are cut in along the cheapest seam, each inside its own mitred wedges, so that no two cuts meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..analysis.sums import nearest
from ..arrays import Array, Laid
from ..canvas import Canvas
from ..draws import below, deck, draw
from ..exemplar import Exemplar
from ..lattice.vectors import UNIT, cell_of
from ..patches.continuation import Continuation
from ..run import Run
from ..search.sizes import elements
from . import bend_kernels, gap_kernels, gap_table_kernels
from .gap_kernels import FAR
from .gap_table import BAR, GapTable
from .grid import BlockSettings
from .places import Shares, dealt, grid_and_places, place_shares
from .pose_sheet import Places, Sheet, lattice_poses, posed_places, sheet_of
from .wrapping import LaidBlocks, Place, beside

STAGE = 2011
KEPT = 12  # best shifts for a gap among which one is drawn
CHOICE = 0.15  # those within this share of the way from the best to the median
APART = 0.5  # the same, where all of them repeat a neighbour


@dataclass(frozen=True, eq=False)
class Mosaic:
    """An endless mosaic."""

    settings: BlockSettings  # the parameters that it is laid by
    seed: int  # what the draws follow from
    laid: LaidBlocks  # where the blocks lie
    sheet: Sheet  # the exemplar's features and usable pixels in all poses, one below the other, that blocks are read in
    # (2, H, W): for every pixel of it the nearest usable one; None where all are usable.
    nearest: NDArray[np.intp] | None
    places: Places  # where on it blocks may be read, 1/256 px, by the parity of their row and column
    shares: Shares  # how often each of the places is to be read, in parts of their sum
    before: Place  # rows and columns added to the exemplar above and to the left, px
    start: Continuation | None = None  # what is on the canvas already, and must be continued
    # Shuffled places, kept for squares of blocks that were asked for, and places that continue the start map.
    orders: dict[tuple[Place, Place], list[int]] = field(default_factory=dict, repr=False)
    fitted: dict[Place, Array | None] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls, settings: BlockSettings, exemplar: Exemplar, canvas: Canvas, seed: int, start: Continuation | None = None
    ) -> Mosaic:
        """Choose blocks, phase and places for an exemplar; FewPlaces where it holds too little."""
        feats = features([exemplar], settings.channel_weights)
        picture = feats.pictures[0]
        usable = np.ones(picture.shape[:2], bool) if exemplar.usable is None else np.asarray(exemplar.usable)
        cell = cell_of(settings.lattice, picture.shape[:2])
        grid, ground, places = grid_and_places(settings, picture, usable, cell, float(elements(exemplar).size))
        laid = LaidBlocks.of(grid, canvas, settings.border / 2)
        poses = lattice_poses(settings.isometries, grid.vectors, exemplar, feats)
        wider, source = replace(feats, pictures=(ground.picture,), _memo={}), ground.placed(grid)
        sheet = sheet_of(wider, ground.usable, ground.source, poses, 2 * math.ceil(laid.half) + 8)
        if len(poses) > 1:
            places = posed_places(sheet, wider, source, places)
        near = nearest(sheet.usable)
        shares = place_shares(source, sheet, near, places)
        return cls(settings, seed, laid, sheet, near, places, shares, ground.before, start)

    def window(
        self, y0: int, x0: int, height: int, width: int, run: Run | None = None
    ) -> tuple[NDArray[np.int32], NDArray[np.uint8] | None]:
        """The exemplar pixels (height, width, 2) and the poses (height, width) of a window; None: all upright."""
        return self.sheet.to_exemplar(self.on_sheet(y0, x0, height, width, run))

    def on_sheet(self, y0: int, x0: int, height: int, width: int, run: Run | None = None) -> NDArray[np.int32]:
        """The pixels of the sheet (height, width, 2) that a window shows."""
        out, run = np.zeros((height, width, 2), np.int32), run or Run()
        fields = self.laid.meeting(y0, x0, height, width)
        done, draft, _ = 0, partial(self._draft, out), self.tables  # made before threads ask for them
        with run.pool() as each:
            for parity in (0, 1):  # gaps are cut into the random blocks; no two gaps meet
                part = [f for f in fields if (f[0] + f[1]) % 2 == parity]
                for begin in range(0, len(part), 64):
                    run.tick(done, len(fields), draft)
                    for block in each(self._block, part[begin : begin + 64]):  # in turn, whichever thread was first
                        self._write(block, out, y0, x0)
                        done += 1
        run.tick(done, len(fields), draft)
        return out

    def _draft(self, out: NDArray[np.int32]) -> Laid:
        """What of a window is laid; the first pixel of the sheet stands for nothing."""
        return *self.sheet.to_exemplar(out), np.asarray(out.any(axis=2))

    @cached_property
    def sparse(self) -> Places:
        """Of places closer together than the slack, one; for gaps, which look around each."""
        side, sparse = (self.settings.slack + 1) * UNIT, {}
        for kind, found in self.places.items():  # the first one in every square
            sparse[kind] = found[np.sort(np.unique(found // side, axis=0, return_index=True)[1])]
        return sparse

    @cached_property
    def tables(self) -> dict[Place, GapTable | None]:
        """How places fit into gaps, by the parity of row and column; None where they are many, or a start goes on."""
        found: dict[Place, GapTable | None] = {(0, 1): None, (1, 0): None}
        if self.start is not None:
            return found
        for i, j in ((0, 1), (1, 0)):
            at, sides, core = self.laid.window(i, j)
            near = []
            for a, b in beside(i, j):
                there, here = (self._shifts(*block, self._places(a, b)) + at for block in ((a, b), (i, j)))
                near.append((there, here, self.shares[a % 2, b % 2]))
            shifts, shares = self._shifts(i, j) + at, self.shares[i, j]
            own = shifts, shares if len(shares) == len(shifts) else np.ones(len(shifts), np.int64)
            picture, usable, slack = self.sheet.picture, self.sheet.usable, self.settings.slack
            found[i, j] = GapTable.of(picture, usable, core, sides, own, near, slack)
        return found

    def _block(self, block: Place) -> tuple[Array, ...]:
        """Canvas rows and columns of the pixels that a block decides, and the exemplar's it shows there."""
        i, j = block
        at, sides, core = self.laid.window(i, j)
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
        height, width = self.sheet.usable.shape
        sy, sx = np.clip(block[2][inside], 0, height - 1), np.clip(block[3][inside], 0, width - 1)
        if self.nearest is not None:
            sy, sx = self.nearest[0][sy, sx], self.nearest[1][sy, sx]
        out[y[inside], x[inside], 0], out[y[inside], x[inside], 1] = sy, sx

    def _gap(self, i: int, j: int, at: Place, sides: Array, core: Array) -> tuple[Array, Array, Array]:
        near = beside(i, j)
        places = np.array([self._place(a, b) for a, b in near])
        t = np.array([self._shift(a, b, place) for (a, b), place in zip(near, places, strict=True)], np.int64) + at
        y, x = np.nonzero(sides >= 0)
        zone = np.stack([y, x, sides[y, x]], axis=1).astype(np.int64)
        if self.start is not None:  # the start map is a fifth neighbour, which shows the exemplar where it lies
            there = self.start.zone(at, (core > 0) | (sides >= 0), len(near))
            free = np.full(core.shape, True)
            free[there[:, 0], there[:, 1]] = False
            zone, t = np.concatenate([zone[free[y, x]], there]), np.concatenate([t, [np.add(at, self.before)]])
        ty, tx = self._fit(i, j, core, zone, t, at)
        owner = np.empty(core.shape, np.uint8)
        sy, sx = np.empty(core.shape, np.int64), np.empty(core.shape, np.int64)
        shift = self._bent(zone, t, (ty, tx), core)
        gap_kernels.fill_gap(self.sheet.picture, self.sheet.usable, sides, core, t, shift, owner, sy, sx)
        own = owner.astype(bool)
        return own, sy[own], sx[own]

    def _bent(self, zone: Array, t: Array, whole: Place, core: Array) -> Array:
        """A gap's shift, pixel by pixel: that of the whole block, bent so that lines meet the neighbours'."""
        shift = np.empty((*core.shape, 2), np.int64)
        shift[:] = whole
        if self.settings.bend:
            spacing = max(round(2 * self.laid.half), 4)
            picture, usable = self.sheet.picture, self.sheet.usable
            places, values = gap_kernels.neighbours_of(picture, usable, zone, t, 1)
            bend_kernels.bend(picture, usable, places, values, self.settings.bend, spacing, core, shift)
        return shift

    def _fit(self, i: int, j: int, core: Array, zone: Array, t: Array, at: Place) -> Place:
        """The shift of a gap: one that fits, and shows neither the same as a neighbour nor what continues it."""
        shifts, table = self._shifts(i, j) + at, self.tables[i % 2, j % 2]
        if table is not None:
            order, costs, moves = table.ranked([self._random(a, b) for a, b in beside(i, j)])
            bits = draw(self.seed, STAGE, 1, *self.laid.number(i, j))
            near = min(self.settings.slack, 1)
            for k in _tried(costs, bits):
                wanted = shifts[order[k : k + 1]] + moves[k]
                gap_table_kernels.move_within(self.sheet.usable, core, near, wanted[0])
                for _, ty, tx in self._best(core, zone, t, wanted, near, 1).tolist():
                    return ty, tx
        found = self._best(core, zone, t, shifts, self.settings.slack)
        if not len(found):
            return int(shifts[0, 0]), int(shifts[0, 1])
        places = np.array([self._place(a, b) for a, b in beside(i, j)])
        return self._choose(i, j, found, t, self._shifts(i, j, places) + at)

    def _best(self, core: Array, zone: Array, t: Array, shifts: Array, slack: int, keep: int = KEPT) -> Array:
        """The best of some shifts for a gap, each moved by up to `slack` px: (n, 3) mismatch and shift, rising."""
        found = np.empty((keep, 3), np.int64)
        picture, usable = self.sheet.picture, self.sheet.usable
        return found[: gap_kernels.best_fits(picture, usable, core, zone, t, shifts, slack, keep, found)]

    def _choose(self, i: int, j: int, found: Array, t: Array, equal: Array) -> Place:
        """Draw among the good shifts of many places.

        `t`: the neighbours' shifts, which would continue them; `equal`: those that would repeat them.
        """
        median = found[len(found) // 2, 0]
        near = [found[:, 0] <= found[0, 0] + share * (median - found[0, 0]) for share in (CHOICE, APART)]
        far = 2 * self.settings.slack
        new, other = (np.abs(found[:, None, 1:] - n).sum(axis=2).min(axis=1) > far for n in (t, equal))
        choices = (near[0] & new & other, near[1] & new & other, near[0] & new, near[0])
        good = found[next(some for some in choices if some.any())]
        row = good[below(len(good), draw(self.seed, STAGE, 1, *self.laid.number(i, j)))]
        return int(row[1]), int(row[2])

    def _random(self, i: int, j: int) -> int:
        """The place that a random block is read from: in each square of blocks as often as its share says, shuffled."""
        i, j = self.laid.number(i, j)
        side = 2 * math.ceil(math.sqrt(len(self._places(i, j)) / 2))
        square, cell = (i // side, j // side), ((i % side) * side + j % side) // 2
        kind = i % 2, j % 2
        order = self.orders.get((square, kind))
        if order is None:
            if len(self.orders) > 256:  # an endless mosaic must not fill the memory
                self.orders.clear()
            cards, bits = deck(len(self.places[kind]), self.seed, STAGE, 2, *square), draw(self.seed, STAGE, 2, *square)
            order = self.orders[square, kind] = dealt(self.shares[kind], bits, cards[::-1])
        return order[cell % len(order)]

    def _place(self, i: int, j: int) -> Array:
        """The place that a block which is no gap is read from: what continues the canvas's start, or any."""
        if self.start is not None:
            if (i, j) not in self.fitted:
                self.fitted[i, j] = self._fitting(i, j, self.start)
            known = self.fitted[i, j]
            if known is not None:
                return known
        place: Array = self._places(i, j)[self._random(i, j)]
        return place

    def _fitting(self, i: int, j: int, start: Continuation) -> Array | None:
        """The place that best continues the start map; None where that is empty, or no place reaches so far."""
        at, sides, core = self.laid.window(i, j)
        zone = start.zone(at, (core > 0) | (sides >= 0), 0)
        if not len(zone):
            return None
        there = np.array([np.add(at, self.before)], np.int64)
        found = self._best(core, zone, there, self._shifts(i, j) + at, self.settings.slack)
        return np.asarray(np.add(self.laid.origin(i, j), (found[0, 1:] - at) * UNIT)) if len(found) else None

    def _shift(self, i: int, j: int, place: Array) -> Place:
        """What to add to canvas px of block (i, j) to read the block at a place."""
        y, x = self.laid.origin(i, j)
        py, px = place
        return (int(py) - y + UNIT // 2) // UNIT, (int(px) - x + UNIT // 2) // UNIT

    def _shifts(self, i: int, j: int, places: Array | None = None) -> NDArray[np.int64]:
        """What to add to read block (i, j) at each of some places (n, 2); None: those for gaps."""
        places = self.sparse[i % 2, j % 2] if places is None else places
        return np.asarray((places - self.laid.origin(i, j) + UNIT // 2) // UNIT)

    def _places(self, i: int, j: int) -> NDArray[np.int64]:
        return self.places[i % 2, j % 2]


def _tried(costs: Array, bits: int) -> list[int]:
    """In which order places are tried, of which `costs` rises: first one of the best, drawn, then all in turn."""
    free = costs[: max(int((costs < BAR).sum()), 1)]
    good = int((free <= free[0] + CHOICE * (free[len(free) // 2] - free[0])).sum())
    first = below(good, bits)
    return [first, *(k for k in range(len(costs)) if k != first and costs[k] < FAR)]
