"""What is known of exemplars before an output is judged: their windows, how alike these are, and two anchors.

An anchor is an output of which the worth is known. `tiles` lays small squares of the exemplar side by side without
looking: no method joins pieces worse.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..draws import draw
from ..lattice.candidates import UNIT
from ..lattice.lattice import Vector, find_lattice
from .windows import SIDE, Windows

REDUCTIONS = (2, 4, 8)  # windows of 16, 32 and 64 px
ASKED = 1100  # windows of which the exemplar's own nearest is looked for
FEW = 16  # windows; of fewer nothing is known
REGULAR, GRAINY = 0.15, 0.35  # own distance by that of unrelated windows: below every window returns, above none does
STAGE = 4101  # keeps the draws of tiles apart from others
TILES = 8  # tiles lie side by side in an exemplar's side
ANCHOR = 256  # px: side of the picture of tiles, at least

LOOSE = 3  # px: pieces may lie so far off a period at most, where the lattice itself is as irregular
FINE = 3  # times the slack: shorter periods cannot be told from others
FAR = 3, 4  # of a side: periods longer than this leave too little to compare


@dataclass(frozen=True)
class Periods:
    """The vectors (rows, columns) by which an exemplar repeats, one or two, and how loose they are; 1/256 px.

    Where an exemplar has a lattice, or rows, a whole brick may lie wherever a brick may: a join between two pieces that
    lie a whole number of periods apart is what the exemplar itself does at every period, and costs nothing. What is
    lost where periods are not kept is seen from the picture alone: it differs more from itself, a period on, than the
    exemplar does.
    """

    vectors: tuple[Vector, ...]
    loose: int

    @classmethod
    def of(cls, picture: NDArray[np.int16], usable: NDArray[np.bool_] | None) -> Periods | None:
        """Find the periods of an exemplar (H, W, C); None where it has none."""
        found = find_lattice(picture, usable).accepted
        if found is None:
            return None
        return cls(tuple((int(y), int(x)) for y, x in found.vectors), min(int(UNIT * found.residual), UNIT * LOOSE))

    def kept(self, moved: Array, slack: int) -> NDArray[np.bool_]:
        """Whether moves (..., 2), in px, lead from one place to its like, a whole number of periods on.

        By `slack` px they may miss it, and by what the periods are loose. Nowhere, where periods are too short to tell.
        """
        far = np.asarray(moved, np.int64) * UNIT
        shorter = min(math.isqrt(y * y + x * x) for y, x in self.vectors)
        if shorter < FINE * slack * UNIT:
            return np.zeros(far.shape[:-1], bool)
        within = min(slack * UNIT + self.loose, shorter // FINE)
        y, x = far[..., 0], far[..., 1]
        (a, b), *other = self.vectors
        if not other:
            square = a * a + b * b
            off = y * a + x * b - _nearest(y * a + x * b, square) * square
            return np.asarray(np.abs(off) <= within * math.isqrt(square))
        ((c, d),) = other
        area = a * d - b * c
        first, second = _nearest(y * d - x * c, area), _nearest(x * a - y * b, area)
        off_y, off_x = y - first * a - second * c, x - first * b - second * d
        return np.asarray(np.maximum(np.abs(off_y), np.abs(off_x)) <= within)

    @property
    def shifts(self) -> Iterator[tuple[int, int]]:
        """The periods, and both diagonals of a cell, in whole px, none of them upward."""
        (a, b), *other = self.vectors
        every = [(a, b), *other, *((a + s * c, b + s * d) for c, d in other for s in (1, -1))]
        for y, x in every:
            rows, columns = (y + UNIT // 2) // UNIT, (x + UNIT // 2) // UNIT
            yield (rows, columns) if rows >= 0 else (-rows, -columns)

    def lost(self, picture: Array, exemplar: Array, usable: NDArray[np.bool_] | None) -> float:
        """By how much more an output differs from itself a period on than the exemplar, in percent of unrelated places.

        The mean over the shifts that both have room for; below 0 where it differs less.
        """
        found = []
        for shift in self.shifts:
            both = [_apart(exemplar, usable, shift), _apart(picture, None, shift)]
            known = [one for one in both if one is not None]
            if len(known) == len(both):
                found.append(known[1] - known[0])
        return 100 * sum(found) / len(found) if found else 0.0


@dataclass(frozen=True, eq=False)
class Level:
    """Windows of one size: those of the exemplars, and how far these are from one another, in 1/16.

    ``own``: of some of them, evenly spread, the distances to their nearest elsewhere; ``usual`` is the median of
    these, ``unrelated`` the distance of any two. ``periods``: of the exemplar.
    """

    windows: Windows
    own: Array
    usual: int
    unrelated: int
    periods: Periods | None = None

    @cached_property
    def untoned(self) -> int:
        """How far two windows are by their tones alone that have nothing to do with one another, in 1/16."""
        return self.windows.unrelated(self.windows.tones)

    @property
    def least_side(self) -> int:
        """The shortest side of an output, px, that holds a window."""
        return SIDE * self.windows.factor

    @classmethod
    def of(cls, windows: Windows, periods: Periods | None = None) -> Level | None:
        """Measure how alike the windows are; None where they are too few, or lie too near one another."""
        own = windows.own(ASKED)[1]
        if len(own) < FEW:
            return None
        usual = int(np.sort(own)[len(own) // 2])
        return cls(windows, own, usual, max(windows.unrelated(), usual), periods)


@dataclass(frozen=True, eq=False)
class Reference:
    """Exemplars as the judge sees them: int16 pictures (H, W, C) of the base plane, and which px may be used."""

    pictures: tuple[NDArray[np.int16], ...]
    usable: tuple[NDArray[np.bool_] | None, ...]

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The windows of 16, 32 and 64 px; fewer sizes, or none, of an exemplar that is too small."""
        cut = (Windows.of(list(self.pictures), list(self.usable), factor) for factor in REDUCTIONS)
        return tuple(level for w in cut if w is not None and (level := Level.of(w, self.periods)) is not None)

    @cached_property
    def periods(self) -> Periods | None:
        """By which steps the exemplar repeats; None where it does not, or there are several."""
        return Periods.of(self.pictures[0], self.usable[0]) if len(self.pictures) == 1 else None

    @cached_property
    def grain(self) -> float:
        """How little the exemplar repeats itself: 0 where every window returns, 1 where none is like another."""
        if not self.levels:
            return 0.0
        share = self.levels[0].usual / self.levels[0].unrelated
        return min(1.0, max(0.0, (share - REGULAR) / (GRAINY - REGULAR)))

    @cached_property
    def tiles(self) -> NDArray[np.int16]:
        """Squares of the exemplars, an eighth of the shorter side wide, side by side as they are drawn."""
        both = zip(self.pictures, self.usable, strict=True)
        spots = [(n, p) for n, (p, free) in enumerate(both) if free is None or free.any()]
        side = max(1, min(min(p.shape[:2]) for _, p in spots) // TILES)
        count = -(-ANCHOR // side)
        out = np.empty((count * side, count * side, spots[0][1].shape[2]), np.int16)
        for place in range(count * count):
            number, picture = spots[draw(0, STAGE, place, 0) % len(spots)]
            rows, columns = (n - side + 1 for n in picture.shape[:2])
            usable, most, best = self.usable[number], -1, (0, 0)
            for again in range(8 if usable is not None else 1):
                y, x = draw(0, STAGE, place, 1, again) % rows, draw(0, STAGE, place, 2, again) % columns
                free = side * side if usable is None else int(usable[y : y + side, x : x + side].sum())
                if free > most:
                    most, best = free, (y, x)
            (y, x), (i, j) = best, divmod(place, count)
            out[i * side : (i + 1) * side, j * side : (j + 1) * side] = picture[y : y + side, x : x + side]
        return out


def _nearest(number: Array, by: int) -> Array:
    """Divide whole numbers, rounded to the nearest."""
    sign = 1 if by > 0 else -1
    return np.asarray((2 * sign * number + sign * by) // (2 * sign * by))


def _apart(picture: Array, usable: NDArray[np.bool_] | None, shift: tuple[int, int]) -> float | None:
    """How much a picture differs from itself, moved: 0 not at all, 1 as unrelated places do; None where that is far."""
    (rows, columns), size = shift, picture.shape[:2]
    if any(abs(move) * FAR[1] >= n * FAR[0] for move, n in zip(shift, size, strict=True)):
        return None
    after = np.s_[rows:, max(columns, 0) : size[1] + min(columns, 0)]
    before = np.s_[: size[0] - rows, max(-columns, 0) : size[1] - max(columns, 0)]
    step = picture[after].astype(np.int64) - picture[before]
    there = picture.reshape(-1, picture.shape[2]).astype(np.int64)
    if usable is not None:
        step, there = step[usable[after] & usable[before]], there[usable.ravel()]
    pairs, n = step.size // step.shape[-1], len(there)
    spread = sum(n * int((c * c).sum()) - int(c.sum()) ** 2 for c in there.T)
    return int((step * step).sum()) * n * n / (2 * pairs * spread) if pairs and spread else None
