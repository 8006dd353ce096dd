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
from ..model.sourcemap import SourceMap
from ..patches import Pick, index_of, picked
from ..patches.patch_synthesis import PatchSettings, PatchSynthesis
from ..search import Candidates
from .graphcut_moves import Move, apply_moves, expand
from .graphcut_textures import TRIES, Box, Constraint, Cut, GraphcutMap, GraphcutSettings
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
    grown : int
        Number of rounds of expansion moves after the passes.
    structure : float
        Weight of outlines in the search, as the ``edge_weight`` of graphcut.
    """

    patch: Pair
    passes: int
    weights: Weights = None
    isometries: Poses = "none"
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


def keeping_guide(growth: PatchSynthesis, guide: Guide) -> Constraint:
    """Return the constraint that the map stays where a patch would differ more from the guide."""
    work, variants = growth.growing, growth.variants

    def off(yx: Array, which: Array, here: Any) -> Array:
        """Return the difference of pixels from the guide: 0 or 1 with labels, else summed over channels."""
        target = guide.target.samples[here]
        out = np.zeros(which.shape, np.float64)
        for number, plane in enumerate(guide.sources):
            mine = which == number
            there = plane.samples[yx[mine, 0], yx[mine, 1]]
            if guide.is_labels:
                out[mine] = (there != target[mine]).any(axis=1)
            else:
                out[mine] = np.abs(there.astype(np.float64) - target[mine]).sum(axis=1)
        return out

    def barred(box: Box, pick: Pick) -> Array:
        """Return (rows, columns) bool: True where patch `pick`, placed at the box's first pixel, may not be taken."""
        size = variants.table[pick[0], 1:3]
        yx = np.moveaxis(np.indices(box[2:], np.int32), 0, 2) + np.array(pick[1:], np.int32)
        yx = (yx % size).astype(np.int32)  # pixels beyond an exemplar that is not toroidal are never taken
        yx, which, _ = variants.to_exemplars(yx, np.full(box[2:], pick[0], np.uint8))
        here = index_of(*box[:2], box[2:], work.variant.shape)
        old, old_which, _ = variants.to_exemplars(work.yx[here], work.variant[here])
        return np.asarray(off(yx, which, here) > off(old, old_which, here))

    return barred


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
    differs more from the guide.
    """

    def __init__(self, repair: Repair, exemplars: Exemplars, canvas: Canvas, smap: SourceMap) -> None:
        settings = PatchSettings(
            repair.patch, (repair.patch[0] // 4, repair.patch[1] // 4), weights=repair.weights,
            structure=repair.structure, isometries=repair.isometries, rim=1,
        )  # fmt: skip
        whole = Canvas(canvas.height, canvas.width, canvas.wrap, smap)
        self.growth = PatchSynthesis(settings, exemplars, whole)
        self.growth.growing.locked[:] = from_start(canvas.start, smap)
        bar = keeping_guide(self.growth, canvas.guide) if canvas.guide else None
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

