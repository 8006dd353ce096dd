"""A finished map, of any method, whose windows are covered anew by patches cut in: what all such passes share.

Repair is the plainest of these passes: the worst seams are found, and covered anew.

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

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..analysis.sums import window_sums
from ..arrays import Array, Mask, Pair
from ..canvas import Canvas
from ..exemplar import Exemplars
from ..geometry import ISOMETRIES
from ..guide import Guide
from ..kernels.cuts import SeamPrice
from ..kernels.windows import Grown
from ..lattice.candidates import UNIT
from ..params import Poses, Steps, Weights
from ..patches.growing_map import Pick, picked
from ..patches.growth import Growth, PatchSettings
from ..patches.repetition import best_measured
from ..run import Run
from ..search.candidates import Candidates, Prices, posed_exemplars
from ..search.fourier import PatchSearch
from ..sourcemap import HOLE, SourceMap
from . import recut_kernels
from .graphcut import APART, SHOWN, TRIES, Box, Cut, GraphcutGrowth, GraphcutSettings, middle
from .improve import improve
from .placement_kernels import mark_steps
from .worst import WorstSeams

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

    patch: Pair
    passes: int
    weights: Weights = None
    isometries: Poses = "none"
    distance: int = 0


@dataclass(frozen=True, eq=False)
class Repaired:
    """A map with its worst seams covered: what they cost before and now, and how many patches were laid."""

    map: SourceMap
    before: int
    after: int
    patches: int


def repaired(
    repair: Repair, exemplars: Exemplars, canvas: Canvas, smap: SourceMap, run: Run
) -> Repaired:
    """Cover the worst seams of a finished map, as long as the whole becomes better.

    What the map still shows of `canvas.start` stays, and under `canvas.guide` no pixel follows the guide less well.
    """
    work = Repairing(repair, exemplars, canvas, smap)
    before, patches = work.sewing.total, 0
    for number in range(repair.passes):
        wave = work.worst.apart(work.around)
        if not wave:
            break
        patches += work.cover(wave, run, lambda _: run.tick(number, repair.passes, work.growth.draft))  # noqa: B023
    run.tick(repair.passes, repair.passes, work.growth.draft)
    return Repaired(work.growth.map(smap.blend), before, work.sewing.total, patches)


class Constraints:
    """Says which pixels of a box must not be taken from a patch.

    Parameters
    ----------
    growth : Growth
        The map, with all that it is made from.
    guide : Guide, optional
        Where a patch differs more from it than the map does, the map stays.
    distance : int
        Where a patch would show an exemplar pixel nearer than so many px to another copy of it, the map stays; 0:
        no such rule.
    """

    def __init__(self, growth: Growth, guide: Guide | None, distance: int) -> None:
        self.work, self.variants, self.wraps = growth.growing, growth.variants, growth.layout.wraps
        self.distance, self.guide = distance, guide
        self.any = guide is not None or distance > 0
        self.tallest = max(e.height for e in growth.exemplars)
        self.widest = max(e.width for e in growth.exemplars)

    def __call__(self, box: Box, pick: Pick) -> Array:
        """Return (rows, columns) bool: True where the patch `pick` that begins at the box's first pixel may not be."""
        yx, which = self._patch(box, pick)
        barred = np.zeros(box[2:], bool)
        if self.guide is not None:
            here = self._around(box, 0)
            old = self.variants.to_exemplars(self.work.yx[here], self.work.variant[here])
            barred |= self._off(yx, which, here) > self._off(old[0], old[1], here)
        if self.distance:
            barred |= self._too_near(box, yx, which)
        return barred

    def returns(self, box: Box, pick: Pick, take: Array) -> bool:
        """Say whether what is taken of a patch would now return too near."""
        if not self.distance:
            return False
        return bool((self._too_near(box, *self._patch(box, pick)) & (take > 0)).any())

    def _patch(self, box: Box, pick: Pick) -> tuple[Array, Array]:
        """Exemplar pixels (rows, columns, 2), and exemplars (rows, columns), that a patch shows in a box."""
        size = self.variants.table[pick[0], 1:3]
        yx = np.moveaxis(np.indices(box[2:], np.int32), 0, 2) + np.array(pick[1:], np.int32)
        yx = (yx % size).astype(np.int32)  # beyond an exemplar that does not continue nothing is taken
        grown, which, _ = self.variants.to_exemplars(yx, np.full(box[2:], pick[0], np.uint8))
        return grown, which

    def _around(self, box: Box, px: int) -> tuple[Array, ...]:
        """Index of a box and `px` around it, within the canvas or round it."""
        axes = []
        for at, n, length, wrap in zip(box[:2], box[2:], self.work.variant.shape, self.wraps, strict=True):
            along = np.arange(at - px, at + n + px)
            axes.append(along % length if wrap else along[(along >= 0) & (along < length)])
        return np.ix_(*axes)

    def _off(self, yx: Array, which: Array, here: tuple[Array, ...]) -> Array:
        """How far pixels are from what the guide asks for here: 0 or 1 with labels, else the sum over channels."""
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
        """Where a copy of the pixel, at another place than this, is nearer than the distance."""
        reach = self.distance - 1
        first = [at - reach if wrap else max(at - reach, 0) for at, wrap in zip(box[:2], self.wraps, strict=True)]
        index = self._around(box, reach)
        there, others, _ = self.variants.to_exemplars(self.work.yx[index], self.work.variant[index])
        mine, known = self._keys(yx, which).ravel(), self._keys(there, others).ravel()
        order = np.argsort(known, kind="stable")
        begin, end = (np.searchsorted(known[order], mine, side) for side in ("left", "right"))
        counts = end - begin
        p = np.repeat(np.arange(len(mine)), counts)  # every pair of a pixel of the patch and a copy on the canvas
        q = order[np.arange(len(p)) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(begin, counts)]
        gaps = [a + f - b - at for a, b, f, at in zip(
            np.divmod(q, others.shape[1]), np.divmod(p, which.shape[1]), first, box[:2], strict=True)]  # fmt: skip
        far = gaps[0] ** 2 + gaps[1] ** 2
        out = np.zeros(len(mine), bool)
        out[p[(far > 0) & (far < self.distance**2)]] = True
        return out.reshape(which.shape)

    def _keys(self, yx: Array, which: Array) -> Array:
        """One number for every exemplar pixel; another one for holes."""
        keys = (which.astype(np.int64) * self.tallest + yx[..., 0]) * self.widest + yx[..., 1]
        return np.where(which == HOLE, -1, keys)



CHUNK = 64  # places that are measured before those follow that may not be among the best
SLACK = 1  # px: how far a patch may leave the lattice, whose vectors are fractions


def in_step(growth: Growth, lattice: Steps, at: Pair, shown: Pick) -> Candidates:
    """Return the best patches for the window at `at` that lie whole steps from the one that has `shown` there.

    `lattice`: one vector or two (dx, dy), px of the exemplar. A middle that was made a hole does not count.
    """
    valid, torus = growth.variants.valid[shown[0]], bool(growth.variants.toroidal[shown[0]])
    j = np.array(ISOMETRIES[int(growth.variants.pose[shown[0]])].j, np.int64)
    side = 2 * int(growth.variants.table[shown[0], 1:3].max())
    steps, ends = np.zeros((2, 2), np.int64), np.array([(0, 1), (0, 1)], np.int64)  # of one vector the second is still
    for k, (dx, dy) in enumerate(lattice):
        steps[k] = (round(dy * UNIT), round(dx * UNIT)) @ j
        far = side * UNIT // max(int(np.abs(steps[k]).max()), UNIT) + 1
        ends[k] = -far, far + 1
    there = np.zeros(valid.shape, np.uint8)
    mark_steps(steps, ends, shown[1:], torus, (UNIT, SLACK), valid.view(np.uint8), there)
    places, most, grown = np.flatnonzero(there), growth.settings.listed, growth.growing
    shows = Grown(grown.variant, grown.yx, growth.layout.wraps)
    feats, known = growth.variants.windows(shows, np.array([at], np.int64), growth.finder.patch)
    rows = np.empty((len(places), 4), np.int64)
    rows[:, 1], rows[:, 2], rows[:, 3] = shown[0], *np.divmod(places, valid.shape[1])
    found = Candidates(rows[:0], 0, feats[0], known[0])
    for first in range(0, len(rows), CHUNK):
        best = best_measured(growth.variants, found, rows[first : first + CHUNK], most, found.rows)
        found = replace(found, rows=best)
    return found


REACH = 6  # a patch reaches 1 / REACH of its side around its window
PLAIN = GraphcutSettings()


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

    weights: Weights = None
    isometries: Poses = "none"
    lattice: Steps = ()
    distance: int = 0
    own: bool = False

    def settings(self, exemplars: Exemplars, side: int, listed: int) -> PatchSettings:
        """Windows of so many px a side, with so many candidates."""
        alike = (1.0,) * (exemplars[0].base.channels - exemplars[0].base.alpha)
        weights = self.weights or alike
        return PatchSettings((side, side), (0, 0), weights=weights, isometries=self.isometries, listed=listed)


class Covering:
    """A finished map, and the windows in which patches are cut in.

    What the map still shows of `canvas.start` stays, and under `canvas.guide` no pixel follows the guide less well. No
    exemplar pixel is put nearer to another copy of it than the laying says.
    """

    def __init__(
        self, laying: Laying, settings: PatchSettings, exemplars: Exemplars, canvas: Canvas, smap: SourceMap,
        stitch: GraphcutSettings = PLAIN,
    ) -> None:  # fmt: skip
        overlap = (settings.patch[0] // 4, settings.patch[1] // 4)  # around the middle that is to be covered
        whole = Canvas(canvas.height, canvas.width, canvas.wrap, smap)
        self.growth = Growth(replace(settings, overlap=overlap, rim=1), exemplars, whole, own=laying.own)
        self.growth.growing.locked[:] = False if canvas.start is None else kept(canvas.start, smap)
        self.bars = Constraints(self.growth, canvas.guide, laying.distance)
        self.margin, self.lattice = min(settings.patch) // REACH, laying.lattice
        stitch = replace(stitch, margin=self.margin)
        self.sewing = GraphcutGrowth(self.growth, stitch, self.bars if self.bars.any else None)
        self.worst: WorstSeams  # the windows that are covered
        self.told: Prices | None = None  # what patches cost besides how they fit, by the map before a wave
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

    def sharpen(self, knee: Pair) -> None:
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

    def boxes(self, wave: dict[Pair, Pair]) -> dict[Pair, Box]:
        """The windows of a wave, by the cells that name them."""
        return {cell: (*at, *self.growth.layout.patch) for cell, at in wave.items()}

    def give_up(self, key: Any) -> None:
        """Leave a window until something changes there."""
        self.worst.give_up(key)

    def found(self, sites: list[Any], run: Run) -> list[Candidates]:
        """What fits around the middles of windows."""
        return self.candidates(sites, list(map(middle, sites)), self.told, run)

    def pays(self, cut: Cut) -> bool:
        """Whether a cut may be laid after what the wave has laid before it."""
        return not self.bars.returns(cut.box, cut.pick, cut.take)

    def lay(self, cut: Cut) -> None:
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

    def candidates(self, boxes: list[Box], holes: list[Box], prices: Prices | None, run: Run) -> list[Candidates]:
        """The candidates that fit windows, which do not touch one another, around holes in them.

        On a lattice those whole steps from what is in the middles of the windows; elsewhere prices count, too.
        """
        sewn, search, shown = self.sewing, self.growth.finder, list[Pick]()
        assert isinstance(search, PatchSearch)
        if self.lattice:
            for y, x, h, w in boxes:  # the patch that goes on what is in the middle
                at = (y + h // 2) % sewn.variant.shape[0], (x + w // 2) % sewn.variant.shape[1]
                u, s = (sewn.yx[at] - (h // 2, w // 2)).tolist()
                shown.append((int(sewn.variant[at]), u, s))
            with sewn.opened(holes), run.pool() as each:
                return each(
                    lambda pair: in_step(self.growth, self.lattice, pair[0][:2], pair[1]),
                    zip(boxes, shown, strict=True),
                )
        assert prices is not None
        firsts = np.array([box[:2] for box in boxes], np.int64)
        size = min(search.batch(), -(-len(boxes) // run.workers))
        chunks = [firsts[begin : begin + size] for begin in range(0, len(boxes), size)]
        with sewn.opened(holes, sewn.locked), run.pool() as each:  # what must stay is what patches must fit
            found = each(lambda chunk: search.find(sewn.grown, chunk, prices), chunks)
        return [candidates for part in found for candidates in part]


def kept(start: SourceMap | None, smap: SourceMap) -> Mask:
    """Say which pixels of a map are what it started with, and must stay."""
    if start is None:
        return np.zeros((smap.height, smap.width), bool)
    same = ~start.holes & (start.yx == smap.yx).all(axis=2) & (start.turns == smap.turns)
    return np.asarray(same & (start.numbers == smap.numbers))


class Repairing(Covering):
    """A finished map under repair."""

    def __init__(self, repair: Repair, exemplars: Exemplars, canvas: Canvas, smap: SourceMap) -> None:
        settings = PatchSettings(
            repair.patch, (0, 0), weights=repair.weights, structure=STRUCTURE, courses=COURSES,
            isometries=repair.isometries,
        )  # fmt: skip
        stitch = GraphcutSettings(seam="sharp")
        super().__init__(Laying(distance=repair.distance), settings, exemplars, canvas, smap, stitch)
        self.worst = WorstSeams(self.sewing.prices, self.growth.layout.patch, self.sewing.wraps)

    def cover(self, wave: dict[Pair, Pair], run: Run, tick: Callable[[int], None]) -> int:
        """Cover windows that lie apart; returns how many patches were laid."""
        self.told = self.sewing.search_prices()
        laid = improve(self, self.boxes(wave), run, tick)
        self.worst.renew(*(cut.box for cut in laid))
        return len(laid)

    def lay(self, cut: Cut) -> None:
        """Write a cut into the map and its prices."""
        self.sewing.paste(cut)

    def best(self, site: Box, found: Candidates) -> Cut | None:
        """The best of the candidates and of what lies nearby, if it makes the seams cheaper."""
        picks = self.sewing.shown(site)[: TRIES // SHOWN]
        price = self.sewing.priced(site, found)
        picks += [picked(found, k) for k in np.argsort(price, kind="stable")[: TRIES - len(picks)].tolist()]
        cut = self.sewing.best(site, picks)
        return cut if cut is not None and cut.change < 0 else None
