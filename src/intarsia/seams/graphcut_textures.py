"""Graph-cut texture synthesis: patches placed by sampling and cut in by max flow over existing seams.

The cut accounts for the cost of seams placed earlier, so a patch may also replace pixels around its window. Several
placements are sampled and compared by coarse cuts; the one that leaves the cheapest seams is cut in at full
resolution (Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003, sections 3 and 4).

A patch next to its own mirror image, or to itself rotated by 180 degrees about a point of it, meets it without a seam.
Such placements are the cheapest of all, and look like wings and rosettes: they are rejected.

A piece is the set of all canvas pixels that show one placement, connected or not. Extending a piece over its
neighbours by one cut is an expansion move (Boykov, Veksler and Zabih, "Fast Approximate Energy Minimization via Graph
Cuts", IEEE PAMI 23, 2001), here limited to the surroundings of the piece. It needs no search. In repairs, pieces near a
window are tried as placements for it, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..analysis import block_sums, window_sums
from ..analysis.contrast_masking import FULL
from ..foundation.arrays import Array, Mask, Pair
from ..foundation.geometry import UNIT
from ..foundation.run import Run, draw
from ..lattice import Vectors, closing_vector
from ..model.sourcemap import HOLE
from ..patches import Pick, Window, index_of, picked, random_patch
from ..patches.patch_synthesis import PatchSynthesis
from ..search import Candidates, Prices
from ..search.fourier import PatchSearch
from . import cut_kernels, energy_kernels, placement_kernels, visibilities
from .cut_kernels import NEVER
from .energy_kernels import Pieces
from .lattice_alignment import SLACK, aligned, aligned_place
from .occurrence_kernels import Usage, count_map
from .occurrences import usage_of
from .placement_kernels import ONE, Look
from .softmax_sampling import boltzmann_weights, weighted_sample

NOTHING = np.empty((0, 0), np.uint8)
Box = tuple[int, int, int, int]  # first row and column, rows and columns

Constraint = Callable[[Box, Pick], Array]  # returns which pixels of a box must not change; see `repair.keeping_guide`


NEARBY = 512  # px, or twice the longest exemplar side if more: side of the area in which repeats count in full
SAMPLES = 64  # sampling points, at most, along each side of the surroundings in which repeats of a window are counted
TRIES = 12  # placements that are drawn for a window and compared by coarse cuts; the paper draws 1
RANDOMNESS = 0.01  # k of exp(-cost / (k sigma^2)), by which placements are drawn; sigma^2 the exemplars' variance
REPEAT = 2.0  # factor of the price of repeats: repeats of large patches are more visible than those of small ones
ROUGH = 6  # px between the sampled pixels of a coarse cut
LEAST = 8  # sampled pixels, at least, along each side of a window in a coarse cut
NEARBY_SHARE = 3  # at most a third of the placements tried in a repair are pieces that lie near the window already
EVERY = 4  # px between the sampling points in the surroundings of a window, at least
FAR = 1 << 24  # px: longer than any canvas or exemplar
APART = 3  # px between windows that are cut in parallel, at least, so that none reads pixels that another changes
TORUS_TOLERANCE = 3  # px off one exemplar size, within which repeats are rejected; 1/4 window rejects good ones
STEP = 4  # px between the pixels that are tested for a mirror image of themselves
MOST = 32  # at most 1 / MOST of the pixels of a window may lie near a mirror image of themselves


@dataclass(frozen=True, eq=False)
class Cut:
    """A patch cut into a window: change of the energy, the window, the patch, and a mask of what it replaces."""

    change: int
    box: Box
    pick: Pick
    take: Array


@dataclass(frozen=True)
class GraphcutSettings:
    """Parameters of placing and cutting patches.

    Attributes
    ----------
    usage : float
        Price of a repeat, relative to the usual distance (:attr:`intarsia.search.Candidates.usual`).
    seam : str
        Cost of a seam. ``difference``: the feature distance of both sides; ``gradient``: that divided by the local
        gradients; ``sharp``: the truncated quadratic of the distance, weighted by visibility.
    margin : int
        How far around its window a patch may replace what is there, px.
    lattice : two vectors, (rows, columns) in 1/256 px
        All patches are aligned to the first one by this lattice; None: they may lie anywhere.
    slack : int
        How far a patch may lie off the lattice, px.
    evenness : float
        Cost of one more occurrence of an exemplar pixel that is used as often as the average, in thresholds of the
        seam cost; 0: none.
    """

    usage: float = 0.05
    seam: str = "difference"
    margin: int = 16
    lattice: Vectors | None = None
    slack: int = SLACK
    evenness: float = 0.0


class Piece(NamedTuple):
    """The bounding box of one placement in a map, and the pick at the box's first pixel."""

    box: Box
    pick: Pick


def pieces_in(variant: Array, yx: Array, least: int = 1) -> list[Piece]:
    """List the pieces of a map, or of part of one, the largest first.

    Equally large ones are ordered by variant, then by the offset of canvas row to exemplar row, then of the columns.

    Parameters
    ----------
    variant, yx : arrays, shape (h, w) and (h, w, 2)
        What is shown: variants, HOLE where none is, and their rows and columns.
    least : int
        Pieces that cover fewer px are left out.
    """
    h, w = variant.shape
    begins, (shown_row, shown_column) = np.ones((h, w), np.bool_), np.moveaxis(yx, 2, 0)
    goes_on = (variant[:, 1:] == variant[:, :-1]) & (shown_row[:, 1:] == shown_row[:, :-1])
    np.logical_not(goes_on & (shown_column[:, 1:] == shown_column[:, :-1] + 1), out=begins[:, 1:])
    runs = np.flatnonzero(begins)  # along their rows
    (row, first), length = divmod(runs, w), np.diff(runs, append=h * w)
    key = (variant[row, first].astype(np.int64) * FAR + row - shown_row[row, first] + FAR // 2) * FAR
    found, number = np.unique(key + first - shown_column[row, first] + FAR // 2, return_inverse=True)
    area, corners = np.bincount(number, length), np.tile([h, w, 0, 0], (len(found), 1))
    for k, ends in enumerate((row, first, row + 1, first + length)):
        (np.maximum if k > 1 else np.minimum).at(corners[:, k], number, ends)
    out = []
    for k in np.argsort(-area, kind="stable").tolist():
        (shown, down), right = divmod(int(found[k]) // FAR, FAR), int(found[k]) % FAR
        top, left, bottom, end = corners[k].tolist()
        if area[k] >= least and shown != HOLE:
            pick = shown, top - down + FAR // 2, left - right + FAR // 2
            out.append(Piece((top, left, bottom - top, end - left), pick))
    return out


def first_of(windows: Array, patches: Array) -> tuple[Box, Pick]:
    """Return the first of windows and patches as :meth:`GraphcutMap.windows` returns them."""
    return tuple(windows[0, :4].tolist()), tuple(patches[0].tolist())


class GraphcutMap:
    """A map under synthesis whose patches are cut over existing seams.

    ``prices`` (H, W, 2) int32: seam costs between every pixel and its right and lower neighbour. `bar`, if given,
    returns which pixels of a box must not change when a given patch is cut in.
    """

    def __init__(
        self, growth: PatchSynthesis, stitch: GraphcutSettings, bar: Constraint | None = None, run: Run | None = None
    ) -> None:
        self.growth, self.stitch, self.variants, self.constraint = growth, stitch, growth.variants, bar
        self._variance, self.price = growth.variance(), growth.seam_price(stitch.seam)
        self.pieces = pieces_of(growth, self.price.threshold)
        work, self.wraps = growth.growing, growth.layout.wraps
        self.variant, self.yx, self.locked = work.variant, work.yx, work.locked
        self.grown = work.grown
        self._sizes = np.column_stack([self.variants.table[:, 1:3], self.variants.toroidal]).tolist()
        self.prices = np.zeros((*self.variant.shape, 2), np.int32)
        nearby = max(NEARBY, 2 * int(self.variants.table[:, 1:3].max()))
        self.once = ONE * math.prod(min(n, nearby) for n in self.variant.shape) // self.variant.size
        assert isinstance(growth.finder, PatchSearch)
        self._search = growth.finder
        self.first: tuple[Pair, Pair] | None = None  # aligned patches: an exemplar pixel, and where it is shown
        self._around = [
            closing_vector(stitch.lattice, n, k) if stitch.lattice and wrap else (n * UNIT * (1 - k), n * UNIT * k)
            for k, (n, wrap) in enumerate(zip(self.variant.shape, self.wraps, strict=True))
        ]
        if stitch.lattice and (self.variant == 0).any():
            y, x = divmod(int((self.variant == 0).argmax()), self.variant.shape[1])
            self.first = (int(self.yx[y, x, 0]), int(self.yx[y, x, 1])), (y, x)
        self.usage = self._counted(stitch.evenness, run or Run())
        self._map, self._prices = (self.grown, self.locked, self.pieces), (self.price, self.usage)
        self._told: Prices | None = None
        self._measure((0, 0, *self.variant.shape))

    def _counted(self, price: float, run: Run) -> Usage:
        """Return the number of occurrences of every exemplar pixel in the map, and what a further one costs."""
        feats, exemplars, stepped = self.growth.features, self.growth.exemplars, self.stitch.lattice is not None
        begins = np.cumsum([0, *(e.free.size for e in exemplars)])
        numbers = [b + np.arange(e.free.size).reshape(e.free.shape) for b, e in zip(begins, exemplars, strict=False)]
        rate, shown = np.empty(0, np.int32), np.zeros(begins[-1], np.int32)
        if price:
            price *= self.growth.seam_price("sharp").threshold
            rate, shown = usage_of(feats, exemplars, self.variant.size, price, stepped, run)
        usage = Usage(self.variants.laid_out(numbers).astype(np.int32), rate, shown)
        count_map(self.grown, self.pieces, usage)
        return usage

    @property
    def total(self) -> int:
        """Seam energy of the map."""
        return int(self.prices.sum(dtype=np.int64))

    @property
    def stretched(self) -> bool:
        """Whether patches are aligned to a lattice that is stretched to fit a canvas that wraps."""
        return self.first is not None and any(self.wraps)

    @property
    def around(self) -> int:
        """Least distance of windows that are filled in parallel, px."""
        return 2 * self.stitch.margin + APART

    # ---- placing

    def best(self, box: Box, picks: Sequence[Pick]) -> Cut | None:
        """Return the full cut of the placement that is cheapest by a coarse cut; None if there is no placement."""
        which = self._cheapest_coarse(box, picks) if picks[1:] else 0  # a single one needs no comparison
        return self.cut(box, picks[which], self.stitch.margin) if picks else None

    def _cheapest_coarse(self, box: Box, picks: Sequence[Pick]) -> int:
        """Return the index of the placement that is cheapest by a coarse cut; of equal ones the first."""
        step, best = max(1, min(ROUGH, min(box[2:]) // LEAST)), np.array([NEVER, len(picks)], np.int64)
        windows, patches = self.windows(box, picks, self.stitch.margin)
        order = np.lexsort(windows[:, 3::-1].T)  # equal windows follow one another, and are read once
        for some in order[:, None] if self.constraint else [order]:
            tried, numbered = windows[some], np.column_stack([some, patches[some]])
            with self._locked_for(*first_of(tried, patches[some])):
                cut_kernels.recut(*self._map, tried, numbered, self._prices, step, NOTHING, best)
        return int(best[1])

    def shown(self, box: Box) -> list[Pick]:
        """Return the pieces in and around a window as placements, the largest first, at most TRIES // NEARBY_SHARE.

        None on a lattice that is stretched around the canvas, as pieces are not stretched.
        """
        if self.stretched:
            return []
        wide = self.wide(box, self.stitch.margin)
        seen, down, right = self.index(wide), box[0] - wide[0], box[1] - wide[1]
        shifts = [
            (v, row + down - top, column + right - left)
            for (top, left, _, _), (v, row, column) in pieces_in(self.variant[seen], self.yx[seen])
        ]
        good = self.apart(box, np.array([(0, *shift) for shift in shifts], np.int64).reshape(-1, 4))
        return [pick for pick, apart in zip(shifts, good, strict=True) if apart][: TRIES // NEARBY_SHARE]

    def apart(self, box: Box, rows: Array) -> Array:
        """Return which candidates have hardly any mirror image nearby, and repeat nothing one whole exemplar away."""
        around = np.zeros(len(rows), np.int64)
        if self.stitch.lattice is None:  # aligned patches repeat it with every period anyway
            placement_kernels.repeats_whole_exemplar(self.grown, self.pieces, box, rows, TORUS_TOLERANCE, around)
        return np.asarray(self._unmirrored(box, rows) & (around == 0))

    def _unmirrored(self, box: Box, rows: Array) -> Array:
        """Return which candidates have at most 1 / MOST of their pixels near a mirror image of them."""
        count = np.zeros(len(rows), np.int64)
        if self.variants.turns.any():
            placement_kernels.mirrored_pixels(self.grown, self.pieces, self.variants.turns, box, rows, STEP, count)
        return np.asarray(count * MOST <= box[2] * box[3])

    def placements(self, box: Box, found: Candidates, bits: int, most: int) -> list[Pick]:
        """Draw up to `most` candidates for a window by softmax of their costs; any valid patch if there are none."""
        good = self.apart(box, found.rows)
        good = good if good.any() else self._unmirrored(box, found.rows)
        found = replace(found, rows=found.rows[good]) if good.any() else found  # if all are rejected, all are kept
        if not len(found.rows):
            return [random_patch(self._allowed(box), draw(bits, 0))]
        price = self.priced(box, found)
        unit = max(round(RANDOMNESS * self._variance * max(int(found.known.sum()), 1)), 1)
        chances = boltzmann_weights((price - price.min()) * 64 // unit)
        return [picked(found, k) for k in weighted_sample(chances.tolist(), most, bits)]

    def priced(self, box: Box, found: Candidates) -> Array:
        """Return the cost of each candidate for a window: its distance plus the price of repeats."""
        rows, shown = found.rows, np.empty(len(found.rows), np.int64)
        look, turns = self.look(box), self.variants.turns
        placement_kernels.repeats(self.grown, self.pieces, turns, look, box, rows, self.once, shown)
        for v, counts in enumerate(self.told.counts):
            mine = rows[:, 1] == v
            y, x = np.minimum(rows[mine, 2:] // self._search.factor, np.subtract(counts.shape, 1)).T
            shown[mine] += counts[y, x]
        price = round(REPEAT * self.stitch.usage * found.usual)
        return np.asarray(rows[:, 0] + np.maximum(shown, 0) * price // ONE)

    def look(self, box: Box) -> Look:
        """Return the part of the canvas around a window in which repeats cost more, and its sampling step."""
        firsts, sides, reach = [], [], placement_kernels.reach_of(box[2], box[3])
        for begin, n, length, wrap in zip(box[:2], box[2:], self.variant.shape, self.wraps, strict=True):
            first = 0 if wrap and 2 * reach >= length else begin + n // 2 - reach
            low, high = (0, length) if wrap else (max(-first, 0), length - first)
            firsts.append((first + low) % length)
            sides.append(min(2 * reach + 1, high) - low)
        return Look(firsts[0], firsts[1], sides[0], sides[1], max(EVERY, -(-2 * reach // SAMPLES)))

    @property
    def told(self) -> Prices:
        """Mean occurrences of the pixels of every patch, by coarse position of the search; cached until a write."""
        if self._told is None:
            search, counts = self._search, []
            f, (h, w) = search.factor, search.cells
            for v, valid in enumerate(search.valid):
                counts.append(np.zeros(valid.shape, np.int32))
                if valid.size:
                    rows, columns = self.variants.picture(v).shape[:2]
                    begin = self.pieces.table[v, 0] // self.pieces.channels
                    origin = self.usage.origin[begin : begin + rows * columns].reshape(rows, columns)
                    within = window_sums(block_sums(self.usage.shown[origin], f), (h, w))
                    counts[v][:] = within * self.once // (h * w * f * f)
            self._told = Prices(counts, round(REPEAT * self.stitch.usage * 65536))
        return self._told

    def found(self, boxes: Sequence[Box], run: Run, valid: Sequence[Mask] | None = None) -> list[Candidates]:
        """Return the candidates for disjoint windows of the map as it is.

        `valid`: masks of the first pixels of patches to which the search is restricted; None: all.
        """
        search, told, first = self._search, self.told, self.first
        search = search if valid is None else search.within(valid)
        size = 1 if first else min(search.batch(), -(-len(boxes) // run.workers))
        chunks = [np.array([box[:2] for box in boxes[n : n + size]], np.int64) for n in range(0, len(boxes), size)]

        def some(at: Array) -> list[Candidates]:
            among = search.within(self._allowed(at[0].tolist())) if first else search
            return among.find(self.grown, at, told)

        with run.pool() as each:
            return [candidates for part in each(some, chunks) for candidates in part]

    def _allowed(self, at: Sequence[int]) -> Sequence[Mask]:
        """Return the valid first pixels of patches for a window at `at`: all, or those aligned to the lattice."""
        valid, lattice = self.variants.valid, self.stitch.lattice
        if lattice is None or self.first is None:
            return valid
        place = aligned_place(self._around, self.first, (at[0], at[1]), self.variant.shape)
        return [aligned(v, lattice, place, self.stitch.slack) for v in valid]

    @contextmanager
    def with_holes(self, boxes: Sequence[Box]) -> Iterator[None]:
        """Turn boxes into holes temporarily, locked pixels excepted."""
        holes = [self.index(box) for box in boxes]
        kept = [self.variant[hole].copy() for hole in holes]
        try:
            for hole in holes:
                self.variant[hole] = np.where(self.locked[hole], self.variant[hole], HOLE)
            yield
        finally:
            for hole, variant in zip(holes, kept, strict=True):
                self.variant[hole] = variant

    # ---- cutting

    def cut(self, box: Box, pick: Pick, margin: int, limit: int = NEVER, step: int = 1) -> Cut:
        """Compute the cut of a patch (variant, row, column at the box's first pixel) in a box and its surroundings.

        Nothing is written. Holes are filled inside the box only; around it, up to `margin` px, the patch may replace
        known pixels. A cut that would change the energy by `limit` or more is given up; its change is then ``NEVER``.
        With `step` above 1 every `step`-th pixel is sampled, along both axes (a coarse cut).
        """
        windows, patches = self.windows(box, [pick], margin)
        window, patch = first_of(windows, patches)
        take, best = np.empty([-(-n // step) for n in window[2:]], np.uint8), np.array([limit, -1], np.int64)
        one = np.array([(0, *patch)], np.int64)
        with self._locked_for(window, patch):
            cut_kernels.recut(*self._map, windows, one, self._prices, step, take, best)
        return Cut(NEVER if best[1] else int(best[0]), window, patch, take)

    def expansion_move(self, piece: Piece, reach: int) -> Cut:
        """Return the expansion move of a piece, up to `reach` px around its box.

        A coarse cut comes first; the full cut is limited to the box of the pixels that the coarse one takes, a sampling
        step larger on each side. A change of 0 or more means that the move does not lower the energy.
        """
        rough = self.cut(piece.box, piece.pick, reach, limit=0, step=ROUGH)
        if rough.change >= 0:
            return rough
        taken, ((y, x, *size), (v, row, column)) = np.argwhere(rough.take), (rough.box, rough.pick)
        top, left = (ROUGH * np.maximum(taken.min(axis=0) - 1, 0)).tolist()
        rows, columns = (np.minimum(ROUGH * (taken.max(axis=0) + 2), size) - (top, left)).tolist()
        return self.cut((y + top, x + left, rows, columns), (v, row + top, column + left), 0, limit=0)

    @contextmanager
    def _locked_for(self, window: Box, patch: Pick) -> Iterator[None]:
        """Lock the pixels barred to a patch temporarily."""
        if self.constraint is None:
            yield
            return
        index = self.index(window)
        kept = self.locked[index].copy()
        self.locked[index] = kept | self.constraint(window, patch)
        try:
            yield
        finally:
            self.locked[index] = kept

    def wide(self, box: Box, margin: int) -> Box:
        """Return a box with up to `margin` px around it, within the canvas."""
        out = list(box)
        for axis, (n, length, wrap) in enumerate(zip(box[2:], self.variant.shape, self.wraps, strict=True)):
            before = min(margin, (length - n) // 2 if wrap else box[axis])
            after = before if wrap else min(margin, length - n - box[axis])
            out[axis], out[2 + axis] = box[axis] - before, n + before + after
        return out[0], out[1], out[2], out[3]

    def windows(self, box: Box, picks: Sequence[Pick], margin: int) -> tuple[Array, Array]:
        """Return windows (n, 8) and patches (n, 3) for the kernel ``recut``, one for each pick.

        A window is the box with its surroundings, up to `margin` px, as far as the pick's exemplar extends.
        """
        wide, windows, patches = self.wide(box, margin), list[list[int]](), list[list[int]]()
        for v, *at in picks:
            window, patch, (*size, torus) = [0] * 8, [v, 0, 0], self._sizes[v]
            for k, length in enumerate(self.variant.shape):
                n, before, left = box[2 + k], box[k] - wide[k], size[k] - box[2 + k]
                room = min(before, max(left, 0) // 2 if torus else at[k])  # a torus goes on, up to the whole of it
                beyond = min(wide[2 + k] - n - before, max(left, 0) - room if torus else left - at[k])
                window[k::2], patch[1 + k] = ((box[k] - room) % length, n + room + beyond, room, n), at[k] - room
            windows.append(window)
            patches.append(patch)
        return np.array(windows, np.int64), np.array(patches, np.int64)

    def join(self, window: Window, pick: Pick, found: Candidates) -> None:
        """Cut a patch into a window without changing its surroundings, and write it into the map."""
        cut = self.cut((*self.growth.at(window), *self.growth.layout.patch), pick, 0)
        self.write(cut)
        self.note(cut)

    def index(self, box: Box) -> Any:
        """Return the NumPy index of the pixels of a box, which may reach over borders that wrap."""
        return index_of(*box[:2], box[2:], self.variant.shape)

    def write(self, cut: Cut) -> None:
        """Write a cut into the map and count it; :meth:`note` then updates its seam costs."""
        cut_kernels.write_cut(self.grown, self.pieces, self.usage, cut.box, cut.pick, cut.take)
        self._told = None
        if self.stitch.lattice is not None and self.first is None:
            self.first = cut.pick[1:], cut.box[:2]

    def note(self, cut: Cut) -> None:
        """Update the seam costs in and around the window of a cut."""
        y, x, h, w = cut.box
        self._measure((y - 1, x - 1, h + 1, w + 1))

    def _measure(self, box: Box) -> None:
        energy_kernels.seam_prices(self.grown, self.pieces, box, self.price, self.prices)


def pieces_of(growth: PatchSynthesis, knee: int) -> Pieces:
    """Return the posed exemplars of a map as seam kernels take them, without the channels used in the search only.

    With a `knee`, the threshold of a truncated quadratic cost, differences are weighted by visibility; with 0, equally.
    """
    variants, exemplars, pictures = growth.variants, growth.exemplars, growth.features.pictures
    seen = variants.channels - growth.features.structure
    if seen < variants.channels:
        pictures = tuple(p[..., :seen] for p in pictures)
        variants = variants.showing(pictures)
    usable = variants.laid_out([e.free for e in exemplars]).astype(np.uint8)
    visible = np.full(usable.size, FULL, np.int16)
    if knee:
        visible = variants.laid_out(visibilities(pictures, exemplars, knee))
    return Pieces(*variants.posed, usable, variants.toroidal, seen, visible)
