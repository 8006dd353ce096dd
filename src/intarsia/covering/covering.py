"""A finished map, of any method, whose windows are covered anew by patches cut in: what all such passes share."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.sums import window_sums
from ..canvas import Canvas
from ..exemplar import Exemplar
from ..kernels.cuts import SeamPrice
from ..patches.growth import Growth
from ..patches.settings import PatchSettings
from ..run import Run
from ..seams import recut_kernels
from ..seams.graphcut import Box, Cut, GraphcutGrowth, GraphcutSettings
from ..search.candidates import Candidates, Prices
from ..search.fourier import PatchSearch
from ..search.posed import posed_exemplars
from ..sourcemap import SourceMap
from .constraints import Constraints
from .lattice_steps import Lattice, in_step

Array = NDArray[Any]

REACH = 6  # a patch reaches 1 / REACH of its side around its window
PLAIN = GraphcutSettings()
AT_ONCE = 64  # windows of a wave that are searched for and cut before progress is told; what they hold is dropped then
APART = 3  # px between the boxes of two windows: what a cut reads and changes is its own


@dataclass(frozen=True)
class Laying:
    """How new patches are laid over a finished map.

    Attributes
    ----------
    weights : tuple of float, optional
        As `channel_weights` of methods; None: all alike, as a step of hue inside an element is seen, however light.
    isometries
        Poses of new patches.
    lattice : vectors (dx, dy), px
        Patches are shifted by whole steps of these; none: by anything.
    distance : int
        No exemplar pixel is put so near to another copy of it, px; 0: no such rule.
    own : bool
        The map is nobody else's, and may be used up: its pixels are laid over in place.
    """

    weights: tuple[float, ...] | None = None
    isometries: str | tuple[int, ...] = "none"
    lattice: Lattice = ()
    distance: int = 0
    own: bool = False

    def settings(self, exemplars: Sequence[Exemplar], side: int, listed: int) -> PatchSettings:
        """Windows of so many px a side, with so many candidates."""
        alike = (1.0,) * (exemplars[0].base.channels - exemplars[0].base.alpha)
        weights = self.weights or alike
        return PatchSettings((side, side), (0, 0), weights=weights, isometries=self.isometries, listed=listed)


class Covering:
    """A finished map, and the windows in which patches are cut in.

    What the map still shows of `canvas.start` stays, and under `canvas.guide` no pixel follows the guide less well. No
    exemplar pixel is put nearer to another copy of it than `distance` px; 0: no such rule.
    """

    def __init__(
        self, settings: PatchSettings, exemplars: Sequence[Exemplar], canvas: Canvas, smap: SourceMap,
        distance: int, stitch: GraphcutSettings = PLAIN, own: bool = False,
    ) -> None:  # fmt: skip
        overlap = (settings.patch[0] // 4, settings.patch[1] // 4)  # around the middle that is to be covered
        whole = Canvas(canvas.height, canvas.width, canvas.wrap, smap)
        self.growth = Growth(replace(settings, overlap=overlap, rim=1), exemplars, whole, own=own)
        self.growth.growing.locked[:] = False if canvas.start is None else kept(canvas.start, smap)
        self.bars = Constraints(self.growth, canvas.guide, distance)
        self.margin = min(settings.patch) // REACH
        stitch = replace(stitch, margin=self.margin)
        self.sewing = GraphcutGrowth(self.growth, stitch, self.bars if self.bars.any else None)
        self._plain, self._unpriced = self.sewing.price, list[Box]()
        self._spread = math.isqrt(self.growth.variance(seen=True))

    @property
    def side(self) -> int:
        """Of windows, px."""
        return min(self.growth.layout.patch)

    @property
    def around(self) -> int:
        """How far apart the windows of a pass are, px."""
        return 2 * self.margin + APART

    def resize(self, side: int) -> None:
        """Take windows of so many px a side from now on; the map stays as it is."""
        growth = copy.copy(self.growth)
        patch, overlap, poses = (side, side), side // 4, growth.settings.poses(growth.canvas.guide)
        growth.settings = replace(growth.settings, patch=patch, overlap=(overlap, overlap))
        growth.layout = replace(growth.layout, patch=patch)
        begun = () if growth.canvas.start is None else growth.canvas.start.poses
        growth.variants = posed_exemplars(growth.exemplars, growth.features, poses, patch, begun)
        growth.finder = PatchSearch(growth.variants, patch, overlap, listed=growth.settings.listed)
        self.growth, self.margin = growth, side // REACH

    def sharpen(self, knee: tuple[int, int]) -> None:
        """Count a seam by its square up to four times what the seams of this map cost on average.

        That average counts as at least, and at most, so many % of the spread of colours. The prices of the map stay
        those of plain differences.
        """
        sewn, spread = self.sewing, self._spread
        sewn.price = self._plain
        for box in self._unpriced:
            sewn.note(box)
        self._unpriced.clear()
        usual = sewn.total // max(int(np.count_nonzero(sewn.prices)), 1)
        least, most = (max(spread * part // 100, 1) for part in knee)
        sewn.price = SeamPrice(knee=min(max(usual, least), most))

    def paste(self, cut: Cut) -> None:
        """Write a cut into the map; its seams are priced when an average is asked for again."""
        recut_kernels.write_cut(self.sewing.grown, self.sewing.pieces, cut.box, cut.pick, cut.take)
        y, x, h, w = cut.box
        self._unpriced.append((y - 1, x - 1, h + 1, w + 1))

    def over_patches(self, values: Sequence[Array], rim: int = 4) -> list[Array]:
        """Of what counts for each pixel of each variant: means over every patch less 1 / rim of it on each side."""
        search = self.growth.finder
        assert isinstance(search, PatchSearch)
        f, (h, w) = search.factor, search.cells
        a, b = (h * f // rim, w * f // rim) if rim else (0, 0)
        size, means = (h * f - 2 * a, w * f - 2 * b), []
        for valid, shown in zip(search.valid, values, strict=True):
            rows, columns = valid.shape
            short = [(0, max((n + c - 1) * f - m, 0)) for n, c, m in zip(valid.shape, (h, w), shown.shape, strict=True)]
            sums = window_sums(np.pad(shown, short, "edge")[a:, b:], size)[::f, ::f][:rows, :columns]
            means.append(np.minimum(2 * sums // (size[0] * size[1]), 1 << 20).astype(np.int32))
        return means

    def stepped(
        self, boxes: list[Box], holes: list[Box], lattice: Lattice, listed: int, run: Run
    ) -> list[Candidates]:
        """The same that lie whole steps of a lattice from what is in the middles of windows."""
        sewn, shown = self.sewing, []
        for y, x, h, w in boxes:  # the patch that goes on what is in the middle
            at = (y + h // 2) % sewn.variant.shape[0], (x + w // 2) % sewn.variant.shape[1]
            u, s = (sewn.yx[at] - (h // 2, w // 2)).tolist()
            shown.append((int(sewn.variant[at]), u, s))
        with sewn.opened(holes), run.pool() as each:
            return each(
                lambda pair: in_step(self.growth, lattice, pair[0][:2], pair[1], listed), zip(boxes, shown, strict=True)
            )

    def found(self, boxes: list[Box], holes: list[Box], prices: Prices, run: Run) -> list[Candidates]:
        """The candidates that fit windows, which do not touch one another, around holes in them."""
        sewn, search = self.sewing, self.growth.finder
        assert isinstance(search, PatchSearch)
        at = np.array([box[:2] for box in boxes], np.int64)
        size = min(search.batch(), -(-len(boxes) // run.workers))
        chunks = [at[begin : begin + size] for begin in range(0, len(boxes), size)]
        with sewn.opened(holes, sewn.locked), run.pool() as each:  # what must stay is what patches must fit
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
