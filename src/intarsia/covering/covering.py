"""A finished map, of any method, whose windows are covered anew by patches cut in: what all such passes share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..exemplar import Exemplar
from ..patches.growth import Growth
from ..patches.settings import PatchSettings
from ..run import Run
from ..seams.graphcut import Box, GraphcutGrowth, GraphcutSettings
from ..search.candidates import Candidates, Prices
from ..search.fourier import PatchSearch
from ..sourcemap import SourceMap
from .constraints import Constraints

Array = NDArray[Any]

REACH = 6  # a patch reaches 1 / REACH of its side around its window
APART = 3  # px between the boxes of two windows: what a cut reads and changes is its own


class Covering:
    """A finished map, and the windows in which patches are cut in.

    What the map still shows of `canvas.start` stays, and under `canvas.guide` no pixel follows the guide less well. No
    exemplar pixel is put nearer to another copy of it than `distance` px; 0: no such rule.
    """

    def __init__(
        self, settings: PatchSettings, exemplars: Sequence[Exemplar], canvas: Canvas, smap: SourceMap,
        distance: int,
    ) -> None:  # fmt: skip
        overlap = (settings.patch[0] // 4, settings.patch[1] // 4)  # around the middle that is to be covered
        whole = Canvas(canvas.height, canvas.width, canvas.wrap, smap)
        self.growth = Growth(replace(settings, overlap=overlap, rim=1), exemplars, whole)
        self.growth.growing.locked[:] = kept(canvas.start, smap)
        self.bars = Constraints(self.growth, canvas.guide, distance)
        self.margin = min(settings.patch) // REACH
        stitch = GraphcutSettings(margin=self.margin)
        self.sewing = GraphcutGrowth(self.growth, stitch, self.bars if self.bars.any else None)

    @property
    def around(self) -> int:
        """How far apart the windows of a pass are, px."""
        return 2 * self.margin + APART

    def found(self, boxes: list[Box], prices: Prices, run: Run) -> list[Candidates]:
        """The candidates that fit around the middles of windows, which do not touch one another."""
        sewn, search = self.sewing, self.growth.finder
        assert isinstance(search, PatchSearch)
        at = np.array([box[:2] for box in boxes], np.int64)
        size = min(search.batch(), -(-len(boxes) // run.workers))
        chunks = [at[begin : begin + size] for begin in range(0, len(boxes), size)]
        with sewn.opened(boxes), run.pool() as each:
            found = each(lambda chunk: search.find(sewn.variant, sewn.yx, chunk, sewn.wraps, prices), chunks)
        return [candidates for part in found for candidates in part]


def kept(start: SourceMap | None, smap: SourceMap) -> NDArray[np.bool_]:
    """Say which pixels of a map are what it started with, and must stay."""
    if start is None:
        return np.zeros((smap.height, smap.width), bool)
    same = ~start.holes & (start.yx == smap.yx).all(axis=2)
    for mine, other in ((start.which, smap.which), (start.pose, smap.pose)):
        same &= np.equal(0 if mine is None else mine, 0 if other is None else other)
    return np.asarray(same)
