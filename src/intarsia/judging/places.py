"""Where an output loses: what joins cost place by place, and the places of the exemplar that it shows too often."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..analysis.sums import window_sums
from ..arrays import Array
from ..lazy import ndimage
from .parts import shown, square_side
from .score import Judged
from .sources import STEP, Sources
from .windows import SIDE

SIZES = 2  # of windows by which joins are told: the smallest
MOST = 3  # places that are told of,
MANY = 60  # but no further one where so many places of the output are told of already
OFTEN = 2.5  # times the mean: what is shown less often is nothing to tell of
RETURNS = 3  # places of the output that show it, at least

Size = tuple[int, int]


@dataclass(frozen=True)
class Spot:
    """A place of a picture: its middle and its radius, in px."""

    y: float
    x: float
    radius: float


@dataclass(frozen=True)
class Often:
    """A place that is shown too often: in exemplar `number` at `place`, so many `times` the mean, at `spots`."""

    number: int
    place: Spot
    times: float
    spots: tuple[Spot, ...]


def joins_at(judged: Judged, size: Size) -> Array:
    """How much joins cost around every place of an output of `size`, 0 to 1: as much as any two windows differ.

    Returns (rows, columns) of squares of 8 px, or of so many times more as the output was looked at reduced.
    """
    rows, columns = (-(-n // (STEP * judged.factor)) for n in size)
    total, count = np.zeros((rows, columns)), np.zeros((rows, columns), np.int64)
    for look in judged.looks:
        top, left = (at // (STEP * judged.factor) for at in look.begin)
        for sources in look.sources[:SIZES]:
            right, below = sources.changes / 1024
            y, x = (at + SIDE * sources.level.windows.factor // (2 * STEP) for at in (top, left))
            for change in (right[:, 1:], below[1:]):  # the first follow none
                high, wide = min(change.shape[0], rows - y), min(change.shape[1], columns - x)
                total[y : y + high, x : x + wide] += change[:high, :wide]
                count[y : y + high, x : x + wide] += 1
    known = [np.flatnonzero(count.any(axis=1 - axis)) for axis in (0, 1)]
    if not count.any():
        return total
    rim = (np.clip(np.arange(n), at[0], at[-1]) for n, at in zip(total.shape, known, strict=True))
    return np.asarray((total / np.maximum(count, 1))[np.ix_(*rim)])


def too_often(judged: Judged, exemplars: Sequence[Size], output: Size, most: int = MOST) -> tuple[Often, ...]:
    """Look for the places of the exemplars that are shown far more often than others, the most used first."""
    first = [look.sources[0] for look in judged.looks if look.sources]
    if not first:
        return ()
    table = first[0].level.windows.table
    often = shown(table, np.sum([s.usage for s in first], axis=0))
    known, side = often >= 0, square_side(table)
    mean = float(often[known].mean()) if known.any() else 0.0
    if mean == 0:
        return ()
    found = list[Often]()
    apart = 2 * side + SIDE // first[0].level.windows.stride
    while len(found) < most and sum(len(o.spots) for o in found) < MANY and often.max() >= OFTEN * mean:
        row, column = (int(n) for n in np.unravel_index(int(often.argmax()), often.shape))
        times = float(often[row, column]) / mean
        often[max(0, row - apart + 1) : row + apart, max(0, column - apart + 1) : column + apart] = -1
        spots = tuple(_spots(judged, (row, column), output))
        if len(spots) >= RETURNS:
            number, place = _place(first[0], (row, column), judged.factor, exemplars)
            found.append(Often(number, place, times, spots))
    return tuple(found)


def usage_of(judged: Judged, exemplars: Sequence[Size]) -> list[Array]:
    """How often pixels of each exemplar are shown, as far as windows tell, of what they would be on average.

    Where a map is known, it tells this exactly. The rest of an exemplar that is looked at reduced counts as 0.
    """
    first = [look.sources[0] for look in judged.looks if look.sources]
    out = [np.zeros(size) for size in exemplars]
    if not first:
        return out
    windows = first[0].level.windows
    usage, n = np.sum([s.usage for s in first], axis=0), windows.factor * judged.factor
    for number, (begin, height, width) in enumerate(_rows(first[0], judged.factor, exemplars)):
        mine = np.s_[begin : begin + height, :width]
        there, counts = (windows.table[mine] >= 0).astype(np.int64), usage[mine]
        spread = -(-SIDE // windows.stride)
        around = ((spread - 1, spread - 1),) * 2
        times, most = (window_sums(np.pad(a, around), (spread, spread)) for a in (counts, there))
        share = np.repeat(np.repeat(times / np.maximum(most, 1), windows.stride * n, 0), windows.stride * n, 1)
        high, wide = (min(a, b) for a, b in zip(share.shape, out[number].shape, strict=True))
        out[number][:high, :wide] = share[:high, :wide]
    mean = float(usage.sum()) / max(int((windows.table >= 0).sum()), 1)
    return [picture / mean for picture in out] if mean else out


def _rows(sources: Sources, factor: int, exemplars: Sequence[Size]) -> list[tuple[int, int, int]]:
    """Where each exemplar begins in the table of windows, how high and how wide it is there."""
    windows, out, begin = sources.level.windows, list[tuple[int, int, int]](), 0
    for size in exemplars:
        room = [n // factor // windows.factor - SIDE + 1 for n in size]
        height, width = (max(0, -(-n // windows.stride)) if min(room) > 0 else 0 for n in room)
        out.append((begin, height, width))
        begin += height + SIDE * (height > 0)
    return out


def _place(sources: Sources, at: tuple[int, int], factor: int, exemplars: Sequence[Size]) -> tuple[int, Spot]:
    """The exemplar, and the place in it, of the square of the table that begins at `at`."""
    windows, (row, column) = sources.level.windows, at
    rows = _rows(sources, factor, exemplars)
    number = max(n for n, (begin, height, _) in enumerate(rows) if height and begin <= row)
    n, radius = windows.factor * factor, _radius(sources, factor)
    return number, Spot(
        (row - rows[number][0]) * windows.stride * n + radius, column * windows.stride * n + radius, radius
    )


def _radius(sources: Sources, factor: int) -> float:
    windows = sources.level.windows
    return (square_side(windows.table) * windows.stride + SIDE) * windows.factor * factor / 2


def _spots(judged: Judged, at: tuple[int, int], output: Size) -> list[Spot]:
    """The places of the output that show the square of the table that begins at `at`."""
    out = list[Spot]()
    for look in judged.looks:
        if not look.sources:
            continue
        sources = look.sources[0]
        windows = sources.level.windows
        off = windows.at[sources.number] - at
        inside = ((off >= 0) & (off < square_side(windows.table))).all(axis=2)
        numbers, count = ndimage.label(inside, np.ones((3, 3)))
        radius, half = _radius(sources, judged.factor), SIDE * windows.factor / 2
        for k in range(1, count + 1):
            middle = np.argwhere(numbers == k).mean(axis=0) * STEP + half
            y, x = (
                (b + float(m) * judged.factor) % n for b, m, n in zip(look.begin, middle, output, strict=True)
            )
            if all(max(_apart(y, s.y, output[0]), _apart(x, s.x, output[1])) > radius for s in out):
                out.append(Spot(y, x, radius))
    return out


def _apart(a: float, b: float, length: int) -> float:
    """How far two places are along an axis that may be closed: seen twice where it is."""
    return min(abs(a - b), length - abs(a - b))
