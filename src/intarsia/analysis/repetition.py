"""Repetition control, written once for all methods that lay patches.

Every patch laid makes its part of the exemplar a little dearer (so that the whole exemplar is used and no flat
spot feeds itself), dearer still close to where it was laid (D0-2), and more so the more striking it is (D0-4).
The price is in units of the usual distance, so a perfect repeat has a price, too (D0-3).
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import ISOMETRIES
from ..kernels import usage
from ..sourcemap import HOLE
from .features import Features
from .rarity import rarity
from .search import Candidates, Prices, Search, every_patch, measured
from .variants import Variants

REACH = 4  # blocks around a window in which nearness counts
LEAST_STRIKING, MOST_STRIKING = 128, 1024  # of 256: even the plainest patch has a price
MATCH = 0.25  # a perfect match counts as this share of the usual distance when the tolerance is applied
DRIFT = 3.0  # used so many times more than its share, a part of the exemplar becomes dear
MOST_EXCESS = 1 << 24
STEADY = 0.3  # the price of a full repeat however far away; nearby it rises to 1.3

Array = NDArray[Any]


@dataclass(frozen=True)
class Layout:
    """The windows of a canvas: first rows, first columns, their size, and the canvas they lie on.

    Windows are a grid, named by row and column of it; or they lie freely at `places`, named by (number, 0).
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    patch: tuple[int, int]
    height: int
    width: int
    wrap_y: bool
    wrap_x: bool
    places: tuple[tuple[int, int], ...] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of windows."""
        return (len(self.rows), len(self.columns)) if self.places is None else (len(self.places), 1)

    def at(self, row: int, column: int) -> tuple[int, int]:
        """First pixel of a window on the canvas."""
        return (self.rows[row], self.columns[column]) if self.places is None else self.places[row]

    @property
    def wraps(self) -> tuple[bool, bool]:
        """Whether rows and columns continue in themselves."""
        return self.wrap_y, self.wrap_x


class Rule(StrEnum):
    """What a repeat costs."""

    PRICES = "prices"  # a little for every use, more close by, more for striking patches
    COUNTER = "counter"  # distance times (1 + uses of any patch that touches it): source 000, 3.4
    MARKS = "marks"  # distance times (1 + mean uses of its pixels): the alternative of source 000


class Repetition:
    """What was laid so far, and what that costs each candidate.

    Parameters
    ----------
    search : Search
        Whose variants and coarse positions are meant.
    layout : Layout
        The windows.
    strength : float
        Price of a full repeat, relative to the usual distance; 0 switches the prices off.
    distance : int
        No exemplar pixel may return within this many output px; 0: no such rule.
    striking : list of int32 arrays, optional
        For every variant, how striking each coarse position is; 256 = usual.
    rule : Rule
        What a repeat costs; `strength` and `striking` belong to PRICES alone.
    """

    def __init__(
        self, search: Search, layout: Layout, strength: float, distance: int,
        striking: list[Array] | None = None, rule: Rule = Rule.PRICES,
    ) -> None:  # fmt: skip
        self.search, self.layout, self.distance, self.strength, self.rule = search, layout, distance, strength, rule
        shapes = [v.shape for v in search.valid]
        self.striking = striking or [np.full(s, 256, np.int32) for s in shapes]
        self._flat = np.zeros(sum(a * b for a, b in shapes), np.int32)
        self._flat_striking = np.concatenate([s.ravel() for s in self.striking])
        begins = np.cumsum([0] + [a * b for a, b in shapes])
        self._offsets = np.array([(o, *s) for o, s in zip(begins, shapes, strict=False)], np.int64)
        # The uses, and what drift adds to them; the source's rules count at once.
        self._priced = self._flat.copy() if rule is Rule.PRICES else self._flat
        self.laid = 0
        self._groups: Array | None = None
        counts = [self._priced[o : o + a * b].reshape(a, b) for o, a, b in self._offsets.tolist()]
        self.told = Prices(counts, round(strength * STEADY * 65536), rule is not Rule.PRICES)
        self._frames = np.array([_frame(search.variants, v) for v in range(len(shapes))], np.int64)
        self._shape = np.array(layout.patch, np.int64)
        self._canvas = np.array((layout.height, layout.width, layout.wrap_y, layout.wrap_x), np.int64)
        self.grid = np.full((*layout.shape, 8), -1, np.int64)
        self.started = np.empty((0, 8), np.int64)  # what a start map shows, as placements
        pitch = min(_least_step(layout.rows, layout.height), _least_step(layout.columns, layout.width))
        self.reach = REACH if strength and rule is Rule.PRICES else 0
        if distance:
            self.reach = max(self.reach, -(-(distance + 2 * max(layout.patch)) // max(pitch, 1)))
        # Windows that lie freely have no neighbours by number: they are looked up by their place.
        self._places = None if layout.places is None else np.array(layout.places, np.int64).reshape(-1, 2)
        self._radius = max(REACH * max(layout.patch) if self.reach else 0, distance + 2 * max(layout.patch))

    def apart(self, groups: Array) -> None:
        """Judge uses within each group of coarse positions alone: parts of other labels do not compete (S0-82)."""
        self._groups = groups

    def account(self) -> None:
        """Take the uses so far into the prices; to be called between waves.

        What was used far more often than the exemplar's share of it becomes dear quickly: a flat or dark spot,
        once chosen, fits itself perfectly, and would fill the output.
        """
        if self.rule is not Rule.PRICES:
            return
        np.copyto(self._priced, self._flat)
        if not self.strength or not self.laid:
            return
        most = int(self._flat.max(initial=0))
        if self._groups is None and most <= DRIFT * self._mean_use() * LEAST_STRIKING:
            return
        uses = self._flat / self._flat_striking  # what strikes was counted more
        even = self._even(uses)
        if most > DRIFT * float(np.min(even)) * LEAST_STRIKING:
            excess = np.maximum(uses / even - DRIFT, 0.0) * (usage.ONE / (self.strength * STEADY))
            self._priced += np.minimum(excess, MOST_EXCESS).astype(np.int32)

    def _mean_use(self) -> float:
        """Uses of each part of the exemplar if all were used alike."""
        return self.laid * math.prod(self.search.cells) / max(self._flat.size, 1) + 1

    def _even(self, uses: Array) -> Any:
        """Uses of each part if all were used alike: of the exemplar, or of each group."""
        if self._groups is None:
            return self._mean_use()
        mean = np.bincount(self._groups, uses) / np.maximum(np.bincount(self._groups), 1)
        return mean[self._groups] + 1

    def prices(self, row: int, column: int, found: Candidates) -> Array:
        """Return for every candidate its distance with the price of repeating; -1 where it is forbidden."""
        out = np.empty(len(found.rows), np.int64)
        at = self.layout.at(row, column)
        steady, unit = round(self.strength * STEADY * found.usual), round(self.strength * found.usual)
        grid, reach = self.grid, self.reach
        if self._places is not None or len(self.started):
            laid = self.grid[self.grid[:, :, 0] >= 0] if self._places is None else self.grid[:, 0]
            places = laid[:, 3:5] if self._places is None else self._places
            near = laid[_within(self._radius, places, at, self.layout)]
            start = self.started[_within(self._radius, self.started[:, 3:5], at, self.layout)]
            grid = np.concatenate([near, start])[:, None]
            row = column = 0
            reach = len(grid) if reach else 0
        usage.prices(
            found.rows, grid, row, column, at, reach, self._shape, self._canvas, self._frames, self._priced,
            self._flat_striking, self._offsets, self.search.factor, self.told.multiply, steady, unit,
            self.distance, out,
        )  # fmt: skip
        return out

    def note_start(self, variant: NDArray[np.uint8], yx: NDArray[np.int32]) -> None:
        """Note what a start map shows, on a grid of half patches, as if patches had been laid there."""
        h, w = self.layout.patch
        found = []
        for y in range(0, self.layout.height, max(h // 2, 1)):
            for x in range(0, self.layout.width, max(w // 2, 1)):
                known = np.argwhere(variant[y : y + h, x : x + w] != HOLE)
                if len(known):  # the middle one of the known pixels stands for all
                    i, j = known[len(known) // 2].tolist()
                    u, s = (yx[y + i, x + j] - (i, j)).tolist()
                    place = np.empty(8, np.int64)
                    usage.placement(self._frames, self._shape, int(variant[y + i, x + j]), u, s, y, x, place)
                    found.append(place)
        self.started = np.array(found, np.int64).reshape(-1, 8)

    def pick(
        self, row: int, column: int, found: Candidates, tolerance: float, bits: int
    ) -> tuple[int, int, int] | None:
        """Draw among the candidates whose price is within the tolerance of the best; None if all are forbidden.

        The tolerance is relative to the best price, or to a quarter of the usual distance if that is more, so
        that an exact continuation is not the only choice (D2-4).
        """
        prices = self.prices(row, column, found)
        k = usage.pick(prices, tolerance, int(MATCH * found.usual), bits >> 32)
        if k < 0:
            return None
        _, v, u, s = found.rows[k].tolist()
        return v, u, s

    def allowed(self, row: int, column: int, found: Candidates, valid: Sequence[Array]) -> Candidates:
        """Return the best of all `valid` patches that would not return too near, where the short-list holds none."""
        every = every_patch(valid)
        permitted = every[self.prices(row, column, replace(found, rows=every, usual=0)) >= 0]
        return replace(found, rows=permitted) if found.free else measured(self.search.variants, found, permitted)

    def pick_all(
        self, windows: list[tuple[int, int]], found: list[Candidates], tolerance: float, bits: list[int]
    ) -> Iterator[tuple[int, list[tuple[int, int, int]]]]:
        """Pick for many windows in turn, noting each, with the rule PRICES.

        Yields the number of every window for which there is no choice among its candidates, with the picks so
        far; the caller notes a patch for it before going on. Last, yields the number of windows.
        """
        n, size = len(windows), max(len(f.rows) for f in found)
        rows, picks = np.empty((n, max(size, 1), 4), np.int64), np.empty((n, 3), np.int64)
        for k, f in enumerate(found):
            rows[k, : len(f.rows)] = f.rows
        counts = np.array([len(f.rows) for f in found], np.int64)
        usual = np.array([f.usual for f in found], np.int64)
        at = np.array([(self.layout.rows[r], self.layout.columns[c]) for r, c in windows], np.int64)
        stop = before = -1
        while stop < n:
            stop = usage.pick_all(
                rows, counts, usual, np.array(windows, np.int64), at, np.array([b >> 32 for b in bits], np.int64),
                tolerance, MATCH, self.strength, self.strength * STEADY, self.grid, self.reach, self._shape,
                self._canvas, self._frames, self._priced, self._flat, self._flat_striking, self._offsets,
                self.search.factor, self.distance, stop + 1, picks,
            )  # fmt: skip
            self.laid += stop - (before + 1)
            before = stop
            yield stop, [(v, u, s) for v, u, s in picks.tolist()]

    def add(self, row: int, column: int, pick: tuple[int, int, int]) -> None:
        """Note that a patch (variant, row, column) was laid at a window."""
        self.laid += 1
        usage.note(
            self._frames, self._shape, pick, self.layout.at(row, column), self.grid[row, column],
            self._offsets, self.search.factor, self._flat, self._flat_striking,
            self.rule is Rule.COUNTER,
        )  # fmt: skip


def _within(radius: int, places: Array, at: tuple[int, int], layout: Layout) -> Array:
    """Which of the places (n, 2) lie within a radius of one, along each axis."""
    gaps = np.abs(places - at)
    for axis, (length, wrap) in enumerate(zip((layout.height, layout.width), layout.wraps, strict=True)):
        if wrap:
            gaps[:, axis] = np.minimum(gaps[:, axis], length - gaps[:, axis])
    return np.asarray((gaps <= radius).all(axis=1))


def _frame(variants: Variants, v: int) -> tuple[int, ...]:
    """Exemplar, the exemplar pixel shown first, J, and the size if toroidal: how a variant lies in its exemplar."""
    iso = ISOMETRIES[variants.pose[v]]
    _, height, width, _ = variants.table[v].tolist()
    start = iso.start(width, height) if iso.swaps else iso.start(height, width)
    torus = (height, width) if variants.toroidal[v] else (0, 0)
    return int(variants.exemplar[v]), *start, *iso.j[0], *iso.j[1], *torus


def striking(feats: Features, search: Search) -> list[Array]:
    """Return for every variant how striking each coarse position is (256 = usual), as prices weigh it."""
    variants, patch = search.variants, search.patch
    out = []
    side = max(1, sum(patch) // 2)
    known = [
        feats.memo(("rarity", number, side), functools.partial(rarity, picture, side))
        for number, picture in enumerate(feats.pictures)
    ]
    for v, valid in enumerate(search.valid):
        number = int(variants.exemplar[v])
        grid, step = known[number]
        y, x = (np.arange(n) * search.factor for n in valid.shape)
        _, first, second, a, b, c, d = _frame(variants, v)[:7]
        cy = 2 * first + (a * (2 * y + patch[0] - 1))[:, None] + (b * (2 * x + patch[1] - 1))[None, :]
        cx = 2 * second + (c * (2 * y + patch[0] - 1))[:, None] + (d * (2 * x + patch[1] - 1))[None, :]
        at = [np.clip((m - p + 1) // (2 * step), 0, n - 1) for m, p, n in zip((cy, cx), patch, grid.shape, strict=True)]
        out.append(np.clip(grid[at[0], at[1]], LEAST_STRIKING, MOST_STRIKING).astype(np.int32))
    return out


def _least_step(starts: tuple[int, ...], length: int) -> int:
    return min((b - a for a, b in itertools.pairwise(starts)), default=length)
