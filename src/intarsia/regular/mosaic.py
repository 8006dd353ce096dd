"""Mosaic of lattice blocks on a chessboard: random blocks on the black fields, fitting ones in the gaps between.

The gaps are the white fields. The block of a field depends only on the field and the seed, so that any window of the
endless mosaic can be computed alone.

Source: Lopez Recas 2011, 4.2. Departures: the block grid begins where cuts are cheapest, in the joints; blocks are
parallelograms of whole periods, upright if the lattice allows it; positions are rounded from exact multiples of the
real lattice vectors; periods that the exemplar's border cuts are completed from others; random blocks are taken from
shuffled decks of all positions; gaps are cut in along the cheapest seam, each inside its own overlap regions with
mitred ends, so that no two cuts meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from ..analysis import nearest
from ..analysis.features import features
from ..foundation.arrays import Array, Int32, Int64, Laid, Mask, Pair
from ..foundation.geometry import UNIT
from ..foundation.run import Run, below, deck, draw
from ..lattice import cell_of
from ..methods.near_regular import NearRegular
from ..model import Exemplar
from . import block_kernels
from .block_grid import BlockGrid, Places, adjacent_blocks
from .continuation import ContinuedExemplar, grid_and_places

STAGE = 2011  # key of the random numbers of mosaics, which makes them independent of other stages
KEPT = 12  # shifts of least mismatch for a gap, of which one is drawn
CHOICE = 0.15  # largest mismatch of the drawn one, as a share of the way from the least to the median
APART = 0.5  # the same if all of these repeat a neighbour or continue it


shuffled = lru_cache(maxsize=64)(deck)  # limited, as an endless mosaic has any number of decks


@dataclass(frozen=True, eq=False)
class Mosaic:
    """An endless mosaic."""

    settings: NearRegular  # its parameters
    seed: int  # of the random numbers
    grid: BlockGrid  # positions of the blocks
    ground: ContinuedExemplar  # the exemplar with completed periods, which blocks are read from
    # (2, H, W): for every pixel of it the nearest usable one; None where all are usable.
    nearest: NDArray[np.intp] | None
    places: Places  # positions there at which blocks may be read, 1/256 px, by parity of block row and column

    @classmethod
    def of(cls, settings: NearRegular, exemplar: Exemplar, seed: int) -> Mosaic:
        """Choose blocks, phase and places for an exemplar. Raise FewPlaces if it has fewer than two places."""
        picture = features([exemplar], settings.channel_weights).pictures[0]
        cell = cell_of(settings.lattice, picture.shape[:2])
        grid, ground, places = grid_and_places(settings, picture, exemplar.free, cell)
        return cls(settings, seed, grid, ground, nearest(ground.usable), places)

    def window(self, y0: int, x0: int, height: int, width: int, run: Run | None = None) -> Int32:
        """Return the exemplar pixels (height, width, 2) of a window, without rotation or mirroring."""
        return self._exemplar(self.continued_window(y0, x0, height, width, run))

    def continued_window(self, y0: int, x0: int, height: int, width: int, run: Run | None = None) -> Int32:
        """Return the pixels of the continued exemplar (height, width, 2) in a window."""
        out, run = np.zeros((height, width, 2), np.int32), run or Run()
        fields = self.grid.intersecting(y0, x0, height, width, self.settings.border / 2)
        done, draft, _ = 0, partial(self._draft, out), self.sparse  # computed before threads share it
        with run.pool() as each:
            for parity in (0, 1):  # random blocks first, then gaps, which do not meet
                part = [f for f in fields if (f[0] + f[1]) % 2 == parity]
                for begin in range(0, len(part), 64):
                    run.tick(done, len(fields), draft)
                    for block in each(self._block, part[begin : begin + 64]):  # in order of blocks, not of threads
                        self._write(block, out, y0, x0)
                        done += 1
        run.tick(done, len(fields), draft)
        return out

    def _draft(self, out: Int32) -> Laid:
        """Return the placed part of a window; the first pixel of the continued exemplar means none."""
        return self._exemplar(out), None, np.asarray(out.any(axis=2))

    def _exemplar(self, yx: Int32) -> Int32:
        """Return the exemplar pixels of pixels (..., 2) of the continued exemplar."""
        return self.ground.source[yx[..., 0], yx[..., 1]]

    @cached_property
    def sparse(self) -> Places:
        """The first place in every square of lattice_tolerance + 1 px; the search for gaps refines around each."""
        side = (self.settings.lattice_tolerance + 1) * UNIT
        squares = {kind: np.unique(some // side, axis=0, return_index=True)[1] for kind, some in self.places.items()}
        return {kind: some[np.sort(squares[kind])] for kind, some in self.places.items()}

    def _block(self, block: Pair) -> tuple[Pair, Mask, Array]:
        """Return the first pixel of a block's window, which pixels the block owns, and their exemplar pixels."""
        i, j = block
        at, sides, core = self.grid.window(i, j, self.settings.border / 2)
        if (i + j) % 2:
            return at, *self._gap(i, j, at, sides, core)
        shown = np.moveaxis(np.indices(core.shape), 0, 2) + (self._shifts(i, j, self._place(i, j)) + at)
        return at, core, shown

    def _write(self, block: tuple[Pair, Mask, Array], out: Array, y0: int, x0: int) -> None:
        """Write the part of a block that lies in a window."""
        at, own, shown = block
        low = np.maximum(at, (y0, x0))
        high = np.minimum(np.add(at, own.shape), np.add((y0, x0), out.shape[:2]))
        here, there = (
            tuple(slice(a - f, b - f) for a, b, f in zip(low, high, first, strict=True)) for first in (at, (y0, x0))
        )
        own = own[here]
        yx = np.clip(shown[here][own], 0, np.subtract(self.ground.usable.shape, 1))
        out[there][own] = yx if self.nearest is None else self.nearest[:, yx[:, 0], yx[:, 1]].T

    def _gap(self, i: int, j: int, at: Pair, sides: Array, core: Array) -> tuple[Mask, Array]:
        """Return which pixels of its window a gap owns, and their exemplar pixels."""
        near = adjacent_blocks(i, j)
        t = np.array([self._shifts(*block, self._place(*block)) for block in near], np.int64) + at
        y, x = np.nonzero(sides >= 0)
        zone = np.stack([y, x, sides[y, x]], axis=1).astype(np.int64)
        ty, tx = self._fit(i, j, core, zone, t, at)
        own, shown = block_kernels.fill_gap(self.ground.picture, self.ground.usable, sides, core, t, ty, tx)
        return own, shown

    def _fit(self, i: int, j: int, core: Array, zone: Array, t: Array, at: Pair) -> Pair:
        """Return the shift of a gap, drawn among those of low mismatch that neither repeat nor continue a neighbour.

        `t`: the shifts of the neighbours, which a gap of the same shift would continue. If none is left, those of
        higher mismatch, then those that repeat, then those that continue one are allowed.
        """
        shifts = self._shifts(i, j) + at
        found = self._best(core, zone, t, shifts)
        if not len(found):
            return int(shifts[0, 0]), int(shifts[0, 1])
        equal = self._shifts(i, j, np.array([self._place(a, b) for a, b in adjacent_blocks(i, j)])) + at
        median = found[len(found) // 2, 0]
        near = [found[:, 0] <= found[0, 0] + share * (median - found[0, 0]) for share in (CHOICE, APART)]
        far = 2 * self.settings.lattice_tolerance
        new, other = (np.abs(found[:, None, 1:] - n).sum(axis=2).min(axis=1) > far for n in (t, equal))
        choices = (near[0] & new & other, near[1] & new & other, near[0] & new, near[0])
        good = found[next(some for some in choices if some.any())]
        row = good[below(len(good), draw(self.seed, STAGE, 1, i, j))]
        return int(row[1]), int(row[2])

    def _best(self, core: Array, zone: Array, t: Array, shifts: Array) -> Array:
        """Return the best shifts for a gap, refined by up to `slack` px: (n, 3), mismatch and shift, by mismatch."""
        picture, usable, slack = self.ground.picture, self.ground.usable, self.settings.lattice_tolerance
        found = block_kernels.best_fits(picture, usable, core, zone, t, shifts, slack, KEPT)
        return np.asarray(found[np.argsort(found[:, 0], kind="stable")])

    def _random(self, i: int, j: int) -> int:
        """Return the index of the place of a random block; each square of blocks draws from its own shuffled deck."""
        count = len(self.places[i % 2, j % 2])
        side = 2 * math.ceil(math.sqrt(count / 2))
        order = shuffled(count, self.seed, STAGE, 2, i // side, j // side)
        return order[-1 - ((i % side) * side + j % side) // 2 % len(order)]

    def _place(self, i: int, j: int) -> Array:
        """Return the place of a block that is no gap, a random one."""
        return np.asarray(self.places[i % 2, j % 2][self._random(i, j)])

    def _shifts(self, i: int, j: int, places: Array | None = None) -> Int64:
        """Return the shifts (..., 2) from canvas px of block (i, j) to exemplar px for places; None: those of gaps."""
        places = self.sparse[i % 2, j % 2] if places is None else places
        return np.asarray((places - self.grid.origin(i, j) + UNIT // 2) // UNIT)
