"""Any window of an endless map, level by level: handed down, jittered, corrected (Lefebvre and Hoppe 2005).

A pixel of the map depends on its absolute place, the seed and the parameters alone. To compute a window, every level
is made a little larger: by what the corrections of the next finer one read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..draws import seed_state
from ..kernels.correction import FINE, ONE, Axis, Room, Site, correct, descend, pixels, positions, put
from ..kernels.scatter import SEEN, TURNS, scatter
from ..run import Run
from .sites import Sites

REACH = 2  # px that a correction reads on each side
FREE = 2  # levels of 1 and 2 px, on which the jitter need not keep to a lattice
ALWAYS = 3  # levels of 1, 2 and 4 px, which are corrected even where nothing was moved
DRAWN = 8  # places drawn for each piece of half the exemplar, to choose from
BAND = 32  # rows that are worth a thread
RULES = {"near": (1, 0), "published": (1, 1), "memo": (2, 0)}  # reach of the candidates, and whether looked up first

Array = NDArray[Any]


class Span(NamedTuple):
    """Pixels start .. stop-1 of an axis at some level; `period` of them close in themselves, if it is not 0."""

    start: int
    stop: int
    period: int

    @property
    def at(self) -> Array:
        """The absolute coordinates, each one in the first period."""
        every = np.arange(self.start, self.stop, dtype=np.int64)
        return every % self.period if self.period else every

    def wider(self, margin: int) -> Span:
        """The span with so many more px on either side."""
        return Span(self.start - margin, self.stop + margin, self.period)

    def above(self) -> Span:
        """The pixels of the next coarser level that these come from."""
        if self.period:
            above = (self.period + 1) // 2
            return Span(0, above, above)
        return Span(self.start >> 1, ((self.stop - 1) >> 1) + 1, 0)


@dataclass(frozen=True)
class Corrections:
    """How a map is corrected: `passes` of `subpasses` each, which candidates, and what a jump costs.

    ``jitter``: px of each level, in 1 / 4096 of its spacing, from the finest on; the last holds for all coarser ones.
    ``factor``: of squared distances of jumps, 256 = 1; -1: no jumps.
    """

    jitter: tuple[int, ...]
    factor: int
    passes: int
    subpasses: int
    rule: str
    lattice: tuple[tuple[float, ...], ...] | None = None  # vectors (x, y), px, that the jitter keeps to
    pins: tuple[tuple[int, ...], ...] = ()  # (exemplar x, y, output x, y, radius), px

    @classmethod
    def of(cls, method: Any) -> Corrections:
        """Take the settings from the fields of a method."""
        jitter = method.jitter if isinstance(method.jitter, tuple) else (method.jitter,)
        factor = -1 if method.kappa == "inf" else round(ONE * float(method.kappa) ** 2)
        shares = tuple(round((1 << FINE) * share) for share in jitter)
        return cls(shares, factor, method.passes, method.subpasses, method.rule, method.lattice, method.pin or ())

    @property
    def margin(self) -> int:
        """How many px around a window the corrections of a level read (S4-31)."""
        return REACH * self.passes * self.subpasses

    def spread(self, level: int) -> int:
        """Jitter of a level, in 1 / 4096 px."""
        return self.jitter[min(level, len(self.jitter) - 1)] << level


@dataclass(frozen=True)
class Descent:
    """A window of the endless map, from the coarsest level to the finest."""

    sites: Sites
    rules: Corrections
    seed: int
    stage: int

    def window(self, rows: Span, cols: Span, run: Run) -> Array:
        """Return the exemplar pixels (y, x) of the output pixels of two spans: (rows, columns, 2) int32."""
        spans = self._spans(rows, cols)
        top = len(spans) - 1
        coords = self._first(spans[top], spans[0])
        for level in range(top, -1, -1):
            run.tick(top - level, top + 1)
            if level < top:
                coords = self._handed_down(coords, level, spans)
            if level < self._mended:
                coords = self._corrected(coords, level, spans[level], run)
            elif edge := self._margin(level):
                coords = coords[edge:-edge, edge:-edge]
        run.tick(top + 1, top + 1)
        return coords

    @cached_property
    def _mended(self) -> int:
        """How many levels are corrected: up to the coarsest one on which pixels were moved."""
        most = len(self.sites.levels)
        moved = [level + 1 for level in range(most) if self.rules.spread(level)]
        return max([min(ALWAYS, most), *moved])

    def _scattered(self, level: int) -> bool:
        """Whether a level is that of the large pieces, half the exemplar, and they are moved."""
        return level == self.sites.count - 2 and level >= self._mended and self.rules.spread(level) > 0

    def _margin(self, level: int) -> int:
        if level < self._mended:
            return self.rules.margin
        return SEEN * (TURNS - 1) if self._scattered(level) else 0

    def _spans(self, rows: Span, cols: Span) -> list[tuple[Span, Span]]:
        """What must be known of each level, from the finest to the coarsest, before it is corrected."""
        spans = [(rows.wider(self._margin(0)), cols.wider(self._margin(0)))]
        for level in range(1, self.sites.count):
            above = [span.above().wider(self._margin(level)) for span in spans[-1]]
            spans.append((above[0], above[1]))
        return spans

    def _first(self, spans: tuple[Span, Span], finest: tuple[Span, Span]) -> Array:
        """The coarsest level: the exemplar side by side, or in step with the lattice, and the first jitter."""
        room, top = self._room, self.sites.count - 1
        places = [_place(span, top, whole.period) for span, whole in zip(spans, finest, strict=True)]
        if len(room.lattice):
            down, across = (_residues(place, room.lattice, axis) for axis, place in enumerate(places))
            start = (down[:, None] + across[None, :] + 128) >> 8
        else:
            start = np.stack(np.meshgrid(*(p % n for p, n in zip(places, room.size, strict=False)), indexing="ij"), 2)
        axes = [Axis(np.arange(len(span.at)), np.zeros(len(span.at), np.int64), span.at) for span in spans]
        coords = self._descended(start, axes, top)
        self._pin(coords, top, spans, finest)
        return coords

    @cached_property
    def _room(self) -> Room:
        exemplar = self.sites.exemplar
        size = np.array([exemplar.height, exemplar.width, exemplar.toroidal], np.int64)
        return Room(size, self.sites.home, _whole_lattice(self.rules.lattice))

    def _handed_down(self, coords: Array, level: int, spans: list[tuple[Span, Span]]) -> Array:
        """A level from the next coarser one, whose pixels stand for twice as many px (2006, equation 2)."""
        axes = []
        for span, above, whole in zip(spans[level], spans[level + 1], spans[0], strict=True):
            parent = Span(0, above.period, above.period) if above.period else above
            up = span.at >> 1
            step = _place(span, level, whole.period) - _place_of(up, parent, level + 1, whole.period)
            axes.append(Axis(up - above.start - self._margin(level + 1), step, span.at))
        coords = self._descended(coords, axes, level)
        self._pin(coords, level, spans[level], spans[0])
        return coords

    def _pin(self, coords: Array, level: int, spans: tuple[Span, Span], finest: tuple[Span, Span]) -> None:
        """Show a feature of the exemplar where it was dragged to: S[p] = u + (h p - q) in a disc (2005, section 5).

        On coarse levels only: what is finer follows from them, and the corrections find the seam.
        """
        exemplar = self.sites.exemplar
        for sx, sy, x, y, radius in self.rules.pins if level >= FREE else ():
            away = []
            for span, whole, q in zip(spans, finest, (y, x), strict=True):
                d = _place(span, level, whole.period) - q
                away.append((d + whole.period // 2) % whole.period - whole.period // 2 if whole.period else d)
            rows, cols = (np.flatnonzero(abs(d) <= radius) for d in away)
            dy, dx = away[0][rows][:, None], away[1][cols][None, :]
            inside = (dy * dy + dx * dx <= radius * radius) & (sy + dy >= 0) & (sx + dx >= 0)
            inside &= (sy + dy < exemplar.height) & (sx + dx < exemplar.width)
            if exemplar.usable is not None:
                inside[inside] &= exemplar.usable[(sy + dy + 0 * dx)[inside], (sx + dx + 0 * dy)[inside]]
            block = coords[np.ix_(rows, cols)]
            block[inside] = np.stack([(sy + dy + 0 * dx)[inside], (sx + dx + 0 * dy)[inside]], axis=1)
            coords[np.ix_(rows, cols)] = block

    def _descended(self, coords: Array, axes: list[Axis], level: int) -> Array:
        drawn = DRAWN if self._scattered(level) else 1
        out = np.empty((drawn, len(axes[0].at), len(axes[1].at), 2), np.int32)
        spread = np.array([[self.rules.spread(level)]], np.int64)
        free = not len(self._room.lattice) or level < FREE
        for number in range(drawn):
            state = np.uint64(seed_state(self.seed, self.stage, level + number * self.sites.count))
            descend(coords, axes[0], axes[1], state, spread, free, self._room, out[number])
        if drawn > 1:
            choices, out = out, np.empty_like(out[:1])
            scatter(choices, axes[0].at, axes[1].at, np.int64(1 << level), self._room.size, out[0])
        return np.asarray(out[0])

    def _corrected(self, coords: Array, level: int, spans: tuple[Span, Span], run: Run) -> Array:
        """Correct a level; what a subpass finds is written when all of it is found (S4-28). The margin is left out."""
        place, side = self.sites.levels[level], round(self.rules.subpasses**0.5)
        site, rule = place.ready(), np.array([*RULES[self.rules.rule], self.rules.factor], np.int64)
        work: Array = np.empty(coords.shape[:2], np.int32)
        positions(coords, place.border, place.stride, work)
        classes = [span.at % side for span in spans]
        with run.pool() as each:
            for number in range(self.rules.passes * self.rules.subpasses):
                here, edge = divmod(number % self.rules.subpasses, side), REACH * (number + 1)
                rows, cols = (
                    edge + np.flatnonzero(own[edge : len(own) - edge] == want)
                    for own, want in zip(classes, here, strict=True)
                )
                _subpass(work, (rows, cols), site, rule, each)
        margin = self.rules.margin
        out: Array = np.empty((len(work) - 2 * margin, work.shape[1] - 2 * margin, 2), np.int32)
        pixels(work, margin, place.border, place.stride, out)
        return out


def _subpass(work: Array, where: tuple[Array, Array], site: Site, rule: Array, each: Any) -> None:
    rows, cols = where
    found = np.empty((len(rows), len(cols)), np.int32)

    def band(low: int) -> None:
        correct(work, rows, cols, low, min(low + BAND, len(rows)), site, rule, found)

    each(band, range(0, len(rows), BAND))
    put(work, rows, cols, found)


def _place(span: Span, level: int, whole: int) -> Array:
    """Where in the output the pixels of a span lie, px: the middle of the squares that they stand for."""
    return _place_of(span.at, span, level, whole)


def _place_of(at: Array, span: Span, level: int, whole: int) -> Array:
    """The same for pixels `at`. A torus of `whole` px is shared out evenly among its pixels.

    Where they cannot all be `h` px apart, the odd steps lie in other places on every level.
    """
    if span.period:
        odd = 2 * span.period * (level * 79 % 128) // 128  # 79 / 128: about the golden section
        return np.asarray(((2 * at + 1) * whole + odd) // (2 * span.period))
    return np.asarray((at << level) + ((1 << level) >> 1))


def _whole_lattice(vectors: tuple[tuple[float, ...], ...] | None) -> Array:
    """Two lattice vectors as (y, x) in 1/256 px, right-handed; a single one gets one px across to it as the second."""
    if not vectors:
        return np.zeros((0, 2), np.int64)
    whole = [[round(256 * y), round(256 * x)] for x, y in vectors]
    if len(whole) == 1:
        (y, x), length = whole[0], math.hypot(*whole[0])
        whole.append([round(-256 * x / length), round(256 * y / length)])
    (ay, ax), (by, bx) = whole
    return np.array(whole if ay * bx > ax * by else whole[::-1], np.int64)


def _residues(places: Array, lattice: Array, axis: int) -> Array:
    """What is left of (place, 0) or (0, place) after whole steps of a lattice: (N, 2), 1/256 px, at any distance."""
    (ay, ax), (by, bx) = lattice.tolist()
    det, out = ay * bx - ax * by, []
    for place in places.tolist():
        y, x = (256 * place, 0) if axis == 0 else (0, 256 * place)
        m, n = (y * bx - x * by) // det, (ay * x - ax * y) // det
        out.append((y - m * ay - n * by, x - m * ax - n * bx))
    return np.array(out, np.int64)
