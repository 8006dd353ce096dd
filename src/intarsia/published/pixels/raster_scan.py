"""Raster scan over a torus: neighbourhoods of Wei and Levoy, initial noise, start maps, resolution levels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, cast

import numpy as np

from ...analysis import principal_axes
from ...analysis.features import features
from ...foundation import MethodError, ndimage
from ...foundation.arrays import Int16, Int64, Mask, Pair
from ...foundation.blend import Blend
from ...foundation.params import words
from ...foundation.run import below, draw_many
from ...kernels import kd_tree
from ...kernels.kd_tree import LEAF, Tree
from ...model import Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import HOLE, SourceMap
from ...patches import MapBuilder
from ...search import posed_exemplars
from . import raster_kernels
from .neighbourhood_kernels import SIZE, START, STRIDE, ExemplarPlanes
from .neighbourhoods import PixelPlanes, Reach, choices, exemplar_planes, layers
from .raster_kernels import ABOVE, BELOW, COARSE, Torus

DIMS = 12  # axes kept of a neighbourhood
SAMPLE = 4096  # neighbourhoods that the axes are measured on

Array = Int64


def tree_of(ground: ExemplarPlanes, places: Int64, components: Int64) -> Tree:
    """Return a kd-tree of the neighbourhoods at (variant, position) `places` (N, 2), projected to principal axes.

    `components` (n, 3) are plane, row and column of what a neighbourhood consists of.
    """
    every = places[:: max(1, len(places) // SAMPLE)]
    rows, (plane, down, along) = ground.table[every[:, :1].T], components.T[:, :, None]
    steps = plane * rows[..., SIZE] + down * rows[..., STRIDE] + along
    some = ground.values[rows[..., START] + every[:, 1] + steps].T
    mean = some.astype(np.int64).sum(axis=0) // len(some)
    centred = (some - mean).astype(np.float64)  # sums of whole numbers below 2**53: exact in any order
    _, axes = principal_axes(centred.T @ centred / len(some), min(DIMS, len(components)))
    whole = np.rint(axes * 16384).astype(np.int64)
    points = np.empty((len(places), len(axes)), np.int32)
    raster_kernels.project(ground, places, components, mean, whole, points)
    order = np.arange(len(places))
    nodes = 4 * (len(places) // LEAF + 1)
    axis, cut = np.zeros(nodes, np.int64), np.zeros(nodes, np.int64)
    kd_tree.build(points, order, axis, cut)
    return Tree(points, order, axis, cut, mean, whole)


def taps_of(window: Pair, coarse: bool) -> list[tuple[int, int, int]]:
    """Return (row, column, kind) of the pixels that a neighbourhood of h_e rows and w_e columns consists of.

    All rows above and the left half of the pixel's own one; the same below and to the right, counted where known
    for good; and, if there is a coarser level, a window of half that size there, in steps of this level.
    """
    up, side = window[0] - 1, window[1] // 2
    own = [(y, x) for y in range(-up, up + 1) for x in range(-side, side + 1) if (y, x) != (0, 0)]
    taps = [(y, x, ABOVE if (y, x) < (0, 0) else BELOW) for y, x in own]
    if coarse:
        high, wide = (up + 1) // 2, (side + 1) // 2
        taps += [(2 * y, 2 * x, COARSE) for y in range(-high, high + 1) for x in range(-wide, wide + 1)]
    return sorted(taps, key=lambda t: (t[0] ** 2 + t[1] ** 2, t[2], t))


def reach_of(window: Pair, coarse: bool, whole: bool) -> Reach:
    """Return how far a neighbourhood reaches up, to the left, down and to the right, px."""
    used = [t for t in taps_of(window, coarse) if whole or t[2] != BELOW]
    rows, columns = [t[0] for t in used], [t[1] for t in used]
    return -min(rows), -min(columns), max(*rows, 0), max(*columns, 0)


def scan_reach(window: Pair, levels: int) -> Reach:
    """Return how far the neighbourhoods of all levels reach, in px of the finest."""
    every = [reach_of(window, k < levels - 1, False) for k in range(levels)]
    up, left, down, right = (max(r[side] << k for k, r in enumerate(every)) for side in range(4))
    return up, left, down, right


def pyramid(given: Sequence[PixelPlanes], levels: int) -> list[list[PixelPlanes]]:
    """Return the variants at every level, the finest first: each half as large as the one before."""
    out = [list(given)]
    for _ in range(levels - 1):
        out.append([_halved(one) for one in out[-1]])
    return out


def _halved(one: PixelPlanes) -> PixelPlanes:
    """Reduce by two with weights 1 3 3 1 in whole numbers; what sees an unusable pixel is unusable."""
    pad, mode = [(0, n % 2) for n in one.usable.shape], cast(Any, "wrap" if one.toroidal else "nearest")
    planes: Any = np.pad(one.planes, [(0, 0), *pad], mode="edge").astype(np.int64)
    for axis in (1, 2):
        planes = ndimage.correlate1d(planes, (1, 3, 3, 1), axis, np.int64, mode, origin=-1)
    usable = ndimage.minimum_filter(np.pad(one.usable, pad, mode="edge"), 4, mode=mode, origin=-1)[::2, ::2]
    return PixelPlanes(((planes[:, ::2, ::2] + 32) >> 6).astype(np.int16), usable, one.toroidal)


class Scan:
    """The partial map of a raster-scan method, level by level.

    A canvas that does not wrap is part of a larger torus. The margin above it takes the first rows, which see
    nothing but noise, and that at its side keeps its left and right edges apart. `white`: it begins as white noise,
    and nothing but what lies above and to the left counts, as published.
    """

    torus: Torus

    def __init__(
        self,
        exemplars: Exemplars,
        canvas: Canvas,
        window: Pair,
        levels: int,
        draws: Pair,
        white: bool = False,
    ) -> None:
        self.exemplars, self.canvas, self.window, self.levels, self.draws = exemplars, canvas, window, levels, draws
        self.white = white
        shown = () if canvas.start is None else canvas.start.poses
        self.variants = posed_exemplars(exemplars, features(exemplars), (0,), (1, 1), shown)
        self.pyramid = pyramid(layers(self.variants, exemplars), levels)
        up, left, _, _ = reach_of(window, levels > 1, True)
        self.margin = (
            0 if canvas.wrap.y else up << (levels - 1),
            0 if canvas.wrap.x else left << (levels - 1),
        )
        self.size = canvas.height + self.margin[0], canvas.width + self.margin[1]
        self.growing = MapBuilder.begin(self.variants, canvas, 0)
        self.total = sum(-(-self.size[0] // (1 << k)) * -(-self.size[1] // (1 << k)) for k in range(levels))
        self.done = 0
        self.level = levels

    def enter(self) -> tuple[Torus, ExemplarPlanes]:
        """Enter the next finer level; return the torus, filled with noise or the coarser level, and the exemplars."""
        coarse = self.level < self.levels
        self.level -= 1
        seed, stage = np.uint64(self.draws[0]), self.draws[1]
        given = self.pyramid[self.level]
        shape = tuple(-(-n // (1 << self.level)) for n in self.size)
        context = np.zeros((0, *shape), np.int16)
        if coarse:
            context = _doubled(_shown(self.torus, self.pyramid[self.level + 1]), shape)
            above = self.pyramid[self.level + 1]
            given = [
                PixelPlanes(
                    np.concatenate([one.planes, _doubled(two.planes, one.usable.shape)]),
                    one.usable & _doubled(two.usable[None], one.usable.shape)[0],
                    one.toroidal,
                )
                for one, two in zip(given, above, strict=True)
            ]
        elif self.white:
            given = [*given, self._noise(shape)]
        exemplar = exemplar_planes(given, *(reach_of(self.window, coarse, whole) for whole in (False, True)))
        places = choices(exemplar, 0)
        if not len(places):
            raise MethodError(
                f"no window={words(self.window)} of the exemplar is free of masked pixels at level {self.level + 1}; "
                "choose fewer levels, a smaller window, or mask less."
            )
        if coarse:
            variant, yx = self._refined(shape)
        elif self.white:
            variant = np.full(shape, len(given) - 1, np.uint8)
            yx = np.ascontiguousarray(np.moveaxis(np.indices(shape, dtype=np.int32), 0, 2))
        else:
            variant, yx = np.zeros(shape, np.uint8), np.zeros((*shape, 2), np.int32)
            raster_kernels.start_from_noise(variant, yx, exemplar, places, seed, stage, self.level)
        done = self._start(variant, yx)
        self.given = done.copy()
        taps = np.array(taps_of(self.window, coarse), np.int64)
        self.torus = Torus(
            variant, yx, done, context, taps, self.variants.channels,
            not self.white and bool((exemplar.closed[1] == 0).any()),
            (self.canvas.wrap.y, self.canvas.wrap.x), places, seed, stage, self.level,
        )  # fmt: skip
        return self.torus, exemplar

    def components(self) -> Int64:
        """Return (plane, row, column) of what the usual neighbourhood of this level consists of, in its order."""
        torus = self.torus
        out = []
        for y, x, kind in torus.taps.tolist():
            if kind != BELOW:
                first, count = (torus.channels, len(torus.coarse)) if kind == COARSE else (0, torus.channels)
                out += [(first + c, y, x) for c in range(count)]
        return np.array(out, np.int64).reshape(-1, 3)

    @property
    def room(self) -> int:
        """Return the largest number of components of a neighbourhood."""
        torus = self.torus
        return len(torus.taps) * max(torus.channels, len(torus.coarse))

    def unknown_runs(self, most: int) -> Iterator[Int64]:
        """Yield the unknown pixels (n, 2) of this level, at most `most` of a row at once."""
        done = self.torus.done
        height, width = done.shape
        for y in range(height):
            for x in range(0, width, most):
                yield np.ascontiguousarray(np.argwhere(~done[y : y + 1, x : x + most]) + np.array([y, x]))
                self.done += min(x + most, width) - x

    def saw_noise(self, most: int) -> list[Int64]:
        """Return the pixels (n, 2), at most `most` together, that saw noise across a wrapped border."""
        torus = self.torus
        if self.white:
            return []
        saw = np.zeros(torus.variant.shape, bool)
        if self.canvas.wrap.y:
            saw[: self.window[0] - 1] = True
        if self.canvas.wrap.x:
            saw[:, : self.window[1] // 2] = True
        pixels = np.ascontiguousarray(np.argwhere(saw & ~self.given))
        return [pixels[k : k + most] for k in range(0, len(pixels), most)]

    def map(self, blend: Blend) -> SourceMap:
        """Return the map as far as it is filled; empty during coarser levels."""
        torus, (top, left) = self.torus, self.margin
        if self.level == 0:
            done = torus.done[top:, left:]
            self.growing.variant[:] = np.where(done, torus.variant[top:, left:], HOLE)
            self.growing.yx[:] = np.where(done[:, :, None], torus.yx[top:, left:], 0)
        return self.growing.map(self.exemplars, self.canvas, blend)

    def _noise(self, shape: tuple[int, ...]) -> PixelPlanes:
        """Return white noise of the torus's size over each channel's range: read like an exemplar, never copied."""
        every = np.concatenate([one.planes.reshape(len(one.planes), -1) for one in self.pyramid[self.level]], axis=1)
        planes, places = np.empty((len(every), *shape), np.int16), np.indices(shape).reshape(2, -1).T
        for c, values in enumerate(every.astype(np.int64)):
            low, many = int(values.min()), int(np.ptp(values)) + 1
            planes[c].flat = [low + below(many, bits) for bits in draw_many(*self.draws, 64 + c, places)]
        return PixelPlanes(planes, np.zeros(shape, bool), False)

    def _refined(self, shape: tuple[int, ...]) -> tuple[Any, Any]:
        """Return variant and coordinates upsampled from the coarser level."""
        torus = self.torus
        variant = np.ascontiguousarray(_doubled(torus.variant[None], shape)[0])
        yx = np.stack([_doubled(2 * torus.yx[None, :, :, k], shape)[0] for k in (0, 1)], axis=2)
        yx += np.moveaxis(np.indices(shape, dtype=np.int32) % 2, 0, 2)
        for v, one in enumerate(self.pyramid[self.level]):
            limit = np.array(one.usable.shape, np.int32) - 1
            yx[variant == v] = np.minimum(yx[variant == v], limit)
        return variant, np.ascontiguousarray(yx)

    def _start(self, variant: Any, yx: Any) -> Mask:
        """Copy the start map into variant and coordinates; return which pixels it makes known."""
        done = np.zeros(variant.shape, bool)
        if self.canvas.start is None:
            return done
        step = 1 << self.level
        known = np.full(self.size, HOLE, np.uint8)
        at = np.zeros((*self.size, 2), np.int32)
        top, left = self.margin
        known[top:, left:], at[top:, left:] = self.growing.variant, self.growing.yx
        known, at = known[::step, ::step], at[::step, ::step] // step
        done |= known != HOLE
        variant[done], yx[done] = known[done], at[done]
        return done


def _doubled(planes: Any, shape: tuple[int, ...]) -> Any:
    """Repeat every pixel of planes (P, h, w) twice each way, up to a size."""
    return planes.repeat(2, axis=1).repeat(2, axis=2)[:, : shape[0], : shape[1]]


def _shown(torus: Torus, given: Sequence[PixelPlanes]) -> Int16:
    """Return the planes of this level's own (P, H, W) that a filled torus shows."""
    out = np.zeros((torus.channels, *torus.variant.shape), np.int16)
    for v, one in enumerate(given):
        mine = torus.variant == v
        out[:, mine] = one.planes[: torus.channels, torus.yx[mine][:, 0], torus.yx[mine][:, 1]]
    return out
