"""Engine of random sampling and gap filling: square blocks, mitred borders, the best matching patch in each gap.

Source: Lopez Recas 2011, 4.2. Departures: vectors are real, positions rounded from exact multiples; which patch is
placed where depends on its block and the seed alone.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2

from ...analysis import valid_windows
from ...analysis.features import features
from ...foundation import MethodError, ParameterError
from ...foundation.arrays import Array, Mask, Pair
from ...foundation.geometry import UNIT
from ...foundation.params import AUTO
from ...foundation.run import Run, below, draw
from ...lattice import cell_of, check_lattice, lattice_of
from ...lattice.correlation_peaks import lattice_points
from ...model import Exemplar, Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import HOLE, SourceMap
from ...regular.block_grid import adjacent_blocks
from .gap_filling import GapFilling
from .goodness import lattice_by_goodness

STAGE = 20110
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
    """Place the random blocks of the canvas, then fill the gaps; blocks that cross its end are cropped."""
    sampling, side = Sampling(method, exemplars[0], seed), method.block
    rows, columns = -(-canvas.height // side), -(-canvas.width // side)
    yx = np.zeros((rows * side, columns * side, 2), np.int32)
    which = np.full(yx.shape[:2], HOLE, np.uint8)
    shown = np.s_[: canvas.height, : canvas.width]
    inside = np.moveaxis(np.indices((side, side), np.int32), 0, 2) + method.border // 2

    def lay(block: Pair, place: Pair) -> None:
        (i, j), here = block, tuple(slice(n * side, (n + 1) * side) for n in block)
        if 0 <= i < rows and 0 <= j < columns:
            yx[here], which[here] = inside + np.array(place, np.int32), 0

    def laid() -> SourceMap:
        holes = which[shown].copy() if (which[shown] == HOLE).any() else None
        return SourceMap(yx[shown].copy(), holes, None, (exemplars[0].source,), blend=method.blend)

    gaps = [block for block in product(range(rows), range(columns)) if sum(block) % 2]
    around = {(0, 0)}.union(*(adjacent_blocks(*gap) for gap in gaps))
    drawn = {block: sampling.drawn(block) for block in around}
    for block, place in drawn.items():
        lay(block, place)
    wave = TOGETHER * run.workers
    with run.pool() as each:
        for k in range(0, len(gaps), wave):
            run.tick(k, len(gaps), laid)
            some = gaps[k : k + wave]
            for gap, place in zip(some, each(lambda gap: sampling.filled(gap, drawn), some), strict=True):
                lay(gap, place)
    run.tick(len(gaps), len(gaps), laid)
    return laid()


class Sampling:
    """The patches of an exemplar, and which of them a block shows."""

    def __init__(self, method: GapFilling, exemplar: Exemplar, seed: int) -> None:
        """Prepare an exemplar; ParameterError if the method's parameters do not go together."""
        self.method, self.seed, side = method, seed, method.block + method.border
        self.picture = features([exemplar], method.channel_weights).pictures[0]
        v1, v2 = cell_of(method.lattice, self.picture.shape[:2])
        if v2 is None:
            raise ParameterError("gap-filling needs two lattice vectors; give both, or use method near-regular.")
        if method.border % 2 or method.border > method.block:
            raise ParameterError(
                f"border={method.border}: gap-filling needs an even border that is no wider than a block "
                f"({method.block} px); choose another."
            )
        self.cell, self.ring = (v1, v2), mitred_border(method.block, method.border)
        self.valid = valid_windows(self.picture.shape, exemplar.usable, False, (side, side))
        if not self.valid.any():
            raise self._no_room()
        self.matcher = FourierMatcher(self.picture, self.ring)
        far = (math.hypot(*v1) + math.hypot(*v2)) / (2 * UNIT) + 1  # no px is farther from the lattice
        self.everywhere = far <= method.lattice_tolerance

    def drawn(self, block: Pair) -> Pair:
        """Draw a patch for a block: all its lattice-aligned places are equally likely (4.2.1)."""
        places = self._places(block, 0)
        places = places[self.valid[*places.T]]
        if not len(places):
            raise self._no_room()
        y, x = places[below(len(places), draw(self.seed, STAGE, 0, *block))].tolist()
        return y, x

    def filled(self, gap: Pair, drawn: dict[Pair, Pair]) -> Pair:
        """Return the patch for a gap whose border matches its four neighbours best (4.2.2)."""
        step = self.method.block
        around = adjacent_blocks(*gap)
        sources = np.array([drawn[n] for n in around]) + step * (np.array(gap) - around)
        border = self.picture[*(self.ring[:, :2] + sources[self.ring[:, 2]]).T].T.astype(np.int64)
        places = np.argwhere(self.valid if self.everywhere else self.valid & self._near(gap))
        if not len(places):
            raise self._no_room()
        y, x = places[self.matcher.best(border, places, self.method.fit == "correlation")].tolist()
        return y, x

    def _places(self, block: Pair, slack: int) -> Array:
        """Return the lattice-aligned places of a block, up to `slack` px beyond the exemplar: (n, 2) px."""
        y, x = (UNIT * (n * self.method.block - self.method.border // 2) for n in block)
        low, high = (-slack, -slack), [side - 1 + slack for side in self.valid.shape]
        return (lattice_points((y, x), *self.cell, low, high) + UNIT // 2) // UNIT

    def _near(self, gap: Pair) -> Mask:
        """Return which places (h, w) lie within the tolerance of a gap's lattice-aligned ones."""
        slack, (height, width) = self.method.lattice_tolerance, self.valid.shape
        marks = np.zeros((height + 4 * slack, width + 4 * slack), bool)
        steps = np.moveaxis(np.indices((2 * slack + 1, 2 * slack + 1)), 0, 2) + slack
        marks[*np.moveaxis(self._places(gap, slack)[:, None, None] + steps, 3, 0)] = True
        return marks[2 * slack : 2 * slack + height, 2 * slack : 2 * slack + width]

    def _no_room(self) -> MethodError:
        side = self.method.block
        return MethodError(
            f"no patch of {side}x{side} px with a border of {self.method.border} px fits into the exemplar at some "
            "place of the lattice; choose a smaller block or border, or a larger exemplar."
        )


def mitred_border(block: int, border: int) -> Array:
    """Return the border pixels of a gap of block x block px: (n, 3), row and column from its outer corner, and side.

    The border is centred on the edge. Sides: 0 above, 1 below, 2 left, 3 right; they meet in 45 degree mitres.
    """
    y, x = np.indices((block + border, block + border))
    depths = np.stack([y, y[::-1], x, x[:, ::-1]])
    at = np.argwhere(depths.min(axis=0) < border)
    return np.column_stack([at, depths.argmin(axis=0)[*at.T]])


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
