"""What strikes and returns in a finished map, whatever method made it, is covered by what was shown less.

The map costs what its seams cost, and for each pixel what its repeats look like: the number of copies of it, as a share
of what would be if all of the exemplar were used alike, times how much it strikes (`analysis/popout.py`). A copy with
the same around it counts more, and one close by most. The dearest windows are taken in waves; a patch that fits around
such a window and is shown less is cut in by maximum flow, in which every pixel that stays pays what its repeats cost:
so the cut takes what returns, and leaves the rest. It stays where the repeats saved are more than what seams cost more.

The windows of a wave are cut at the same time, by the map as it was; then each is judged again in turn, by the map as
it has become. So threads change nothing, and no new patch is laid twice because two windows liked it.

Source: seams and cut of Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003; that pixels which
are used too often are dear is the thought of Kaspar, Neubert, Lischinski, Pauly and Kopf, "Self Tuning Texture
Optimization", Eurographics 2015. What a repeat costs is this project's own.
"""

from __future__ import annotations

import math

import numpy as np

from ..analysis.features import Features
from ..analysis.popout import popout
from ..analysis.sums import spreads
from ..arrays import Array, UInt8
from ..canvas import Canvas
from ..corrections import stack
from ..exemplar import Exemplar, Exemplars, sampled
from ..geometry import ISOMETRIES
from ..patches.growing_map import Pick, picked
from ..run import Run
from ..search import sizes
from ..search.candidates import Candidates, PosedExemplars, Prices
from ..sourcemap import SourceMap
from . import copies_kernels
from .copies_kernels import FINE, STEP, Copies, Origins, Repeats, Terms
from .covering import Covering, Laying
from .graphcut import Box, Cut, laid_out
from .improve import improve
from .worst import WorstSeams

FLOOR = 31  # of 256: what a repeat of the plainest pixel costs; without it all but what strikes is repeated
PLAIN, STEEP = 307, 2  # of 256: what strikes less than this strikes not at all; half of what it strikes more counts,
MOST = 384  # up to so much


def origins_of(
    variants: PosedExemplars, usable: UInt8, feats: Features, exemplars: Exemplars
) -> Origins:
    """Say of every pixel of the variants which exemplar pixel it is; of these, the cell and how much they strike.

    `usable` (pixels of all variants,): which may be shown.
    """
    numbers, place, cell, weight, begin, cells = [], [], [], [], 0, 0
    for number, e in enumerate(exemplars):
        numbers.append(begin + np.arange(e.height * e.width).reshape(e.height, e.width))
        place.append(np.moveaxis(np.indices((e.height, e.width), np.int32), 0, 2).reshape(-1, 2))
        wide = -(-e.width // STEP)
        cell.append((np.arange(e.height)[:, None] // STEP * wide + np.arange(e.width) // STEP + cells).ravel())
        weight.append(strikes(feats, number, e).ravel())
        begin, cells = begin + e.height * e.width, cells + wide * -(-e.height // STEP)
    pixels, frames = laid_out(variants, numbers).astype(np.int32), variants.table.copy()
    frames[:, 0] //= variants.channels
    return Origins(
        pixels, np.where(usable, pixels, np.int32(-1)), frames, variants.toroidal,
        np.array([np.array(ISOMETRIES[p].j).ravel() for p in variants.pose.tolist()], np.int64), variants.pose,
        np.concatenate(place), np.concatenate(cell).astype(np.int32), np.concatenate(weight),
    )  # fmt: skip


def strikes(feats: Features, number: int, exemplar: Exemplar) -> Array:
    """How much a repeat of each pixel of an exemplar is seen, (H, W) int32, 256 = usual; measured once."""

    def measured() -> Array:
        found = popout(feats.pictures[number][:, :, : feats.base], exemplar.usable, exemplar.toroidal)
        return (FLOOR + np.clip((found - PLAIN) // STEEP, 0, MOST)).astype(np.int32)

    return feats.memo(("strikes", number), measured)


def around(px: int, width: int) -> Array:
    """Eight places around a pixel in each pose, as they lie around a copy of it in each: (8, 8, 8, 3).

    As rows, columns, and pixels of a canvas so wide.
    """
    slant = px * 181 // 256
    straight = (px, 0), (-px, 0), (0, px), (0, -px)
    places = np.array([*straight, (slant, slant), (slant, -slant), (-slant, slant), (-slant, -slant)])
    steps = [np.array(isometry.j) for isometry in ISOMETRIES]  # orthogonal: their transposes lead back
    away = np.array([[places @ a.T @ b for b in steps] for a in steps], np.int64)
    return np.concatenate([away, away[..., :1] * width + away[..., 1:]], axis=3)


def no_copies(shape: tuple[int, ...], tile: int, cells: int) -> Copies:
    """Empty lists of copies, in tiles of at least so many px that cover a canvas evenly."""
    counts = [max(n // tile, 1) for n in shape]
    tiles = [-(-n // c) for n, c in zip(shape, counts, strict=True)]
    samples = math.prod(-(-n // STEP) for n in shape)
    return Copies(
        np.full(shape, -1, np.int32), np.full((cells, math.prod(counts)), -1, np.int32),
        np.full(samples, -1, np.int32), np.full(samples, -1, np.int32), np.zeros((samples, 5), np.int32),
        np.zeros(cells, np.int32), np.array([*counts, *tiles], np.int64),
    )  # fmt: skip


# What is weighed how: chosen by eye, and by how often what graders named is shown, on 32 textures:
WINDOWS = ((3, 2), (3, 2), (4, 5), (4, 5))  # side of each wave's, in elements
LEAST = 32  # px, of a window: smaller ones hold no element
LISTED = 12  # candidates of a window
TRIES = 2  # of which are cut in; with 1 a quarter to a half more arrangements return, for 0.8 of the time
UNIT = 16  # tenths of the spread of colours that a whole copy costs at price 1
SPARE = 64  # of 256: so much of its share costs a pixel nothing; at 0 what is rare vanishes
NEAR = 192  # of 256: how much dearer a copy beside itself is; at 0 copies move together
REACH = 60  # % of the exemplar's shorter side: from there on nearness does not count
AROUND = 75  # % of an element: where the surroundings of two copies are compared
TILE = 80  # % of the exemplar's shorter side: copies are looked at in 3 x 3 such tiles
KNEE = (25, 125)  # %: the usual seam counts as at least, at most so much of the spread of colours
TAPER = 35  # % of a window: at its edge nothing is saved; without it cuts run straight along the edge
GAIN = 2  # % of what a patch covers must be saved
DEAR = 50  # % of the mean: windows that cost less are left
ROWS = 256  # of the canvas, a multiple of a block's: so many are priced together, so nothing large is held besides


def spread_out(
    price: float, laying: Laying, exemplars: Exemplars, canvas: Canvas, smap: SourceMap, run: Run
) -> SourceMap:
    """Return a finished map in which what strikes returns less; the same map where nothing can be gained.

    `price`: of repeats, against that of seams.

    Clouds stay, whose steps of tone a patch more would add to, pictures that hold less than one and a half times what
    the exemplars do, and what is too small for a window. What the map still shows of `canvas.start` stays, and under
    `canvas.guide` no pixel follows the guide less well.
    """
    shown = sampled(exemplars)
    sides, work = wave_sides(shown, smap), None
    few = 2 * smap.height * smap.width < 3 * sum(e.height * e.width for e in shown)
    if few or not sides or any(stack.is_cloudy(e) for e in shown):
        run.tick(1, 1)
        return smap
    for number, side in enumerate(sides):
        work = work or Spreading(price, laying, exemplars, canvas, smap, side)
        work.resize(side)
        run.tick(number, len(sides), work.growth.draft)
        work.wave(run.part(number, len(sides)))
    assert work is not None
    run.tick(len(sides), len(sides), work.growth.draft)
    return work.growth.map(smap.blend)


def wave_sides(exemplars: Exemplars, smap: SourceMap) -> list[int]:
    """The windows' sides of all waves, px; none where exemplars or map are too small."""
    shorter = min(smap.height, smap.width, *(min(e.height, e.width) for e in exemplars))
    size, found = _element(exemplars), []
    for above, below in WINDOWS:
        side = min(max(size * above // below // 8 * 8, LEAST), shorter // 2 // 8 * 8)
        if side >= LEAST and sizes.supplied(exemplars, side, side) == side:
            found.append(side)
    return found


def _element(exemplars: Exemplars) -> int:
    shorter = min(min(e.height, e.width) for e in exemplars)
    return min(max(max(round(sizes.elements(e).size) for e in exemplars), 16), max(shorter // 3, 16))


class Spreading(Covering):
    """A finished map whose repeats are spread, by windows of one size at a time, the largest first."""

    def __init__(
        self, price: float, laying: Laying, exemplars: Exemplars, canvas: Canvas, smap: SourceMap, side: int
    ) -> None:
        settings = laying.settings(exemplars, side, LISTED)
        super().__init__(laying, settings, exemplars, canvas, smap)
        shown = sampled(exemplars)
        sewn, element = self.sewing, _element(shown)
        self._shorter = min(min(e.height, e.width) for e in shown)
        self.origins = origins_of(self.growth.variants, sewn.pieces.usable, self.growth.features, exemplars)
        pixels = sum(int(e.free.sum()) for e in shown)
        self.share = max(256 * sewn.variant.size // pixels, 256)  # of 256: copies of each pixel if all were used alike
        base = self.growth.features.base
        colours = self.growth.features.pictures[0][:, :, :base].reshape(-1, base)
        wide = sum(math.isqrt(s // len(colours) ** 2) for s in spreads(colours))
        unit = round(price * 256) * UNIT * wide * FINE * 256 // (10 * element * self.share)
        beside = around(max(element * AROUND // 100, STEP), sewn.variant.shape[1])
        spare, near = (part * self.share // 256 for part in (SPARE, NEAR))
        self.terms = Terms(unit, spare, near, max(self._shorter * REACH // 100, 1), beside)
        self._field = np.zeros((*sewn.variant.shape, 1), np.int32)
        self._size()

    def resize(self, side: int) -> None:
        """Take windows of so many px a side from now on."""
        if side != self.side:
            super().resize(side)
            self._size()

    def _size(self) -> None:
        """List what is shown in tiles that hold two windows, and look for the dearest windows."""
        self.sharpen(KNEE)
        sewn = self.sewing
        self._taper = max(self.side * TAPER // 100, 1)
        tile = max(self._shorter * TILE // 100, 2 * self.side)
        self.copies = no_copies(sewn.variant.shape, tile, int(self.origins.cell[-1]) + 1)
        self.repeats = Repeats(sewn.grown, self.origins, self.copies, self.terms)
        self._list((0, 0, *sewn.variant.shape))
        self.worst, self._stale = WorstSeams(self._field, self.growth.layout.patch, sewn.wraps), True

    def field(self) -> Array:
        """What repeats cost every pixel of the map as it is, in 1/FINE: (H, W, 1) int32."""
        height, width = self.sewing.variant.shape
        for top in range(0, height if self._stale else 0, ROWS):
            rows = min(ROWS, height - top)
            self._field[top : top + rows, :, 0] = self._priced((top, 0, rows, width))
        if self._stale:
            self._stale = False
            self.worst.read()
        return self._field

    def wave(self, run: Run) -> int:
        """Cover the dearest windows that lie apart; returns how many patches were laid."""
        self.field()
        wave = self.worst.apart(self.around, DEAR)
        self.told = None if self.lattice else self._told()
        return len(improve(self, self.boxes(wave), run, lambda begin: run.tick(begin, len(wave), self.growth.draft)))

    def pays(self, cut: Cut) -> bool:
        """Whether it is still a gain after what was laid before it."""
        return self._gain(cut) > 0 and super().pays(cut)

    def lay(self, cut: Cut) -> None:
        """Write a cut into the map, and what it shows into the lists."""
        super().lay(cut)
        self._list(cut.box)
        self._stale = True

    def best(self, site: Box, found: Candidates) -> Cut | None:
        """Of the best candidates by repeats and fit the one whose cut gains most; None where none does."""
        (y, x, h, w), area = site, max(int(found.known.sum()), 1)
        height, width = self._field.shape[:2]
        inner = ((y + h // 4) % height, (x + w // 4) % width, h - 2 * (h // 4), w - 2 * (w // 4))
        high, wide = (np.minimum(n - np.arange(0, n, 2 * STEP), 2 * STEP) for n in inner[2:])  # of blocks
        costs = []
        for far, variant, u, s in found.rows.tolist():
            price = int(high @ self._blocks(inner, (variant, u + h // 4, s + w // 4), 2 * STEP) @ wide)
            costs.append(price + math.isqrt(far // area) * (h + w) * FINE)
        known = dict[Box, Array]()

        def tried(k: int) -> tuple[int, Cut]:
            prices = list[Array]()

            def saved(window: Box, patch: Pick) -> Array:
                """What staying as it is costs each pixel of a window more than a patch; less towards the edges."""
                if window not in known:
                    known[window] = self._blocks(window)
                prices[:] = known[window], self._blocks(window, patch)
                more = np.empty(window[2:], np.int32)
                copies_kernels.savings(prices[0], prices[1], self._taper, more)
                return more

            cut = self.sewing.cut(site, picked(found, k), self.margin, saved=saved)
            return self._gain(cut, *prices), cut

        best = np.argsort(costs, kind="stable")[: TRIES].tolist()
        gain, cut = max(map(tried, best), key=lambda one: one[0], default=(0, None))
        return cut if gain > 0 else None

    def _gain(self, cut: Cut, *prices: Array) -> int:
        """What repeats saved are worth beyond what seams cost more; seams saved are no reason to change anything.

        On a lattice seams may not become dearer at all: they lie in joints, and others would part elements. `prices`
        of the box as it is and with the patch, where they are known.
        """
        if self.lattice and cut.change > 0:
            return 0
        old, new = prices or (self._blocks(cut.box), self._blocks(cut.box, cut.pick))
        paid, left = copies_kernels.taken_sums(old, new, cut.take)
        return int(paid - left) - FINE * max(cut.change, 0) - GAIN * int(paid) // 100

    def _blocks(self, box: Box, pick: Pick = (-1, 0, 0), step: int = STEP) -> Array:
        """What repeats cost each block of step x step px of a box as it is, or with a patch, in 1/FINE: int32."""
        out = np.empty([-(-n // step) for n in box[2:]], np.int32)
        copies_kernels.block_prices(self.repeats, box, (int(pick[0]), int(pick[1]), int(pick[2])), step, out)
        return out

    def _priced(self, box: Box, pick: Pick = (-1, 0, 0)) -> Array:
        """The same for each pixel of a box: (rows, columns) int32."""
        return self._blocks(box, pick).repeat(STEP, 0).repeat(STEP, 1)[: box[2], : box[3]]

    def _list(self, box: Box) -> None:
        copies_kernels.list_box(self.sewing.grown, self.sewing.pieces, self.origins, self.copies, box)

    # ---- candidates

    def _told(self) -> Prices:
        """How striking and how used the middle of every patch is, for the short-list."""
        variants, values = self.sewing.variants, list[Array]()
        used = self.copies.shows[self.origins.cell].astype(np.int64) * self.origins.weight * 256 // self.share
        for v in range(len(variants)):
            begin, (high, wide) = int(variants.table[v, 0]) // variants.channels, variants.picture(v).shape[:2]
            values.append(used[self.origins.pixel[begin : begin + high * wide]].reshape(high, wide))
        return Prices(self.over_patches(values), 1 << 15)
