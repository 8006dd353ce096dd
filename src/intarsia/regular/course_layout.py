"""Course layout by dynamic programming: bricks between fixed knots, joints staggered against the courses around.

A knot (anchor) is a joint at a place that follows from its number only, followed by a random brick. Between two knots
the cheapest sequence of bricks that fits exactly is found. Every fourth course is laid out first, then the one half-way
between, then the others: each depends on earlier ones around it only, so that any part can be made alone.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from ..foundation.arrays import Array, Int64, Pair
from ..foundation.geometry import UNIT
from ..foundation.run import below, draw
from . import wall_kernels
from .course_rows import DEALT, STAGE, Piece, Rows, cached_deck
from .masonry import Bricks, Masonry, Sorting
from .unequal_courses import Unequal
from .wall_kernels import NO_JOINT

Around = list[tuple[int, list[Piece]]]  # chains: how many courses off, and their pieces


def neighbours(chain: list[Piece]) -> list[Pair]:
    """Return the pairs of adjacent stones, left and right."""
    return [(a.brick, b.brick) for a, b in pairwise(chain)]


LONG = 512  # px from anchor to anchor; halved: repeats in brick walls rise from 46 to 59, doubled: they stay
LEAST_LONG = 8  # usual bricks from anchor to anchor; halved: 25 joints lie over others instead of 9, doubled: 8
HAND = 16  # bricks that a chain chooses among; halved: 73 joints over others instead of 40, doubled: 29 in more time
NEARBY = 2.5  # usual bricks that a brick keeps away from itself; halved: 816 returns instead of 608, doubled: 528
NEVER = 1_000_000  # more than any chain costs


class Costs:
    """Costs of a course; only their ratios count. Counts are sums over 16 walls of 512 px (docs/design/012)."""

    turn = 100  # a brick that it is not the turn of: the unit; without it a third fewer bricks are used
    again = 2000  # a brick used one or two before: at 0 1590 of them instead of 654; halved and doubled: the same
    near = 500  # a brick beside itself; halved: 730 instead of 652 near themselves, doubled: 138 instead of 150
    loose = 15  # bricks that are no neighbours in the exemplar; at 0: 2666 such pairs instead of 2404, at 60: 2399
    odd = 150  # bricks of courses of other lengths; at 0 a drawn English bond mixes 118 pairs instead of 32
    border = 30  # a brick cut by the border of the exemplar; halved: 379 are used instead of 339, doubled: 266
    cut = 250  # a brick cut to fit; halved: 50 cut ones instead of 42, doubled: the same on 13 walls of 16
    drawn = 60  # up to so much by chance, at anchors; halved and doubled: other places, nothing is seen


class StoneChoice:
    """Which stones fit a course, and what pairs that are repeated cost."""

    near = 0.12  # of a course's height a stone may be higher or lower. At 0.18 stones touch across beds
    fewest = 7  # stones to choose from, or others that are like them, too; at 5 twice as many pairs return in rows
    twice = 600  # a pair that is used nearby already; at 300 125 are repeated in rows, not 106
    give = 4  # joints are so many times as wide as they may become wider or narrower, 1 px or more, and at most
    wider = 2  # px: a stone that is too long by more is a cut one
    cut = 1500  # what a stone costs that is cut to fit; of 2000 stones none is, with 250 some are
    rounds = 6  # times at most that a chain is made while it repeats pairs; 4 and 8: a few pairs more or less


class CourseLayout:
    """The courses of an endless canvas, piece by piece; `own`: the height of each stone, if courses are unequal."""

    def __init__(self, work: Masonry, bricks: Bricks, rows: Rows, seed: int, own: Int64 | None = None) -> None:
        self.rows, self.seed, self.bricks = rows, seed, bricks
        usual, wide = max(bricks.usual, 1.0), rows.width
        step = round(max(LEAST_LONG, round(LONG / usual)) * usual * UNIT)  # whole bricks
        # Px from anchor to anchor, as a fraction: of a canvas that wraps, and how many are around it.
        self.pace = (wide, max(1, round(wide * UNIT / step))) if wide else (step, UNIT)
        self._known, self._anchors = dict[Pair, list[Piece]](), dict[Pair, int]()
        course = bricks.table[:, 0]
        self.mean = np.array([bricks.sizes[course == k].mean() for k in course])
        # Px by which a joint may be wider or narrower, what a brick costs that is cut to fit, times that a chain is
        # made, and which bricks each course of the exemplar may use.
        self.give, self.cut, self.rounds = 1, Costs.cut, 0
        self.cards: list[Sequence[int]] = [range(len(bricks.table))]
        if own is not None:
            self.give, self.cut = min(max(work.thickness // StoneChoice.give, 1), StoneChoice.wider), StoneChoice.cut
            self.rounds, self.cards = StoneChoice.rounds, [_alike(bricks, own, height) for height in rows.heights]

    def pieces(self, i: int, first: int, end: int) -> list[Piece]:
        """Return the pieces of course i that touch some columns, from left to right."""
        s = first * self.pace[1] // self.pace[0] - 1
        found: list[Piece] = []
        while self.anchor(i, s) < end:
            found += [p for p in self.chain(i, s) if p.end > first and p.first < end]
            s += 1
        return found

    def anchor(self, i: int, s: int) -> int:
        """Return the column of knot s of course i."""
        i, s, by = self.named(i, s)
        if (i, s) not in self._anchors:
            whole, parts = self.pace
            place = s * whole // parts
            self._anchors[i, s] = place + self._knot_offset(i, s, place, whole // parts // 2)
        return self._anchors[i, s] + by

    def chain(self, i: int, s: int) -> list[Piece]:
        """Return the pieces of course i between its knots s and s + 1."""
        i, s, by = self.named(i, s)
        if (i, s) not in self._known:
            self._known[i, s] = self._chained(i, s)
        return [p._replace(first=p.first + by, end=p.end + by) for p in self._known[i, s]]

    def named(self, i: int, s: int) -> tuple[int, int, int]:
        """Return the course and the knot modulo the canvas, and how many columns further on they lie."""
        turns, s = divmod(s, self.pace[1]) if self.rows.width else (0, s)
        return self.rows.named(i, turns), s, turns * self.rows.width

    def _around(self, i: int, s: int) -> Around:
        """Return the chains around that are made earlier: how many courses off, and their pieces."""
        around = [(off, part) for off in (-2, -1, 1, 2) for part in (s - 1, s, s + 1)]
        before = [p for p in around if self.rows.rank(self.named(i + p[0], p[1])[0]) < self.rows.rank(i)]
        return [(abs(off), self.chain(i + off, part)) for off, part in before]

    def _around_anchor(self, i: int, s: int) -> Around:
        """Return the same for a knot; none if slanted courses meet others once around, as both would wait."""
        return [] if s == 0 and self.rows.turn else self._around(i, s)

    def _knot_offset(self, i: int, s: int, place: int, room: int) -> int:
        """Return how far behind its place a knot lies, less than `room`: best staggered against the courses around."""
        choices = [int((m + 0.5) * self.bricks.usual) for m in range(max(1, int(room / self.bricks.usual)))]
        drawn = [below(Costs.drawn, draw(self.seed, STAGE, 1 + m, i, s)) for m in range(len(choices))]
        late = (np.array(choices, np.int64) + self.bricks.common * (i % 2)) % max(1, room)
        return int(late[np.argmin(self._joints(self._around_anchor(i, s), late + place) + np.array(drawn))])

    def _joints(self, around: Around, at: Array) -> Int64:
        """Return the cost of joints at some columns, by the joints around."""
        total = np.zeros(len(at), np.int64)
        for off, table in ((1, self.bricks.beside), (2, self.bricks.beyond)):
            placed = np.array([*{u for o, chain in around if o == off for p in chain for u in (p.first, p.end)}])
            if len(placed):
                near = np.abs(placed[:, None] - at).min(axis=0)
                total += table[np.minimum(near, len(table) - 1)]
        return total

    def _candidates(self, i: int, s: int) -> list[int]:
        """Return the bricks that a chain may use, the first one first: from a shuffled deck, so that all are used."""
        cards = self.cards[self.rows.kind(i)]
        n = len(cards)
        held = min(HAND, n)
        number, hand = divmod(i, n // held)
        order = [cards[e] for e in cached_deck(n, self.seed, STAGE, DEALT, number, s)]
        mine = order[hand * held : (hand + 1) * held]
        start = [e for e in mine if self.bricks.table[e, 3] != NO_JOINT]
        if not start:
            start = ([e for e in order if self.bricks.table[e, 3] != NO_JOINT] or order)[:1]
            mine = [*start, *mine[1:]]
        at, around = self.anchor(i, s), self._around_anchor(i, s)
        # A brick of the same kind nearby makes another one begin.
        costs = self._starts(start, around, at, 0)[:, 0] if around else np.zeros(len(start))
        first = start[int(np.argmin(costs))]
        return [first, *[e for e in mine if e != first]]

    def _chained(self, i: int, s: int) -> list[Piece]:
        """Return the cheapest chain, or of several the one that repeats the fewest pairs."""
        if not self.rounds:
            return self._linked(i, s, {})
        near = Counter[Pair]()
        for _, chain in self._around(i, s):
            near.update(neighbours(chain))
        if s % 2:  # every other chain of a course knows those beside it
            for beside in (s - 1, s + 1):
                if self.named(i, beside)[1] % 2 == 0:
                    near.update(neighbours(self.chain(i, beside)))
        more = Counter({pair: StoneChoice.twice * n for pair, n in near.items()})
        best, least = list[Piece](), math.inf
        for _ in range(self.rounds):
            chain = self._linked(i, s, more)
            own = Counter(neighbours(chain))
            again = sum(n - 1 for n in own.values()) + sum(n for pair, n in own.items() if pair in near)
            if again < least:
                best, least = chain, again
            if not any(n > 1 for n in own.values()):
                break
            more.update({pair: StoneChoice.twice * (n - 1) for pair, n in own.items()})
        return best

    def _linked(self, i: int, s: int, more: Mapping[Pair, int]) -> list[Piece]:
        """Return the cheapest chain; `more`: additional costs of some pairs."""
        first, end = self.anchor(i, s), self.anchor(i, s + 1)
        length = end - first
        hand = self._candidates(i, s)
        around = self._around(i, s)
        sizes = self.bricks.sizes[hand]
        n, t, _ = self.named(i, s + 1)
        following = self._candidates(n, t)[0]
        turn = hand.index(following) if following in hand else -1
        pair, follow = self._pairs(hand), self._pairs([*hand, following])[:-1, -1]
        for (a, b), price in more.items():
            if a in hand and b in hand:
                pair[hand.index(a), hand.index(b)] += price
            if a in hand and b == following:
                follow[hand.index(a)] += price
        slack = 1 + int(self.give * length / self.bricks.usual)
        rules = np.array([0, slack, self.bricks.least, self.cut, Costs.again, turn], np.int64)
        joint = self._joints(around, np.arange(length + 1) + first)
        out = np.empty((length + 2, 3), np.int64)
        start = self._starts(hand, around, first, length)
        count = wall_kernels.best_chain(length, sizes, start, joint, pair, np.ascontiguousarray(follow), rules, out)
        return [self._piece(hand[int(k)], first + int(a), first + int(b)) for k, a, b in out[:count]]

    def _piece(self, brick: int, first: int, end: int) -> Piece:
        """Return a brick from column to column; cut at its right end if it is much too long."""
        k, low, high, left, right = (int(v) for v in self.bricks.table[brick])
        over = end - first - (high - low)
        if over < -2:
            return Piece(first, end, low, k, left, NO_JOINT, low, low + end - first, brick)
        return Piece(first, end, low - over // 2, k, left, right, low, high, brick)

    def _pairs(self, hand: list[int]) -> Int64:
        """Return the cost of each brick after each other one."""
        left, right, mean = self.bricks.table[hand, 3], self.bricks.table[hand, 4], self.mean[hand]
        apart = np.abs(mean[:, None] - mean) / self.bricks.usual
        cost = Costs.loose + np.rint(Costs.odd * np.minimum(apart, 1)).astype(np.int64)
        cost[(right[:, None] == left) & (left != NO_JOINT)] = 0
        cost[(right[:, None] == NO_JOINT) & (left == NO_JOINT)] = NEVER
        names = np.array(hand)
        cost[names[:, None] == names] = Costs.again
        return np.ascontiguousarray(cost, np.int64)

    def _starts(
        self, hand: list[int], around: Around, first: int, length: int
    ) -> Int64:
        """Return the cost of each brick by the column that it begins at."""
        count, usual = len(hand), self.bricks.usual
        turn = (np.arange(length + 1) / usual).astype(np.int64)
        cost = Costs.turn * ((np.arange(count)[:, None] - turn) % count) // count
        cost += Costs.border * (self.bricks.table[hand, 3:] == NO_JOINT).any(axis=1)[:, None]
        reach = int(NEARBY * usual)
        fall = Costs.near * (reach - np.abs(np.arange(-reach, reach + 1))) ** 2 // max(reach, 1) ** 2
        places = {brick: k for k, brick in enumerate(hand)}
        for off, chain in around:
            for p in chain:
                at = p.first - first - reach
                low, high = max(0, at), min(length + 1, at + 2 * reach + 1)
                if p.brick in places and low < high:
                    cost[places[p.brick], low:high] += fall[low - at : high - at] // off
        return np.ascontiguousarray(cost, np.int64)


def boards_of(work: Masonry) -> Bricks:
    """Return courses without joints as bricks, one each, cut by the border of the exemplar at both ends."""
    table = []
    for k, (x0, x1) in work.spans.items():
        spare = min(Sorting.margin, (x1 - x0 - 1) // 2)
        table.append((k, x0 + spare, x1 - spare, NO_JOINT, NO_JOINT))
    usual = float(np.mean([end - begin for _, begin, end, _, _ in table]))
    free = np.zeros(int(2 * usual) + 2, np.int64)  # no joint lies better than another
    least = max(2, int(Sorting.half * usual))
    return Bricks(np.array(table, np.int64), usual, least, free, free, int(usual / 2))


def _alike(bricks: Bricks, own: Int64, height: int) -> list[int]:
    """Return the stones about as high as a course; those nearest in height if they are few."""
    off = np.abs(own - height)
    beyond = np.maximum(off - int(StoneChoice.near * height), 0)  # px too high or too low
    order = np.argsort(beyond, kind="stable")
    near = int((off <= Unequal.like * height).sum())
    whole = int(np.flatnonzero(bricks.table[order, 3] != NO_JOINT)[0]) + 1
    count = max(int((beyond == 0).sum()), min(StoneChoice.fewest, near), whole)
    return sorted(order[:count].tolist())
