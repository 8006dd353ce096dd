"""Growth patch by patch: the order of filling, the growing map, labels, and repetition.

A map that grows patch by patch: what is known, what must stay, and in which order windows are filled.

The start map of a canvas, for methods that lay out an endless texture by a lattice, by courses or by tiles.

Such a method continues a picture, too: its texture is laid so that the lattice of the picture goes on, and is then cut
against the picture along the cheapest seam (Kwatra et al. 2003, eq. 1), at most as deep as the rim.

Where windows lie when part of the canvas is already filled, and in which order: outward from the filled part.

A grid that begins at the corner of the canvas meets the edge of the filled part anywhere: some windows then have only a
few pixels to fill, others hardly a known pixel to match. Here windows begin an overlap inside the filled part, lie
centred on small holes, and are filled ring by ring, those with most known pixels first.

Source: no paper; our own rule (Multrus 2003, 5.1, extends to one side, from the left). Departures: none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis import window_sums
from ..foundation import ndimage
from ..foundation.arrays import Array, Int16, Int32, Int64, Laid, Mask, Pair, UInt8
from ..foundation.blend import Blend
from ..foundation.geometry import ISOMETRIES, Wrap, apart, spread
from ..foundation.run import below
from ..kernels import maps
from ..kernels.cuts import PLAIN, SeamPrice, min_cut, seam_costs
from ..kernels.maxflow import FREE, NEW, OLD
from ..model import Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import HOLE, Source, SourceMap
from ..search import Candidates, PosedExemplars, WindowGrid

Wraps = tuple[bool, bool]

EDGE = 2  # a ring takes windows in which at least 1/EDGE of one seam is known


def fill_order(known: Mask, patch: Pair, overlap: Pair, wraps: Wraps) -> list[Pair]:
    """Return the first pixels of the windows that fill all that is not known, in the order of filling.

    `known` (H, W): what is on the canvas; some of it, or nothing is to be continued. `patch`, `overlap`: rows and
    columns of a window, not larger than the canvas; `wraps`: whether rows and columns continue in themselves.
    """
    left = ~known
    found = list(_outside(known, patch, overlap, wraps))
    for y, x in found:
        left[index_of(y, x, patch, known.shape)] = False
    holes = ndimage.find_objects(ndimage.label(left, np.ones((3, 3), int))[0]) if left.any() else []
    for box in holes:
        part = left[box]
        if not part.any():  # a window of an earlier hole holds this one, too
            continue
        for y, x in _over(part, box, patch, overlap, known.shape, wraps):
            index = index_of(y, x, patch, known.shape)
            if left[index].any():
                found.append((y, x))
                left[index] = False
    return _ordered(known.copy(), found, patch, overlap, wraps)


def levels(found: list[Pair], patch: Pair, size: Pair, wraps: Wraps) -> list[int]:
    """Return for every window the wave in which it can be filled: after all earlier ones that it touches."""
    near = Neighbours(found, patch, size, wraps)
    out = [-1] * len(found)
    for k in range(len(found)):
        out[k] = 1 + max((out[j] for j in near.of(found[k])), default=-1)
    return out


def _outside(known: Mask, patch: Pair, overlap: Pair, wraps: Wraps) -> Iterator[Pair]:
    """Windows that fill what lies outside the rectangle around all that is known."""
    axes, whole = [], True
    for axis in (0, 1):
        some = np.flatnonzero(known.any(axis=1 - axis))
        begin, end, length = int(some[0]), int(some[-1]) + 1, known.shape[axis]
        whole &= begin == 0 and end == length
        axes.append(_beside(begin, end, length, patch[axis], overlap[axis], wraps[axis]))
    if whole:
        return
    for y in axes[0]:
        for x in axes[1]:
            if not known[index_of(y, x, patch, known.shape)].all():
                yield y, x


def _beside(begin: int, end: int, length: int, patch: int, overlap: int, wrap: bool) -> list[int]:
    """First pixels along one axis: before what is known, over it, and behind it; neighbours share an overlap."""
    if begin == 0 and end == length:
        return spread(length, patch, overlap, wrap)[0]
    middle = _cover(begin, end, patch, overlap, length, wrap)
    if wrap:
        gap = _cover(end - overlap, length + begin + overlap, patch, overlap, length, True)
        return sorted({s % length for s in middle + gap})
    before = _cover(0, begin + overlap, patch, overlap, length, False) if begin else []
    behind = _cover(end - overlap, length, patch, overlap, length, False) if end < length else []
    return sorted({*before, *middle, *behind})


def _over(part: Mask, box: tuple[slice, ...], patch: Pair, overlap: Pair, size: Pair, wraps: Wraps) -> list[Pair]:
    """Windows over one hole: one in its middle if it is small, else a grid that begins an overlap before it."""
    axes = []
    for axis in (0, 1):
        some = np.flatnonzero(part.any(axis=1 - axis)) + box[axis].start
        begin, end = int(some[0]), int(some[-1]) + 1
        rim = overlap[axis] if end - begin + 2 * (overlap[axis] // 2) > patch[axis] else 0
        axes.append(_cover(begin - rim, end + rim, patch[axis], overlap[axis], size[axis], wraps[axis]))
    return [(y, x) for y in axes[0] for x in axes[1]]


def _cover(begin: int, end: int, patch: int, overlap: int, length: int, wrap: bool) -> list[int]:
    """First pixels of windows from `begin` to `end`, within the canvas; a single one lies in the middle."""
    if not wrap:
        begin, end = max(begin, 0), min(end, length)
    if end - begin <= patch:
        starts = [begin - (patch - (end - begin)) // 2]
    else:
        starts = [begin + s for s in spread(end - begin, patch, overlap, False)[0]]
    return [s % length if wrap else min(max(s, 0), length - patch) for s in starts]


def _ordered(known: Mask, found: list[Pair], patch: Pair, overlap: Pair, wraps: Wraps) -> list[Pair]:
    """Order windows ring by ring from what is known; move those that hold little still unknown to its middle."""
    size, least = known.shape, min(overlap[0] * patch[1], overlap[1] * patch[0]) // EDGE
    near = Neighbours(found, patch, size, wraps)
    counts = np.array([np.count_nonzero(known[index_of(y, x, patch, size)]) for y, x in found], np.int64)
    waiting = np.ones(len(found), bool)
    out: list[Pair] = []
    while waiting.any():
        most = int(counts[waiting].max())
        ring = np.flatnonzero(waiting & (counts >= min(max(least, 1), most)))
        waiting[ring] = False
        changed: set[int] = set()
        for k in sorted(ring.tolist(), key=lambda k: found[k]):
            index = index_of(*found[k], patch, size)
            if known[index].all():
                continue
            place = _centred(found[k], ~known[index], patch, overlap, size, wraps)
            known[index_of(*place, patch, size)] = True
            changed.update(near.of(place))
            out.append(place)
        for k in changed:
            if waiting[k]:
                counts[k] = np.count_nonzero(known[index_of(*found[k], patch, size)])
    return out


def _centred(place: Pair, left: Mask, patch: Pair, overlap: Pair, size: Pair, wraps: Wraps) -> Pair:
    """Move a window so that what is left in it lies in its middle, if that is little."""
    out = []
    for axis in (0, 1):
        some = np.flatnonzero(left.any(axis=1 - axis))
        begin, end = int(some[0]), int(some[-1]) + 1
        at = place[axis]
        if end - begin + 2 * overlap[axis] <= patch[axis]:
            at += begin - (patch[axis] - (end - begin)) // 2
            at = at % size[axis] if wraps[axis] else min(max(at, 0), size[axis] - patch[axis])
        out.append(at)
    return out[0], out[1]


def index_of(y: int, x: int, patch: Pair, size: tuple[int, ...]) -> Any:
    """What selects a window of a canvas; fast where it does not reach over a border."""
    if 0 <= y <= size[0] - patch[0] and 0 <= x <= size[1] - patch[1]:
        return slice(y, y + patch[0]), slice(x, x + patch[1])
    return np.ix_((np.arange(patch[0]) + y) % size[0], (np.arange(patch[1]) + x) % size[1])


class Neighbours:
    """Finds the windows that overlap a given one, or lie side by side with it."""

    def __init__(self, found: list[Pair], patch: Pair, size: tuple[int, ...], wraps: Wraps) -> None:
        self.found, self.patch, self.size, self.wraps = found, patch, size, wraps
        self.counts = tuple(max(n // p, 1) for n, p in zip(size, patch, strict=True))
        self.cells: dict[Pair, list[int]] = {}
        for k, place in enumerate(found):
            self.note(k, place)

    def note(self, k: int, place: Pair) -> None:
        """Note the k-th of the windows that were found."""
        self.cells.setdefault((place[0] // self.patch[0], place[1] // self.patch[1]), []).append(k)

    def of(self, place: Pair) -> Iterator[int]:
        """Yield the numbers of the windows that touch the one at `place`, in no order that matters."""
        rows, columns = (self._cells_near(axis, place[axis]) for axis in (0, 1))
        for r in rows:
            for c in columns:
                for k in self.cells.get((r, c), ()):
                    gaps = map(apart, place, self.found[k], self.size, self.wraps)
                    if all(gap <= side for gap, side in zip(gaps, self.patch, strict=True)):
                        yield k

    def _cells_near(self, axis: int, at: int) -> set[int]:
        cell, length, patch = at // self.patch[axis], self.size[axis], self.patch[axis]
        near = {cell - 1, cell, cell + 1}
        if self.wraps[axis]:
            near |= {(a % length) // patch for a in range(at - patch, at + patch + 1, max(patch // 2, 1))}
            near |= {((at + patch) % length) // patch, 0, (length - 1) // patch}
        return near


def depth_of(known: Mask, wrap: Wrap, most: int) -> Array:
    """How deep known pixels lie, px from the nearest hole, 1 beside it; around a border that wraps up to `most`."""
    if known.all():
        return np.full(known.shape, most + 1, np.int32)
    pad = [(most + 1, most + 1) if around else (0, 0) for around in (wrap.y, wrap.x)]
    depth = ndimage.distance_transform_cdt(np.pad(known, pad, mode="wrap"), metric="chessboard")
    inner = tuple(slice(p[0], n + p[0]) for p, n in zip(pad, known.shape, strict=True))
    return np.asarray(depth[inner])


def drafted(laid: Laid, start: SourceMap | None, source: Source, wrap: Wrap) -> SourceMap:
    """Return the map of a canvas as far as it is laid: with what it begins with, and holes where nothing is yet."""
    yx, pose, there = laid
    if start is not None:
        yx, pose, there = np.where(start.holes[:, :, None], yx, start.yx), None, there | ~start.holes
    return SourceMap(yx, np.where(there, 0, HOLE).astype(np.uint8), pose, (source,), wrap)


@dataclass(frozen=True, eq=False)
class Continuation:
    """The start of a canvas."""

    start: SourceMap  # what is there
    depth: Array  # (H, W): how deep its pixels lie, 0 in holes
    rim: int  # how deep they may be replaced, px
    # The exemplar pixel that canvas pixel (0, 0) shows, or would show if the piece of most pixels reached so far.
    anchor: Pair
    band: Mask  # (H, W): the pixels of that piece near holes: what is added must go on from there

    @classmethod
    def of(cls, canvas: Canvas, rim: int) -> Continuation | None:
        """Look at the start of a canvas; None where it is empty. `rim`: the method's own, if the canvas names none."""
        if canvas.start is None or bool(canvas.start.holes.all()):
            return None
        start, deepest = canvas.start, rim if canvas.rim is None else canvas.rim
        known = ~start.holes
        depth = depth_of(known, canvas.wrap, max(rim, deepest))
        here = np.moveaxis(np.indices(known.shape), 0, 2)
        offset = start.yx.astype(np.int64) - here
        upright = known if start.pose is None else known & (start.pose == 0)
        found, counts = np.unique(offset[upright if upright.any() else known], axis=0, return_counts=True)
        anchor: Pair = tuple(found[int(np.argmax(counts))].tolist())  # of equals the first
        band = upright & (offset == anchor).all(axis=2) & (depth <= rim)
        return cls(start, depth, deepest, anchor, band)

    @property
    def full(self) -> bool:
        """True where nothing is to be added."""
        return not bool(self.start.holes.any())

    def zone(self, at: Pair, window: Mask, side: int) -> Int64:
        """List the band's pixels in a window at `at` of the endless texture: (n, 3) row, column, `side`."""
        ok, index = [], []
        for axis, around in enumerate((self.start.wrap.y, self.start.wrap.x)):
            n, length = np.arange(window.shape[axis]) + at[axis] - self.anchor[axis], self.band.shape[axis]
            ok.append(np.full(len(n), True) if around else (n >= 0) & (n < length))
            index.append(n % length)
        y, x = np.nonzero(self.band[np.ix_(*index)] & np.outer(*ok) & window)
        return np.stack([y, x, np.full(len(y), side)], axis=1).astype(np.int64)

    def joined(
        self, yx: Int32, pose: UInt8 | None, picture: Int16
    ) -> tuple[Int32, UInt8 | None]:
        """Lay the start map over a new map, cut along the cheapest seam; `picture`: the exemplar's features."""
        taken = self._taken(yx, picture)
        if pose is not None or self.start.pose is not None:
            new, old = (np.zeros(taken.shape, np.uint8) if p is None else p for p in (pose, self.start.pose))
            pose = np.where(taken, new, old)
        return np.where(taken[:, :, None], yx, self.start.yx), pose

    def _taken(self, yx: Int32, picture: Int16) -> Mask:
        """Where the new map is shown: in holes, beside them if the rim allows, and as far as the cut goes."""
        state = np.where(self.depth > self.rim, OLD, FREE).astype(np.uint8)
        state[self.depth <= min(self.rim, 1)] = NEW
        taken: Mask = state == NEW
        free = np.argwhere(state == FREE)
        if len(free):
            (y0, x0), (y1, x1) = np.maximum(free.min(axis=0) - 1, 0), free.max(axis=0) + 2
            box = slice(y0, y1), slice(x0, x1)
            new = picture[yx[box][:, :, 0], yx[box][:, :, 1]]
            old = picture[self.start.yx[box][:, :, 0], self.start.yx[box][:, :, 1]]
            out = np.empty(new.shape[:2], np.uint8)
            min_cut(np.ascontiguousarray(state[box]), *seam_costs(old, new, PLAIN), out)
            taken[box] = out.astype(bool)
        return taken


def frame_of(variants: PosedExemplars, v: int) -> tuple[int, ...]:
    """Exemplar, the exemplar pixel shown first, J, and the size if toroidal: how a variant lies in its exemplar."""
    iso = ISOMETRIES[variants.pose[v]]
    _, height, width, _ = variants.table[v].tolist()
    start = iso.start(width, height) if iso.swaps else iso.start(height, width)
    torus = (height, width) if variants.toroidal[v] else (0, 0)
    return int(variants.exemplar[v]), *start, *iso.j[0], *iso.j[1], *torus


Window = tuple[int, int]
STRIP = 256  # rows of a start map that are read together: nothing larger is held besides the map


@dataclass(frozen=True, eq=False)
class GrowingMap:
    """The growing map, in variants and their pixels, and the pixels that must stay."""

    variants: PosedExemplars
    variant: UInt8
    yx: Int32
    locked: Mask

    @classmethod
    def begin(cls, variants: PosedExemplars, canvas: Canvas, rim: int) -> GrowingMap:
        """Begin with the canvas's start map; what lies deeper than `rim` px from every hole is locked."""
        shape = (canvas.height, canvas.width)
        if canvas.start is None:
            empty = np.full(shape, HOLE, np.uint8), np.zeros((*shape, 2), np.int32)
            return cls(variants, *empty, np.zeros(shape, bool))
        start = canvas.start
        variant, yx = np.full(shape, HOLE, np.uint8), np.zeros((*shape, 2), np.int32)
        for top in range(0, canvas.height, STRIP):
            rows = slice(top, top + STRIP)
            for v in range(len(variants)):
                mine = np.ones(yx[rows].shape[:2], bool)
                if start.which is not None or variants.exemplar[v]:
                    mine &= (0 if start.which is None else start.which[rows]) == variants.exemplar[v]
                if start.pose is not None or variants.pose[v]:
                    mine &= (0 if start.pose is None else start.pose[rows]) == variants.pose[v]
                if not mine.any():
                    continue
                _, *origin, a, b, c, d, _, _ = frame_of(variants, v)
                away = np.moveaxis(start.yx[rows], 2, 0) - np.array(origin, np.int32)[:, None, None]
                for axis, (down, right) in enumerate(((a, c), (b, d))):
                    np.copyto(yx[rows, :, axis], away[0] * down + away[1] * right, where=mine)
                variant[rows][mine] = v
        return cls(variants, variant, yx, depth_of(variant != HOLE, canvas.wrap, rim) > rim)

    def open_windows(self, layout: WindowGrid, wanted: Mask | None = None) -> Mask:
        """Return which windows hold a pixel that is not known yet, or that is `wanted`."""
        if layout.places is not None or (wanted is None and not (self.variant != HOLE).any()):
            return np.ones(layout.shape, bool)
        holes = self.variant == HOLE if wanted is None else wanted
        return layout.of_windows(window_sums(layout.widened(holes, 0), layout.patch)) > 0

    def cut_in(
        self, at: Window, pick: tuple[int, int, int], found: Candidates, layout: WindowGrid, price: SeamPrice
    ) -> None:
        """Cut the patch `pick` (variant, row, column) into the window at `at` along the cheapest seam."""
        maps.paste(
            maps.Grown(self.variant, self.yx, layout.wraps), self.locked, self.variants.posed, *at, *pick,
            found.feats, found.known, price,
        )  # fmt: skip

    def lay_over(
        self, at: Window, pick: tuple[int, int, int], known: Array, layout: WindowGrid, seam: Pair
    ) -> None:
        """Lay the patch `pick` into the window at `at`, cut straight in the middle of seams of `seam` px."""
        maps.overlay(
            maps.Grown(self.variant, self.yx, layout.wraps), self.locked, self.variants.posed, *at, *pick, known,
            seam,
        )  # fmt: skip

    def known(self, at: Window, layout: WindowGrid) -> UInt8:
        """Say which pixels of a window are known: (rows, columns) of 0 and 1."""
        y, x = (np.arange(n) + a for n, a in zip(layout.patch, at, strict=True))
        return np.asarray(self.variant[np.ix_(y % layout.height, x % layout.width)] != HOLE, dtype=np.uint8)

    def map(self, exemplars: Exemplars, canvas: Canvas, blend: Blend) -> SourceMap:
        """The map as far as it has grown; it shares its memory with this one where it can."""
        yx, which, pose = self.variants.to_exemplars(self.yx, self.variant)
        return SourceMap(
            yx,
            which if len(exemplars) > 1 or bool((which == HOLE).any()) else None,
            pose if self.variants.pose.any() else None,
            tuple(e.source for e in exemplars),
            canvas.wrap,
            blend,
        )


def waves(layout: WindowGrid, wanted: Mask, around: int = 0) -> list[list[Window]]:
    """Order the wanted windows in waves: the windows of a wave do not touch, earlier waves come first.

    With `around` there are so many px between them, where the canvas has room.

    The order is that of a raster scan as far as overlapping windows can tell: a window comes after those above
    and to the left of it, and after the one above to the right. Windows that lie freely keep the order of their
    numbers: outward from what is known.
    """
    if layout.places is not None:
        size = layout.height, layout.width
        wide = min(layout.patch[0] + around, size[0]), min(layout.patch[1] + around, size[1])
        wave_of = levels(list(layout.places), wide, size, layout.wraps)
        free: list[list[Window]] = [[] for _ in range(max(wave_of, default=-1) + 1)]
        for k, wave in enumerate(wave_of):
            free[wave].append((k, 0))
        return free
    rows = _neighbours(layout.rows, layout.patch[0] + around, layout.height, layout.wrap_y)
    columns = _neighbours(layout.columns, layout.patch[1] + around, layout.width, layout.wrap_x)
    reach = [b - a for a, near in enumerate(columns) for b in near]
    half = len(columns) // 2 if layout.wrap_x else len(columns)
    slope = 1 + max((r for r in reach if r <= half), default=0)
    out: list[list[Window]] = []
    if not (layout.wrap_y or layout.wrap_x) and wanted.all():  # what the loop below finds, in closed form
        r, c = np.indices(wanted.shape)
        number = (c + slope * r).ravel()
        by_wave = np.lexsort((r.ravel(), number))
        begins = np.flatnonzero(np.diff(number[by_wave], prepend=-1))
        cells = list(zip(r.ravel()[by_wave].tolist(), c.ravel()[by_wave].tolist(), strict=True))
        return [cells[a:b] for a, b in zip(begins, [*begins[1:], None], strict=True)]
    order = sorted(zip(*np.nonzero(wanted), strict=True), key=lambda w: (w[1] + slope * w[0], w[0]))
    level = np.full(wanted.shape, -1)
    for row, column in order:
        mine = 1 + max((int(level[r, c]) for r in rows[row] for c in columns[column]), default=-1)
        level[row, column] = mine
        if mine == len(out):
            out.append([])
        out[mine].append((int(row), int(column)))
    return out


Pick = tuple[int, int, int]


def picked(found: Candidates, k: int) -> Pick:
    """The variant, row and column of one of the candidates."""
    _, variant, row, column = found.rows[k].tolist()
    return variant, row, column


def random_patch(valid: Sequence[Array], bits: int) -> Pick:
    """Draw any patch of those that are `valid`, variant by variant: (variant, row, column)."""
    counts = [int(np.count_nonzero(v)) for v in valid]
    k = below(sum(counts), bits)
    for v, n in enumerate(counts):
        if k < n:
            at = int(np.flatnonzero(valid[v])[k])
            return v, *divmod(at, valid[v].shape[1])
        k -= n
    raise AssertionError("counts and draws disagree")


def _neighbours(starts: tuple[int, ...], patch: int, length: int, wrap: bool) -> list[list[int]]:
    """Of every window along an axis, which ones overlap it (itself included)."""
    out = []
    for a in starts:
        out.append([k for k, b in enumerate(starts) if apart(a, b, length, wrap) < patch])
    return out
