"""Seam refinement of finished maps: the worst seams are covered by new patches, cut in by max flow.

A method that fills window by window does not revise earlier patches: where the border of a patch cuts through a stone,
the stone stays cut. Here windows around the most expensive seams are refined, in passes; the windows of a pass do not
overlap. For each window patches are searched that fit the pixels around its middle half; the best is cut in by maximum
flow, with the costs of the old seams inside the window and around it taken into account. The cut is kept only if it
lowers the energy of all seams.

Source: the refinement of Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003, section 4, for
maps of any method, with the additions of the method ``graphcut``: the seam cost ``sharp``, outlines in the search,
nearby pieces as placements, and placements compared by coarse cuts. Departures: nothing is random; a pass refines many
windows, so that threads can share the work.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..foundation.arrays import Array, Mask, Pair
from ..foundation.params import Poses, Weights
from ..foundation.run import Run
from ..model import Exemplars
from ..model.canvas import Canvas, Guide
from ..model.sourcemap import HOLE, SourceMap
from ..patches import Pick, index_of, picked
from ..patches.patch_synthesis import PatchSettings, PatchSynthesis
from ..search import Candidates
from .graphcut_moves import Move, apply_moves, expand
from .graphcut_textures import TRIES, Box, Cut, GraphcutMap, GraphcutSettings
from .worst_seams import WorstSeams


@dataclass(frozen=True)
class Repair:
    """Parameters of a repair.

    Attributes
    ----------
    patch : (rows, columns)
        Size of a window, px.
    passes : int
        How many times the worst seams are found and refined, at most.
    weights, isometries
        As the parameters of the methods: channel weights, isometries of new patches.
    distance : int
        New patches place no exemplar pixel nearer than this to another copy of it, px; 0: no such rule.
    grown : int
        Number of rounds of expansion moves after the passes.
    structure : float
        Weight of outlines in the search, as the ``edge_weight`` of graphcut.
    """

    patch: Pair
    passes: int
    weights: Weights = None
    isometries: Poses = "none"
    distance: int = 0
    grown: int = 0
    structure: float = 1.0


@dataclass(frozen=True, eq=False)
class Repaired:
    """A repaired map: its energy before and after, and the number of patches placed."""

    map: SourceMap
    before: int
    after: int
    patches: int


def repaired(
    repair: Repair, exemplars: Exemplars, canvas: Canvas, smap: SourceMap, run: Run
) -> Repaired:
    """Refine the worst seams of a finished map, then try expansion moves; only what lowers the energy is kept.

    Pixels that the map still shows as `canvas.start` does stay; under `canvas.guide` no pixel is replaced by one that
    differs more from the guide.
    """
    work = SeamRefinement(repair, exemplars, canvas, smap)
    before, patches, total = work.sewn.total, 0, repair.passes + repair.grown
    for number in range(repair.passes):
        wave = work.worst.apart(work.sewn.around)
        if not wave:
            break
        patches += work.cover(wave, run, lambda _: run.tick(number, total, work.growth.draft))  # noqa: B023
    expand(work.sewn, run, repair.grown, 1, repair.passes)
    return Repaired(work.growth.map(smap.blend), before, work.sewn.total, patches)


class Constraints:
    """A function that returns which pixels of a box must not be taken from a patch.

    Parameters
    ----------
    growth : PatchSynthesis
        The map, and the exemplars, features and windows that it is made from.
    guide : Guide, optional
        Where a patch differs more from it than the map does, the map stays.
    distance : int
        Where a patch would show an exemplar pixel nearer than so many px to another copy of it, the map stays; 0:
        no such rule.
    """

    def __init__(self, growth: PatchSynthesis, guide: Guide | None, distance: int) -> None:
        self.work, self.variants = growth.growing, growth.variants
        self.distance, self.guide = distance, guide
        self.side = int(self.variants.table[:, 1:3].max())

    def __call__(self, box: Box, pick: Pick) -> Array:
        """Return (rows, columns) bool: True where patch `pick`, placed at the box's first pixel, may not be taken."""
        size = self.variants.table[pick[0], 1:3]
        yx = np.moveaxis(np.indices(box[2:], np.int32), 0, 2) + np.array(pick[1:], np.int32)
        yx = (yx % size).astype(np.int32)  # pixels beyond an exemplar that is not toroidal are never taken
        yx, which, _ = self.variants.to_exemplars(yx, np.full(box[2:], pick[0], np.uint8))
        barred = np.zeros(box[2:], bool)
        if self.guide is not None:
            here = index_of(*box[:2], box[2:], self.work.variant.shape)
            old = self.variants.to_exemplars(self.work.yx[here], self.work.variant[here])
            barred |= self._off(yx, which, here) > self._off(old[0], old[1], here)
        if self.distance:
            barred |= self._too_near(box, yx, which)
        return barred

    def _off(self, yx: Array, which: Array, here: Any) -> Array:
        """Return the difference of pixels from the guide: 0 or 1 with labels, else summed over channels."""
        assert self.guide is not None
        target = self.guide.target.samples[here]
        out = np.zeros(which.shape, np.float64)
        for number, plane in enumerate(self.guide.sources):
            mine = which == number
            there = plane.samples[yx[mine, 0], yx[mine, 1]]
            if self.guide.is_labels:
                out[mine] = (there != target[mine]).any(axis=1)
            else:
                out[mine] = np.abs(there.astype(np.float64) - target[mine]).sum(axis=1)
        return out

    def _too_near(self, box: Box, yx: Array, which: Array) -> Array:
        """Return where another occurrence of the same exemplar pixel would be nearer than `distance` px (Euclidean)."""
        around, shape = [], self.work.variant.shape
        for at, n, length, wrap in zip(box[:2], box[2:], shape, self.work.wraps, strict=True):
            along = np.arange(at - self.distance + 1, at + n + self.distance - 1)
            around.append(along if wrap else along[(along >= 0) & (along < length)])
        index = np.ix_(*(along % length for along, length in zip(around, shape, strict=True)))
        there, others, _ = self.variants.to_exemplars(self.work.yx[index], self.work.variant[index])
        mine, known = self._keys(yx, which).ravel(), self._keys(there, others).ravel()
        order = np.argsort(known, kind="stable")
        begin, end = (np.searchsorted(known[order], mine, side) for side in ("left", "right"))
        counts = end - begin
        p = np.repeat(np.arange(len(mine)), counts)  # every pair of a pixel of the patch and a copy on the canvas
        q = order[np.arange(len(p)) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(begin, counts)]
        far = np.zeros(len(p), np.int64)
        for along, at, i, k in zip(around, box, np.divmod(p, box[3]), np.divmod(q, len(around[1])), strict=False):
            far += (along[k] - at - i) ** 2
        out = np.zeros(len(mine), bool)
        out[p[(far > 0) & (far < self.distance**2)]] = True
        return out.reshape(which.shape)

    def _keys(self, yx: Array, which: Array) -> Array:
        """Return one number for every exemplar pixel, -1 for holes."""
        keys = (which.astype(np.int64) * self.side + yx[..., 0]) * self.side + yx[..., 1]
        return np.where(which == HOLE, -1, keys)


REACH = 6  # a patch may replace pixels up to 1 / REACH of its shorter side around its window


def from_start(start: SourceMap | None, smap: SourceMap) -> Mask:
    """Return which pixels of a map are those of the start map, and must stay: (H, W) bool."""
    if start is None:
        return np.zeros((smap.height, smap.width), bool)
    same = ~start.holes & (start.yx == smap.yx).all(axis=2) & (start.turns == smap.turns)
    return np.asarray(same & (start.numbers == smap.numbers))


def middle(box: Box) -> Box:
    """Return the middle of a window, half as high and wide."""
    y, x, h, w = box
    return y + h // 4, x + w // 4, h // 2, w // 2


class SeamRefinement(Move):
    """A finished map under repair.

    Pixels that the map still shows as `canvas.start` does stay; under `canvas.guide` no pixel is replaced by one that
    differs more from the guide. No new patch places an exemplar pixel nearer to a copy of it than `repair.distance`.
    """

    def __init__(self, repair: Repair, exemplars: Exemplars, canvas: Canvas, smap: SourceMap) -> None:
        settings = PatchSettings(
            repair.patch, (repair.patch[0] // 4, repair.patch[1] // 4), weights=repair.weights,
            structure=repair.structure, isometries=repair.isometries, rim=1,
        )  # fmt: skip
        whole = Canvas(canvas.height, canvas.width, canvas.wrap, smap)
        self.growth = PatchSynthesis(settings, exemplars, whole)
        self.growth.growing.locked[:] = from_start(canvas.start, smap)
        bar = Constraints(self.growth, canvas.guide, repair.distance) if canvas.guide or repair.distance else None
        stitch = GraphcutSettings(seam="sharp", margin=min(repair.patch) // REACH)
        super().__init__(GraphcutMap(self.growth, stitch, bar))
        self.worst = WorstSeams(self.sewn.prices, self.growth.layout.patch, self.sewn.wraps)

    def cover(self, wave: dict[Pair, Pair], run: Run, tick: Callable[[int], None]) -> int:
        """Refine disjoint windows; return the number of patches placed."""
        laid = apply_moves(self, {cell: (*at, *self.growth.layout.patch) for cell, at in wave.items()}, run, tick)
        self.worst.renew(*(cut.box for cut in laid))
        return len(laid)

    def found(self, sites: list[Any], run: Run) -> list[Candidates]:
        """Return the candidates that fit around the middles of windows."""
        with self.sewn.with_holes(list(map(middle, sites))):  # the search compares the pixels around the middles
            return self.sewn.found(sites, run)

    def best(self, site: Box, found: Candidates) -> Cut | None:
        """Return the best cut of the candidates and of the pieces nearby, None where none lowers the energy."""
        picks = self.sewn.shown(site)
        price = self.sewn.priced(site, found)
        picks += [picked(found, k) for k in np.argsort(price, kind="stable")[: TRIES - len(picks)].tolist()]
        cut = self.sewn.best(site, picks)
        return cut if cut is not None and cut.change < 0 else None

    def give_up(self, key: Pair) -> None:
        """Skip a window until something changes there."""
        self.worst.give_up(key)

