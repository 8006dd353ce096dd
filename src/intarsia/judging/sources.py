"""Sources of an output's windows in the exemplar, cost of joins between neighbours, and reference measurements.

The source of a window is the exemplar window that it was probably copied from. Moved by the step from a window of the
output to its neighbour it gives the continued source. Within one piece the neighbour equals it. Across a join the
neighbour differs from it: a little if the join runs along a gap, as much as unrelated windows do if it cuts through a
stone. A join costs nothing if the offset of its two pieces is a whole number of periods of the exemplar, as any brick
may follow any other.

Reference measurements of an exemplar: its windows, how similar they are to one another, and a bad output as an anchor:
`Reference.tiles`, small random squares of the exemplar side by side without matching.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..analysis import scaled_variances
from ..analysis.saliency import saliency_map, saliency_weights
from ..foundation.arrays import Array, Int16, Mask, Pair
from ..foundation.geometry import UNIT
from ..foundation.run import draw
from ..lattice import Vector, find_lattice
from .windows import ALL, SIDE, Windows

REDUCTIONS = (2, 4, 8)  # windows of 16, 32 and 64 px
ASKED = 1100  # windows of the exemplar, about, whose nearest one in the exemplar itself is searched
FEW = 16  # windows: a size of which there are fewer is not evaluated
# Distance of windows to the nearest one elsewhere in the exemplar, relative to that of unrelated windows, at which the
# grain is 0 (every window recurs) and 1 (none does).
REGULAR, GRAINY = 0.15, 0.35
STAGE = 4101  # stage of the counter-based random numbers of tiles
TILES = 8  # tiles along the exemplar's shorter side
ANCHOR = 256  # px: least side of the picture of tiles

LOOSE = 3  # px: largest tolerance of periods, for lattices whose own residual is as large
FINE = 3  # periods shorter than so many times the tolerance are not used, as any offset would be near a multiple
FAR = 3, 4  # numerator and denominator: periods of 3/4 of a side or more leave too little to compare


@dataclass(frozen=True)
class Periods:
    """The one or two lattice vectors (rows, columns) of an exemplar, and their tolerance ``loose``; in 1/256 px.

    A join of two pieces whose offset is a whole number of periods costs nothing, as the exemplar itself continues so.
    Whether an output keeps the periods is measured on its pixels alone: if not, it differs more from itself, shifted by
    a period, than the exemplar does.
    """

    vectors: tuple[Vector, ...]
    loose: int

    @classmethod
    def of(cls, picture: Int16, usable: Mask | None) -> Periods | None:
        """Return the periods of an exemplar (H, W, C); None if it has none."""
        found = find_lattice(picture, usable).accepted
        if found is None:
            return None
        return cls(tuple((int(y), int(x)) for y, x in found.vectors), min(int(UNIT * found.residual), UNIT * LOOSE))

    def kept(self, moved: Array, slack: int) -> Mask:
        """Whether offsets (..., 2), in px, are a whole number of periods.

        Within `slack` px plus the tolerance of the periods. False everywhere if periods are too short for that.
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
        """The periods and both diagonals of a cell, rounded to px, none of them upward."""
        (a, b), *other = self.vectors
        every = [(a, b), *other, *((a + s * c, b + s * d) for c, d in other for s in (1, -1))]
        for y, x in every:
            rows, columns = (y + UNIT // 2) // UNIT, (x + UNIT // 2) // UNIT
            yield (rows, columns) if rows >= 0 else (-rows, -columns)

    def lost(self, picture: Array, exemplar: Array, usable: Mask | None) -> float:
        """Return by how much more an output differs from itself, shifted by a period, than the exemplar does.

        In percent of the difference of unrelated places; the mean over the shifts that fit into both; negative if it
        differs less.
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
    """The windows of the exemplars at one size, and distances among them, in 1/16.

    ``own``: distances of a regular sample of windows to the nearest one elsewhere; ``usual``: their median;
    ``unrelated``: median distance of arbitrary pairs, at least ``usual``; ``periods``: those of the exemplar.
    """

    windows: Windows
    own: Array
    usual: int
    unrelated: int
    periods: Periods | None = None

    @cached_property
    def untoned(self) -> int:
        """Median distance of unrelated windows by their mean tones alone, in 1/16."""
        return self.windows.unrelated(self.windows.tones)

    @property
    def least_side(self) -> int:
        """The least side of an output, px, that holds a window."""
        return SIDE * self.windows.factor

    @classmethod
    def of(cls, windows: Windows, periods: Periods | None = None) -> Level | None:
        """Measure the distances among the windows; None if fewer than FEW have another one that is far enough away."""
        own = windows.own(ASKED)[1]
        if len(own) < FEW:
            return None
        usual = int(np.sort(own)[len(own) // 2])
        return cls(windows, own, usual, max(windows.unrelated(), usual), periods)


@dataclass(frozen=True, eq=False)
class Reference:
    """Exemplars as they are compared: int16 features (H, W, C) of the base plane, and masks of usable px."""

    pictures: tuple[Int16, ...]
    usable: tuple[Mask | None, ...]

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The windows of 16, 32 and 64 px; fewer sizes, or none, if an exemplar is too small."""
        cut = (Windows.of(list(self.pictures), list(self.usable), factor) for factor in REDUCTIONS)
        return tuple(level for w in cut if w is not None and (level := Level.of(w, self.periods)) is not None)

    @cached_property
    def periods(self) -> Periods | None:
        """The periods of the exemplar; None if it has none, or there are several exemplars."""
        return Periods.of(self.pictures[0], self.usable[0]) if len(self.pictures) == 1 else None

    @cached_property
    def grain(self) -> float:
        """How rarely windows of the exemplar recur in it: 0 if all recur, 1 if none resembles another."""
        if not self.levels:
            return 0.0
        share = self.levels[0].usual / self.levels[0].unrelated
        return min(1.0, max(0.0, (share - REGULAR) / (GRAINY - REGULAR)))

    @cached_property
    def salient(self) -> tuple[Array, ...]:
        """The saliency of every pixel of the exemplars; 0 where it is not salient."""
        strikes = [saliency_map(p, free) for p, free in zip(self.pictures, self.usable, strict=True)]
        flat = np.split(saliency_weights(strikes, 0.0), np.cumsum([s.size for s in strikes])[:-1])
        return tuple(part.reshape(s.shape) for part, s in zip(flat, strikes, strict=True))

    @cached_property
    def tiles(self) -> Int16:
        """A picture of random squares of the exemplars, an eighth of the shorter side wide, without matching."""
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
    """Return integers divided by an integer, rounded to the nearest."""
    sign = 1 if by > 0 else -1
    return np.asarray((2 * sign * number + sign * by) // (2 * sign * by))


def _apart(picture: Array, usable: Mask | None, shift: Pair) -> float | None:
    """Return the difference of a picture to itself, shifted, relative to unrelated places; None if shifted too far."""
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
    spread = sum(scaled_variances(there))
    return int((step * step).sum()) * n * n / (2 * pairs * spread) if pairs and spread else None


STEP = 8  # px between neighbouring windows of the output
ROUNDS = 3  # rounds of propagation of sources to neighbours
NEAR = 115, 100  # percent: a neighbour's continued source is taken if its distance is at most 1.15 times the least one
SLACK = 20  # plus 1/SLACK of the median distance of exemplar windows to their nearest ones
NEXT = ((0, 1), (1, 0), (0, -1), (-1, 0))  # steps (rows, columns) to the four neighbours


@dataclass(frozen=True, eq=False)
class Sources:
    """The windows of an output of one size, on a grid of STEP px, and their source windows in the exemplar.

    ``waves`` (rows, columns, features): their DCT coefficients; ``distance`` (rows, columns): to the nearest exemplar
    window, in 1/16; ``number`` (rows, columns): that of the source window, chosen among those nearly as near so that
    neighbours are coherent.
    """

    level: Level
    waves: Array
    distance: Array
    number: Array

    @classmethod
    def of(cls, level: Level, picture: Array) -> Sources:
        """Find the sources of the windows of an output picture (H, W, C)."""
        waves = level.windows.cut(picture, STEP)
        distance, number = level.windows.nearest(waves.reshape(-1, waves.shape[2]))
        distance, number = (a.reshape(waves.shape[:2]) for a in (distance, number))
        return cls(level, waves, distance, _agreed(level, waves, distance, number))

    @property
    def flat(self) -> Array:
        """The windows as (n, features)."""
        return self.waves.reshape(-1, self.waves.shape[2])

    @property
    def join_costs(self) -> Array:
        """The cost of joins (2, rows, columns) with the left and the upper neighbour: 0 to 1024, as unrelated windows.

        0 if the offset of the sources is a whole number of periods of the exemplar.
        """
        return self._changes(ALL, self.level.unrelated, 1)

    @property
    def steps(self) -> Array:
        """Steps of tone: as `join_costs`, but for the mean colour of windows alone, and clipped at 2048."""
        return self._changes(self.level.windows.tones, self.level.untoned, 2)

    def _changes(self, features: slice, unrelated: int, most: int) -> Array:
        windows, out = self.level.windows, []
        here = windows.apart(self.waves, self.number, features)
        for step in NEXT[:2]:
            ahead, inside = continued_sources(self.level, self.number, step)
            inside &= ~self._kept(step)
            there = windows.apart(self.waves, np.maximum(ahead, 0), features)
            change = np.clip((np.where(ahead >= 0, there, unrelated + here) - here) * 1024 // unrelated, 0, 1024 * most)
            out.append(np.where(inside, change, 0))
        return np.stack(out)

    def _kept(self, step: Pair) -> Mask:
        """Whether a window's source and its predecessor's continued source differ by a whole number of periods."""
        windows, periods = self.level.windows, self.level.periods
        if periods is None:
            return np.zeros(self.number.shape, bool)
        at = windows.at[self.number]
        far = STEP // windows.factor // windows.stride
        moved = at - np.roll(at, step, (0, 1)) - np.array(step) * far
        return periods.kept(moved * (windows.stride * windows.factor), 1 + windows.factor)

    @property
    def usage(self) -> Array:
        """How often each entry of the exemplar's table of windows is used."""
        table = self.level.windows.table
        at = self.level.windows.at[self.number.ravel()]
        return np.bincount(at[:, 0] * table.shape[1] + at[:, 1], minlength=table.size).reshape(table.shape)


def continued_sources(level: Level, number: Array, step: Pair) -> tuple[Array, Array]:
    """Return the continued source of the window `step` before each, and a mask of the windows that have such a one.

    -1 where the continued source lies outside of the exemplar.
    """
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
    """Return sources made coherent: a neighbour's continued source is taken if nearly as near (Ashikhmin 2001)."""
    number = number.copy()
    limit = distance * NEAR[0] // NEAR[1] + level.usual // SLACK
    for _ in range(ROUNDS):
        for step in NEXT:
            ahead, _inside = continued_sources(level, number, step)
            there = level.windows.apart(waves, np.maximum(ahead, 0))
            take = (ahead >= 0) & (there <= limit)
            number[take] = ahead[take]
    return number
