"""Where windows lie when part of the canvas is already filled, and in which order: outward from the filled part.

A grid that begins at the corner of the canvas meets the edge of the filled part anywhere: some windows then have only a
few pixels to fill, others hardly a known pixel to match. Here windows begin an overlap inside the filled part, lie
centred on small holes, and are filled ring by ring, those with most known pixels first.

Source: no paper; our own rule (Multrus 2003, 5.1, extends to one side, from the left). Departures: none.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arrays import Mask, Pair
from ..geometry import apart, spread
from ..lazy import ndimage

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
        left[_index(y, x, patch, known.shape)] = False
    holes = ndimage.find_objects(ndimage.label(left, np.ones((3, 3), int))[0]) if left.any() else []
    for box in holes:
        part = left[box]
        if not part.any():  # a window of an earlier hole holds this one, too
            continue
        for y, x in _over(part, box, patch, overlap, known.shape, wraps):
            index = _index(y, x, patch, known.shape)
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
            if not known[_index(y, x, patch, known.shape)].all():
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
    counts = np.array([np.count_nonzero(known[_index(y, x, patch, size)]) for y, x in found], np.int64)
    waiting = np.ones(len(found), bool)
    out: list[Pair] = []
    while waiting.any():
        most = int(counts[waiting].max())
        ring = np.flatnonzero(waiting & (counts >= min(max(least, 1), most)))
        waiting[ring] = False
        changed: set[int] = set()
        for k in sorted(ring.tolist(), key=lambda k: found[k]):
            index = _index(*found[k], patch, size)
            if known[index].all():
                continue
            place = _centred(found[k], ~known[index], patch, overlap, size, wraps)
            known[_index(*place, patch, size)] = True
            changed.update(near.of(place))
            out.append(place)
        for k in changed:
            if waiting[k]:
                counts[k] = np.count_nonzero(known[_index(*found[k], patch, size)])
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


def _index(y: int, x: int, patch: Pair, size: tuple[int, ...]) -> Any:
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
