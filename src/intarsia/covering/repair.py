"""The worst seams of a finished map, found and covered anew, whatever method made it.

A method that fills window by window never looks back: its errors stay, and where the border of a patch cuts through a
stone, the stone stays cut. Here the dearest places are taken first, in passes; the windows of a pass lie apart. A patch
is sought that fits the pixels around the middle of such a window, and is cut in by maximum flow, in which the old seams
inside the window and around it are remembered. It stays only where all seams together become cheaper by it.

Source: the refinement of Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003, section 4, for
maps of any method, as ``graphcut`` does it: the price ``sharp``, outlines in the search, pieces nearby that may grow,
and placements compared by rough cuts. Departures: nothing is drawn; a pass covers many places, so that threads share
the work.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..canvas import Canvas
from ..exemplar import Exemplar
from ..patches.settings import PatchSettings
from ..run import Run
from ..seams.graphcut import SHOWN, TRIES, Box, Cut, GraphcutSettings, middle
from ..seams.worst import Cell, WorstSeams
from ..search.candidates import Candidates
from ..sourcemap import SourceMap
from .covering import Covering

STRUCTURE, COURSES = 1.0, 0.7  # weights of outlines and of courses in the search, as of graphcut


@dataclass(frozen=True)
class Repair:
    """How a map is repaired.

    Attributes
    ----------
    patch : (rows, columns)
        Of a window, px.
    passes : int
        How often the worst places are looked for.
    weights, isometries
        As the parameters of the methods: channel weights, poses of new patches.
    distance : int
        No exemplar pixel is put so near to another copy of it, px; 0: no such rule.
    """

    patch: tuple[int, int]
    passes: int
    weights: tuple[float, ...] | None = None
    isometries: str | tuple[int, ...] = "none"
    distance: int = 0


@dataclass(frozen=True, eq=False)
class Repaired:
    """A map with its worst seams covered: what they cost before and now, and how many patches were laid."""

    map: SourceMap
    before: int
    after: int
    patches: int


def repaired(
    repair: Repair, exemplars: Sequence[Exemplar], canvas: Canvas, smap: SourceMap, run: Run
) -> Repaired:
    """Cover the worst seams of a finished map, as long as the whole becomes better.

    What the map still shows of `canvas.start` stays, and under `canvas.guide` no pixel follows the guide less well.
    """
    work = Repairing(repair, exemplars, canvas, smap)
    before, patches = work.sewing.total, 0
    for number in range(repair.passes):
        run.tick(number, repair.passes, work.growth.draft)
        wave = work.worst.apart(work.around)
        if not wave:
            break
        patches += work.cover(wave, run)
    run.tick(repair.passes, repair.passes, work.growth.draft)
    return Repaired(work.growth.map(smap.blend), before, work.sewing.total, patches)


class Repairing(Covering):
    """A finished map under repair."""

    def __init__(self, repair: Repair, exemplars: Sequence[Exemplar], canvas: Canvas, smap: SourceMap) -> None:
        settings = PatchSettings(
            repair.patch, (0, 0), weights=repair.weights, structure=STRUCTURE, courses=COURSES,
            isometries=repair.isometries,
        )  # fmt: skip
        stitch = GraphcutSettings(seam="sharp")
        super().__init__(settings, exemplars, canvas, smap, repair.distance, stitch)
        self.worst = WorstSeams(self.sewing.prices, self.growth.layout.patch, self.sewing.wraps)

    def cover(self, wave: dict[Cell, tuple[int, int]], run: Run) -> int:
        """Cover windows that lie apart; returns how many patches were laid."""
        boxes = [(*at, *self.growth.layout.patch) for at in wave.values()]
        found = self.found(boxes, list(map(middle, boxes)), self.sewing.search_prices(), run)
        with run.pool() as each:
            cuts = each(lambda pair: self._best(*pair), zip(boxes, found, strict=True))
        laid: list[Cut] = []
        for cell, cut in zip(wave, cuts, strict=True):
            if cut is None:
                self.worst.give_up(cell)
            elif not self.bars.returns(cut.box, cut.pick, cut.take):  # what this pass laid before counts, too
                self.sewing.paste(cut)
                laid.append(cut)
        self.worst.renew(*(cut.box for cut in laid))
        return len(laid)

    def _best(self, box: Box, found: Candidates) -> Cut | None:
        """The best of the candidates and of what lies nearby, if it makes the seams cheaper."""
        picks = self.sewing.shown(box)[: TRIES // SHOWN]
        price = self.sewing.priced(box, found)
        for k in np.argsort(price, kind="stable")[: TRIES - len(picks)].tolist():
            _, variant, u, s = found.rows[k].tolist()
            picks.append((variant, u, s))
        cut = self.sewing.best(box, picks)
        return cut if cut is not None and cut.change < 0 else None
