"""Which brick lies where: every course is a chain from anchor to anchor, joints off those of the courses around.

An anchor is a joint at a place that follows from its number only, with a drawn brick behind it. Between two anchors
the least costly chain of bricks is found that fits in exactly. Every fourth course is chained alone, then the one
half-way between, then the others: each knows those around it that came before, so any part can be made alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..draws import below, deck, draw
from ..lattice.vectors import UNIT
from . import chain_kernels
from .bricks import Bricks
from .brickwork import Brickwork
from .rows import CourseRows
from .wall_kernels import FACE

Array = NDArray[Any]

STAGE = 2012
LONG = 512  # px from anchor to anchor
HAND = 16  # bricks that a chain chooses among
TURN = 100  # what a brick costs that it is not the turn of
TWICE, AGAIN, NEAR = 2000, 1500, 500  # what it costs to show a brick twice in a row; soon again; near itself
LOOSE = 15  # two bricks that are no neighbours in the exemplar
ODD, TALL = 150, 80  # bricks of courses of other lengths; much longer ones than usual
BORDER, CUT = 30, 250  # a brick cut by the border of the exemplar; cut to fit
NEVER = 1_000_000
NEARBY = 2.5  # usual bricks that a brick keeps away from itself


@dataclass(frozen=True)
class Piece:
    """A piece of a course on the canvas.

    Attributes
    ----------
    first, end : int
        Its columns on the canvas, up to the middle of the joints at both ends.
    source : int
        The exemplar column that `first` shows.
    course, left, right, low, high, brick : int
        The exemplar's course, what lies at both ends (a joint, FACE or OPEN), the exemplar columns of the ends, and
        the number of the brick.
    """

    first: int
    end: int
    source: int
    course: int
    left: int
    right: int
    low: int
    high: int
    brick: int

    def moved(self, by: int) -> Piece:
        """The same piece further on."""
        if by == 0:
            return self
        return Piece(
            self.first + by, self.end + by, self.source, self.course, self.left, self.right, self.low, self.high,
            self.brick,
        )  # fmt: skip


@dataclass(eq=False)
class Chains:
    """Chains of bricks along the courses of an endless canvas."""

    work: Brickwork
    bricks: Bricks
    rows: CourseRows
    seed: int
    _known: dict[tuple[int, int], list[Piece]] = field(default_factory=dict)
    _anchors: dict[tuple[int, int], int] = field(default_factory=dict)
    _decks: dict[tuple[int, int], list[int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        usual = max(self.bricks.usual, 1.0)
        self.step = round(max(8, round(LONG / usual)) * usual * UNIT)  # whole bricks, so that a bond is kept
        self.parts = max(1, round(self.rows.width * UNIT / self.step)) if self.rows.width else 0
        means = dict.fromkeys(self.work.courses, 0.0)
        for k in means:
            own = self.bricks.sizes[self.bricks.table[:, 0] == k]
            means[k] = float(own.mean()) if len(own) else usual
        self.mean = np.array([means[k] for k in self.bricks.table[:, 0]])

    def pieces(self, i: int, first: int, end: int) -> list[Piece]:
        """The pieces of course i that touch some columns, from left to right."""
        s = self._part(first) - 1
        found: list[Piece] = []
        while self.anchor(i, s) < end:
            found += [p for p in self.chain(i, s) if p.end > first and p.first < end]
            s += 1
        return found

    def anchor(self, i: int, s: int) -> int:
        """The column of anchor s of course i."""
        i, s, by = self._name(i, s)
        if (i, s) not in self._anchors:
            self._anchors[i, s] = self._anchor(i, s)
        return self._anchors[i, s] + by

    def chain(self, i: int, s: int) -> list[Piece]:
        """The pieces of course i between its anchors s and s + 1."""
        i, s, by = self._name(i, s)
        if (i, s) not in self._known:
            self._known[i, s] = self._linked(i, s)
        return [p.moved(by) for p in self._known[i, s]]

    def _part(self, u: int) -> int:
        """A number of an anchor not far from a column."""
        return u * self.parts // self.rows.width if self.parts else u * UNIT // self.step

    def _name(self, i: int, s: int) -> tuple[int, int, int]:
        if not self.parts:
            return self.rows.named(i, 0), s, 0
        turns, s = divmod(s, self.parts)
        return self.rows.named(i, turns), s, turns * self.rows.width

    def _rank(self, i: int, s: int) -> int:
        return self.rows.rank(self._name(i, s)[0])

    def _around(self, i: int, s: int) -> list[tuple[int, list[Piece]]]:
        """The chains around that came before: how many courses off, and their pieces."""
        own, found = self.rows.rank(i), list[tuple[int, list[Piece]]]()
        for off in (-2, -1, 1, 2):
            for part in (s - 1, s, s + 1):
                if self._rank(i + off, part) < own:
                    found.append((abs(off), self.chain(i + off, part)))
        return found

    def _around_anchor(self, i: int, s: int) -> list[tuple[int, list[Piece]]]:
        """The same for an anchor; none where leaning courses meet others once around, for both would wait."""
        return [] if s == 0 and self.rows.turn else self._around(i, s)

    def _anchor(self, i: int, s: int) -> int:
        """Near its place, where its joint lies best above and below those that are there."""
        usual = self.bricks.usual
        at = s * self.rows.width // self.parts if self.parts else s * self.step // UNIT
        room = (self.rows.width // self.parts if self.parts else self.step // UNIT) // 2
        choices = [int((m + 0.5) * usual) for m in range(max(1, int(room / usual)))]
        side = self.bricks.common * (i % 2)
        drawn = [draw(self.seed, STAGE, 1 + m, i, s) for m in range(len(choices))]
        places = (np.array(choices, np.int64) + side) % max(1, room)  # so that anchors stay in order
        costs = self._joints(self._around_anchor(i, s), places + at) + np.array([below(60, d) for d in drawn])
        return at + int(places[np.argmin(costs)])

    def _joints(self, around: list[tuple[int, list[Piece]]], at: Array) -> NDArray[np.int64]:
        """What joints at some columns cost, by those around."""
        total = np.zeros(len(at), np.int64)
        for off, table in ((1, self.bricks.beside), (2, self.bricks.beyond)):
            placed = sorted({u for o, chain in around if o == off for p in chain for u in (p.first, p.end)})
            if placed:
                joints = np.array(placed)
                k = np.searchsorted(joints, at)
                left = np.abs(at - joints[np.maximum(k - 1, 0)])
                right = np.abs(joints[np.minimum(k, len(joints) - 1)] - at)
                total += table[np.minimum(np.minimum(left, right), len(table) - 1)]
        return total

    def _hand(self, i: int, s: int) -> list[int]:
        """The bricks that a chain may show, the first one first: dealt from a shuffled deck, so all are shown."""
        n = len(self.bricks.table)
        held = min(HAND, n)
        deck, hand = divmod(i, n // held)
        order = self._deck(deck, s)
        mine = order[hand * held : (hand + 1) * held]
        start = [e for e in mine if self.bricks.table[e, 3] != FACE]
        if not start:
            start = [e for e in order if self.bricks.table[e, 3] != FACE][:1]
            mine = [*start, *mine[1:]]
        at, around = self.anchor(i, s), self._around_anchor(i, s)
        # A brick of the same kind nearby makes another one begin.
        costs = self._starts(start, around, at, 0)[:, 0] if around else np.zeros(len(start))
        first = start[int(np.argmin(costs))]
        return [first, *[e for e in mine if e != first]]

    def _deck(self, number: int, s: int) -> list[int]:
        if (number, s) not in self._decks:
            self._decks[number, s] = deck(len(self.bricks.table), self.seed, STAGE, 64, number, s)
        return self._decks[number, s]

    def _linked(self, i: int, s: int) -> list[Piece]:
        first, end = self.anchor(i, s), self.anchor(i, s + 1)
        length = end - first
        hand = self._hand(i, s)
        around = self._around(i, s)
        sizes = self.bricks.sizes[hand]
        pair = self._pairs(hand)
        n, t, _ = self._name(i, s + 1)
        following = self._hand(n, t)[0]
        follow = self._pairs([*hand, following])[:-1, -1]
        slack = 1 + int(length / self.bricks.usual)
        rules = np.array([0, slack, self.bricks.least, CUT, AGAIN, _at(hand, following)], np.int64)
        joint = self._joints(around, np.arange(length + 1) + first)
        out = np.empty((length + 2, 3), np.int64)
        start = self._starts(hand, around, first, length)
        count = chain_kernels.link(length, sizes, start, joint, pair, np.ascontiguousarray(follow), rules, out)
        return [self._piece(hand[int(k)], first + int(a), first + int(b)) for k, a, b in out[:count]]

    def _piece(self, brick: int, first: int, end: int) -> Piece:
        """A brick from column to column; cut at its right end where it is much too long."""
        k, low, high, left, right = (int(v) for v in self.bricks.table[brick])
        over = end - first - (high - low)
        if over < -2:
            return Piece(first, end, low, k, left, FACE, low, low + end - first, brick)
        return Piece(first, end, low - over // 2, k, left, right, low, high, brick)

    def _pairs(self, hand: list[int]) -> NDArray[np.int64]:
        """What it costs that one brick follows another."""
        left, right, mean = self.bricks.table[hand, 3], self.bricks.table[hand, 4], self.mean[hand]
        apart = np.abs(mean[:, None] - mean) / self.bricks.usual
        cost = LOOSE + np.rint(ODD * np.minimum(apart, 1)).astype(np.int64)
        cost[(right[:, None] == left) & (left != FACE)] = 0
        cost[(right[:, None] == FACE) & (left == FACE)] = NEVER
        names = np.array(hand)
        cost[names[:, None] == names] = TWICE
        return np.ascontiguousarray(cost, np.int64)

    def _starts(
        self, hand: list[int], around: list[tuple[int, list[Piece]]], first: int, length: int
    ) -> NDArray[np.int64]:
        """What each brick costs by the column that it begins at."""
        count, usual = len(hand), self.bricks.usual
        turn = (np.arange(length + 1) / usual).astype(np.int64)
        cost = TURN * ((np.arange(count)[:, None] - turn) % count) // count
        sizes, table = self.bricks.sizes[hand], self.bricks.table[hand]
        cost += (BORDER * ((table[:, 3] == FACE) | (table[:, 4] == FACE)) + TALL * (sizes > 1.6 * usual))[:, None]
        reach = int(NEARBY * usual)
        fall = NEAR * (reach - np.abs(np.arange(-reach, reach + 1))) ** 2 // max(reach, 1) ** 2
        places = {brick: k for k, brick in enumerate(hand)}
        for off, chain in around:
            for p in chain:
                at = p.first - first - reach
                low, high = max(0, at), min(length + 1, at + 2 * reach + 1)
                if p.brick in places and low < high:
                    cost[places[p.brick], low:high] += fall[low - at : high - at] // off
        return np.ascontiguousarray(cost, np.int64)


def _at(hand: list[int], brick: int) -> int:
    return hand.index(brick) if brick in hand else -1
