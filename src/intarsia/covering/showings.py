"""How often striking things are shown on a canvas, and which of their showings are too many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..exemplar import Exemplar
from ..kernels.pieces_of_maps import boxes_of_parts, parts
from ..seams.cut import Box
from ..segments.things import things
from ..sourcemap import HOLE, SourceMap

Array = NDArray[Any]


class Counting(NamedTuple):
    """When a thing counts as shown: chosen by eye on twelve photographs."""

    seen: int = 30  # % of a thing: less of it is not seen as one
    least: int = 12  # px, nor is less than this
    whole: int = 80  # %: so much of it is as good as all
    apart: int = 4  # no two within the canvas's sides through this
    around: int = 4  # px on each side of a thing, in the middle of its window, half as wide


COUNTING = Counting()
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
        return 2 * (max(self.box[2:]) + COUNTING.around)


def asked_for(share: float, exemplars: Sequence[Exemplar], canvas: Canvas) -> int:
    """How often a thing may be shown: as area asks, times `share`; at least once where that is not 0."""
    pixels = sum(e.height * e.width if e.usable is None else int(e.usable.sum()) for e in exemplars)
    asked = math.floor(share * canvas.height * canvas.width / max(pixels, 1) + 0.5)
    return max(asked, 1) if share else 0


class Staying(NamedTuple):
    """Which showings of a thing stay on a canvas (height, width) that wraps (y, x), so many of them at most."""

    most: int
    size: tuple[int, ...]
    wraps: tuple[bool, bool]

    def of(self, shows: list[Show], fixed: set[int]) -> list[Show]:
        """Those of a thing that stay: what may not go; then whole ones, each the farthest of all; then parts."""
        near = 4 * (min(self.size) // COUNTING.apart) ** 2
        middles = np.array([[2 * s.box[axis] + s.box[2 + axis] for axis in (0, 1)] for s in shows], np.int64)
        stays, stay, far = np.zeros(len(shows), bool), list[Show](), np.full(len(shows), near)

        def keep(k: int) -> None:
            away = self._far(middles, middles[k])
            far[:] = np.minimum(far, away) if stay else away
            stays[k] = True
            stay.append(shows[k])

        for k in (k for k, show in enumerate(shows) if show.part in fixed):
            keep(k)
        percent = np.array([show.percent for show in shows])
        for least in (COUNTING.whole, 0):
            while len(stay) < self.most:
                k = int(np.where(stays | (percent < least), -1, far).argmax())
                if stays[k] or percent[k] < least or far[k] < near:
                    break
                keep(k)
        return stay

    def _far(self, middles: Array, middle: Array) -> Array:
        """The squares of how far middles (n, 2) are from another, all in half px."""
        gap, length = np.abs(middles - middle), np.multiply(2, self.size)
        short = np.where(self.wraps, np.minimum(gap % length, -gap % length), gap)
        return np.asarray((short * short).sum(axis=1))


class Often:
    """How often the things of exemplars are shown, and which of their showings are too many."""

    def __init__(self, share: float, exemplars: Sequence[Exemplar], canvas: Canvas, locked: Array) -> None:
        self.wraps, self.locked = (canvas.wrap.y, canvas.wrap.x), locked
        found, self.labels, areas = [things(e) for e in exemplars], list[Array](), [np.zeros(1, np.int64)]
        self.strikes = [mine.strikes for mine in found]
        self.peaks = np.concatenate([areas[0], *(mine.peaks for mine in found)])
        for mine in found:
            self.labels.append(np.where(mine.labels, mine.labels + sum(map(len, areas)) - 1, 0).astype(np.int32))
            areas.append(mine.areas)
        self.areas = np.concatenate(areas)
        self.most = asked_for(share, exemplars, canvas)
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
        for k in np.flatnonzero(box[:, 4] >= np.maximum(whole * COUNTING.seen // 100, COUNTING.least)).tolist():
            top, left, h, w, area = box[k].tolist()
            out.append(Show(int(names[k + 1]), (top, left, h, w), k + 1, 100 * area // max(int(whole[k]), 1)))
        return part, out

    def surplus(self, thing: Array) -> tuple[Array, list[Show]]:
        """The parts of the canvas, and the showings that are too many."""
        part, shows = self.shown(thing)
        fixed = set(np.unique(part[self.locked]).tolist())
        staying = Staying(self.most, part.shape, self.wraps)
        by_thing = dict[int, list[Show]]()
        for show in shows:
            by_thing.setdefault(show.thing, []).append(show)
        out = []
        for number in sorted(by_thing):
            stay = {show.part for show in staying.of(by_thing[number], fixed)}
            out += [show for show in by_thing[number] if show.part not in stay]
        return part, out
