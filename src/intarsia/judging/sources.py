"""What is known of exemplars before an output is judged; where its windows come from, and what changes where two meet.

An output that is made of pieces shows each piece beside others. Continue the source of a window by a step: where the
output goes on in the same piece, this is what it shows. Where it does not, the two differ as the exemplar does, a
little where a gap was met, as much as unrelated windows where a stone was cut. Where the exemplar has periods, pieces
that lie whole periods apart meet as they do in it: a brick may stand beside any other.

Of exemplars their windows are known, how alike these are, and an output of which the worth is known: `tiles` lays small
squares of the exemplar side by side without looking, and no method joins pieces worse.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..analysis import spreads
from ..analysis.popout import popout, saliency
from ..foundation.arrays import Array, Int16, Mask, Pair
from ..foundation.geometry import UNIT
from ..foundation.run import draw
from ..lattice import Vector, find_lattice
from .windows import ALL, SIDE, Windows

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
    def of(cls, picture: Int16, usable: Mask | None) -> Periods | None:
        """Find the periods of an exemplar (H, W, C); None where it has none."""
        found = find_lattice(picture, usable).accepted
        if found is None:
            return None
        return cls(tuple((int(y), int(x)) for y, x in found.vectors), min(int(UNIT * found.residual), UNIT * LOOSE))

    def kept(self, moved: Array, slack: int) -> Mask:
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
    def shifts(self) -> Iterator[Pair]:
        """The periods, and both diagonals of a cell, in whole px, none of them upward."""
        (a, b), *other = self.vectors
        every = [(a, b), *other, *((a + s * c, b + s * d) for c, d in other for s in (1, -1))]
        for y, x in every:
            rows, columns = (y + UNIT // 2) // UNIT, (x + UNIT // 2) // UNIT
            yield (rows, columns) if rows >= 0 else (-rows, -columns)

    def lost(self, picture: Array, exemplar: Array, usable: Mask | None) -> float:
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

    pictures: tuple[Int16, ...]
    usable: tuple[Mask | None, ...]

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
    def salient(self) -> tuple[Array, ...]:
        """How salient every pixel of the exemplars is; 0 where it does not strike."""
        strikes = [popout(p, free) for p, free in zip(self.pictures, self.usable, strict=True)]
        flat = np.split(saliency(strikes, 0.0), np.cumsum([s.size for s in strikes])[:-1])
        return tuple(part.reshape(s.shape) for part, s in zip(flat, strikes, strict=True))

    @cached_property
    def tiles(self) -> Int16:
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


def _apart(picture: Array, usable: Mask | None, shift: Pair) -> float | None:
    """How much a picture differs from itself, moved: 0 not at all, 1 as unrelated places do; None where that is far."""
    (rows, columns), size = shift, picture.shape[:2]
    if any(abs(move) * FAR[1] >= n * FAR[0] for move, n in zip(shift, size, strict=True)):
        return None
    after = np.s_[rows:, max(columns, 0) : size[1] + min(columns, 0)]
    before = np.s_[: size[0] - rows, max(-columns, 0) : size[1] - max(columns, 0)]
    step = picture[after].astype(np.int64) - picture[before]
    there = picture.reshape(-1, picture.shape[2])
    if usable is not None:
        step, there = step[usable[after] & usable[before]], there[usable.ravel()]
    pairs, n = step.size // step.shape[-1], len(there)
    spread = sum(spreads(there))
    return int((step * step).sum()) * n * n / (2 * pairs * spread) if pairs and spread else None


STEP = 8  # px between neighbouring windows of the output
ROUNDS = 3  # of looking at what neighbours show
NEAR = 115, 100  # a neighbour's source is taken where it is nearly as near,
SLACK = 20  # or nearer by a 20th of what is usual
NEXT = ((0, 1), (1, 0), (0, -1), (-1, 0))


@dataclass(frozen=True, eq=False)
class Sources:
    """The windows of an output of one size, on a grid of STEP px, and which windows of the exemplar they show.

    ``waves`` (rows, columns, features); ``distance`` to the nearest window, in 1/16; ``number``: of the window that
    each shows, chosen among those nearly as near so that neighbours agree.
    """

    level: Level
    waves: Array
    distance: Array
    number: Array

    @classmethod
    def of(cls, level: Level, picture: Array) -> Sources:
        """Look for the sources of an output picture (H, W, C)."""
        waves = level.windows.cut(picture, STEP)
        distance, number = level.windows.nearest(waves.reshape(-1, waves.shape[2]))
        distance, number = (a.reshape(waves.shape[:2]) for a in (distance, number))
        return cls(level, waves, distance, _agreed(level, waves, distance, number))

    @property
    def flat(self) -> Array:
        """The windows one after the other, (n, features)."""
        return self.waves.reshape(-1, self.waves.shape[2])

    @property
    def changes(self) -> Array:
        """How much changes from each window to the next, right and below: 0 nothing, 1024 as much as any two differ.

        Nothing where the two lie whole periods of the exemplar apart.
        """
        return self._changes(ALL, self.level.unrelated, 1)

    @property
    def steps(self) -> Array:
        """The same of the mean tone of windows alone, up to twice as much as any two differ."""
        return self._changes(self.level.windows.tones, self.level.untoned, 2)

    def _changes(self, features: slice, unrelated: int, most: int) -> Array:
        windows, out = self.level.windows, []
        here = windows.apart(self.waves, self.number, features)
        for step in NEXT[:2]:
            ahead, inside = continued(self.level, self.number, step)
            inside &= ~self._kept(step)
            there = windows.apart(self.waves, np.maximum(ahead, 0), features)
            change = np.clip((np.where(ahead >= 0, there, unrelated + here) - here) * 1024 // unrelated, 0, 1024 * most)
            out.append(np.where(inside, change, 0))
        return np.stack(out)

    def _kept(self, step: Pair) -> Mask:
        """Where a window shows what lies whole periods of the exemplar away from what the one before leads to."""
        windows, periods = self.level.windows, self.level.periods
        if periods is None:
            return np.zeros(self.number.shape, bool)
        at = windows.at[self.number]
        far = STEP // windows.factor // windows.stride
        moved = at - np.roll(at, step, (0, 1)) - np.array(step) * far
        return periods.kept(moved * (windows.stride * windows.factor), 1 + windows.factor)

    @property
    def usage(self) -> Array:
        """How often each place of the exemplar's table of windows is shown."""
        table = self.level.windows.table
        at = self.level.windows.at[self.number.ravel()]
        return np.bincount(at[:, 0] * table.shape[1] + at[:, 1], minlength=table.size).reshape(table.shape)


def continued(level: Level, number: Array, step: Pair) -> tuple[Array, Array]:
    """What every window would show if the one before it, by `step`, went on; -1 off the exemplar. And where one is."""
    windows = level.windows
    rows, columns = number.shape
    inside = np.zeros(number.shape, bool)
    (dy, dx), moved = step, np.roll(number, step, (0, 1))
    inside[max(dy, 0) : rows + min(dy, 0), max(dx, 0) : columns + min(dx, 0)] = True
    far = STEP // windows.factor // windows.stride
    at = windows.at[moved] + np.array(step) * far
    high, wide = windows.table.shape
    held = inside & ((at >= 0) & (at < (high, wide))).all(axis=2)
    at = np.where(held[..., None], at, 0)
    return np.where(held, windows.table[at[..., 0], at[..., 1]], -1), inside


def _agreed(level: Level, waves: Array, distance: Array, number: Array) -> Array:
    """Let every window show what its neighbours' sources continue with, where that is nearly as near."""
    number = number.copy()
    limit = distance * NEAR[0] // NEAR[1] + level.usual // SLACK
    for _ in range(ROUNDS):
        for step in NEXT:
            ahead, _inside = continued(level, number, step)
            there = level.windows.apart(waves, np.maximum(ahead, 0))
            take = (ahead >= 0) & (there <= limit)
            number[take] = ahead[take]
    return number
