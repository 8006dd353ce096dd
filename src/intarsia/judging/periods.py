"""The periods of an exemplar as the judge uses them: which joins keep them, and how well an output repeats by them.

Where an exemplar has a lattice, or rows, a whole brick may lie wherever a brick may: a join between two pieces that lie
a whole number of periods apart is what the exemplar itself does at every period, and costs nothing. What is lost
where the periods are not kept is seen from the picture alone: it differs more from itself, a period on, than the
exemplar does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..lattice.lattice import find_lattice
from ..lattice.vectors import UNIT, Vector

LOOSE = 3  # px: pieces may lie so far off a period at most, where the lattice itself is as irregular
FINE = 3  # times the slack: shorter periods cannot be told from others
FAR = 3, 4  # of a side: periods longer than this leave too little to compare


@dataclass(frozen=True)
class Periods:
    """The vectors (rows, columns) by which an exemplar repeats, one or two, and how loose they are; 1/256 px."""

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


def periods_of(
    pictures: Sequence[NDArray[np.int16]], usable: Sequence[NDArray[np.bool_] | None]
) -> Periods | None:
    """The periods of the exemplars: those of one that is alone; several have none in common."""
    return Periods.of(pictures[0], usable[0]) if len(pictures) == 1 else None


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
