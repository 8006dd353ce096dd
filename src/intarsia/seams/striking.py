"""Striking things of a finished map, shown so often at most: the others are covered by what goes on around them.

One brown leaf on a lawn is seen each time it returns, however well it is spread. Of each thing (`segments/wholes.py`)
as many are kept as area asks for, times a share, no two within a quarter of the canvas: whole ones, the farthest apart.
Over every other a patch is cut in that shows none: the thing must go, what is around it may, by maximum flow, and the
placement is the one with the cheapest seams of those that fit around it.

Source: seams and cut of Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures", SIGGRAPH 2003. The count of things
is this project's own.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..analysis.features import pose_array
from ..arrays import Array, Pair
from ..canvas import Canvas
from ..exemplar import Exemplars
from ..kernels.pieces_of_maps import boxes_of_parts, parts
from ..patches.growing_map import Neighbours, Pick, picked
from ..run import Run
from ..search.candidates import Candidates, Prices
from ..segments.wholes import things
from ..sourcemap import HOLE, SourceMap
from . import striking_kernels as kernels
from .covering import Covering, Laying, kept
from .graphcut import Box, Cut
from .improve import improve
from .placement_kernels import Samples
from .striking_kernels import Looks

# When a thing counts as shown: chosen by eye on twelve photographs:
SEEN = 30  # % of a thing: less of it is not seen as one
LEAST = 12  # px, nor is less than this
WHOLE = 80  # %: so much of it is as good as all
APART = 4  # no two within the canvas's sides through this
AROUND = 4  # px on each side of a thing, in the middle of its window, half as wide
STRIP = 256  # rows of the canvas that are looked at together: nothing larger is held besides the map


class Show(NamedTuple):
    """One showing of a thing: which thing, where, its number among the parts of the canvas, how much of it."""

    thing: int
    box: Box
    part: int
    percent: int

    @property
    def window(self) -> int:
        """The side of the smallest window that has it in its middle, px."""
        return 2 * (max(self.box[2:]) + AROUND)


class Staying(NamedTuple):
    """Which showings of a thing stay on a canvas (height, width) that wraps (y, x), so many of them at most."""

    most: int
    size: tuple[int, ...]
    wraps: tuple[bool, bool]

    def of(self, shows: list[Show], fixed: set[int]) -> list[Show]:
        """Those of a thing that stay: what may not go; then whole ones, each the farthest of all; then parts."""
        near = 4 * (min(self.size) // APART) ** 2
        middles = np.array([[2 * s.box[axis] + s.box[2 + axis] for axis in (0, 1)] for s in shows], np.int64)
        around = np.multiply(2, self.size)
        stays, stay, far = np.zeros(len(shows), bool), list[Show](), np.full(len(shows), near)

        def keep(k: int) -> None:
            gap = np.abs(middles - middles[k])  # in half px
            short = np.where(self.wraps, np.minimum(gap % around, -gap % around), gap)
            away = (short * short).sum(axis=1)
            far[:] = np.minimum(far, away) if stay else away
            stays[k] = True
            stay.append(shows[k])

        for k in (k for k, show in enumerate(shows) if show.part in fixed):
            keep(k)
        percent = np.array([show.percent for show in shows])
        for least in (WHOLE, 0):
            while len(stay) < self.most:
                k = int(np.where(stays | (percent < least), -1, far).argmax())
                if stays[k] or percent[k] < least or far[k] < near:
                    break
                keep(k)
        return stay


class Often:
    """How often the things of exemplars are shown, and which of their showings are too many."""

    def __init__(self, share: float, exemplars: Exemplars, canvas: Canvas, locked: Array) -> None:
        self.wraps, self.locked = (canvas.wrap.y, canvas.wrap.x), locked
        found, self.labels, areas = [things(e) for e in exemplars], list[Array](), [np.zeros(1, np.int64)]
        self.strikes = [mine.strikes for mine in found]
        self.peaks = np.concatenate([areas[0], *(mine.peaks for mine in found)])
        for mine in found:
            self.labels.append(np.where(mine.labels, mine.labels + sum(map(len, areas)) - 1, 0).astype(np.int32))
            areas.append(mine.areas)
        self.areas = np.concatenate(areas)
        pixels = sum(int(e.free.sum()) for e in exemplars)
        asked = math.floor(share * canvas.height * canvas.width / max(pixels, 1) + 0.5)
        self.most = max(asked, 1) if share else 0
        self.begin = np.cumsum([0, *(labels.size for labels in self.labels)])
        self.width = np.array([labels.shape[1] for labels in self.labels], np.int64)
        self.flat = np.concatenate([labels.ravel() for labels in self.labels])

    def things(self, smap: SourceMap) -> Array:
        """The thing that every pixel of a canvas shows, (H, W) int32; 0: none."""
        thing = np.empty((smap.height, smap.width), np.int32)
        for top in range(0, smap.height, STRIP):
            strip = slice(top, top + STRIP)
            y, x = smap.yx[strip, :, 0], smap.yx[strip, :, 1]
            if smap.which is None:
                thing[strip] = self.labels[0][y, x]
            else:
                at = np.minimum(smap.which[strip], len(self.labels) - 1)  # of a hole anything
                shows = self.flat[self.begin[at] + y * self.width[at] + x]
                thing[strip] = np.where(smap.which[strip] == HOLE, 0, shows)
        return thing

    def shown(self, thing: Array) -> tuple[Array, list[Show]]:
        """Number the showings of all things on a canvas, (H, W) int32, and list those that are seen as such."""
        part = np.empty(thing.shape, np.int32)
        box = np.empty((parts(thing, self.wraps, part), 5), np.int64)
        boxes_of_parts(part, self.wraps, box)
        names = np.zeros(len(box) + 1, np.int32)
        for top in range(0, len(part), STRIP):
            names[part[top : top + STRIP].ravel()] = thing[top : top + STRIP].ravel()
        whole = self.areas[names[1:]]
        out = []
        for k in np.flatnonzero(box[:, 4] >= np.maximum(whole * SEEN // 100, LEAST)).tolist():
            top, left, h, w, area = box[k].tolist()
            out.append(Show(int(names[k + 1]), (top, left, h, w), k + 1, 100 * area // max(int(whole[k]), 1)))
        return part, out

    def surplus(self, thing: Array) -> tuple[Array, list[Show]]:
        """The parts of the canvas, and the showings that are too many, thing by thing; what is locked stays."""
        part, shows = self.shown(thing)
        fixed, staying = set(np.unique(part[self.locked]).tolist()), Staying(self.most, part.shape, self.wraps)
        by_thing = dict[int, list[Show]]()
        for show in shows:
            by_thing.setdefault(show.thing, []).append(show)
        stay = {show.part for some in by_thing.values() for show in staying.of(some, fixed)}
        return part, [show for number in sorted(by_thing) for show in by_thing[number] if show.part not in stay]


# What is weighed how: chosen by eye on twelve photographs:
SIDES = (24, 32, 48, 64, 96, 128)  # of windows, px
LISTED = 24  # placements of a window that fit around it,
TRIES = 12  # those compared by cuts
ROUGH = 3  # px from one to the next where they are compared
LOOKED = 3  # px from one to the next where it is counted how often they show what is there already,
USUAL = 10 * 256  # which costs a placement a tenth of the usual distance for each time,
AGAIN = 8 * 256  # and a cut an eighth of a knee for each px of its outline
RARER = (4, 3)  # and shown and striking no more than three quarters as much as the thing
PLAIN = 192  # of 256: what strikes less does not strike
EDGE = 2  # px around a thing go with it
LEFT = 25  # % of it may stay, where all patches show things themselves
DEAR = (3, 2)  # knees for each px of its outline: the most that seams may cost more,
STRONG = 1600  # and by the square of what it strikes beyond so much of 256
KNEE = (25, 125)  # %: the usual seam counts as at least, at most so much of the spread of colours
MUST = 1 << 24  # what it costs to leave what must go
SHOWN = 18  # 2**SHOWN: the price of a placement whose middle shows nothing but things


class Job(NamedTuple):
    """A showing to be covered: its window, where it lies in it, and whether that is the middle."""

    show: Show
    box: Box
    hole: Box
    middle: bool


def thinned(
    share: float, laying: Laying, exemplars: Exemplars, canvas: Canvas, smap: SourceMap, run: Run
) -> SourceMap:
    """Return a finished map in which every striking thing is shown as often as area asks, times `share`, or less.

    At least once where `share` is not 0. What the map still shows of `canvas.start` stays, and under `canvas.guide` no
    pixel follows the guide less well; where no patch fits, a thing stays, too.
    """
    often = Often(share, exemplars, canvas, kept(canvas.start, smap))
    shorter = min(smap.height, smap.width, *(min(e.height, e.width) for e in exemplars))
    fit = [side for side in SIDES if 2 * side <= shorter] if often.areas.size > 1 else []
    part, many, work = *(often.surplus(often.things(smap)) if fit else (np.empty((0, 0), np.int32), [])), None
    for number, side in enumerate(fit):
        run.tick(number, len(fit), None if work is None else work.growth.draft)
        least = fit[number - 2] if number > 1 else 0  # what stayed is tried in the next larger windows
        shows = [show for show in many if least < show.window and (show.window <= side or side == fit[-1])]
        if shows:
            work = work or Thinning(often, laying, exemplars, canvas, smap, side)
            work.resize(side)
            work.cover(part, shows, run.part(number, len(fit)))
            part, many = often.surplus(often.things(work.growth.map(smap.blend)))
    run.tick(1, 1)
    if work is None:
        return smap
    work.sewing.bar = None  # no circle keeps what is not needed any more
    return work.growth.map(smap.blend)


class Thinning(Covering):
    """A finished map whose showings of things that are too many are covered, by windows of one size at a time."""

    def __init__(
        self, often: Often, laying: Laying, exemplars: Exemplars, canvas: Canvas, smap: SourceMap, side: int
    ) -> None:
        settings = laying.settings(exemplars, side, LISTED)
        super().__init__(laying, settings, exemplars, canvas, smap)
        self.often, self.sewing.bar = often, self._barred
        variants, table = self.growth.variants, self.growth.variants.table
        posed = list(zip(variants.exemplar.tolist(), variants.pose.tolist(), strict=True))
        self.labels = [pose_array(often.labels[e], pose) for e, pose in posed]
        strikes = np.concatenate([pose_array(often.strikes[e], pose).ravel() for e, pose in posed])
        frames = np.zeros((len(posed), 3), np.int64)
        frames[:, 1:] = table[:, 1:3]
        frames[1:, 0] = np.cumsum(frames[:-1, 1] * frames[:-1, 2])
        self.looks = Looks(np.concatenate([labels.ravel() for labels in self.labels]), strikes, frames)
        self._samples: Samples | None = None
        self._measure()

    def resize(self, side: int) -> None:
        """Take windows of so many px a side from now on."""
        if side != self.side:
            super().resize(side)
            self._measure()

    def _measure(self) -> None:
        """Measure what seams cost on average now; which patches show things is measured when it is asked for."""
        self.sharpen(KNEE)
        self._prices = dict[bool, Prices]()

    def _priced(self, middle: bool) -> Prices:
        """What patches cost that show things in their middle, or anywhere."""
        if middle not in self._prices:
            shown = [(labels > 0).astype(np.int64) << SHOWN for labels in self.labels]
            self._prices[middle] = Prices(self.over_patches(shown, 4 if middle else 0), 1 << 15)
        return self._prices[middle]

    def cover(self, part: Array, shows: list[Show], run: Run) -> None:
        """Cover showings of things, each once: those first whose windows do not touch, then the others."""
        sewn, total = self.sewing, len(shows)
        while left := [show for show in shows if (part[sewn.index(show.box)] == show.part).any()]:  # some went
            (wave, shows), self.part = self._apart(left), part
            if max(sewn.variant.shape) <= sewn.nearby:  # all of it is seen together
                self._samples = sewn.samples((0, 0, 1, 1), LOOKED)
            tick = partial(self._tick, run, total - len(left), total)
            for cut in improve(self, dict(enumerate(wave)), run, tick):
                part[sewn.index(cut.box)] *= cut.take == 0  # it shows no thing

    def _tick(self, run: Run, done: int, total: int, begin: int) -> None:
        run.tick(done + begin, total, self.growth.draft)

    def give_up(self, key: Any) -> None:
        """Leave a showing: it is tried in larger windows."""

    def _apart(self, shows: list[Show]) -> tuple[list[Job], list[Show]]:
        """Those whose windows do not touch, with their windows, and the others."""
        out, others, side = list[Job](), list[Show](), self.side
        size, wraps = self.sewing.variant.shape, self.sewing.wraps
        near, n = side + self.around - 1, EDGE
        places = list[Pair]()
        taken = Neighbours(places, (near, near), size, wraps)
        for show in shows:
            at, hole, middle = list[int](), [*show.box], True
            for axis in (0, 1):
                first = show.box[axis] + show.box[2 + axis] // 2 - side // 2
                low, high = show.box[axis] - n, show.box[axis] + show.box[2 + axis] + n
                if not wraps[axis]:
                    low, high, inside = max(low, 0), min(high, size[axis]), min(max(first, 0), size[axis] - side)
                    first, middle = inside, middle and inside == first
                at.append(first % size[axis])
                hole[axis], hole[2 + axis] = low, high - low
            if next(taken.of((at[0], at[1])), None) is None:
                taken.note(len(places), (at[0], at[1]))
                places.append((at[0], at[1]))
                out.append(Job(show, (at[0], at[1], side, side), (hole[0], hole[1], hole[2], hole[3]), middle))
            else:
                others.append(show)
        return out, others

    def _barred(self, box: Box, pick: Pick) -> Array:
        """Where a patch over a box would show a thing, or may not be anyway."""
        begin, *size = self.looks.frames[pick[0]].tolist()
        y, x = ((np.arange(n) + first) % side for n, first, side in zip(box[2:], pick[1:], size, strict=True))
        shows: Array = self.looks.things[begin + y[:, None] * size[1] + x] > 0
        return shows | self.bars(box, pick) if self.bars.any else shows

    def found(self, sites: list[Any], run: Run) -> list[Candidates]:
        """What fits around the showings of things, and shows none in its middle."""
        out = dict[int, Candidates]()
        for middle in (True, False):
            mine = [k for k, job in enumerate(sites) if job.middle == middle]
            if mine:
                boxes, holes = [sites[k].box for k in mine], [sites[k].hole for k in mine]
                prices = None if self.lattice else self._priced(middle)
                out.update(zip(mine, self.candidates(boxes, holes, prices, run), strict=True))
        return [out[k] for k in range(len(sites))]

    def _often(self, job: Job, found: Candidates) -> tuple[Array, int]:
        """How often what placements would show for a thing, and the thing, are shown elsewhere, and how they strike.

        Once is 256 for what strikes one and a half times as much as usual; nearby it counts up to four times.
        """
        sewn, rows, now = self.sewing, found.rows.copy(), np.zeros((1, 4), np.int64)
        where = sewn.index(job.hole)
        y, x = np.nonzero(self.part[where] == job.show.part)
        middle = int(y[len(y) // 2]), int(x[len(x) // 2])
        now[0, 1], now[0, 2:] = sewn.variant[where][middle], sewn.yx[where][middle] - middle
        for axis in (0, 1):  # the placements begin with the window
            away = job.hole[axis] - job.box[axis]
            rows[:, 2 + axis] += away % sewn.variant.shape[axis] if sewn.wraps[axis] else away
        rows = np.concatenate([rows, now])
        strikes, samples = np.empty(len(rows), np.int64), self._samples
        if samples is None:
            samples = sewn.samples(job.hole, LOOKED)
        kernels.mean_strikes(self.looks, job.hole, rows, strikes)
        out = sewn.repeats(job.hole, rows, samples) * np.maximum(strikes - PLAIN, 1) // PLAIN
        return out[:-1], int(out[-1])

    def best(self, site: Job, found: Candidates) -> Cut | None:
        """The patch that covers a showing with the cheapest seams; None where they would be dear, or it would stay."""
        sewn, known, show, box = self.sewing, dict[Box, tuple[Array, int]](), site.show, site.box

        def going(window: Box, patch: Pick = (0, 0, 0)) -> Array:
            if window not in known:
                wanted = np.empty(window[2:], np.int32)
                area = kernels.mark_part(self.part, sewn.wraps, window, show.part, EDGE, MUST, wanted)
                known[window] = wanted, int(area)
            return known[window][0]

        def stays(cut: Cut, step: int) -> int:
            return int(((going(cut.box)[::step, ::step] > 0) & (cut.take == 0)).sum()) * step * step

        knee, step = max(sewn.price.knee, 1), min(ROUGH, self.side // 8)
        length, (often, now) = 2 * (show.box[2] + show.box[3]), self._often(site, found)
        costs = found.rows[:, 0] + often * found.usual // USUAL
        rarer = np.flatnonzero((often * RARER[0] <= now * RARER[1]) | (not self.often.most))
        tried = rarer[np.argsort(costs[rarer], kind="stable")][: TRIES]

        def price(k: int) -> int:
            cut = sewn.cut(box, picked(found, k), self.margin, step, saved=going)
            return cut.change * step + stays(cut, step) * knee + int(often[k]) * length * knee // AGAIN

        best = min(tried.tolist(), key=price, default=None)
        if best is None:
            return None
        cut = sewn.cut(box, picked(found, best), self.margin, saved=going)
        area = known[cut.box][1]
        strong = max(int(self.often.peaks[show.thing]), STRONG) ** 2
        most = DEAR[0] * length * knee * strong // (DEAR[1] * STRONG**2)
        cheap = not self.often.most or cut.change <= most
        return cut if cheap and 100 * stays(cut, 1) <= LEFT * area else None
