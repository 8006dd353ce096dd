"""Random sampling and gap filling as published: square blocks, wedge borders, the best fitting patch in each gap.

Which patch lies where depends only on its block and the seed: any window of the endless texture can be made alone.

Source: Lopez Recas 2011, 4.2. Departures: vectors are real, positions rounded from exact multiples; draws belong to
places, so that any window can be made alone; a wrapped canvas is closed by stretching the lattice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from scipy.fft import fft, ifft, irfft, next_fast_len, rfft

from ...analysis.features import features
from ...analysis.sums import running_sums, valid_windows
from ...arrays import Array, Int16, Int32, Laid, Mask, Pair
from ...blocks.mosaic import STRAIN, beside, returning
from ...canvas import Canvas
from ...draws import draw_many
from ...errors import MethodError, ParameterError
from ...exemplar import Exemplar, Exemplars
from ...geometry import Box
from ...lattice.candidates import UNIT
from ...lattice.lattice import Vector, cell_of, check_lattice, lattice_of, unfit
from ...params import AUTO
from ...patches.growing_map import drafted
from ...run import Run
from ...sourcemap import SourceMap
from . import sampling_kernels as kernels
from .gap_filling import GapFilling
from .goodness import lattice_by_goodness

STAGE = 20110
SEEDS = 4  # whose layouts are kept at a time
LONGEST = 256  # values compared at once: their squared differences fit into 32 bits
DENSE = (0.03, 0.01)  # share of an exemplar's places from which transforms are quicker; for correlation
TOGETHER = 16  # gaps that one call fills
ERROR = 1e-5  # of two lengths' product: far above what rounding in single precision does to a sum of products
MOST = 0.9  # share of a picture's variance in its main colours


def resolved(method: GapFilling, exemplars: Exemplars, canvas: Canvas) -> GapFilling:
    """Find the lattice; MethodError where there is none."""
    if method.lattice is AUTO and method.detector == "goodness":
        return replace(method, lattice=lattice_by_goodness(exemplars[0], method.channel_weights))
    if method.lattice is AUTO:
        return replace(method, lattice=lattice_of(exemplars[0], method.slug, method.channel_weights))
    check_lattice(method.lattice, exemplars[0])
    return method


def synthesize(method: GapFilling, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Pair the random blocks of the canvas, then fill the gaps."""
    laid, source = Sampling.of(method, exemplars[0], canvas, seed), exemplars[0].source
    drafting = run.drafting(lambda now: drafted(now, None, source, canvas.wrap))
    yx, _ = laid.window(0, 0, canvas.height, canvas.width, drafting)
    return SourceMap(yx, None, None, (source,), canvas.wrap, method.blend)


def window(method: GapFilling, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
    """Lay the blocks that a box meets; what they are read from is prepared once for an exemplar and a seed."""

    def prepared() -> Sampling:
        plane = Canvas(1, 1)
        return Sampling.of(method.resolved(exemplars, plane), exemplars[0], plane, seed)

    laid = exemplars[0].latest(f"gap-filling {seed % SEEDS}", (method, seed), prepared)
    yx, _ = laid.window(box.y0, box.x0, box.height, box.width, run)
    return SourceMap(yx, None, None, (exemplars[0].source,), blend=method.blend)


@dataclass(frozen=True)
class SquareBlocks:
    """Square blocks of a canvas, and the lattice under it."""

    block: Pair  # rows and columns of a block, px; around a wrapped canvas some are one px shorter
    lengths: Pair  # rows and columns of the canvas, px
    around: Pair  # how many blocks lie around it along each axis; 0 where it does not wrap
    # The lattice vectors, 1/256 px, that go once around; one px along the axis where it does not wrap.
    turns: tuple[Vector, Vector]

    @classmethod
    def of(cls, cell: tuple[Vector, Vector], side: int, canvas: Canvas) -> SquareBlocks:
        """Lay blocks of `side` px on a canvas; ParameterError where it does not close on the lattice."""
        rows = 2 * max(1, round(canvas.height / (2 * side))) if canvas.wrap.y else 0
        columns = 2 * max(1, round(canvas.width / (2 * side))) if canvas.wrap.x else 0
        block = -(-canvas.height // rows) if rows else side, -(-canvas.width // columns) if columns else side
        down = once_around(cell, canvas.height, 0) if rows else (UNIT, 0)
        across = once_around(cell, canvas.width, 1) if columns else (0, UNIT)
        return cls(block, (canvas.height, canvas.width), (rows, columns), (down, across))

    def begin(self, i: int, j: int) -> Pair:
        """First pixel of a block."""
        y, x = (
            n * length // count if count else n * side
            for n, length, count, side in zip((i, j), self.lengths, self.around, self.block, strict=True)
        )
        return y, x

    def block_of(self, y: int, x: int) -> Pair:
        """The block that holds a pixel."""
        i, j = (
            ((p + 1) * count - 1) // length if count else p // side
            for p, length, count, side in zip((y, x), self.lengths, self.around, self.block, strict=True)
        )
        return i, j

    def number(self, i: int, j: int) -> Pair:
        """Number of a block; around a wrapped canvas the numbers return."""
        return returning(self.around, i, j)

    def lattice_place(self, i: int, j: int) -> Pair:
        """Where a block begins in the lattice, 1/256 px: as on the canvas, less the stretch."""
        y, x = self.begin(*self.number(i, j))
        (a, b), (c, d) = self.turns
        tall, wide = (n if count else 1 for n, count in zip(self.lengths, self.around, strict=True))
        whole = tall * wide
        return (
            (2 * (y * a * wide + x * c * tall) + whole) // (2 * whole),
            (2 * (y * b * wide + x * d * tall) + whole) // (2 * whole),
        )


@dataclass(frozen=True, eq=False)
class Sampling:
    """An endless texture of square blocks."""

    picture: Int16  # (H, W, C): the exemplar's features
    valid: Mask  # where a patch with its border may begin in the exemplar
    cell: tuple[Vector, Vector]  # the lattice vectors (rows, columns), 1/256 px
    blocks: SquareBlocks  # how the canvas lies on the lattice, and where its blocks begin
    border: int  # px
    slack: int  # how far a gap's patch may leave the lattice, px
    correlate: bool  # compare borders by correlation in place of squared differences
    seed: int  # what the draws follow from
    ring: Array  # (n, 3): the px of a gap's border and the neighbour that each is read from
    runs: Array  # (n, 3): stretches of rows that make up the border, in the order in which they are compared
    sums: tuple[Array, Array]  # of values and of squares in the border of every place, (h, w, C)
    short_list: ShortList | None  # where places are so many that comparing them one by one would be slow
    everywhere: Array | None  # (n, 2): all places, where a gap's patch may come from any of them

    @classmethod
    def of(cls, method: GapFilling, exemplar: Exemplar, canvas: Canvas, seed: int) -> Sampling:
        """Prepare an exemplar; MethodError where its patches are too few."""
        picture = features([exemplar], method.channel_weights).pictures[0]
        v1, v2 = cell_of(method.lattice, picture.shape[:2])
        if v2 is None:
            raise ParameterError("gap-filling needs two lattice vectors; give both, or use method near-regular.")
        border = method.border
        laid = SquareBlocks.of((v1, v2), method.block, canvas)
        height, width = laid.block
        if border % 2 or border > min(height, width):
            raise ParameterError(
                f"border={border}: gap-filling needs an even border that is no wider than a block "
                f"({min(height, width)} px); choose another."
            )
        valid = valid_windows(picture.shape, exemplar.usable, False, (height + border, width + border))
        area = abs(v1[0] * v2[1] - v1[1] * v2[0])
        room = [max(0, n - 1) * UNIT for n in valid.shape]  # a px is lost by rounding; masks are seen later
        if math.prod(room) < area or max(room) < min(math.hypot(*v1), math.hypot(*v2)):
            raise _no_room(laid.block, border)
        ring = kernels.wedges(height, width, border)
        runs = _runs(ring, border, picture.shape)
        correlate = method.fit == "correlation"
        sums = kernels.ring_sums(picture, height, width, border)
        share = min(1.0, (2 * method.slack + 1) ** 2 * UNIT**2 / area)
        far = (math.hypot(*v1) + math.hypot(*v2)) / (2 * UNIT) + 1  # no px is farther from the lattice
        everywhere = np.argwhere(valid) if far <= method.slack else None
        listed = ShortList(picture, ring, sums, correlate) if share > DENSE[correlate] else None
        slack = method.slack
        return cls(picture, valid, (v1, v2), laid, border, slack, correlate, seed, ring, runs, sums, listed, everywhere)

    def window(
        self, y0: int, x0: int, height: int, width: int, run: Run | None = None
    ) -> tuple[Int32, None]:
        """The exemplar pixels (height, width, 2) of a window, all upright."""
        run = run or Run()
        out = np.zeros((height, width, 2), np.int32)
        (i0, j0), (i1, j1) = self.blocks.block_of(y0, x0), self.blocks.block_of(y0 + height - 1, x0 + width - 1)
        fields = [(i, j) for i in range(i0, i1 + 1) for j in range(j0, j1 + 1)]
        gaps = [f for f in fields if sum(f) % 2]
        drawn = self._sampled(sorted({n for f in gaps for n in beside(*f)} | {f for f in fields if sum(f) % 2 == 0}))
        parts = [gaps[k : k + TOGETHER] for k in range(0, len(gaps), TOGETHER)]
        filled: dict[Pair, Pair] = {}
        wave = 4 * run.workers

        def draft() -> Laid:
            now = np.full(out.shape, -1, np.int32)
            self._write_all(fields, drawn | filled, now, y0, x0)
            return np.maximum(now, 0), None, now[:, :, 0] >= 0

        with run.pool() as each:
            for k in range(0, len(parts), wave):
                run.tick(k, len(parts), draft)
                for made in each(lambda part: self._filled(part, drawn), parts[k : k + wave]):
                    filled |= made
        self._write_all(fields, drawn | filled, out, y0, x0)
        run.tick(len(parts), len(parts), draft)
        return out, None

    def _write_all(self, fields: list[Pair], found: dict[Pair, Pair], out: Array, y0: int, x0: int) -> None:
        """Write what of some blocks lies in a window, if they were found."""
        for f in fields:
            if f in found:
                self._write(f, found[f], out, y0, x0)

    def _sampled(self, blocks: list[Pair]) -> dict[Pair, Pair]:
        """Draw a patch for each block: all its places in the lattice are equally likely (4.2.1)."""
        first = np.array([self._first(*b) for b in blocks], np.int64).reshape(-1, 2)
        bits = [b >> 32 for b in draw_many(self.seed, STAGE, 0, [self.blocks.number(*b) for b in blocks])]
        v1, v2 = np.array(self.cell, np.int64)
        found = kernels.sampled(first, v1, v2, self.valid, np.array(bits, np.int64))
        if (found < 0).any():
            raise _no_room(self.blocks.block, self.border)
        return dict(zip(blocks, map(tuple, found.tolist()), strict=True))

    def _filled(self, gaps: list[Pair], drawn: dict[Pair, Pair]) -> dict[Pair, Pair]:
        """Find the patch for each gap whose border fits its four neighbours best (4.2.2)."""
        v1, v2 = np.array(self.cell, np.int64)
        channels = self.picture.shape[2]
        exemplar = self.picture.reshape(-1), self.picture.shape[1] * channels, channels, self.runs
        marks = np.zeros(self.valid.shape, np.uint8)
        border = np.empty(len(self.ring) * channels, np.int16)
        found = {}
        for gap in gaps:
            y, x = self.blocks.begin(*gap)
            sources = []
            for n in beside(*gap):
                (py, px), (by, bx) = drawn[n], self.blocks.begin(*n)
                sources.append((py - by + y, px - bx + x))  # both begin half a border before the block
            kernels.template(self.picture, self.ring, np.array(sources, np.int64), border)
            places = self.everywhere
            if places is None:
                first = np.array(self._first(*gap), np.int64)
                places = kernels.near_places(first, v1, v2, self.valid, self.slack, marks)
            if not len(places):
                raise _no_room(self.blocks.block, self.border)
            if self.short_list is not None:
                places = self.short_list.best(border, places)
            if self.correlate:
                best = kernels.best_by_correlation(*exemplar, border, places, *self.sums)
            else:
                best = kernels.best_by_difference(*exemplar, border, places)
            found[gap] = int(places[best, 0]), int(places[best, 1])
        return found

    def _first(self, i: int, j: int) -> Pair:
        """Where a block lies in the lattice, 1/256 px, its border included: near the exemplar's first pixel."""
        y, x = self.blocks.lattice_place(i, j)
        y, x = y - self.border // 2 * UNIT, x - self.border // 2 * UNIT
        (a, b), (c, d) = self.cell
        area = a * d - b * c
        m, n = (y * d - x * c) // area, (x * a - y * b) // area
        return y - m * a - n * c, x - m * b - n * d

    def _write(self, block: Pair, place: Pair, out: Array, y0: int, x0: int) -> None:
        """Write what of a block lies in a window."""
        (y, x), (v, u) = self.blocks.begin(*block), self.blocks.begin(block[0] + 1, block[1] + 1)
        top, left = max(y, y0), max(x, x0)
        bottom, right = min(v, y0 + out.shape[0]), min(u, x0 + out.shape[1])
        if bottom <= top or right <= left:
            return
        sy, sx = place[0] + self.border // 2 - y, place[1] + self.border // 2 - x
        part = out[top - y0 : bottom - y0, left - x0 : right - x0]
        part[:, :, 0] = np.arange(top + sy, bottom + sy)[:, None]
        part[:, :, 1] = np.arange(left + sx, right + sx)


def _runs(ring: Array, border: int, shape: tuple[int, ...]) -> Array:
    """Cut a border into stretches of rows; well spread, so that poor fits show early."""
    channels = shape[2]
    longest = max(1, min(border, LONGEST // channels))
    found, begin = [], 0
    for k in range(1, len(ring) + 1):
        next_one = k < len(ring) and ring[k, 0] == ring[k - 1, 0] and ring[k, 1] == ring[k - 1, 1] + 1
        if not next_one or k - begin == longest:
            y, x = ring[begin, :2].tolist()
            found.append(((y * shape[1] + x) * channels, begin * channels, (k - begin) * channels))
            begin = k
    runs = np.array(found, np.int64)
    return runs[np.argsort(np.arange(len(runs)) * 40503 % 65536, kind="stable")]


def _no_room(block: Pair, border: int) -> MethodError:
    return MethodError(
        f"no patch of {block[1]}x{block[0]} px with a border of {border} px fits into the exemplar at some place of "
        "the lattice; choose a smaller block or border, or a larger exemplar."
    )


def once_around(cell: tuple[Vector, Vector], length: int, axis: int) -> Vector:
    """The lattice vector that goes once around an axis of `length` px; ParameterError above 2 % of stretch."""
    (a, b), (c, d) = cell
    area = a * d - b * c

    def nearest(size: int) -> tuple[float, Vector]:
        y, x = goal = (size * UNIT, 0) if axis == 0 else (0, size * UNIT)
        m, n = (y * d - x * c) // area, (x * a - y * b) // area
        around = [(s, t) for s in range(m - 1, m + 3) for t in range(n - 1, n + 3) if (s, t) != (0, 0)]
        points = [(s * a + t * c, s * b + t * d) for s, t in around]
        return min((math.dist(v, goal), v) for v in points)

    off, best = nearest(length)
    if off <= STRAIN * length * UNIT:
        return best
    good: list[int] = []
    for sizes in (range(length - 1, 0, -1), range(length + 1, 5 * length + 4096)):
        good += islice((n for n in sizes if nearest(n)[0] <= STRAIN * n * UNIT / 2), 1)
    raise ParameterError(unfit(axis, length, "is no whole number of periods", off / (length * UNIT), good))


class ShortList:
    """Leave those of many places that may fit a border best, by Fourier transforms (Lopez Recas 2011, eq. 4.5).

    Rounding errors decide nothing: a place that may be the best but for them stays, to be compared in whole numbers.
    Of squared differences only the main axes of colour are transformed, mostly one, from dark to bright: a place that
    differs more along these than another does in all channels cannot be the best.
    """

    def __init__(self, picture: Array, ring: Array, sums: tuple[Array, Array], correlate: bool) -> None:
        self.picture, self.ring = picture, ring
        self.flat = [s.reshape(-1, picture.shape[2]).astype(np.float64) for s in sums]
        self.tall, self.wide = (int(n) + 1 for n in ring[:, :2].max(axis=0))
        self.size = tuple(next_fast_len(n, real=k == 1) for k, n in enumerate(picture.shape[:2]))
        self.mean = picture.mean(axis=(0, 1))
        centred = picture - self.mean
        self.axes = np.eye(len(self.mean)) if correlate else _main_colours(centred)
        seen = np.ascontiguousarray(np.moveaxis(centred @ self.axes, 2, 0), np.float32)
        self.length = float(np.sqrt(np.square(seen, dtype=np.float64).sum()))
        self.spectra = [fft(rfft(plane, self.size[1]), self.size[0], axis=0) for plane in seen]
        self.energy = None if correlate else self._energy(np.square(seen, dtype=np.float64).sum(axis=0))

    def best(self, border: Array, places: Array) -> Array:
        """The places (n, 2) among which is the best for a border (n C,), all ties included, in their order."""
        values = border.reshape(len(self.ring), -1)
        own = (values - self.mean) @ self.axes
        product = self._products(own.astype(np.float32))
        at = places[:, 0] * product.shape[1] + places[:, 1]
        if self.energy is not None:
            return self._least(values, own, product, places, at)
        return self._correlated(values, own, product.reshape(-1)[at], places, at)

    def _least(self, values: Array, own: Array, product: Array, places: Array, at: Array) -> Array:
        """Those that differ no more in the main colours than one of them does in all channels."""
        length = float(np.sqrt((own * own).sum()))
        least = (self.energy - 2 * product).reshape(-1)[at] + length * length
        y, x = self.ring[:, :2].T + places[int(np.argmin(least))][:, None]
        known = int(np.square(self.picture[y, x].astype(np.int64) - values).sum())
        return np.asarray(places[least <= known + ERROR * (known + 4 * length * self.length)])

    def _correlated(self, values: Array, own: Array, product: Array, places: Array, at: Array) -> Array:
        """Those that may correlate best (GNCC of all channels)."""
        n, exact = len(self.ring), values.astype(np.float64)
        sums, squares = (s.take(at, axis=0) for s in self.flat)
        own_sums, own_squares = exact.sum(axis=0), np.square(exact).sum(axis=0)
        spread = (n * squares - sums * sums) * (n * own_squares - own_sums * own_sums)
        below = np.sqrt(np.maximum(spread, 0)).sum(axis=1)
        covered = n * product - (sums - n * self.mean) @ (own_sums - n * self.mean)
        fit = np.where(below > 0, covered / np.maximum(below, 1.0), 0.0)
        error = ERROR * n * self.length * float(np.sqrt((own * own).sum())) / np.maximum(below, 1.0) * (below > 0)
        return np.asarray(places[fit + error >= (fit - error).max() - ERROR])

    def _products(self, own: Array) -> Array:
        """Sums of products of a border (n, k) and every place of the exemplar: (h, w)."""
        rows, columns = (n - m + 1 for n, m in zip(self.picture.shape, (self.tall, self.wide), strict=False))
        laid = np.zeros((self.tall, self.wide), np.float32)
        total: Any = 0.0
        for spectrum, values in zip(self.spectra, own.T, strict=True):
            laid[self.ring[:, 0], self.ring[:, 1]] = values
            mine = fft(rfft(laid, self.size[1]), self.size[0], axis=0, overwrite_x=True)
            total = total + spectrum * np.conj(mine, out=mine)
        lines = ifft(total, axis=0, overwrite_x=True)[:rows]  # no border begins in the rows below
        return np.asarray(irfft(lines, self.size[1]))[:, :columns]

    def _energy(self, squares: Array) -> Array:
        """Add up squares (H, W) in the border of every place: (h, w)."""
        running = running_sums(squares, np.float64)
        rows, columns = running.shape[0] - self.tall, running.shape[1] - self.wide
        hole = np.ones((self.tall, self.wide), bool)
        hole[self.ring[:, 0], self.ring[:, 1]] = False
        inner = np.argwhere(hole)
        boxes = [(1, 0, 0, self.tall, self.wide)]
        if len(inner):
            boxes.append((-1, *inner[0].tolist(), *(inner[-1] + 1).tolist()))
        total = np.zeros((rows, columns))
        for sign, y0, x0, y1, x1 in boxes:
            for y, x, part in ((y1, x1, sign), (y0, x1, -sign), (y1, x0, -sign), (y0, x0, sign)):
                total += part * running[y : y + rows, x : x + columns]
        return total.astype(np.float32)


def _main_colours(centred: Array) -> Array:
    """The fewest directions of colour (C, k), each of length 1, that hold most of how a picture (H, W, C) varies."""
    flat = centred.reshape(-1, centred.shape[2])
    spread, directions = np.linalg.eigh(flat.T @ flat)  # the strongest last; which way they point does not matter here
    held = spread[::-1].cumsum() >= MOST * spread.sum()
    return np.asarray(directions[:, ::-1][:, : int(held.argmax()) + 1])
