"""Repetition control of patch-based methods: prices of repeats.

Every patch placed raises the price of its part of the exemplar, so that the whole exemplar is used, and a flat area,
which fits next to itself, does not spread. The price is higher near to where the patch was placed, and the higher the
rarer the patch. It is added to the distance, in units of the usual distance; as a factor it would leave a perfect
repeat free, whose distance is 0.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any, ClassVar

import numpy as np

from ..analysis.features import Features
from ..analysis.saliency import rarity
from ..foundation.arrays import Array, Int32, Pair, UInt8
from ..model.sourcemap import HOLE
from ..search import Candidates, Prices, Search, WindowGrid, in_one_row
from . import Pick, picked, repetition_kernels
from .repetition_kernels import Terms, Uses, Wave

REACH = 4  # windows around one in which a repeat costs more the nearer it is
LEAST_STRIKING, MOST_STRIKING = 128, 1024  # limits of rarity, 256 = median: even the most common patch has a price
MATCH = 0.25  # the tolerance is relative to the best price, or to this share of the usual distance if that is more
DRIFT = 3.0  # a part of the exemplar that is used this many times as often as the mean becomes expensive
MOST_EXCESS = 1 << 24  # limit of that addition, in 1/256 uses, so that it fits into int32
STEADY = 0.3  # share of the price of a full repeat however far away; at the same place it is 1.3


class Repetition:
    """The placements so far, and the prices of repeating them.

    `search`: the search whose variants and coarse positions are used; `strength`: price of a full repeat, relative to
    the usual distance, 0: no prices; `striking`: for every variant, the rarity of the patch at each coarse position,
    256 = median.
    """

    in_turn: ClassVar[bool] = False
    """Whether every window is a batch of its own, in raster order, so that each use counts for the next window."""

    def __init__(
        self, search: Search, layout: WindowGrid, strength: float, striking: list[Array] | None = None
    ) -> None:
        self.search, self.layout, self.strength = search, layout, strength
        shapes = [v.shape for v in search.valid]
        self.striking = striking or [np.full(s, 256, np.int32) for s in shapes]
        flat, self._offsets = in_one_row(search.valid)
        self._flat = np.zeros(len(flat), np.int32)
        self._flat_striking = np.concatenate([s.ravel() for s in self.striking])
        self._priced = self._flat.copy()  # the uses, plus the excess that `account` adds
        self.laid = 0
        self._groups: Array | None = None
        counts = [self._priced[o : o + a * b].reshape(a, b) for o, a, b in self._offsets.tolist()]
        self.search_prices = Prices(counts, round(strength * STEADY * 65536))
        self._laid = Uses(
            search.variants.frames,
            np.array(layout.patch, np.int64),
            np.array((*layout.size, *layout.wraps), np.int64),
            self._offsets, search.factor, self._flat_striking, self._flat, self._priced,
        )  # fmt: skip
        self.grid = np.full((*layout.shape, 8), -1, np.int64)
        self.started = np.empty((0, 8), np.int64)  # what a start map shows, as placements
        self.reach = REACH if strength else 0

    def apart(self, groups: Array) -> None:
        """Compare uses within groups of coarse positions, such as those of one label; `groups`: the group of each."""
        self._groups = groups

    def account(self) -> None:
        """Update the prices by the uses so far; call between batches.

        A coarse position used more than DRIFT times as often as the mean gets an additional price, in proportion to the
        excess: a flat or dark area, once chosen, fits itself perfectly, and would otherwise fill the output.
        """
        np.copyto(self._priced, self._flat)
        if not self.strength or not self.laid:
            return
        most = int(self._flat.max(initial=0))
        # Uses of each part of the exemplar, or of each group, if all were used alike.
        even: Any = self.laid * math.prod(self.search.cells) / max(self._flat.size, 1) + 1
        if self._groups is None and most <= DRIFT * even * LEAST_STRIKING:
            return
        uses = self._flat / self._flat_striking  # uses were counted in proportion to rarity
        if self._groups is not None:
            even = (np.bincount(self._groups, uses) / np.maximum(np.bincount(self._groups), 1))[self._groups] + 1
        if most > DRIFT * float(np.min(even)) * LEAST_STRIKING:
            excess = np.maximum(uses / even - DRIFT, 0.0) * (repetition_kernels.ONE / (self.strength * STEADY))
            self._priced += np.minimum(excess, MOST_EXCESS).astype(np.int32)

    def prices(self, row: int, column: int, found: Candidates) -> Array:
        """Return for every candidate its distance plus the price of repeats."""
        out = np.empty(len(found.rows), np.int64)
        steady, unit = round(self.strength * STEADY * found.usual), round(self.strength * found.usual)
        others = self._around(row, column) if unit else np.empty((0, 8), np.int64)
        repetition_kernels.prices(found.rows, others, self.layout.at(row, column), self._laid, steady, unit, out)
        return out

    def _around(self, row: int, column: int) -> Array:
        """Return the placements (n, 8) near a window."""
        if self.layout.places is None and not len(self.started):
            return np.asarray(repetition_kernels.placed_near(self.grid, row, column, self.reach, self._laid.canvas))
        every = np.concatenate([self.grid.reshape(-1, 8), self.started])
        every = every[every[:, 5] >= 0]
        radius = self.reach * max(self.layout.patch)
        return every[self.layout.within(radius, every[:, 3:5], self.layout.at(row, column))]

    def note_start(self, variant: UInt8, yx: Int32) -> None:
        """Record a start map as placements, on a grid of half patches."""
        if not self.strength:  # placements are never read
            return
        h, w = self.layout.patch
        found = []
        for y in range(0, self.layout.size[0], max(h // 2, 1)):
            for x in range(0, self.layout.size[1], max(w // 2, 1)):
                known = np.argwhere(variant[y : y + h, x : x + w] != HOLE)
                if len(known):  # the middle one of the known pixels stands for all
                    i, j = known[len(known) // 2].tolist()
                    u, s = (yx[y + i, x + j] - (i, j)).tolist()
                    place = np.empty(8, np.int64)
                    v = int(variant[y + i, x + j])
                    repetition_kernels.placement(self._laid.frames, self._laid.shape, v, u, s, y, x, place)
                    found.append(place)
        self.started = np.array(found, np.int64).reshape(-1, 8)

    def pick(
        self, row: int, column: int, found: Candidates, tolerance: float, bits: int
    ) -> Pick:
        """Draw among the candidates whose price is within the tolerance of the best.

        The tolerance is relative to the best price, or to a quarter of the usual distance if that is more, so that a
        perfect match is not the only choice. The upper 32 of the 64 `bits` are used.
        """
        prices = self.prices(row, column, found)
        return picked(found, repetition_kernels.pick(prices, tolerance, int(MATCH * found.usual), bits >> 32))

    def pick_all(self, windows: list[Pair], found: list[Candidates], tolerance: float, bits: list[int]) -> list[Pick]:
        """Pick for many windows of a grid, which have candidates, one after the other, recording each use."""
        n, size = len(windows), max(len(f.rows) for f in found)
        rows, picks = np.empty((n, size, 4), np.int64), np.empty((n, 3), np.int64)
        for k, f in enumerate(found):
            rows[k, : len(f.rows)] = f.rows
        counts = np.array([len(f.rows) for f in found], np.int64)
        usual = np.array([f.usual for f in found], np.int64)
        at = np.array([(self.layout.rows[r], self.layout.columns[c]) for r, c in windows], np.int64)
        drawn = np.array([b >> 32 for b in bits], np.int64)
        wave = Wave(np.array(windows, np.int64), at, drawn, rows, counts, usual)
        strength = float(self.strength)
        terms = Terms(float(tolerance), MATCH, strength, strength * STEADY, self.reach)
        repetition_kernels.pick_all(wave, terms, self._laid, self.grid, picks)
        self.laid += n
        return [(v, u, s) for v, u, s in picks.tolist()]

    def add(self, row: int, column: int, pick: Pick) -> None:
        """Record that a patch (variant, row, column) was placed in a window."""
        self.laid += 1
        repetition_kernels.note(self._laid, pick, self.layout.at(row, column), self.grid[row, column])


def patch_saliency(feats: Features, search: Search) -> list[Array]:
    """Return the rarity of the patch at every coarse position of each variant, 256 = median, within its limits."""
    patch, side, out = search.patch, max(1, sum(search.patch) // 2), []
    for valid, (number, *frame) in zip(search.valid, search.variants.frames.tolist(), strict=True):
        grid, step = feats.memo(("rarity", number, side), partial(rarity, feats.pictures[number], side))
        y, x = np.ix_(*(2 * search.factor * np.arange(n) + p - 1 for n, p in zip(valid.shape, patch, strict=True)))
        at = []  # indices in the grid of rarities of the patches that have the same middle
        for first, down, across, p, n in zip(frame[:2], frame[2:6:2], frame[3:6:2], patch, grid.shape, strict=True):
            at.append(np.clip((2 * first + down * y + across * x - p + 1) // (2 * step), 0, n - 1))
        out.append(np.clip(grid[at[0], at[1]], LEAST_STRIKING, MOST_STRIKING).astype(np.int32))
    return out
