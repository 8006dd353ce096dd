"""What is known of exemplars before an output is judged: their windows, how alike these are, and two anchors.

An anchor is an output of which the worth is known. `tiles` lays small squares of the exemplar side by side without
looking: no method joins pieces worse.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..draws import draw
from .periods import Periods, periods_of
from .windows import SIDE, Windows

REDUCTIONS = (2, 4, 8)  # windows of 16, 32 and 64 px
ASKED = 1100  # windows of which the exemplar's own nearest is looked for
FEW = 16  # windows; of fewer nothing is known
REGULAR, GRAINY = 0.15, 0.35  # own distance by that of unrelated windows: below every window returns, above none does
STAGE = 4101  # keeps the draws of tiles apart from others
TILES = 8  # tiles lie side by side in an exemplar's side
ANCHOR = 256  # px: side of the picture of tiles, at least


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
        return periods_of(self.pictures, self.usable)

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
