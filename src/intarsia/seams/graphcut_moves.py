"""The local search over a map: batches of disjoint windows are searched and cut in parallel, then written in turn.

All windows of a batch are searched and cut against the map as it was before the batch; the cuts are then written one
after the other. Therefore the result does not depend on the number of threads.

The cut accounts for the cost of seams placed earlier, so a patch may also replace pixels around its window (Kwatra,
Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003, sections 3 and 4). Departure: in the paper patches
are placed one after the other, and each choice depends on all earlier ones. Here a choice does not depend on the other
windows of its batch, which are too far away to share a seam, so repeats within a batch are not noticed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Array
from ..foundation.run import Run, draw
from ..model.sourcemap import HOLE
from ..patches import Window, window_batches
from .canvas_border import SHARE, border_candidates
from .graphcut_textures import APART, TRIES, Box, Cut, GraphcutMap, Piece, pieces_in

AT_ONCE = 64  # windows that are searched and cut between two reports of progress; limits memory, changes no result
REACH = 2  # patch sides by which an expansion move may extend a piece beyond its bounding box, at most
SMALLEST = 4  # pieces smaller than 1 / SMALLEST of the area of a patch are not expanded


class Move:
    """A kind of move of the local search, tried at sites: windows or pieces, each of which a key names."""

    def __init__(self, sewn: GraphcutMap) -> None:
        self.sewn = sewn

    def found(self, sites: list[Any], run: Run) -> Sequence[Any]:
        """Return proposals for disjoint sites of the map as it is; by default the sites themselves."""
        return sites

    def best(self, site: Any, found: Any) -> Cut | None:
        """Return the best cut among the proposals for a site, None to leave the site as it is; thread-safe."""
        raise NotImplementedError

    def give_up(self, key: Any) -> None:
        """Note that no move was found for a site, so that it may be skipped later."""


def apply_moves(work: Move, wave: Mapping[Any, Any], run: Run, tick: Callable[[int], None]) -> list[Cut]:
    """Apply a batch of moves; return the cuts that were written.

    A cut is written unless :meth:`Move.best` returns None. `tick` is called with the number of sites done.
    """
    sites, cuts, laid = list(wave.values()), list[Cut | None](), list[Cut]()
    for begin in range(0, len(sites), AT_ONCE):
        tick(begin)
        some = sites[begin : begin + AT_ONCE]
        found = work.found(some, run)
        with run.pool() as each:
            cuts += each(lambda pair: work.best(*pair), zip(some, found, strict=True))
    for key, cut in zip(wave, cuts, strict=True):
        if cut is None:
            work.give_up(key)
        else:
            work.sewn.write(cut)
            laid.append(cut)
    with run.pool() as each:
        each(work.sewn.note, laid)
    return laid


class Place(NamedTuple):
    """A window, and the 64 random bits that its placements are drawn by."""

    box: Box
    bits: int


class PlacementMove(Move):
    """Fill windows of the layout by placements drawn by their costs."""

    def __init__(self, sewn: GraphcutMap) -> None:
        super().__init__(sewn)
        self.even = bool(sewn.stitch.evenness) and sewn.stitch.lattice is None and not (sewn.variant < HOLE).any()

    def found(self, sites: list[Any], run: Run) -> Sequence[Any]:
        """Return two sets of candidates for each window: all, and those of :func:`border_candidates`."""
        boxes = [place.box for place in sites]
        ends = border_candidates(self.sewn, boxes, run) if self.even else [None] * len(boxes)
        return list(zip(self.sewn.found(boxes, run), ends, strict=True))

    def best(self, site: Any, found: Any) -> Cut | None:
        """Return the cut of the cheapest of TRIES placements; a third are :func:`border_candidates` if any."""
        anywhere, end = found
        rest = TRIES // SHARE if end else 0
        picks = self.sewn.placements(site.box, anywhere, site.bits, TRIES - rest)
        picks += self.sewn.placements(site.box, end, site.bits + 1, rest) if end else []
        return self.sewn.best(site.box, picks)


def fill(sewn: GraphcutMap, seed: int, stage: int, run: Run, times: int = 0) -> None:
    """Fill the windows of the layout in batches; progress is reported as if `times` equally long rounds followed."""
    growth, work, done = sewn.growth, PlacementMove(sewn), 0
    order: list[list[Window]] = window_batches(growth.layout, growth.windows, sewn.around)
    if sewn.stitch.lattice and sewn.first is None:  # all others are aligned to the first
        order[:1] = [order[0][:1], order[0][1:]] if order else []
    total = sum(map(len, order)) * (1 + times)
    for wave in order:
        boxes = {w: Place((*growth.at(w), *growth.layout.patch), draw(seed, stage, 0, *w)) for w in wave}
        apply_moves(work, boxes, run, lambda begin: run.tick(done + begin, total, growth.draft))  # noqa: B023
        done += len(wave)
    run.tick(done, total, growth.draft)


class ExpansionMove(Move):
    """Expansion moves: a piece is extended over its neighbours where that lowers the energy."""

    def best(self, site: Any, found: Any) -> Cut | None:
        """Return the expansion move of a piece, None where it does not lower the energy."""
        cut = self.sewn.expansion_move(site, self.reach(site))
        return cut if cut.change < 0 else None

    def reach(self, site: Piece) -> int:
        """Return how far beyond its box a piece may be extended, px: 2/3 of its longer side, up to REACH patches.

        At most the margin on a lattice that is stretched around the canvas, as pieces are not stretched.
        """
        most = self.sewn.stitch.margin if self.sewn.stretched else REACH * min(self.sewn.growth.layout.patch)
        return min(most, 2 * max(site.box[2:]) // 3)


def expand(sewn: GraphcutMap, run: Run, times: int, unit: int = 1, before: int = 0) -> list[int]:
    """Try an expansion move of every piece of a map in each of `times` rounds; return what every accepted cut saved.

    The label of a pixel is its placement; a move expands one label (Boykov, Veksler and Zabih 2001) within the
    surroundings of its piece. Pieces are assigned to batches in the order of their size, the largest first. Left out
    are pieces below 1 / SMALLEST of a patch, and those that :meth:`GraphcutMap.apart` rejects. A round counts as `unit`
    steps of progress, after `before` rounds.
    """
    growth, work, saved = sewn.growth, ExpansionMove(sewn), list[int]()
    least, total = math.prod(growth.layout.patch) // SMALLEST, unit * (before + times)
    for number in range(times):
        pieces, done = pieces_in(sewn.variant, sewn.yx, least), 0
        pieces = [piece for piece in pieces if sewn.apart(piece.box, np.array([(0, *piece.pick)]))]
        boxes = [sewn.windows(piece.box, [piece.pick], work.reach(piece))[0][:, :4] for piece in pieces]
        for wave in batches(np.concatenate([np.empty((0, 4), np.int64), *boxes]), sewn.variant.shape, sewn.wraps):
            told = unit * (before + number) + unit * done // len(pieces)
            laid = apply_moves(work, {k: pieces[k] for k in wave}, run, lambda _: run.tick(told, total, growth.draft))  # noqa: B023
            saved += [-cut.change for cut in laid]
            done += len(wave)
    run.tick(total, total, growth.draft)
    return saved


def batches(windows: Array, shape: Sequence[int], wraps: Sequence[bool]) -> list[list[int]]:
    """Assign windows (n, 4) to batches, each to the first batch whose windows are all at least APART px from it."""
    wave = np.zeros(len(windows), np.int64)
    for k, window in enumerate(windows):
        near = np.ones(k, np.bool_)
        for axis, (n, wrap) in enumerate(zip(shape, wraps, strict=True)):
            away = windows[:k, axis] - window[axis]
            mine, theirs = window[2 + axis] + APART, windows[:k, 2 + axis] + APART
            near &= (away % n < mine) | (-away % n < theirs) if wrap else (away < mine) & (-away < theirs)
        taken = set(wave[:k][near].tolist())
        wave[k] = next(n for n in range(k + 1) if n not in taken)
    return [np.flatnonzero(wave == n).tolist() for n in range(int(wave.max(initial=-1)) + 1)]
