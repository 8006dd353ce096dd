"""Striking elements of a finished map, shown so often at most: the others show the inside of another element.

One white pebble among gray ones is seen each time it returns. A patch that covers it covers parts of its neighbours,
too, and fuses them. So its outline stays, and what is inside comes from another whole element, one that does not strike
and fills it. Of each element that strikes as many are kept as area asks for, times a share, whole ones, the farthest
apart (`striking.py`).

Source: the cut along the outline is that of Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003.
That elements are exchanged within their outlines is this project's own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import fft

from ..arrays import Array, Int64, Mask, Pair
from ..canvas import Canvas
from ..exemplar import Exemplar, Exemplars
from ..geometry import widened
from ..kernels.pieces_of_maps import boxes_of_parts
from ..lazy import ndimage
from ..patches.growing_map import Pick
from ..run import Run
from ..seams.graphcut import Box, Cut
from ..seams.whole import MUST, RING, RULE, Elements, Mending
from ..segments.wholes import things, wholes
from ..sourcemap import SourceMap
from .covering import Covering, Laying
from .striking import COUNTING, Show, asked_for, too_many


class Scale(NamedTuple):
    """What is weighed how: chosen by eye on seven photographs."""

    strong: int = 140  # % of what elements usually strike: one that strikes so much all over is one that strikes;
    sure: float = 0.9  # it is an element for sure, as is what fills it,
    large: float = 0.5  # and has so much of the usual area at least
    fills: int = 80  # % of a showing that what fills it covers,
    covers: int = 99  # % with its joint
    outside: int = 2  # px: so far around the outline the cut may run,
    inside: int = 1  # and so far within
    steps: tuple[int, ...] = (3, 1)  # px: a place is moved so far as long as that makes it cheaper
    again: int = 16  # 1/16 knees for each px of the outline: what each time costs that an element fills one,
    usual: int = 8  # and each time that others are shown on average that it is shown more often
    left: int = 25  # % of a showing may stay
    window: int = 32  # px: nothing hangs on it, as no window is searched for


SCALE = Scale()


class Place(NamedTuple):
    """Where an element lies that fills a showing: its first row and column on the window of that, and what it costs."""

    price: float
    element: int
    y: int
    x: int


def known(exemplars: Exemplars) -> bool:
    """Whether the elements of all exemplars are known."""
    return all(wholes(e) is not None for e in exemplars)


def exchanged(
    share: float, laying: Laying, exemplars: Exemplars, canvas: Canvas, smap: SourceMap, run: Run
) -> SourceMap:
    """Return a finished map in which every striking element is shown as often as area asks, times `share`, or less.

    The elements of all exemplars have to be known. What the map still shows of `canvas.start` stays, and under
    `canvas.guide` no pixel follows the guide less well; where no element fills it, one stays, too.
    """
    strikes = [striking(e) for e in exemplars]
    if not any(mine.any() for mine in strikes):
        return smap
    side = min(SCALE.window, *(n // 2 for e in exemplars for n in (e.height, e.width)), smap.height, smap.width)
    settings = laying.settings(exemplars, side, 1)
    work = Covering(laying, settings, exemplars, canvas, smap)
    elements = Elements(work.growth.variants, [w for w in map(wholes, exemplars) if w is not None])
    if len(elements.boxes) < RULE.fewest:
        return smap
    exchange = Exchange(work, elements, np.concatenate(strikes)[elements.kin - 1])
    done = exchange.carried_out(asked_for(share, exemplars, canvas), run)
    work.sewing.bar = None  # no circle keeps what is not needed any more
    return work.growth.map(smap.blend) if done else smap


def striking(exemplar: Exemplar) -> Int64:
    """How much each element of an exemplar strikes, in 1/256 of what is usual; 0: not more than others."""
    found, seen = wholes(exemplar), things(exemplar)
    assert found is not None
    flat, n = found.labels.ravel(), len(found.sure)
    area = np.maximum(np.bincount(flat, minlength=n), 1)[1:]
    mean = np.bincount(flat, seen.strikes.ravel(), n)[1:].astype(np.int64) // area
    large = area >= SCALE.large * float(np.median(area))
    strong = 100 * mean >= SCALE.strong * int(np.median(mean))
    return np.where(large & strong & (found.sure[1:] >= SCALE.sure), mean, 0)


class Exchange:
    """A finished map whose striking elements are exchanged where they are too many."""

    def __init__(self, work: Covering, elements: Elements, strikes: Int64) -> None:
        self.work, self.sewn, self.elements = work, work.sewing, elements
        self.map = Mending(self.sewn, elements)
        self.map.number()
        self.strikes = np.where(np.arange(len(elements.all)) > 0, strikes, 0)
        self.free = np.zeros(self.map.shape, bool)  # what may be taken from a patch,
        self._freed = self.sewn.index((0, 0, 1, 1))  # all of it here
        self.sewn.bar = self._barred
        shown, count = self.map.shown, self.map.count
        whole = 2 * shown.area[1:count] > shown.whole[1:count]
        often = np.bincount(shown.element[1:count][whole], minlength=len(elements.all))
        total, n = max(int(often.sum()), 1), len(elements.boxes)
        self.dear = SCALE.usual * np.maximum(often * n - total, 0) // total
        fills = (elements.known[1] >= SCALE.sure) & (self.strikes == 0)
        self.fillers = [int(row[6]) for row in elements.boxes if fills[row[6]]]

    def carried_out(self, most: int, run: Run) -> int:
        """Exchange what is shown more than so often; returns how many were."""
        shows, done = self.surplus(most), 0
        for number, show in enumerate(shows):
            run.tick(number, len(shows))
            done += self._exchange(show)
        run.tick(1, 1)
        return done

    def surplus(self, most: int) -> list[Show]:
        """The showings of striking elements that are too many, where `most` of each may stay."""
        box = np.empty((self.map.count - 1, 5), np.int64)
        boxes_of_parts(self.map.joined, self.sewn.wraps, box)
        shows = list[Show]()
        for k in range(1, self.map.count):
            element, area = int(self.map.shown.element[k]), int(self.map.shown.area[k])
            whole = int(self.elements.known[0][element])
            if self.strikes[element] and 100 * area >= COUNTING.seen * whole and area >= RULE.least:
                y, x, h, w = box[k - 1, :4].tolist()
                kin = int(self.elements.kin[element])
                shows.append(Show(kin, (y, x, h, w), k, 100 * area // whole))
        return too_many(shows, most, self.map.joined, self.sewn.locked, self.sewn.wraps)

    def _barred(self, box: Box, pick: Pick) -> Array:
        stays = ~self.free[self.sewn.index(box)]
        return stays | self.work.bars(box, pick) if self.work.bars.any else stays

    def _exchange(self, show: Show) -> bool:
        """Fill the outline of a showing with the element that makes the cheapest seams; whether there was one."""
        box = widened(show.box, SCALE.outside + 1, self.map.shape, self.sewn.wraps)
        where = self.sewn.index(box)
        mine = self.map.joined[where] == show.part
        solid = ndimage.binary_fill_holes(mine)
        self.free[self._freed], self._freed = False, where
        self.free[where] = ndimage.binary_dilation(solid, iterations=SCALE.outside)
        must = ~ndimage.binary_dilation(~solid, iterations=SCALE.inside) * np.int32(MUST)
        unit = 2 * (show.box[2] + show.box[3]) * self.map.knee
        found = [self._placed(number, box, mine, must, int(self.dear[number]) * unit // 16) for number in self.fillers]
        best = min((place for place in found if place is not None), default=None)
        if best is None:
            return False
        cut = self._cut(best, box, must)
        left = int((mine & (cut.take == 0)).sum())
        if 100 * left > SCALE.left * int(mine.sum()) or self.work.bars.returns(cut.box, cut.pick, cut.take):
            return False
        self.sewn.paste(cut)
        self.dear[best.element] += SCALE.again
        return True

    def _placed(self, number: int, box: Box, mine: Array, must: Array, more: int) -> Place | None:
        """Lay an element over a showing so that it fills it and seams are cheap; None where it does not fill it."""
        mask, ring = self.elements[number].mask, self.elements[number].ring
        area = int(mine.sum())
        if 100 * int(mask.sum()) < SCALE.fills * area:
            return None
        inner = np.pad(mask, RING)
        by, with_joint = covered(inner, mine), covered(inner | ring, mine)
        fits = (100 * by >= SCALE.fills * area) & (100 * with_joint >= SCALE.covers * area)
        fits &= self._within(number, box, fits.shape)
        if not fits.any():
            return None
        known = dict[Pair, int]()

        def price(at: Pair) -> int:
            if at not in known:
                known[at] = self._cut(self._place(number, box, at), box, must).change
            return known[at]

        y, x = divmod(int(np.where(fits, by, -1).argmax()), fits.shape[1])
        for step in SCALE.steps:
            while True:
                near = [(y - step, x), (y + step, x), (y, x - step), (y, x + step)]
                near = [(a, b) for a, b in near if 0 <= a < fits.shape[0] and 0 <= b < fits.shape[1] and fits[a, b]]
                best = min(near, key=price, default=(y, x))
                if price(best) >= price((y, x)):
                    break
                y, x = best
        return self._place(number, box, (y, x), price((y, x)) + more)

    @staticmethod
    def _place(number: int, box: Box, at: Pair, price: int = 0) -> Place:
        """The place that an index of `covered` stands for, where the element was wider by its ring."""
        return Place(price, number, box[2] - 1 + RING - at[0], box[3] - 1 + RING - at[1])

    def _within(self, number: int, box: Box, shape: tuple[int, ...]) -> Array:
        """Whether the exemplar reaches as far as the window, for every index of `covered`."""
        element, out = self.elements[number], np.ones(shape, bool)
        if not self.sewn.variants.toroidal[element.variant]:
            for axis in (0, 1):
                first = element.at[axis] + np.arange(shape[axis]) - (box[2 + axis] - 1 + RING)
                size = int(self.sewn.variants.table[element.variant, 1 + axis])
                inside = (first >= 0) & (first + box[2 + axis] <= size)
                out &= inside[:, None] if axis == 0 else inside[None]
        return out

    def _cut(self, place: Place, box: Box, must: Array) -> Cut:
        element = self.elements[place.element]
        pick = (element.variant, element.at[0] - place.y, element.at[1] - place.x)
        return self.sewn.cut(box, pick, 0, saved=lambda box, pick: must)


def covered(mask: Mask, mine: Mask) -> Int64:
    """How many pixels of `mine` (h, w) a mask (m, n) covers, for every way it may lie: (m + h - 1, n + w - 1).

    At (y, x) the first pixel of `mine` lies over row y - h + 1 and column x - w + 1 of the mask.
    """
    size = [a + b - 1 for a, b in zip(mask.shape, mine.shape, strict=True)]
    product = fft.rfft2(mask.astype(np.float64), size) * fft.rfft2(mine[::-1, ::-1].astype(np.float64), size)
    return np.rint(fft.irfft2(product, size)).astype(np.int64)
