"""Course layout by dynamic programming: bricks between fixed knots, joints staggered against the courses around.

A knot (``anchor`` in the code) is a head joint near a column that follows from its number. Between two knots the
cheapest sequence of bricks that fits exactly, a chain, is found by dynamic programming. Every fourth course is laid out
first, then the one half-way between, then the others: each depends only on courses around it that come earlier, so that
any part can be computed alone.
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

Around = list[tuple[int, list[Piece]]]  # chains: distance in courses, and their pieces


def neighbours(chain: list[Piece]) -> list[Pair]:
    """Return the pairs of adjacent bricks of a chain, numbers of the left and the right one."""
    return [(a.brick, b.brick) for a, b in pairwise(chain)]


LONG = 512  # px between knots; halved: repeats in brick walls rise from 46 to 59, doubled: the same
LEAST_LONG = 8  # least mean bricks between knots; halved: 25 stacked joints instead of 9, doubled: 8
HAND = 16  # bricks a chain chooses among; halved: 73 stacked joints instead of 40, doubled: 29, slower
NEARBY = 2.5  # mean bricks within which reuse of a brick costs; halved: 816 reuses instead of 608, doubled: 528
NEVER = 1_000_000  # more than any chain costs


class Costs:
    """Costs of a chain; only their ratios matter. Counts are sums over 16 walls of 512 px (docs/design/012)."""

    turn = 100  # at most, the unit: a brick out of its turn in the shuffled hand; at 0 a third fewer bricks are used
    again = 2000  # a brick among the three before; 0: 1590 such instead of 654; halved, doubled: the same
    near = 500  # at most, a brick near itself; halved: 730 such instead of 652, doubled: 138 instead of 150
    loose = 15  # bricks that are not adjacent in the exemplar; 0: 2666 such pairs instead of 2404, 60: 2399
    odd = 150  # at most, pairs from courses of other mean length; 0: a drawn English bond has 118 instead of 32
    border = 30  # a brick cut by the border of the exemplar; halved: 379 are used instead of 339, doubled: 266
    cut = 250  # a brick cut to fit; halved: 50 cut ones instead of 42, doubled: the same on 13 walls of 16
    drawn = 60  # random part of the cost of a knot, below this; halved, doubled: other places, no visible effect


class StoneChoice:
    """Choice of stones for courses of unequal heights, and cost of repeated pairs."""

    near = 0.12  # largest difference in height, as a share of the course's height; 0.18: stones touch across beds
    fewest = 7  # least number of stones to choose from, filled up with those nearest in height; 5: twice the repeats
    twice = 600  # cost of a pair of stones used nearby already; 300: 125 pairs are repeated in rows instead of 106
    give = 4  # joints may change in width by their mean width divided by this, by 1 px at least
    wider = 2  # px: and by this at most; a stone longer than its place by more than 2 px counts as cut
    cut = 1500  # cost of a stone cut to fit; of 2000 stones none is cut, at 250 some are
    rounds = 6  # largest number of times a chain is computed while it repeats pairs; 4, 8: a few pairs differ


class CourseLayout:
    """The courses of an endless canvas, piece by piece; `own`: the height of each stone, if courses are unequal."""

    def __init__(self, work: Masonry, bricks: Bricks, rows: Rows, seed: int, own: Int64 | None = None) -> None:
        self.rows, self.seed, self.bricks = rows, seed, bricks
        usual, wide = max(bricks.usual, 1.0), rows.width
        step = round(max(LEAST_LONG, round(LONG / usual)) * usual * UNIT)  # whole bricks
        # Px between knots, as a fraction; if the canvas wraps, its width and the number of knots around it.
        self.pace = (wide, max(1, round(wide * UNIT / step))) if wide else (step, UNIT)
        self._known, self._anchors = dict[Pair, list[Piece]](), dict[Pair, int]()
        course = bricks.table[:, 0]
        self.mean = np.array([bricks.sizes[course == k].mean() for k in course])
        # Px by which a joint may be wider or narrower, cost of a brick cut to fit, largest number of rounds, and for
        # each course of the exemplar the bricks that it may use.
        self.give, self.cut, self.rounds = 1, Costs.cut, 0
        self.cards: list[Sequence[int]] = [range(len(bricks.table))]
        if own is not None:
            self.give, self.cut = min(max(work.thickness // StoneChoice.give, 1), StoneChoice.wider), StoneChoice.cut
            self.rounds, self.cards = StoneChoice.rounds, [_alike(bricks, own, height) for height in rows.heights]

    def pieces(self, i: int, first: int, end: int) -> list[Piece]:
        """Return the pieces of course i that meet columns `first` to `end` - 1, from left to right."""
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
        """Return the course and the knot modulo the canvas, and the columns from there to course i, knot s."""
        turns, s = divmod(s, self.pace[1]) if self.rows.width else (0, s)
        return self.rows.named(i, turns), s, turns * self.rows.width

    def _around(self, i: int, s: int) -> Around:
        """Return the chains up to two courses away that are laid out earlier: distance in courses, and pieces."""
        around = [(off, part) for off in (-2, -1, 1, 2) for part in (s - 1, s, s + 1)]
        before = [p for p in around if self.rows.rank(self.named(i + p[0], p[1])[0]) < self.rows.rank(i)]
        return [(abs(off), self.chain(i + off, part)) for off, part in before]

    def _around_anchor(self, i: int, s: int) -> Around:
        """Return the same for a knot; none for knot 0 of courses that continue as others once around the canvas.

        Otherwise each would depend on the other.
        """
        return [] if s == 0 and self.rows.turn else self._around(i, s)

    def _knot_offset(self, i: int, s: int, place: int, room: int) -> int:
        """Return the offset of a knot from column `place`, 0 to `room`, at which joints around it are best staggered.
        """
        choices = [int((m + 0.5) * self.bricks.usual) for m in range(max(1, int(room / self.bricks.usual)))]
        drawn = [below(Costs.drawn, draw(self.seed, STAGE, 1 + m, i, s)) for m in range(len(choices))]
        late = (np.array(choices, np.int64) + self.bricks.common * (i % 2)) % max(1, room)
        return int(late[np.argmin(self._joints(self._around_anchor(i, s), late + place) + np.array(drawn))])

    def _joints(self, around: Around, at: Array) -> Int64:
        """Return the cost of joints at columns `at`, from the distance to the nearest joints of the chains around."""
        total = np.zeros(len(at), np.int64)
        for off, table in ((1, self.bricks.beside), (2, self.bricks.beyond)):
            placed = np.array([*{u for o, chain in around if o == off for p in chain for u in (p.first, p.end)}])
            if len(placed):
                near = np.abs(placed[:, None] - at).min(axis=0)
                total += table[np.minimum(near, len(table) - 1)]
        return total

    def _candidates(self, i: int, s: int) -> list[int]:
        """Return the numbers of the bricks that a chain may use, first the one that it begins with.

        They are drawn without replacement from shuffled decks, so that all are used.
        """
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
        # The chain begins with a brick that is not used nearby.
        costs = self._starts(start, around, at, 0)[:, 0] if around else np.zeros(len(start))
        first = start[int(np.argmin(costs))]
        return [first, *[e for e in mine if e != first]]

    def _chained(self, i: int, s: int) -> list[Piece]:
        """Return the cheapest chain; with stones, of up to six the one that repeats the fewest pairs nearby."""
        if not self.rounds:
            return self._linked(i, s, {})
        near = Counter[Pair]()
        for _, chain in self._around(i, s):
            near.update(neighbours(chain))
        if s % 2:  # odd chains are computed after both even neighbours
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
        """Return the cheapest chain between knots s and s + 1; `more`: additional costs of pairs of bricks."""
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
        """Return a brick placed in columns `first` to `end` - 1, cut at its right end if it is over 2 px too long."""
        k, low, high, left, right = (int(v) for v in self.bricks.table[brick])
        over = end - first - (high - low)
        if over < -2:
            return Piece(first, end, low, k, left, NO_JOINT, low, low + end - first, brick)
        return Piece(first, end, low - over // 2, k, left, right, low, high, brick)

    def _pairs(self, hand: list[int]) -> Int64:
        """Return the cost of pairs of bricks: (n, n), the row is the left one."""
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
        """Return the cost of each brick by the column that it begins at: (n, length + 1), columns from `first`."""
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
    """Return each course, which has no head joints, as one brick, cut by the exemplar's border at both ends."""
    table = []
    for k, (x0, x1) in work.spans.items():
        spare = min(Sorting.margin, (x1 - x0 - 1) // 2)
        table.append((k, x0 + spare, x1 - spare, NO_JOINT, NO_JOINT))
    usual = float(np.mean([end - begin for _, begin, end, _, _ in table]))
    free = np.zeros(int(2 * usual) + 2, np.int64)  # joints cost nothing
    least = max(2, int(Sorting.half * usual))
    return Bricks(np.array(table, np.int64), usual, least, free, free, int(usual / 2))


def _alike(bricks: Bricks, own: Int64, height: int) -> list[int]:
    """Return the numbers of the stones about as high as a course, filled up with those nearest in height if few.

    `own`: heights of stones; `height`: of the course, px. At least one stone has a joint at its left end.
    """
    off = np.abs(own - height)
    beyond = np.maximum(off - int(StoneChoice.near * height), 0)  # px beyond the tolerance
    order = np.argsort(beyond, kind="stable")
    near = int((off <= Unequal.like * height).sum())
    whole = int(np.flatnonzero(bricks.table[order, 3] != NO_JOINT)[0]) + 1
    count = max(int((beyond == 0).sum()), min(StoneChoice.fewest, near), whole)
    return sorted(order[:count].tolist())
