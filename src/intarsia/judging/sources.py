"""Where the windows of an output come from, and how much changes where two sources meet.

An output that is made of pieces shows each piece beside others. Continue the source of a window by a step: where the
output goes on in the same piece, this is what it shows. Where it does not, the two differ as the exemplar does, a
little where a gap was met, as much as unrelated windows where a stone was cut. Where the exemplar has periods, pieces
that lie whole periods apart meet as they do in it: a brick may stand beside any other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from .reference import Level
from .windows import ALL

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

    def _kept(self, step: tuple[int, int]) -> NDArray[np.bool_]:
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


def continued(level: Level, number: Array, step: tuple[int, int]) -> tuple[Array, Array]:
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
