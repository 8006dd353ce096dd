"""Which stone lies where in courses of unequal heights: each in a course as high as it is, and no pair twice nearby."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .chains import Chains
from .rows import Piece
from .stack import StackedRows
from .unequal import UNEQUAL, Masonry
from .wall_kernels import FACE


class Laying(NamedTuple):
    """Which stones lie in a course, and what pairs that return cost."""

    near: float = 0.12  # of a course's height a stone may be higher or lower. At 0.18 stones touch across beds
    fewest: int = 7  # stones to choose from, or others that are like them, too; at 5 twice as many pairs return in rows
    twice: int = 600  # what a pair costs that is shown nearby already; at 300 125 return in rows, not 106
    give: int = 4  # joints are so many times as wide as they may become wider or narrower, 1 px or more, and at most
    wider: int = 2  # px: a stone that is too long by more is a cut one
    cut: int = 1500  # what a stone costs that is cut to fit; of 2000 stones none is, with 250 some are
    rounds: int = 6  # times at most that a chain is laid while pairs return in it; 4 and 8: a few pairs more or less


LAYING = Laying()


class Stones(Chains):
    """Chains of whole stones along courses of unequal heights."""

    def __init__(self, found: Masonry, rows: StackedRows, seed: int) -> None:
        super().__init__(found.work, found.bricks, rows, seed)
        self.stacked = rows
        self.give, self.cut = min(max(found.work.thickness // LAYING.give, 1), LAYING.wider), LAYING.cut
        self.cards = [self._alike(found, height) for height in found.heights]

    @staticmethod
    def _alike(found: Masonry, height: int) -> list[int]:
        """The stones about as high as a course, those that fit best if they are few."""
        off = np.abs(found.own - height)
        beyond = np.maximum(off - int(LAYING.near * height), 0)  # px too high or too low
        order = np.argsort(beyond, kind="stable")
        near = int((off <= UNEQUAL.like * height).sum())
        whole = int(np.flatnonzero(found.bricks.table[order, 3] != FACE)[0]) + 1
        count = max(int((beyond == 0).sum()), min(LAYING.fewest, near), whole)
        return sorted(order[:count].tolist())

    def _cards(self, i: int) -> Sequence[int]:
        return self.cards[self.stacked.kind(i)]

    def _chained(self, i: int, s: int) -> list[Piece]:
        """The chain in which the fewest pairs return."""
        near = Counter[tuple[int, int]]()
        for _, chain in self._around(i, s):
            near.update(neighbours(chain))
        if s % 2:  # every other chain of a course knows those beside it
            for beside in (s - 1, s + 1):
                if self.named(i, beside)[1] % 2 == 0:
                    near.update(neighbours(self.chain(i, beside)))
        more = {pair: LAYING.twice * n for pair, n in near.items()}
        best, least = list[Piece](), -1
        for _ in range(LAYING.rounds):
            chain = self._linked(i, s, more)
            own = Counter(neighbours(chain))
            again = sum(n - 1 for n in own.values()) + sum(n for pair, n in own.items() if pair in near)
            if least < 0 or again < least:
                best, least = chain, again
            if not any(n > 1 for n in own.values()):
                break
            for pair, n in own.items():
                more[pair] = more.get(pair, 0) + LAYING.twice * (n - 1)
        return best


def neighbours(chain: list[Piece]) -> list[tuple[int, int]]:
    """Return the pairs of stones of which the second lies right of the first."""
    return [(a.brick, b.brick) for a, b in pairwise(chain)]
