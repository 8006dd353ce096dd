"""Where in the exemplar a mosaic's blocks may be read, and how often each place is to be: all of it equally often.

Where places overlap (blocks of half periods, periods completed from others) the middle of an exemplar lies in many
places, its edges in few: read equally often, they would show the edges less. So a place's share falls while its px are
shown more often than the mean, and rises while they are shown less: steps towards the least sum of squares of how
often px are shown. Shares are whole numbers; equal ones are left where places show the exemplar evenly enough.

The exemplar, continued past its edges: periods that its border cuts are completed from others, if these fit.

Photographs of tiles are often cut to whole periods, but not along the joints: then one row and one column of periods
is cut in two. Where at least half of it is there, the rest is taken one or more periods away (on the opposite side of
the exemplar, if that fits best), joined along the cheapest seam (Kwatra et al. 2003, eq. 1). A seam that is dearer than
those between blocks would be seen: then the periods stay cut, and are not shown.

How well every place fits into a gap of a mosaic, where places are few; and prices that make gaps use them evenly.

Random blocks show every place equally often, but gaps take what fits best, and some places fit nearly everywhere. As
in an auction (Bertsekas 1988) a place's price rises while more gaps than its share want it, and falls while fewer do:
in the end gaps take every place about as often as it is to be shown, each where it fits best. The gaps of the auction
are imagined, around neighbours that are drawn, so prices are a matter of the exemplar alone: no window or seed changes
them. They are many: prices that even out few gaps even out just these.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Floats, Int16, Int32, Int64, Mask, Pair, UInt8
from ..draws import below, draw_many
from ..errors import MethodError
from ..kernels import paths
from ..kernels.paths import BARRED
from ..lattice.candidates import UNIT
from ..methods.near_regular import NearRegular
from . import gap_kernels
from .grid import BlockGrid, Cell, Places, Sheet, block_places, block_vectors, phased

LEAST_KNOWN = 0.5  # of a period: less of it is not completed
WELL = 1.3  # a seam may cost so much more than the average one between blocks
UNSEEN = 4 * 16  # a seam of 4 grey levels of 1023 is never seen
SPARE = 2  # px more than is missing, since places are rounded
ASIDE = 4  # px at the ends of a strip that repeat the last one
REACH = 24  # multiples of the vectors that are looked at
TRIED = 6  # continuations of which the seam is sought
COVERED = 0.6  # of a strip must exist
Move = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Continued:
    """An exemplar's features with completed periods around it."""

    picture: Int16  # (H, W, C): the features
    usable: Mask  # (H, W): which of them exist
    source: Int32  # (H, W, 2): the exemplar's pixel that each shows
    before: Pair = (0, 0)  # rows and columns added above and to the left, px

    def placed(self, grid: BlockGrid) -> BlockGrid:
        """The grid of the exemplar as it lies here."""
        y, x = grid.phase
        return replace(grid, phase=(y + self.before[0] * UNIT, x + self.before[1] * UNIT))


def continued(
    picture: Int16, usable: Mask, grid: BlockGrid, steps: tuple[float, float],
    costs: tuple[float, float], border: int,
) -> Continued:  # fmt: skip
    """Complete the periods at the four edges.

    `grid`: the blocks; `steps`: px from period to period along both axes; `costs`: what a seam between blocks costs
    across each, 1/16 of a feature unit a px; `border`: px in which a seam may lie.
    """
    size = picture.shape[:2]
    out = Continued(picture, usable, np.moveaxis(np.indices(size, np.int32), 0, 2))
    (a, b), (c, d) = grid.vectors
    times = range(-REACH, REACH + 1)
    found = {(round((m * a + n * c) / UNIT), round((m * b + n * d) / UNIT)) for m in times for n in times}
    vectors = sorted(v for v in found if abs(v[0]) <= size[0] and abs(v[1]) <= size[1])
    before = [0, 0]
    for axis in (0, 1):
        phase, other = (grid.phase[axis] / UNIT) % steps[axis], (grid.columns, grid.rows)[axis]
        lean = abs(other[axis] / other[1 - axis]) * size[1 - axis]  # px that the last period lies off the first
        for end, known in ((0, phase), (1, (size[axis] - phase) % steps[axis])):
            missing = math.ceil(steps[axis] - known + lean) + SPARE if known >= LEAST_KNOWN * steps[axis] else 0
            limit = WELL * costs[axis] + UNSEEN
            wider = _longer(out, axis, end, missing, vectors, min(border, size[axis]), limit) if missing > 0 else None
            if wider is not None:
                out = wider
                before[axis] += missing if end == 0 else 0
    return replace(out, before=(before[0], before[1]))


def _longer(
    known: Continued, axis: int, end: int, more: int, vectors: list[Move], border: int, limit: float
) -> Continued | None:
    """Add `more` px at one end of an axis; None where no continuation joins at a cost of at most `limit`."""

    def turned(a: Array) -> Array:  # so that what is added comes below
        a = a if axis == 0 else a.swapaxes(0, 1)
        return a if end else a[::-1]

    def back(a: Array) -> Array:
        a = a if end else a[::-1]
        return np.ascontiguousarray(a if axis == 0 else a.swapaxes(0, 1))

    picture, usable, source = turned(known.picture), turned(known.usable), turned(known.source)
    sign = 1 if end else -1
    moves = sorted({(sign * v[axis], v[1 - axis]) for v in vectors})
    steps = [_last_step(picture, m) for m in moves if 0 < m[0] < len(picture) and abs(m[1]) <= ASIDE]
    strips = [s for m in moves if (s := Strip.of(picture, usable, m, more, border, steps)) is not None]
    tried = sorted(strips, key=lambda s: (not s.whole, s.mismatch))[:TRIED]
    fitting = [s for s in tried if s.cost <= limit]
    if not fitting:
        return None
    # From far away, if it goes: that is what no whole period shows.
    best = min(fitting, key=lambda s: (not s.whole, int(s.y[0]), s.cost))
    y, x, exists = best.joined(usable)
    parts = [np.concatenate([a[:-border], a[y, x]]) for a in (picture, source)]
    valid = np.concatenate([usable[:-border], exists])
    return Continued(back(parts[0]), back(valid), back(parts[1]))


def _last_step(picture: Array, move: Move) -> Int64:
    """What changes from the last row to the next, seen one translation of the lattice before: (W, C)."""
    x = np.clip(np.arange(picture.shape[1]) - move[1], 0, picture.shape[1] - 1)
    y = len(picture) - move[0]
    return np.asarray(picture[y, x].astype(np.int64) - picture[y - 1, x])


def _colour_distances(a: Array, b: Array) -> Int64:
    """How far pixels (..., C) differ, 1/16 of a feature unit."""
    return np.asarray(np.floor(16.0 * np.sqrt(((a.astype(np.int64) - b) ** 2).sum(axis=-1))), np.int64)


@dataclass(frozen=True, eq=False)
class Strip:
    """The last `border` rows of a picture and those to be added below them, as one translation reads them."""

    y: Array  # (rows,): what is read
    x: Array  # (columns,): the same
    there: Mask  # (rows, columns): which of it exists
    # (border, columns): how far what is read differs from the rows that are there, 1/16 of a feature unit; 0
    # where one is missing, BARRED above the exemplar's first row.
    apart: Int64

    @classmethod
    def of(cls, picture: Array, usable: Array, move: Move, more: int, border: int, steps: list[Array]) -> Strip | None:
        """Read a strip; None where too little of it exists. `steps`: as :func:`_step` finds them elsewhere."""
        height, width = usable.shape
        y, x = np.arange(height - border, height + more) - move[0], np.arange(width) - move[1]
        if y[border] < -ASIDE or y[-1] >= height:
            return None
        inside, before = (x >= -ASIDE) & (x < width + ASIDE), y[:border] < 0
        x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
        there = usable[np.ix_(y, x)] & inside
        if there[border:].mean() < COVERED:
            return None
        both = there[:border] & usable[-border:]
        apart = np.where(both, _colour_distances(picture[np.ix_(y[:border], x)], picture[-border:]), 0)
        if before[-1]:  # from the opposite edge: no seam but a straight one, good where the step across it is usual
            across = picture[y[border], x].astype(np.int64) - picture[-1]
            nearest = min((_colour_distances(across, s) for s in steps), key=lambda d: int(d.sum()), default=None)
            among = [int(_colour_distances(s, t).mean()) for k, s in enumerate(steps) for t in steps[:k]]
            apart[-1] = BARRED if nearest is None else np.maximum(nearest - min(among, default=0), 0)
            before[-1] = False
        apart[before] = BARRED
        return cls(y, x, there, apart)

    @property
    def whole(self) -> bool:
        """Whether all of it exists."""
        return bool(self.there.all())

    @property
    def mismatch(self) -> float:
        """How far the rows differ, on average."""
        known = self.there[: len(self.apart)] & (self.apart < BARRED)
        return float(self.apart[known].sum()) / max(int(known.sum()), 1)

    @cached_property
    def path(self) -> Int64:
        """The row of the cheapest seam in every column."""
        return np.asarray(paths.cheapest(np.ascontiguousarray(self.apart.T)))

    @property
    def cost(self) -> float:
        """What a px of that seam costs, on average."""
        width = len(self.x)
        along = self.apart[self.path, np.arange(width)]
        return float(along.sum()) / max(int(self.there[self.path, np.arange(width)].sum()), 1)

    def joined(self, usable: Array) -> tuple[Array, Array, Mask]:
        """Rows and columns that are read when the strip is joined along its seam, and which of them exist."""
        border, height = len(self.apart), len(usable)
        own = np.zeros(self.there.shape, bool)
        own[:border] = usable[-border:]
        below = np.arange(len(self.y))[:, None] > self.path
        taken = self.there & (below | ~own)
        rows = np.clip(np.arange(height - border, height - border + len(self.y)), 0, height - 1)[:, None]
        return np.where(taken, self.y[:, None], rows), np.where(taken, self.x, np.arange(len(self.x))), taken | own


IMAGINED = 2012  # keeps the draws of imagined gaps apart: on level 0, where courses, of the same number, draw nothing
GAPS = 96  # imagined gaps for each place
LEAST_GAPS = 1024
MOST_PLACES = 40  # of more, each is seldom shown anyway
ZONE = 120  # px of a gap's seam zone that are compared
BIDS = 40
EVEN = 5  # percent from its share at which a place keeps its price, or px may be shown more or less often than usual
BAR = 1 << 40  # above any mismatch
Shifts = Int64


@dataclass(frozen=True, eq=False)
class GapTable:
    """What pairs of places cost side by side."""

    # For each neighbour (above, below, left, right) squared differences (k, n, moves) of its places and the gap's.
    sums: tuple[Floats, ...]
    px: tuple[Floats, ...]  # and of how many px; whole numbers
    # (k, n) each: 1 where a place of the gap repeats the neighbour's, 2 where it only continues it.
    barred: tuple[UInt8, ...]
    sampled: int  # px that were compared
    slack: int  # how far a place is moved, px
    prices: Int64  # (n,): what a place costs beside its mismatch

    @classmethod
    def of(
        cls, picture: Int16, usable: Mask, core: UInt8, sides: NDArray[np.int8],
        own: tuple[Shifts, Int64], neighbours: Sequence[tuple[Shifts, Shifts, Int64]], slack: int,
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
        zone = zone[:: max(1, len(zone) // ZONE)]
        pairs, barred, around, order = [], [], [], _orders(max(LEAST_GAPS, GAPS * count))
        for side, (there, here, each) in enumerate(neighbours):
            ends = np.cumsum(each)  # each place lies beside exactly as many imagined gaps as its share says
            around.append(np.searchsorted(ends, order[:, side] * ends[-1] // len(order), side="right"))
            pairs.append(gap_kernels.pair_sums(picture, usable, zone[zone[:, 2] == side], places, there, slack))
            alike, next_to = (np.abs(places - given[:, None]).sum(axis=2) <= 2 * slack for given in (here, there))
            barred.append(np.where(next_to, 2, alike).astype(np.uint8))
        sums, px = zip(*pairs, strict=True)
        cut = ~whole_moves(usable, core, places, slack)
        for each in px:
            each[:, cut] = 0  # not read, as if not there: what a real gap refuses must not be counted on
        table = cls(sums, px, tuple(barred), len(zone), slack, np.zeros(count, np.int64))
        gap_kernels.auction(table.costs(np.stack(around, axis=1))[0], shares, BIDS, EVEN, BAR, table.prices)
        return table

    def costs(self, around: Int64) -> tuple[Int64, Int64]:
        """What each place costs in gaps (g, n) without its price, and how it is best moved; `around` (g, 4)."""
        shape = len(around), len(self.prices)
        costs, moves = np.empty(shape, np.int64), np.empty(shape, np.int64)
        gap_kernels.gap_costs(self.sums, self.px, self.barred, around, self.sampled, BAR, costs, moves)
        return costs, moves

    def ranked(self, around: Sequence[int]) -> tuple[Int64, Int64, Shifts]:
        """The places for a gap, the best first: their numbers, what they cost, and their moves (n, 2) px."""
        costs, moves = self.costs(np.array([around], np.int64))
        priced = costs[0] + self.prices
        order = np.argsort(priced, kind="stable")
        side = 2 * self.slack + 1
        return order, priced[order], np.stack(np.divmod(moves[0][order], side), axis=1) - self.slack


@lru_cache(maxsize=2)
def _orders(gaps: int) -> Int64:
    """Four orders of the numbers below `gaps`, drawn: (gaps, 4)."""
    bits = np.array(draw_many(0, IMAGINED, 0, [(k, side) for k in range(gaps) for side in range(4)]), np.uint64)
    return np.argsort(bits.reshape(gaps, 4), axis=0, kind="stable").astype(np.int64)


def whole_moves(usable: Mask, core: UInt8, places: Shifts, slack: int) -> Mask:
    """Say for which moves of which places of a gap, (n, moves), its `core` can be read whole; `places` as for pairs."""
    moves = np.stack(np.divmod(np.arange((2 * slack + 1) ** 2), 2 * slack + 1), axis=1) - slack
    return np.array([[gap_kernels.covers(usable, core, *to) for to in place + moves] for place in places])


SAMPLES = 16  # px of a block along each side that are looked at
BINS = 8  # of a block's side, in which shown px are counted
WHOLE = 1 << 16  # sum of the shares of the places that one block may be read from
MOST = 2  # times more or less often than the mean a place may be read
ROUNDS = 20
Shares = dict[Pair, Int64]


class FewPlaces(MethodError):
    """The exemplar holds too little for a mosaic; its best tile can still be repeated."""


def grid_and_places(
    settings: NearRegular, picture: Int16, usable: Mask, cell: Cell, element: float
) -> tuple[BlockGrid, Continued, Places]:
    """Choose the blocks and complete the periods around them; smaller ones where there are too few places for large.

    Returns the grid as it lies in the exemplar, what blocks are read from, and their places there.
    """
    room = int(picture.shape[0]), int(picture.shape[1])
    wide = min(max(1.5 * element, 48.0), min(room) / 2.5)
    target = float(settings.block) if settings.block is not None else None
    down, across = block_vectors(*cell, 1.0, wide, room)  # one period
    periods = down[0] / UNIT, abs(across[1]) / UNIT
    for wanted in (target, 1.0):
        rows, columns = block_vectors(*cell, wanted, wide, room)
        grid, costs = phased(picture, rows, columns, cell, settings.border)
        ground = continued(picture, usable, grid, periods, costs, settings.border)
        placed = ground.placed(grid)
        places = {(i, j): block_places(placed, ground.usable, (i, j)) for i in (0, 1) for j in (0, 1)}
        if min(len(p) for p in places.values()) >= 2:
            return grid, ground, places
    raise FewPlaces("the exemplar holds fewer than two places for a block of one period; give a larger exemplar.")


def place_shares(grid: BlockGrid, sheet: Sheet, nearest: NDArray[np.intp] | None, places: Places) -> Shares:
    """Shares of the places by the parity of row and column, as `places`; equal ones where they are many.

    `grid`: the blocks as they lie on the sheet; `nearest`: for every px of it the nearest usable one, or None.
    """
    counts = {kind: len(some) for kind, some in places.items()}
    equal = {kind: np.full(n, WHOLE // n, np.int64) for kind, n in counts.items()}
    if max(counts.values()) > MOST_PLACES:
        return equal
    shown, size = _parts_shown(grid, sheet, nearest, np.concatenate(list(places.values())))
    ends = np.cumsum(list(counts.values()))
    evened = np.split(_even_shares(shown, size, np.split(np.arange(len(shown)), ends[:-1])), ends[:-1])
    return dict(zip(counts, evened, strict=True))


def dealt(shares: Int64, bits: int, order: list[int]) -> list[int]:
    """One place for each number of `order`, each place as often as its share says, rounded up or down by drawn bits."""
    if shares.min() == shares.max():
        return order
    ends = np.cumsum(shares)
    step = int(ends[-1]) // len(order)
    at = np.array(order, np.int64) * step + below(step, bits)
    found: list[int] = np.searchsorted(ends, at, side="right").tolist()
    return found


def _parts_shown(
    grid: BlockGrid, sheet: Sheet, nearest: NDArray[np.intp] | None, places: Int64
) -> tuple[Int64, Int64]:
    """The part of the exemplar that each of a block's px shows at each place, (n, px), and how many px it has."""
    half, parts = 2 * np.indices((SAMPLES, SAMPLES)).reshape(2, -1, 1) + 1, 2 * SAMPLES
    offsets = (half[0] * grid.rows + half[1] * grid.columns) // parts
    y, x = np.moveaxis((places[:, None] + offsets) // UNIT, 2, 0)
    y, x = np.clip(y, 0, sheet.usable.shape[0] - 1), np.clip(x, 0, sheet.usable.shape[1] - 1)
    if nearest is not None:
        y, x = nearest[0][y, x], nearest[1][y, x]
    yx, _ = sheet.to_exemplar(np.stack([y, x], axis=-1).astype(np.int32))
    side = max(1, round(grid.determinant**0.5 / UNIT / BINS))
    height, width = int(sheet.source[..., 0].max()) + 1, int(sheet.source[..., 1].max()) + 1
    across = -(-width // side)
    rows, columns = (np.bincount(np.arange(n) // side) for n in (height, width))
    parts_yx = np.asarray(yx, np.int64) // side
    return parts_yx[..., 0] * across + parts_yx[..., 1], np.outer(rows, columns).reshape(-1).astype(np.int64)


def _even_shares(shown: Int64, size: Int64, kinds: list[NDArray[np.intp]]) -> Int64:
    """The shares of places that show parts of `size` px, those of one kind (numbers of places) equal where they may."""
    shares = np.empty(len(shown), np.int64)
    for own in kinds:
        shares[own] = WHOLE // len(own)
    least, most = shares // MOST, shares * MOST
    for _ in range(ROUNDS):
        weights = np.repeat(shares, shown.shape[1]).astype(np.float64)  # whole numbers, so that sums are exact
        often = np.bincount(shown.reshape(-1), weights, len(size)).astype(np.int64) * 256 // size
        seen, before = often[shown].sum(axis=1), shares.copy()
        for own in kinds:
            mean = int((seen[own] // 256 * shares[own]).sum()) // int(shares[own].sum())
            more = seen[own] // 256 - mean
            beyond = np.sign(more) * np.maximum(np.abs(more) - mean * EVEN // 100, 0)
            shares[own] -= shares[own] * beyond // max(mean, 1)
        shares = np.clip(shares, least, most)
        if (shares == before).all():
            break
    return shares
