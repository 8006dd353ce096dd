"""How well every place fits into a gap of a mosaic, where places are few; and prices that make gaps use them evenly.

Random blocks show every place equally often, but gaps take what fits best, and some places fit nearly everywhere. As
in an auction (Bertsekas 1988) a place's price rises while more gaps than its share want it, and falls while fewer do:
in the end gaps take every place about as often as it is to be shown, each where it fits best. The gaps of the auction
are imagined, around neighbours that are drawn, so prices are a matter of the exemplar alone: no window or seed changes
them. They are many: prices that even out few gaps even out just these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..draws import draw_many
from . import gap_table_kernels

IMAGINED = 2012  # keeps the draws of imagined gaps apart: on level 0, where courses, of the same number, draw nothing
GAPS = 96  # imagined gaps for each place
LEAST_GAPS = 1024
MOST_PLACES = 40  # of more, each is seldom shown anyway
SAMPLES = 120  # px of a gap's seam zone that are compared
ROUNDS = 40
EVEN = 5  # percent from its share at which a place keeps its price
BAR = 1 << 40  # above any mismatch
Shifts = NDArray[np.int64]
Shares = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class GapTable:
    """What pairs of places cost side by side."""

    # For each neighbour (above, below, left, right) squared differences (k, n, moves) of its places and the gap's.
    sums: tuple[NDArray[np.float64], ...]
    px: tuple[NDArray[np.float64], ...]  # and of how many px; whole numbers
    # (k, n) each: 1 where a place of the gap repeats the neighbour's, 2 where it only continues it.
    barred: tuple[NDArray[np.uint8], ...]
    sampled: int  # px that were compared
    slack: int  # how far a place is moved, px
    prices: NDArray[np.int64]  # (n,): what a place costs beside its mismatch

    @classmethod
    def of(
        cls, picture: NDArray[np.int16], usable: NDArray[np.bool_], core: NDArray[np.uint8], sides: NDArray[np.int8],
        own: tuple[Shifts, Shares], neighbours: Sequence[tuple[Shifts, Shifts, Shares]], slack: int,
    ) -> GapTable | None:  # fmt: skip
        """Compare all places; None where they are too many.

        `core`, `sides`: the window of a gap, as :func:`.gap_kernels.ring` makes them; `own`: what is added to its px to
        read the gap's places (n, 2), and how often each is to be shown (n,); `neighbours`: for each side the same for
        the neighbour's places where they lie, for these places in the gap, and their shares.
        """
        places, shares = own
        count, most = len(places), max(len(there) for there, _, _ in neighbours)
        if not 2 <= count <= MOST_PLACES or most > MOST_PLACES:
            return None
        y, x = np.nonzero(sides >= 0)
        zone = np.stack([y, x, sides[y, x]], axis=1).astype(np.int64)
        zone = zone[:: max(1, len(zone) // SAMPLES)]
        pairs, barred = [], []
        for side, (there, here, _) in enumerate(neighbours):
            pairs.append(gap_table_kernels.pair_sums(picture, usable, zone[zone[:, 2] == side], places, there, slack))
            alike, next_to = (np.abs(places - given[:, None]).sum(axis=2) <= 2 * slack for given in (here, there))
            barred.append(np.where(next_to, 2, alike).astype(np.uint8))
        sums, px = zip(*pairs, strict=True)
        cut = ~gap_table_kernels.whole_moves(usable, core, places, slack)
        for each in px:
            each[:, cut] = 0  # not read, as if not there: what a real gap refuses must not be counted on
        table = cls(sums, px, tuple(barred), len(zone), slack, np.zeros(count, np.int64))
        order = _orders(max(LEAST_GAPS, GAPS * count))
        around = np.stack([_dealt(order[:, k], each) for k, (_, _, each) in enumerate(neighbours)], axis=1)
        gap_table_kernels.auction(table.costs(around)[0], shares, ROUNDS, EVEN, BAR, table.prices)
        return table

    def costs(self, around: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """What each place costs in gaps (g, n) without its price, and how it is best moved; `around` (g, 4)."""
        shape = len(around), len(self.prices)
        costs, moves = np.empty(shape, np.int64), np.empty(shape, np.int64)
        gap_table_kernels.gap_costs(self.sums, self.px, self.barred, around, self.sampled, BAR, costs, moves)
        return costs, moves

    def ranked(self, around: Sequence[int]) -> tuple[NDArray[np.int64], NDArray[np.int64], Shifts]:
        """The places for a gap, the best first: their numbers, what they cost, and their moves (n, 2) px."""
        costs, moves = self.costs(np.array([around], np.int64))
        priced = costs[0] + self.prices
        order = np.argsort(priced, kind="stable")
        side = 2 * self.slack + 1
        return order, priced[order], np.stack(np.divmod(moves[0][order], side), axis=1) - self.slack


@lru_cache(maxsize=2)
def _orders(gaps: int) -> NDArray[np.int64]:
    """Four orders of the numbers below `gaps`, drawn: (gaps, 4)."""
    bits = np.array(draw_many(0, IMAGINED, 0, [(k, side) for k in range(gaps) for side in range(4)]), np.uint64)
    return np.argsort(bits.reshape(gaps, 4), axis=0, kind="stable").astype(np.int64)


def _dealt(order: NDArray[np.int64], shares: Shares) -> NDArray[np.int64]:
    """A neighbour's place for each imagined gap: each exactly as often as its share says, as in a real mosaic."""
    ends = np.cumsum(shares)
    return np.asarray(np.searchsorted(ends, order * ends[-1] // len(order), side="right"), np.int64)
