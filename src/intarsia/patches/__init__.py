"""Patch-based synthesis: the map under synthesis, the order in which windows are filled, and start maps.

A start map is continued in one of two ways. Methods that construct an endless texture (by a lattice, courses or tiles)
align it with the start map, and cut it against that along the cheapest seam (Kwatra et al. 2003, eq. 1), at most `rim`
px deep. All others fill windows outward from the known part: windows overlap it by one overlap, are centred on small
holes, and are filled ring by ring, those with the most known pixels first. A regular grid from the corner of the canvas
would be out of phase with the edge of the known part: some windows would have few pixels to fill, others hardly any
known ones to match.

Source of the order: no paper; our own rule (Multrus 2003, 5.1, extends to one side, from the left). Departures: none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, product
from typing import Any, NamedTuple

import numpy as np

from ..analysis import window_sums
from ..foundation import ndimage
from ..foundation.arrays import Array, Int32, Laid, Mask, Pair, UInt8
from ..foundation.blend import Blend
from ..foundation.geometry import Wrap, apart, spread
from ..foundation.run import below
from ..kernels import maps
from ..kernels.cuts import SeamPrice
from ..kernels.maps import PartialMap
from ..model import Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import HOLE, Source, SourceMap
from ..search import Candidates, PosedExemplars, WindowGrid, Wraps

EDGE = 2  # a ring consists of the windows in which at least 1/EDGE of the area of one overlap region is known


class Axis(NamedTuple):
    """One axis of a canvas: its length, the sides of a window and of an overlap, px, and whether it wraps."""

    length: int
    patch: int
    overlap: int
    wrap: bool

    def kept(self, at: int) -> int:
        """Return the first pixel of a window moved onto the canvas, or modulo its length where it wraps."""
        return at % self.length if self.wrap else min(max(at, 0), self.length - self.patch)

    def cover(self, begin: int, end: int) -> list[int]:
        """Return the first pixels of windows that cover `begin` to `end` of the canvas; a single one is centred."""
        if not self.wrap:
            begin, end = max(begin, 0), min(end, self.length)
        if end - begin <= self.patch:
            return [self.kept(begin - (self.patch - (end - begin)) // 2)]
        return [self.kept(begin + s) for s in spread(end - begin, self.patch, self.overlap, False)[0]]

    def beside(self, begin: int, end: int) -> list[int]:
        """Return the first pixels of windows before, over and after the known span, which overlap it by one overlap."""
        if (begin, end) == (0, self.length):
            return spread(self.length, self.patch, self.overlap, self.wrap)[0]
        found = self.cover(begin, end)
        if self.wrap:
            found += self.cover(end - self.overlap, self.length + begin + self.overlap)
        else:
            found += self.cover(0, begin + self.overlap) if begin else []
            found += self.cover(end - self.overlap, self.length) if end < self.length else []
        return sorted(set(found))

    def over(self, begin: int, end: int) -> list[int]:
        """Return the first pixels of windows over a hole: centred if it is small, else from one overlap before it."""
        rim = self.overlap if end - begin + 2 * (self.overlap // 2) > self.patch else 0
        return self.cover(begin - rim, end + rim)

    def centred(self, at: int, begin: int, end: int) -> int:
        """Return a window's first pixel, moved so that its unknown part `begin` to `end` is centred if small."""
        if end - begin + 2 * self.overlap > self.patch:
            return at
        return self.kept(at + begin - (self.patch - (end - begin)) // 2)


def fill_order(known: Mask, patch: Pair, overlap: Pair, wraps: Wraps) -> list[Pair]:
    """Return the first pixels of the windows that fill all that is not known, in the order of filling.

    Parameters
    ----------
    known : (H, W) bool
        Which pixels of the canvas are known; at least one.
    patch, overlap : (rows, columns)
        Of a window and of the overlap of neighbours, px; a window is not larger than the canvas.
    wraps : (rows, columns)
        Whether the canvas is toroidal along each axis.
    """
    axes = [Axis(*each) for each in zip(known.shape, patch, overlap, wraps, strict=True)]
    left, found, spans = ~known, list[Pair](), _spans(known)
    if spans != [(0, length) for length in known.shape]:  # first what lies outside the bounding box of the known pixels
        lines = [axis.beside(*span) for axis, span in zip(axes, spans, strict=True)]
        found = [(y, x) for y, x in product(*lines) if not known[index_of(y, x, patch, known.shape)].all()]
    for y, x in found:
        left[index_of(y, x, patch, known.shape)] = False
    holes = ndimage.find_objects(ndimage.label(left, np.ones((3, 3), int))[0]) if left.any() else []
    for box in holes:
        part = left[box]
        if not part.any():  # a window of an earlier hole holds this one, too
            continue
        each = zip(axes, box, _spans(part), strict=True)
        for y, x in product(*(axis.over(at.start + begin, at.start + end) for axis, at, (begin, end) in each)):
            index = index_of(y, x, patch, known.shape)
            if left[index].any():
                found.append((y, x))
                left[index] = False
    return _ordered(known.copy(), found, axes)


def _spans(mask: Mask) -> list[Pair]:
    """Return the first row with a True and one past the last, and the same for columns."""
    some = [np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0)]
    return [(int(s[0]), int(s[-1]) + 1) for s in some]


def _ordered(known: Mask, found: list[Pair], axes: list[Axis]) -> list[Pair]:
    """Order windows ring by ring outward from the known pixels; centre windows on small unknown parts.

    A ring is filled in raster order. `known` is overwritten.
    """
    size, patch, overlap, wraps = zip(*axes, strict=True)
    least = min(overlap[0] * patch[1], overlap[1] * patch[0]) // EDGE
    near = neighbour_query(found, patch, size, wraps)

    def count(k: int) -> int:
        return int(np.count_nonzero(known[index_of(*found[k], patch, size)]))

    counts, waiting, out = np.array(list(map(count, range(len(found))))), np.ones(len(found), bool), list[Pair]()
    while waiting.any():
        most = int(counts[waiting].max())
        ring = np.flatnonzero(waiting & (counts >= min(max(least, 1), most)))
        waiting[ring] = False
        changed = set[int]()
        for at in sorted(found[k] for k in ring):
            index = index_of(*at, patch, size)
            if known[index].all():
                continue
            each = zip(axes, at, _spans(~known[index]), strict=True)
            y, x = (axis.centred(n, *span) for axis, n, span in each)
            known[index_of(y, x, patch, size)] = True
            changed.update(near([(y, x)])[0])
            out.append((y, x))
        for k in changed:
            counts[k] = count(k)
    return out


def neighbour_query(found: Sequence[Pair], patch: Pair, size: Pair, wraps: Wraps) -> Callable[[Sequence[Pair]], Any]:
    """Return a query: for each of some first pixels, the numbers of the windows that overlap or touch one there."""
    from scipy.spatial import cKDTree  # it is slow to import

    scale = np.array(patch[::-1])  # windows become squares
    tree = cKDTree(np.reshape(found, (-1, 2)) * scale, boxsize=np.where(wraps, size, 0) * scale)
    return lambda places: tree.query_ball_point(np.reshape(places, (-1, 2)) * scale, math.prod(patch), p=np.inf)


def batch_numbers(near: Iterable[Iterable[int]]) -> list[int]:
    """Return the batch number of every window: one more than the highest of the earlier windows `near` it, or 0."""
    out = list[int]()
    for k, others in enumerate(near):
        out.append(1 + max((out[j] for j in others if j < k), default=-1))
    return out


def index_of(y: int, x: int, patch: Pair, size: Sequence[int]) -> Any:
    """Return the NumPy index of a window of a canvas: slices, or index arrays where it extends over a border."""
    if 0 <= y <= size[0] - patch[0] and 0 <= x <= size[1] - patch[1]:
        return slice(y, y + patch[0]), slice(x, x + patch[1])
    return np.ix_((np.arange(patch[0]) + y) % size[0], (np.arange(patch[1]) + x) % size[1])


def depth_of(known: Mask, wrap: Wrap, most: int) -> Array:
    """Return the depth of known pixels: chessboard distance from the nearest hole, px, so 1 next to it; 0 in holes.

    Exact up to `most`, also across borders that wrap; `most` + 1 everywhere if there is no hole.
    """
    if known.all():
        return np.full(known.shape, most + 1, np.int32)
    pad = [(most + 1, most + 1) if around else (0, 0) for around in (wrap.y, wrap.x)]
    depth = ndimage.distance_transform_cdt(np.pad(known, pad, mode="wrap"), metric="chessboard")
    inner = tuple(slice(p[0], n + p[0]) for p, n in zip(pad, known.shape, strict=True))
    return np.asarray(depth[inner])


def drafted(laid: Laid, source: Source, wrap: Wrap) -> SourceMap:
    """Return the unfinished map of a canvas: what is placed already, and holes."""
    yx, pose, there = laid
    return SourceMap(yx, np.where(there, 0, HOLE).astype(np.uint8), pose, (source,), wrap)


Window = Pair  # row and column in the grid of windows; (number, 0) for windows that lie freely
Pick = tuple[int, int, int]  # a patch: variant, row and column of its first pixel in it
STRIP = 256  # rows of a start map that are converted at a time, which limits memory


@dataclass(frozen=True, eq=False)
class MapBuilder:
    """The map under synthesis: the variant and its pixel at every place, and the locked pixels."""

    variants: PosedExemplars
    variant: UInt8  # (H, W): HOLE where nothing is known
    yx: Int32  # (H, W, 2): row and column in the variant
    locked: Mask  # (H, W): pixels that must not change
    wraps: Wraps

    @classmethod
    def begin(cls, variants: PosedExemplars, canvas: Canvas, rim: int) -> MapBuilder:
        """Begin with the canvas's start map; pixels deeper than `rim` px from every hole are locked."""
        shape, start, wraps = (canvas.height, canvas.width), canvas.start, (canvas.wrap.y, canvas.wrap.x)
        variant, yx = np.full(shape, HOLE, np.uint8), np.zeros((*shape, 2), np.int32)
        if start is None:
            return cls(variants, variant, yx, np.zeros(shape, bool), wraps)
        for top in range(0, canvas.height, STRIP):
            rows = slice(top, top + STRIP)
            which, pose = (0 if plane is None else plane[rows] for plane in (start.which, start.pose))
            for v, frame in enumerate(variants.frames.astype(np.int32)):
                mine = np.ones(variant[rows].shape, bool) & (which == variants.exemplar[v]) & (pose == variants.pose[v])
                yx[rows][mine] = (start.yx[rows][mine] - frame[1:3]) @ frame[3:7].reshape(2, 2)
                variant[rows][mine] = v
        return cls(variants, variant, yx, depth_of(variant != HOLE, canvas.wrap, rim) > rim, wraps)

    @cached_property
    def grown(self) -> PartialMap:
        """The map as kernels take it."""
        return PartialMap(self.variant, self.yx, self.wraps)

    def open_windows(self, layout: WindowGrid, wanted: Mask | None = None) -> Mask:
        """Return which windows hold an unknown pixel or, if given, a `wanted` one; all of those that lie freely."""
        if layout.places is not None or (wanted is None and not (self.variant != HOLE).any()):
            return np.ones(layout.shape, bool)
        holes = self.variant == HOLE if wanted is None else wanted
        return layout.of_windows(window_sums(layout.widened(holes, 0), layout.patch)) > 0

    def cut_in(self, at: Pair, pick: Pick, found: Candidates, price: SeamPrice) -> None:
        """Cut a patch into the window at `at` along the cheapest seam."""
        maps.paste(self.grown, self.locked, self.variants.posed, *at, *pick, found.feats, found.known, price)

    def lay_over(self, at: Pair, pick: Pick, known: Array, seam: Pair) -> None:
        """Place a patch into the window at `at`, cut straight in the middle of overlap regions of `seam` px."""
        maps.overlay(self.grown, self.locked, self.variants.posed, *at, *pick, known, seam)

    def map(self, exemplars: Exemplars, canvas: Canvas, blend: Blend) -> SourceMap:
        """Return the source map as it is now; it may share memory with this map."""
        yx, which, pose = self.variants.to_exemplars(self.yx, self.variant)
        return SourceMap(
            yx,
            which if len(exemplars) > 1 or bool((which == HOLE).any()) else None,
            pose if self.variants.pose.any() else None,
            tuple(e.source for e in exemplars),
            canvas.wrap,
            blend,
        )


def window_batches(layout: WindowGrid, wanted: Mask, around: int = 0) -> list[list[Window]]:
    """Return the wanted windows in batches of windows that do not overlap, and so may be filled in parallel.

    Windows of a batch are at least `around` px from one another.

    For windows that overlap, batches keep the order of a raster scan: a window comes in a later batch than those above
    and to the left of it, and than the one above to the right. Windows that lie freely keep the order of their numbers
    (outward from the known part); all of them are wanted.
    """
    high, wide = layout.patch[0] + around, layout.patch[1] + around
    if layout.places is not None:
        order = [(k, 0) for k in range(len(layout.places))]
        near: Iterable[Iterable[int]] = neighbour_query(layout.places, (high, wide), layout.size, layout.wraps)(
            layout.places
        )
    else:
        rows, columns = (_overlapping(*each) for each in zip(
            (layout.rows, layout.columns), (high, wide), layout.size, layout.wraps, strict=True))  # fmt: skip
        half = len(columns) // 2 if layout.wraps[1] else len(columns)
        slope = 1 + max((b - a for a, others in enumerate(columns) for b in others if b - a <= half), default=0)
        order = sorted(((r, c) for r, c in np.argwhere(wanted).tolist()), key=lambda w: (w[1] + slope * w[0], w[0]))
        if not any(layout.wraps) and wanted.all():  # windows on one slanted diagonal
            return [list(wave) for _, wave in groupby(order, key=lambda w: w[1] + slope * w[0])]
        number = {window: k for k, window in enumerate(order)}
        near = ([number[w] for w in product(rows[r], columns[c]) if w in number] for r, c in order)
    wave_of = batch_numbers(near)
    out: list[list[Window]] = [[] for _ in range(max(wave_of, default=-1) + 1)]
    for window, wave in zip(order, wave_of, strict=True):
        out[wave].append(window)
    return out


def _overlapping(starts: Sequence[int], patch: int, length: int, wrap: bool) -> list[list[int]]:
    """Return for every window along an axis the numbers of those less than `patch` px away, its own included."""
    return [[k for k, b in enumerate(starts) if apart(a, b, length, wrap) < patch] for a in starts]


def picked(found: Candidates, k: int) -> Pick:
    """Return the variant, row and column of one of the candidates."""
    _, variant, row, column = found.rows[k].tolist()
    return variant, row, column


def random_patch(valid: Sequence[Array], bits: int) -> Pick:
    """Draw one of the `valid` first pixels of all variants, uniformly: (variant, row, column)."""
    counts = [int(np.count_nonzero(v)) for v in valid]
    k = below(sum(counts), bits)
    for v, n in enumerate(counts):
        if k < n:
            at = int(np.flatnonzero(valid[v])[k])
            return v, *divmod(at, valid[v].shape[1])
        k -= n
    raise AssertionError("counts and draws disagree")
