"""Coarse-to-fine pyramid for any window of an endless map: upsample, jitter, correct (Lefebvre and Hoppe 2005).

A pixel of the map depends only on its absolute position, the seed and the parameters. To compute a window, every level
is computed with the margin that the corrections of the next finer level read.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..foundation.arrays import Array, Pair
from ..foundation.field import Field
from ..foundation.run import Run, seed_state
from ..model import Exemplar
from .appearance import above_half
from .correction_kernels import (
    AROUND,
    FINE,
    ONE,
    SCATTER_CLASSES,
    SCATTER_REACH,
    UNIT,
    CoordinateDomain,
    correct,
    jittered,
    spread_large_pieces,
    subpixel_offsets,
)
from .guide import StackGuide
from .span import (
    Orientation,
    Span,
    Spans,
    place_of,
    places_of,
    previewed,
    residues,
    turns,
    warped_origins,
    whole_lattice,
    zooms,
)
from .stack import ExemplarStack, StackLevel

# Halved and doubled on 24 textures, eight of them with a lattice (docs/design/012).
STAGE = 200505  # key of these random numbers, which makes them independent of other methods
REACH = 2  # px that a correction reads on each side: 5 x 5 neighbourhoods (2005, 2006)
OFF_LATTICE = 2  # finest levels, whose jitter is not by lattice vectors; 4: seams cost more on five of eight textures
ALWAYS_CORRECTED = 3  # finest levels, corrected even without jitter; 1: straight seams, 6: elements are lost
PLACES_DRAWN = 8  # places drawn per piece of half the exemplar; 4, 16: like another seed; 1: 1/4 more px unused
SIDE = 1024  # places along each axis at which functions are evaluated in one call
BAND = 32  # rows of a parallel task; 8 and 128: the same bytes
# By rule: reach of the candidates in px, and 1 if jumps are looked up before shifting, as in 2005. "near" is our own,
# "published" is of 2005, "memo" of the memorandum (S4-05).
RULES = {"near": (1, 0), "published": (1, 1), "memo": (2, 0)}
ALL = Field(1.0)  # all of the jitter



@dataclass(frozen=True)
class CorrectionParameters:
    """Parameters of the corrections: `passes` of `subpasses` each, candidates, and the factor of jumps.

    ``jitter``: amplitude on each level, in 1 / 4096 of its spacing, from the finest on; the last holds for all coarser
    ones. ``factor``: multiplies the squared distances of jumps, 256 = 1; -1: no jumps.
    """

    jitter: tuple[int, ...]
    factor: int
    passes: int
    subpasses: int = 4  # by even and odd rows and columns; correction-2008 sets others, and other rules
    rule: str = "near"
    lattice: tuple[tuple[float, ...], ...] | None = None  # vectors (x, y), px, by which jitter moves pixels
    pins: tuple[tuple[int, ...], ...] = ()  # exemplar x, y, output x, y, radius, px: copied there
    orientation: Orientation | None = None  # rotation and scale; None: as in the exemplar
    # Factors of the jitter, 0 to 1: by output position, and by exemplar position before jitter (2005, section 5).
    output: Field = ALL
    exemplar: Field = ALL

    @classmethod
    def of(cls, method: Any) -> CorrectionParameters:
        """Return the parameters given by the fields of a method."""
        jitter = method.jitter if isinstance(method.jitter, tuple) else (method.jitter,)
        factor = -1 if method.kappa == "inf" else round(ONE * float(method.kappa) ** 2)
        steps = tuple(round((1 << FINE) * r) for r in jitter)
        given = method.jitter_output, method.jitter_exemplar
        output, exemplar = (ALL if v is None else v if isinstance(v, Field) else Field(v) for v in given)
        pins, lie = method.pin or (), Orientation.of(method.angle, method.zoom)
        own = {name: getattr(method, name) for name in ("subpasses", "rule") if hasattr(method, name)}
        return cls(
            steps, factor, method.passes, lattice=method.lattice, pins=pins, orientation=lie, output=output,
            exemplar=exemplar, **own,
        )  # fmt: skip

    @property
    def everywhere(self) -> bool:
        """Whether both factors of the jitter are 1 everywhere."""
        return self.output.number == self.exemplar.number == 1

    @property
    def margin(self) -> int:
        """How many px around a window the corrections of a level read."""
        return REACH * self.passes * self.subpasses

    @property
    def border(self) -> int:
        """How far beyond the exemplar a correction may read, in units of the level's spacing."""
        return REACH if self.orientation is None else self.orientation.reach

    def spread(self, level: int) -> int:
        """Return the jitter amplitude of a level, in 1 / 4096 px."""
        return self.jitter[min(level, len(self.jitter) - 1)] << level


@dataclass(frozen=True)
class PyramidSynthesis:
    """Synthesises windows of the endless map, from the coarsest level to the finest."""

    stack: ExemplarStack
    rules: CorrectionParameters
    seed: int
    wanted: StackGuide | None = None  # the guide of a canvas whose first pixel is (0, 0)

    def window(self, rows: Span, cols: Span, run: Run, least: int = 0) -> Array:
        """Return the exemplar pixels (y, x) of the output pixels of two spans: (rows, columns, 2) int32.

        `least`: the finest level to compute; above 0 each pixel stands for 2**least px a side.
        """
        spans = self._spans(rows, cols, least)
        top = len(spans) - 1
        if self.wanted is not None:
            self.wanted.lay([places_of(level, spans) for level in range(len(spans))])
        frame = self._frame(top, spans)
        coords = self._first(spans, frame)

        def drafted(coords: Array, level: int) -> Array:
            return previewed(coords, places_of(level, spans), (rows, cols), self._room.size)

        for level in range(top, least - 1, -1):
            part = run.part(top - level, top + 1)
            part.tick(0, 1, partial(drafted, coords, min(level + 1, top)))
            if level < top:
                frame = self._frame(level, spans)
                coords = self._upsampled(coords, level, spans, frame)
            if level < self._corrected_levels:
                drafting = part.drafting(partial(drafted, level=level))
                coords = self._corrected(coords, level, spans, drafting, frame)
            elif edge := self._margin(level):
                coords = coords[edge:-edge, edge:-edge]
        run.part(top, top + 1).tick(1, 1, partial(drafted, coords, least))
        return coords

    def asked(self, rows: Span, cols: Span) -> list[list[Array]]:
        """Return the positions at which fields over the output are evaluated: rows and columns in px, per level.

        Those of a window are contained in those of any larger window around it.
        """
        spans = self._spans(*self._wider(rows, cols))
        return [places_of(level, spans) for level in range(len(spans))]

    def oriented_window(self, rows: Span, cols: Span, run: Run) -> tuple[Array, Array, Array]:
        """Return the map of a rotated or scaled texture, J of every pixel, (H, W, 2, 2) float32, and its remainder.

        The remainder, (H, W, 2) float32 in px, is a pixel's exact exemplar position minus its whole coordinates.
        """
        coords, frame = self.window(*self._wider(rows, cols), run), self._frame(0, [(rows, cols)])
        assert frame is not None
        size, unit = frame.shape[:2], np.float32(1 / (1 << UNIT))  # a power of two, and few bits: all is exact
        sub = np.empty((*size, 2), np.int32)
        subpixel_offsets(coords, frame, self._room.size, sub)
        whole = np.ascontiguousarray(coords[AROUND:-AROUND, AROUND:-AROUND])
        return whole, frame.astype(np.float32).reshape(*size, 2, 2) * unit, sub.astype(np.float32) * unit

    def _wider(self, rows: Span, cols: Span) -> Spans:
        """Return the spans of the finest level that are needed, which are wider if pixels are interpolated."""
        return rows.wider(self.around), cols.wider(self.around)

    @property
    def around(self) -> int:
        """How many px more than the output are needed on each side."""
        return 0 if self.rules.orientation is None else AROUND

    def _frame(self, level: int, spans: list[Spans]) -> Array | None:
        """Return J at the pixels of a level, or None if the texture is neither rotated nor scaled."""
        return None if self.rules.orientation is None else self.rules.orientation.at(*places_of(level, spans))

    @cached_property
    def _corrected_levels(self) -> int:
        """How many levels are corrected: up to the coarsest one with jitter."""
        most = len(self.stack.levels)
        moved = [level + 1 for level in range(most) if self.rules.spread(level)]
        return max([min(ALWAYS_CORRECTED, most), *moved])

    def _scattered(self, level: int) -> bool:
        """Return whether pieces of a level are scattered: the level of half the exemplar, jittered, not corrected."""
        return level == self.stack.count - 2 and level >= self._corrected_levels and self.rules.spread(level) > 0

    def _margin(self, level: int) -> int:
        if level < self._corrected_levels:  # a guide reads 1 px around before the first correction
            return self.rules.margin + (self.wanted is not None)
        return SCATTER_REACH * (SCATTER_CLASSES - 1) if self._scattered(level) else 0

    def _spans(self, rows: Span, cols: Span, least: int = 0) -> list[Spans]:
        """Return the rows and columns needed of each level before it is corrected, from the finest to the coarsest."""
        edges = [self._margin(level) if level >= least else 0 for level in range(self.stack.count)]
        spans = [(rows.wider(edges[0]), cols.wider(edges[0]))]
        for edge in edges[1:]:
            above = [span.above().wider(edge) for span in spans[-1]]
            spans.append((above[0], above[1]))
        return spans

    def _first(self, spans: list[Spans], frame: Array | None) -> Array:
        """Return the coarsest level: the exemplar tiled, or aligned to the lattice, then jittered."""
        room, top = self._room, self.stack.count - 1
        places = places_of(top, spans)
        if frame is not None:
            start = warped_origins(frame, places[0], places[1], room.size, room.lattice)
        elif len(room.lattice):
            down, across = (residues(place, room.lattice, axis) for axis, place in enumerate(places))
            start = (down[:, None] + across[None, :] + 128) >> 8
        else:
            start = np.stack(np.meshgrid(places[0] % room.size[0], places[1] % room.size[1], indexing="ij"), axis=2)
        return self._begun(start, top, spans, frame)

    @cached_property
    def _room(self) -> CoordinateDomain:
        exemplar = self.stack.exemplar
        size = np.array([exemplar.height, exemplar.width, exemplar.toroidal], np.int64)
        return CoordinateDomain(size, self.stack.home, whole_lattice(self.rules.lattice))

    def _upsampled(
        self, coords: Array, level: int, spans: list[Spans], frame: Array | None
    ) -> Array:
        """Return a level upsampled from the next coarser one (2006, equation 2), then jittered."""
        parents, steps = [], []
        for span, above, whole in zip(spans[level], spans[level + 1], spans[0], strict=True):
            up = span.at >> 1
            parents.append(up - above.start - self._margin(level + 1))
            own, coarse = (span.at, span.period, level), (up, above.period, level + 1)
            steps.append(place_of(*own, whole.period) - place_of(*coarse, whole.period))
        coords, down, across = coords[np.ix_(*parents)], steps[0][:, None], steps[1]
        if frame is not None:
            return self._begun(coords + stepped(frame, down, across), level, spans, frame)
        coords[..., 0] += down
        coords[..., 1] += across
        return self._begun(coords, level, spans, None)

    @cached_property
    def _exemplar_shares(self) -> Array:
        exemplar = self.stack.exemplar
        return jitter_shares(self.rules.exemplar, np.arange(exemplar.height), np.arange(exemplar.width))

    def _begun(self, coords: Array, level: int, spans: list[Spans], frame: Array | None) -> Array:
        """Return the coordinates of a level after jitter, the scatter of large pieces, the guide and the pins."""
        places, (rows, cols) = places_of(level, spans), (span.at for span in spans[level])
        drawn = PLACES_DRAWN if self._scattered(level) else 1
        out = np.empty((drawn, *coords.shape), np.int32)
        spread = np.array([[self.rules.spread(level)]], np.int64)
        if spread.any() and not self.rules.everywhere:
            output = jitter_shares(self.rules.output, *places)
            spread = local_jitter(self.rules.spread(level), output, self._exemplar_shares, coords)
        lattice = self._room.lattice if level >= OFF_LATTICE else self._room.lattice[:0]
        for number in range(drawn):
            state = np.uint64(seed_state(self.seed, STAGE, level + number * self.stack.count))
            jittered(coords, rows, cols, state, spread, not len(lattice), self._room, out[number])
        made: Array = out[0]
        if drawn > 1:
            made = np.empty_like(out[0])
            spread_large_pieces(out, rows, cols, np.int64(1 << level), self._room.size, made)
        if self.wanted is not None:
            made = self.wanted.placed_by_guide(made, level, (rows, cols), (self.seed, STAGE + 1), lattice)
        for pin in self.rules.pins if level >= OFF_LATTICE else ():
            pinned(made, places, (spans[0][0].period, spans[0][1].period), pin, self.stack.exemplar, frame)
        return made

    def _without_jitter(self, coords: Array, level: int, spans: list[Spans]) -> Array | None:
        """Return which pixels of a level have no jitter, and so are not corrected; None: no pixel, or a fine level."""
        if level < ALWAYS_CORRECTED or self.rules.everywhere:
            return None
        over = jitter_shares(self.rules.output, *places_of(level, spans))
        return np.asarray(over * self._exemplar_shares[coords[..., 0], coords[..., 1]] == 0)

    def _corrected(
        self, coords: Array, level: int, spans: list[Spans], run: Run, frame: Array | None = None
    ) -> Array:
        """Return a level corrected, without its margin; a subpass reads the map before it."""
        place, side = self.stack.levels[level].ready(), round(self.rules.subpasses**0.5)
        if self.wanted is not None:
            place = self.wanted.beside(place, level)
        work = place.positions(coords)
        classes, still = [span.at % side for span in spans[level]], self._without_jitter(coords, level, spans)
        with run.pool() as each:
            for number in range(self.rules.passes * self.rules.subpasses):
                run.tick(number, self.rules.passes * self.rules.subpasses, partial(place.pixels, work))
                here, edge = divmod(number % self.rules.subpasses, side), REACH * (number + 1)
                rows, cols = (
                    edge + np.flatnonzero(own[edge : len(own) - edge] == want)
                    for own, want in zip(classes, here, strict=True)
                )
                found = subpass(work, (rows, cols), place, self.rules, frame, run, each)
                where = np.ix_(rows, cols)
                work[where] = found if still is None else np.where(still[where], work[where], found)
        margin = self._margin(level)
        return place.pixels(work[margin : len(work) - margin, margin : work.shape[1] - margin])


def subpass(
    work: Array, where: tuple[Array, Array], level: StackLevel, rules: CorrectionParameters, frame: Array | None,
    run: Run, each: Any,
) -> Array:  # fmt: skip
    """Return corrected positions for some rows and columns of a map, in parallel bands; the map is unchanged."""
    rows, cols = where
    found = np.empty((len(rows), len(cols)), np.int32)
    rule = np.array([*RULES[rules.rule], rules.factor], np.int64)

    def band(low: int) -> None:
        run.check()
        correct(work, rows, cols, low, min(low + BAND, len(rows)), level, rule, frame, found)

    each(band, range(0, len(rows), BAND))
    return found


def stepped(frame: Array, down: Array, across: Array) -> Array:
    """Return J, the frame of each pixel, times an offset, in whole px: (H, W, 2)."""
    j = frame.astype(np.int64)
    rows = ((j[..., n] * down + j[..., n + 1] * across + (1 << (UNIT - 1))) >> UNIT for n in (0, 2))
    return np.stack(tuple(rows), axis=2)


def pinned(
    coords: Array, places: list[Array], periods: Pair, pin: tuple[int, ...], exemplar: Exemplar, frame: Array | None
) -> None:
    """Write a feature into the coordinates (H, W, 2) of a level: S[p] = u + J(p) (h p - q) in a disc around q.

    Drag and drop (2005, section 5). ``pin``: exemplar x, y, output x, y, radius; ``places``: rows and columns of the
    level in the output, px; ``periods``: of the output along y and x, or 0.
    """
    sx, sy, to_x, to_y, radius = pin
    away = []
    for at, period, q in zip(places, periods, (to_y, to_x), strict=True):
        d = at - q
        away.append((d + period // 2) % period - period // 2 if period else d)
    rows, cols = (np.flatnonzero(abs(d) <= radius) for d in away)
    dy, dx = np.meshgrid(away[0][rows], away[1][cols], indexing="ij")
    inside = dy * dy + dx * dx <= radius**2
    if frame is not None:
        dy, dx = np.moveaxis(stepped(frame[np.ix_(rows, cols)], dy, dx), 2, 0)
    y, x = sy + dy, sx + dx
    inside &= (y >= 0) & (x >= 0) & (y < exemplar.height) & (x < exemplar.width)
    if exemplar.usable is not None:
        inside[inside] &= exemplar.usable[y[inside], x[inside]]
    block = coords[np.ix_(rows, cols)]
    block[inside] = np.stack([y[inside], x[inside]], axis=1)
    coords[np.ix_(rows, cols)] = block


def local_jitter(whole: int, output: Array, exemplar: Array, coords: Array) -> Array:
    """Return the jitter amplitude of each pixel of a level, in 1 / 4096 px: (H, W) int64.

    `whole`: amplitude of the level; `output` (H, W) and `exemplar` (H', W'): factors of pixels of the level and of the
    exemplar in 1 / 4096, the latter read at the coordinates `coords` before jitter, wrapped into the exemplar.
    """
    part = output * exemplar[coords[..., 0] % exemplar.shape[0], coords[..., 1] % exemplar.shape[1]]
    return np.asarray((whole * part + (1 << (2 * FINE - 1))) >> (2 * FINE))


def jitter_shares(field: Field, rows: Array, cols: Array) -> Array:
    """Return the factor of the jitter at places, in 1 / 4096: (rows, columns) int64."""
    return np.asarray(np.rint(field.at(rows, cols) * (1 << FINE)), np.int64)


INTEGERS_OF: dict[str, Callable[[Field, Array, Array], Array]] = {
    "angle": turns,
    "feature": above_half,
    "jitter_exemplar": jitter_shares,
    "jitter_output": jitter_shares,
    "zoom": zooms,
}
"""Function parameter -> conversion to the integers that are used, so that hashes differ exactly if pictures may."""


def field_hash(field: Field, used: Callable[[Field, Array, Array], Array], places: list[list[Array]]) -> str:
    """Return SHA-256, 64 hexadecimal digits, of the integers of a field at places (rows, columns).

    `used`: the conversion to integers, of INTEGERS_OF.
    """
    found = hashlib.sha256()
    for rows, cols in places:
        found.update(f"{len(rows)}x{len(cols)}|".encode())
        for y in range(0, len(rows), SIDE):
            for x in range(0, len(cols), SIDE):
                numbers = used(field, rows[y : y + SIDE], cols[x : x + SIDE])
                found.update(numbers.astype("<i2").tobytes())
    return found.hexdigest()
