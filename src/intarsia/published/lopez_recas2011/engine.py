"""Engine of random sampling and gap filling: square blocks, mitred borders, the best matching patch in each gap.

Which patch is placed where depends only on its block and the seed, so any window of the endless texture can be made
alone.

Source: Lopez Recas 2011, 4.2. Departures: vectors are real, positions rounded from exact multiples; draws belong to
places, so that any window can be made alone; a wrapped canvas is closed by stretching the lattice.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from itertools import islice

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2

from ...analysis import valid_windows
from ...analysis.features import features
from ...foundation import MethodError, ParameterError
from ...foundation.arrays import Array, Int32, Laid, Pair
from ...foundation.geometry import UNIT, Box
from ...foundation.params import AUTO
from ...foundation.run import Run, below, draw
from ...lattice import STRAIN, Vector, cell_of, check_lattice, lattice_of, misfit_message
from ...lattice.correlation_peaks import lattice_points
from ...model import Exemplar, Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import SourceMap
from ...patches import drafted
from ...regular.block_grid import adjacent_blocks
from . import engine_kernels as kernels
from .gap_filling import GapFilling
from .goodness import lattice_by_goodness

STAGE = 20110
SEEDS = 4  # prepared samplings cached at a time
LONGEST = 256  # values compared at once: their squared differences fit into 32 bits
DENSE = 0.03  # share of an exemplar's places from which transforms are quicker
TOGETHER = 64  # gaps filled per thread between two progress reports


def resolved(method: GapFilling, exemplars: Exemplars, canvas: Canvas) -> GapFilling:
    """Return the method with its lattice; MethodError if none is found."""
    if method.lattice is not AUTO:
        check_lattice(method.lattice, exemplars[0])
        return method
    if method.detector == "goodness":
        return replace(method, lattice=lattice_by_goodness(exemplars[0], method.channel_weights))
    return replace(method, lattice=lattice_of(exemplars[0], method.slug, method.channel_weights))


def synthesize(method: GapFilling, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Place the random blocks of the canvas, then fill the gaps."""
    laid, source = Sampling(method, exemplars[0], canvas, seed), exemplars[0].source
    drafting = run.drafting(lambda now: drafted(now, source, canvas.wrap))
    yx = laid.window(0, 0, canvas.height, canvas.width, drafting)
    return SourceMap(yx, None, None, (source,), canvas.wrap, method.blend)


def window(method: GapFilling, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
    """Place the blocks that meet a box; the exemplar is prepared once per method and seed."""

    def prepared() -> Sampling:
        plane = Canvas(1, 1)
        return Sampling(method.resolved(exemplars, plane), exemplars[0], plane, seed)

    laid = exemplars[0].latest(f"gap-filling {seed % SEEDS}", (method, seed), prepared)
    yx = laid.window(box.y0, box.x0, box.height, box.width, run)
    return SourceMap(yx, None, None, (exemplars[0].source,), blend=method.blend)


class SquareBlocks:
    """The grid of square blocks on a canvas, and its relation to the lattice.

    ``block``: rows and columns of a block, px; around a wrapped canvas some are one px shorter. ``lengths``: rows and
    columns of the canvas, px. ``around``: how many blocks lie around it along each axis; 0 where it does not wrap.
    ``turns``: the lattice vectors, 1/256 px, that go once around; one px along the axis where it does not wrap.
    """

    def __init__(self, cell: tuple[Vector, Vector], side: int, canvas: Canvas) -> None:
        """Divide a canvas into blocks of `side` px; ParameterError if it wraps but does not close on the lattice."""
        self.lengths = canvas.height, canvas.width
        rows, columns = (
            2 * max(1, round(n / (2 * side))) if wraps else 0
            for n, wraps in zip(self.lengths, (canvas.wrap.y, canvas.wrap.x), strict=True)
        )
        self.around = rows, columns
        high, wide = (-(-n // count) if count else side for n, count in zip(self.lengths, self.around, strict=True))
        self.block = high, wide
        down = closing_vector(cell, canvas.height, 0) if rows else (UNIT, 0)
        self.turns = down, closing_vector(cell, canvas.width, 1) if columns else (0, UNIT)

    def begin(self, i: int, j: int) -> Pair:
        """Return the first pixel of a block."""
        y, x = (
            n * length // count if count else n * side
            for n, length, count, side in zip((i, j), self.lengths, self.around, self.block, strict=True)
        )
        return y, x

    def block_of(self, y: int, x: int) -> Pair:
        """Return the block that holds a pixel."""
        i, j = (
            ((p + 1) * count - 1) // length if count else p // side
            for p, length, count, side in zip((y, x), self.lengths, self.around, self.block, strict=True)
        )
        return i, j

    def number(self, i: int, j: int) -> Pair:
        """Return the number of a block, modulo the number of blocks on a wrapped canvas."""
        rows, columns = self.around
        return (i % rows if rows else i), (j % columns if columns else j)

    def lattice_place(self, i: int, j: int) -> Pair:
        """Return where a block begins on the unstretched lattice, 1/256 px."""
        y, x = self.begin(*self.number(i, j))
        tall, wide = (n if count else 1 for n, count in zip(self.lengths, self.around, strict=True))
        whole = tall * wide
        twice = (2 * (y * a * wide + x * c * tall) for a, c in zip(*self.turns, strict=True))
        down, along = ((n + whole) // (2 * whole) for n in twice)
        return down, along


class Sampling:
    """An endless texture of square blocks."""

    def __init__(self, method: GapFilling, exemplar: Exemplar, canvas: Canvas, seed: int) -> None:
        """Prepare an exemplar; ParameterError, or MethodError if it has no room for a patch."""
        self.method, self.seed, border = method, seed, method.border
        self.picture = features([exemplar], method.channel_weights).pictures[0]
        v1, v2 = cell_of(method.lattice, self.picture.shape[:2])
        if v2 is None:
            raise ParameterError("gap-filling needs two lattice vectors; give both, or use method near-regular.")
        self.cell, self.blocks = (v1, v2), SquareBlocks((v1, v2), method.block, canvas)
        height, width = self.blocks.block
        if border % 2 or border > min(height, width):
            raise ParameterError(
                f"border={border}: gap-filling needs an even border that is no wider than a block "
                f"({min(height, width)} px); choose another."
            )
        self.valid = valid_windows(self.picture.shape, exemplar.usable, False, (height + border, width + border))
        area = abs(v1[0] * v2[1] - v1[1] * v2[0])
        room = [max(0, n - 1) * UNIT for n in self.valid.shape]  # a px is lost by rounding; masks are seen later
        if math.prod(room) < area or max(room) < min(math.hypot(*v1), math.hypot(*v2)):
            raise self._no_room()
        self.ring = mitred_border(height, width, border)
        self.runs = _runs(self.ring, border, self.picture.shape)
        # For correlation, and where there are so many places that comparing one by one would be slow.
        many = method.fit == "correlation" or min(1.0, (2 * method.lattice_tolerance + 1) ** 2 * UNIT**2 / area) > DENSE
        self.transforms = FourierMatcher(self.picture, self.ring) if many else None
        far = (math.hypot(*v1) + math.hypot(*v2)) / (2 * UNIT) + 1  # no px is farther from the lattice
        self.everywhere = np.argwhere(self.valid) if far <= method.lattice_tolerance else None

    def window(self, y0: int, x0: int, height: int, width: int, run: Run) -> Int32:
        """Return the exemplar pixels (height, width, 2) of a window, all upright."""
        (i0, j0), (i1, j1) = self.blocks.block_of(y0, x0), self.blocks.block_of(y0 + height - 1, x0 + width - 1)
        fields = [(i, j) for i in range(i0, i1 + 1) for j in range(j0, j1 + 1)]
        gaps = [f for f in fields if sum(f) % 2]
        found = {f: self._drawn(f) for f in {n for f in gaps for n in adjacent_blocks(*f)} | {*fields} - {*gaps}}
        wave = TOGETHER * run.workers

        def draft() -> Laid:
            now = np.full((height, width, 2), -1, np.int32)
            for field in fields:
                if field in found:
                    self._write(field, found[field], now, y0, x0)
            return np.maximum(now, 0), None, now[:, :, 0] >= 0

        with run.pool() as each:
            for k in range(0, len(gaps), wave):
                run.tick(k, len(gaps), draft)
                some = gaps[k : k + wave]
                found.update(zip(some, each(lambda gap: self._filled(gap, found), some), strict=True))
        run.tick(len(gaps), len(gaps), draft)
        return draft()[0]

    def _places(self, block: Pair, slack: int) -> Array:
        """Return the lattice-aligned places of a block, up to `slack` px beyond the exemplar: (n, 2) px."""
        y, x = (at - self.method.border // 2 * UNIT for at in self.blocks.lattice_place(*block))
        (a, b), (c, d) = self.cell
        area = a * d - b * c
        m, n = (y * d - x * c) // area, (x * a - y * b) // area  # to what lies near the exemplar's first pixel
        low, high = (-slack, -slack), [side - 1 + slack for side in self.valid.shape]
        return (lattice_points((y - m * a - n * c, x - m * b - n * d), *self.cell, low, high) + UNIT // 2) // UNIT

    def _drawn(self, block: Pair) -> Pair:
        """Draw a patch for a block: all its lattice-aligned places are equally likely (4.2.1)."""
        places = self._places(block, 0)
        places = places[self.valid[*places.T]]
        if not len(places):
            raise self._no_room()
        y, x = places[below(len(places), draw(self.seed, STAGE, 0, *self.blocks.number(*block)))].tolist()
        return y, x

    def _filled(self, gap: Pair, drawn: dict[Pair, Pair]) -> Pair:
        """Return the patch for a gap whose border matches its four neighbours best (4.2.2)."""
        sources = [  # both begin half a border before the block
            np.array(drawn[n]) - self.blocks.begin(*n) + self.blocks.begin(*gap) for n in adjacent_blocks(*gap)
        ]
        border = self.picture[*(self.ring[:, :2] + np.array(sources)[self.ring[:, 2]]).T]
        places = self.everywhere
        if places is None:
            slack = self.method.lattice_tolerance
            places = np.argwhere(kernels.near_lattice(self._places(gap, slack), self.valid, slack))
        if not len(places):
            raise self._no_room()
        if self.transforms is not None:
            best = self.transforms.best(border.T.astype(np.int64), places, self.method.fit == "correlation")
        else:
            best = kernels.best_place(self.picture, self.runs, border.ravel(), places)
        y, x = places[best].tolist()
        return y, x

    def _write(self, block: Pair, place: Pair, out: Array, y0: int, x0: int) -> None:
        """Write the part of a block that lies in a window."""
        (y, x), (v, u) = self.blocks.begin(*block), self.blocks.begin(block[0] + 1, block[1] + 1)
        top, left = max(y, y0), max(x, x0)
        bottom, right = min(v, y0 + out.shape[0]), min(u, x0 + out.shape[1])
        if bottom <= top or right <= left:
            return
        sy, sx = (p + self.method.border // 2 - at for p, at in zip(place, (y, x), strict=True))
        part = out[top - y0 : bottom - y0, left - x0 : right - x0]
        part[:, :, 0] = np.arange(top + sy, bottom + sy)[:, None]
        part[:, :, 1] = np.arange(left + sx, right + sx)

    def _no_room(self) -> MethodError:
        height, width = self.blocks.block
        return MethodError(
            f"no patch of {width}x{height} px with a border of {self.method.border} px fits into the exemplar at some "
            "place of the lattice; choose a smaller block or border, or a larger exemplar."
        )


def mitred_border(height: int, width: int, border: int) -> Array:
    """Return the border pixels of a gap of height x width px: (n, 3), row and column from its outer corner, and side.

    The border is centred on the edge. Sides: 0 above, 1 below, 2 left, 3 right; they meet in 45 degree mitres.
    """
    y, x = np.indices((height + border, width + border))
    depths = np.stack([y, y[::-1], x, x[:, ::-1]])
    at = np.argwhere(depths.min(axis=0) < border)
    return np.column_stack([at, depths.argmin(axis=0)[*at.T]])


def _runs(ring: Array, border: int, shape: tuple[int, ...]) -> Array:
    """Cut a border into row segments, in an order that spreads them well, so that poor matches are rejected early."""
    channels = shape[2]
    longest = max(1, min(border, LONGEST // channels))
    begins = np.flatnonzero((np.diff(ring[:, :2], axis=0, prepend=-2) != (0, 1)).any(axis=1)).tolist()
    whole = itertools.pairwise([*begins, len(ring)])
    cut = [(k, min(longest, stop - k)) for begin, stop in whole for k in range(begin, stop, longest)]
    first, count = np.array(cut, np.int64).T
    runs = channels * np.stack([ring[first, 0] * shape[1] + ring[first, 1], first, count], axis=1)
    return runs[np.argsort(np.arange(len(runs)) * 40503 % 65536, kind="stable")]


def closing_vector(cell: tuple[Vector, Vector], length: int, axis: int) -> Vector:
    """Return the lattice vector that goes once around an axis of `length` px; ParameterError above 2 % of stretch."""
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
    raise ParameterError(misfit_message(axis, length, "is no whole number of periods", off / (length * UNIT), good))


class FourierMatcher:
    """Compare a border with all places of an exemplar at once, by Fourier transforms (Lopez Recas 2011, eq. 4.5).

    Sums of products of whole numbers are whole, and doubles are wrong by far less than a half: rounded, they are exact.
    """

    def __init__(self, picture: Array, ring: Array) -> None:
        self.at, sides = tuple(ring[:, :2].T), ring[:, :2].max(axis=0) + 1
        self.sides, self.shown = sides, tuple(slice(n - m + 1) for n, m in zip(picture.shape, sides, strict=False))
        self.size = [next_fast_len(n, real=True) for n in picture.shape[:2]]
        values, ones = np.moveaxis(picture.astype(np.float64), 2, 0), np.ones((1, len(ring)))
        self.spectra, squared = rfft2(values, self.size), rfft2(values**2, self.size)
        self.sums, self.squares = (
            np.stack([self._products(one[None], ones) for one in every]) for every in (self.spectra, squared)
        )

    def best(self, border: Array, places: Array, correlate: bool) -> int:
        """Return which of places (m, 2) matches a border (C, n) best, the first of equals: by GNCC in 1e-9 or SSD."""
        y, x = places.T
        products, sums, squares = self._products(self.spectra, border)[y, x], self.sums[:, y, x], self.squares[:, y, x]
        if not correlate:
            return int((squares.sum(axis=0) - 2 * products).argmin())
        n, own = border.shape[1], border.sum(axis=1, keepdims=True)
        second = n * (border**2).sum(axis=1, keepdims=True) - own**2
        below = np.sqrt((n * squares - sums**2).astype(np.float64) * second).sum(axis=0)
        above = 1e9 * (n * products - (own * sums).sum(axis=0))
        return int(np.rint(np.divide(above, below, out=np.zeros_like(below), where=below > 0)).argmax())

    def _products(self, spectra: Array, values: Array) -> Array:
        """Return the sums of products of a border (k, n) and every place of the exemplar: (h, w)."""
        laid = np.zeros((len(values), *self.sides))
        laid[:, *self.at] = values
        total = (spectra * np.conj(rfft2(laid, self.size))).sum(axis=0)
        return np.rint(irfft2(total, self.size)[self.shown]).astype(np.int64)
