"""The local search over a map: batches of disjoint windows are searched and cut in parallel, then written in turn.

The windows of a wave are searched and cut by the map as it was before; what was cut is then laid in turn, where it
still pays after what the wave laid before. So threads share a wave, and change no byte.

A patch is cut in with old seams remembered, so it may replace what lies around its window as well (Kwatra, Schoedl,
Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003, sections 3 and 4). Departure: there one patch follows
another, each chosen by what all before it show; here only repeats of the same wave are not seen.
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

AT_ONCE = 64  # windows of a wave that are searched for and cut before progress is told; what they hold is dropped then
REACH = 2  # patches that a large piece may grow around the box that it lies in
SMALLEST = 4  # pieces below 1 / SMALLEST of a patch grow no more


class Move:
    """One kind of move at the sites of a map, each of which a key names."""

    def __init__(self, sewn: GraphcutMap) -> None:
        self.sewn = sewn

    def found(self, sites: list[Any], run: Run) -> Sequence[Any]:
        """Return proposals for disjoint sites by the map as it is; the sites themselves where none are searched."""
        return sites

    def best(self, site: Any, found: Any) -> Cut | None:
        """Return the best cut of what was found, None where none pays; thread-safe."""
        raise NotImplementedError

    def give_up(self, key: Any) -> None:
        """Skip a site at which nothing pays."""


def apply_moves(work: Move, wave: Mapping[Any, Any], run: Run, tick: Callable[[int], None]) -> list[Cut]:
    """Apply a batch of moves that pay; return the cuts that were written. `tick` gets the number of sites done."""
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
        elif work.sewn.pays(cut):
            work.sewn.write(cut)
            laid.append(cut)
    with run.pool() as each:
        each(work.sewn.note, laid)
    return laid


class Place(NamedTuple):
    """A window, and the random bits for its placement."""

    box: Box
    bits: int


class PlacementMove(Move):
    """Fill empty windows by placements drawn among those that fit."""

    def __init__(self, sewn: GraphcutMap) -> None:
        super().__init__(sewn)
        self.even = bool(sewn.stitch.evenness) and sewn.stitch.lattice is None and not (sewn.variant < HOLE).any()

    def found(self, sites: list[Any], run: Run) -> Sequence[Any]:
        """Return the candidates of each window, and those that end at the exemplar's border where the canvas ends."""
        boxes = [place.box for place in sites]
        ends = border_candidates(self.sewn, boxes, run) if self.even else [None] * len(boxes)
        return list(zip(self.sewn.found(boxes, run), ends, strict=True))

    def best(self, site: Any, found: Any) -> Cut | None:
        """Return the cheapest cut of the placements drawn."""
        anywhere, end = found
        rest = TRIES // SHARE if end else 0
        picks = self.sewn.placements(site.box, anywhere, site.bits, TRIES - rest)
        picks += self.sewn.placements(site.box, end, site.bits + 1, rest) if end else []
        return self.sewn.best(site.box, picks)


def fill(sewn: GraphcutMap, seed: int, stage: int, run: Run, times: int = 0) -> None:
    """Fill the windows of the layout in batches; progress allows for `times` rounds of expansion moves after that."""
    growth, work, done = sewn.growth, PlacementMove(sewn), 0
    order: list[list[Window]] = window_batches(growth.layout, growth.windows, sewn.around)
    if sewn.stitch.lattice and sewn.first is None:  # all others lie in step with the first
        order[:1] = [order[0][:1], order[0][1:]] if order else []
    total = sum(map(len, order)) * (1 + times)
    for wave in order:
        boxes = {w: Place((*growth.at(w), *growth.layout.patch), draw(seed, stage, 0, *w)) for w in wave}
        apply_moves(work, boxes, run, lambda begin: run.tick(done + begin, total, growth.draft))  # noqa: B023
        done += len(wave)
    run.tick(done, total, growth.draft)


class ExpansionMove(Move):
    """Expansion moves: pieces grow over their neighbours."""

    def best(self, site: Any, found: Any) -> Cut | None:
        """Return the expansion move of a piece, None where it does not lower the energy."""
        cut = self.sewn.expansion_move(site, self.reach(site))
        return cut if cut.change < 0 else None

    def reach(self, site: Piece) -> int:
        """Return how far around its box a piece may grow, px: two thirds of its length, up to REACH patches.

        The margin alone on a lattice that is stretched around a canvas, as pieces are not stretched.
        """
        most = self.sewn.stitch.margin if self.sewn.stretched else REACH * min(self.sewn.growth.layout.patch)
        return min(most, 2 * max(site.box[2:]) // 3)


def expand(sewn: GraphcutMap, run: Run, times: int, unit: int = 1, before: int = 0) -> list[int]:
    """Try an expansion move of every piece of a map `times` times; return what every accepted cut saved.

    An expansion move of each label (Boykov, Veksler and Zabih 2001), kept to what lies around it; largest pieces first
    as far as a batch has room. Each round counts as `unit` steps of progress, after `before` units.
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
    """Assign windows (n, 4) to batches, each to the first in which no window is so near that either reads the other."""
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
