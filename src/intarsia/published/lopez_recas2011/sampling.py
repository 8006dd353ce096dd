"""Random sampling and gap filling as published: square blocks, wedge borders, the best fitting patch in each gap.

Which patch lies where depends only on its block and the seed: any window of the endless texture can be made alone.

Source: Lopez Recas 2011, 4.2. Departures: vectors are real, positions rounded from exact multiples; draws belong to
places, so that any window can be made alone; a wrapped canvas is closed by stretching the lattice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2

from ...analysis import valid_windows
from ...analysis.features import features
from ...foundation import MethodError, ParameterError
from ...foundation.arrays import Array, Int16, Int32, Laid, Mask, Pair
from ...foundation.geometry import UNIT, Box
from ...foundation.params import AUTO
from ...foundation.run import Run, below, draw
from ...lattice import Vector, cell_of, check_lattice, lattice_of, unfit
from ...lattice.candidates import lattice_points
from ...model import Exemplar, Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import SourceMap
from ...patches import drafted
from ...regular.mosaic import STRAIN, beside, returning
from . import sampling_kernels as kernels
from .gap_filling import GapFilling
from .goodness import lattice_by_goodness

STAGE = 20110
SEEDS = 4  # whose layouts are kept at a time
LONGEST = 256  # values compared at once: their squared differences fit into 32 bits
DENSE = 0.03  # share of an exemplar's places from which transforms are quicker
TOGETHER = 16  # gaps that one call fills


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
    cell: Array  # the lattice vectors (rows, columns), 1/256 px
    blocks: SquareBlocks  # how the canvas lies on the lattice, and where its blocks begin
    border: int  # px
    slack: int  # how far a gap's patch may leave the lattice, px
    correlate: bool  # compare borders by correlation in place of squared differences
    seed: int  # what the draws follow from
    ring: Array  # (n, 3): the px of a gap's border and the neighbour that each is read from
    runs: Array  # (n, 3): stretches of rows that make up the border, in the order in which they are compared
    transforms: Transforms | None  # for correlation, and where places are so many that one by one would be slow
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
        ring, slack, correlate = wedges(height, width, border), method.slack, method.fit == "correlation"
        many = correlate or min(1.0, (2 * slack + 1) ** 2 * UNIT**2 / area) > DENSE
        far = (math.hypot(*v1) + math.hypot(*v2)) / (2 * UNIT) + 1  # no px is farther from the lattice
        return cls(
            picture, valid, np.array((v1, v2), np.int64), laid, border, slack, correlate, seed,
            ring, _runs(ring, border, picture.shape), Transforms(picture, ring) if many else None,
            np.argwhere(valid) if far <= slack else None,
        )  # fmt: skip

    def window(
        self, y0: int, x0: int, height: int, width: int, run: Run | None = None
    ) -> tuple[Int32, None]:
        """The exemplar pixels (height, width, 2) of a window, all upright."""
        run = run or Run()
        out = np.zeros((height, width, 2), np.int32)
        (i0, j0), (i1, j1) = self.blocks.block_of(y0, x0), self.blocks.block_of(y0 + height - 1, x0 + width - 1)
        fields = [(i, j) for i in range(i0, i1 + 1) for j in range(j0, j1 + 1)]
        gaps = [f for f in fields if sum(f) % 2]
        drawn = {f: self._drawn(f) for f in {n for f in gaps for n in beside(*f)} | {*fields} - {*gaps}}
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
                for made in each(lambda part: {gap: self._filled(gap, drawn) for gap in part}, parts[k : k + wave]):
                    filled |= made
        self._write_all(fields, drawn | filled, out, y0, x0)
        run.tick(len(parts), len(parts), draft)
        return out, None

    def _write_all(self, fields: list[Pair], found: dict[Pair, Pair], out: Array, y0: int, x0: int) -> None:
        """Write what of some blocks lies in a window, if they were found."""
        for f in fields:
            if f in found:
                self._write(f, found[f], out, y0, x0)

    def _places(self, block: Pair, slack: int) -> Array:
        """The places of a block in the lattice, or up to `slack` px beyond the exemplar: (n, 2) px."""
        low, high = (-slack, -slack), [n - 1 + slack for n in self.valid.shape]
        points = lattice_points(self._first(*block), self.cell[0], self.cell[1], low, high)
        return (points + UNIT // 2) // UNIT

    def _drawn(self, block: Pair) -> Pair:
        """Draw a patch for a block: all its places in the lattice are equally likely (4.2.1)."""
        places = self._places(block, 0)
        places = places[self.valid[*places.T]]
        if not len(places):
            raise _no_room(self.blocks.block, self.border)
        y, x = places[below(len(places), draw(self.seed, STAGE, 0, *self.blocks.number(*block)))].tolist()
        return y, x

    def _filled(self, gap: Pair, drawn: dict[Pair, Pair]) -> Pair:
        """Find the patch for a gap whose border fits its four neighbours best (4.2.2)."""
        sources = [  # both begin half a border before the block
            np.array(drawn[n]) - self.blocks.begin(*n) + self.blocks.begin(*gap) for n in beside(*gap)
        ]
        border = self.picture[*(self.ring[:, :2] + np.array(sources)[self.ring[:, 2]]).T]
        places = self.everywhere
        if places is None:
            places = np.argwhere(kernels.near(self._places(gap, self.slack), self.valid, self.slack))
        if not len(places):
            raise _no_room(self.blocks.block, self.border)
        if self.transforms is not None:
            best = self.transforms.best(border.T.astype(np.int64), places, self.correlate)
        else:
            best = kernels.best_place(self.picture, self.runs, border.ravel(), places)
        y, x = places[best].tolist()
        return y, x

    def _first(self, i: int, j: int) -> Pair:
        """Where a block lies in the lattice, 1/256 px, its border included: near the exemplar's first pixel."""
        y, x = self.blocks.lattice_place(i, j)
        y, x = y - self.border // 2 * UNIT, x - self.border // 2 * UNIT
        (a, b), (c, d) = self.cell.tolist()
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


def wedges(height: int, width: int, border: int) -> Array:
    """Describe the border of a gap of height x width px: (n, 3), row and column from its outer corner, and side.

    The border is centred on the edge. Sides: 0 above, 1 below, 2 left, 3 right; they meet in 45 degree mitres.
    """
    y, x = np.indices((height + border, width + border))
    depths = np.stack([y, y[::-1], x, x[:, ::-1]])
    at = np.argwhere(depths.min(axis=0) < border)
    return np.column_stack([at, depths.argmin(axis=0)[*at.T]])


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


class Transforms:
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
        """Which of places (m, 2) fits a border (C, n) best, the first of equals: GNCC in 1e-9, or differences."""
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
        """Sums of products of a border (k, n) and every place of the exemplar: (h, w)."""
        laid = np.zeros((len(values), *self.sides))
        laid[:, *self.at] = values
        total = (spectra * np.conj(rfft2(laid, self.size))).sum(axis=0)
        return np.rint(irfft2(total, self.size)[self.shown]).astype(np.int64)
