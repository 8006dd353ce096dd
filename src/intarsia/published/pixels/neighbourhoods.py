"""Exemplars laid out for neighbourhood search, and automatic windows of pixel-based methods."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...analysis import valid_windows
from ...foundation import MethodError, ParameterError
from ...foundation.arrays import Int16, Int64, Mask, Pair
from ...foundation.params import AUTO, extent, words
from ...model import Exemplar, Exemplars, sampled
from ...search import PosedExemplars, elements
from .neighbourhood_kernels import LEFT_OUT, ExemplarPlanes

Reach = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class PixelPlanes:
    """One variant of the exemplar as planes (P, H, W), and which of its pixels may be used."""

    planes: Int16
    usable: Mask
    toroidal: bool


def layers(variants: PosedExemplars, exemplars: Exemplars) -> list[PixelPlanes]:
    """Split variants made for patches of one pixel into planes."""
    return [
        PixelPlanes(
            np.ascontiguousarray(np.moveaxis(variants.picture(v), 2, 0)),
            variants.valid[v],
            exemplars[variants.exemplar[v]].toroidal,
        )
        for v in range(len(variants))
    ]


def exemplar_planes(given: Sequence[PixelPlanes], half: Reach, whole: Reach) -> ExemplarPlanes:
    """Lay variants out for neighbourhoods of two kinds, each reaching so far (up, left, down, right) px.

    Neighbourhoods lie inside the exemplar and hold usable pixels only.
    """
    top, left, bottom, right = whole
    table = np.zeros((len(given), 13), np.int64)
    values, closed = [], []
    begin = at = 0
    for v, one in enumerate(given):
        planes, usable = one.planes, one.usable
        if one.toroidal:
            pad = ((0, top + bottom), (0, left + right))
            planes, usable = np.pad(planes, ((0, 0), *pad), mode="wrap"), np.pad(usable, pad, mode="wrap")
        count, rows, stride = planes.shape
        height, width = one.planes.shape[1:]
        begins = (top, left) if one.toroidal else (0, 0)
        table[v, :9] = begin, height, width, stride, rows * stride, at, *begins, one.toroidal
        for kind, reach in enumerate((half, whole)):
            allowed = _allowed(usable, reach)
            if one.toroidal:  # every pixel once
                inner = np.zeros_like(allowed)
                inner[top : top + height, left : left + width] = True
                allowed &= inner
            found = np.flatnonzero(allowed)
            table[v, [9 + kind, 11 + kind]] = (found[0], found[-1] + 1) if len(found) else (0, 0)
            closed.append(np.where(allowed, np.float32(0), LEFT_OUT).ravel())
        values.append(planes.ravel())
        begin += count * rows * stride
        at += rows * stride
    flat = np.concatenate(values)
    both = np.stack([np.concatenate(closed[kind::2]) for kind in (0, 1)])
    return ExemplarPlanes(flat, flat.astype(np.float32), table, both)


def choices(of: ExemplarPlanes, kind: int) -> Int64:
    """List all (variant, position) at which a neighbourhood of that kind may lie, in order: (n, 2)."""
    found = []
    for v, row in enumerate(of.table):
        positions = np.flatnonzero(of.closed[kind, row[5] : row[5] + row[4]] == 0)
        found.append(np.stack([np.full(len(positions), v), positions], axis=1))
    return np.concatenate(found).astype(np.int64)


def check_window(exemplars: Exemplars, window: str, reach: Reach) -> None:
    """Raise ParameterError or MethodError if a window fits nowhere in an exemplar that is sampled."""
    for e in sampled(exemplars):
        rows, columns = reach[0] + reach[2] + 1, reach[1] + reach[3] + 1
        if not e.toroidal and (rows > e.height or columns > e.width):
            raise ParameterError(
                f"window={window} reaches over {columns}x{rows} px, more than the exemplar ({e.width} x {e.height} px) "
                "has; choose a smaller window, or a larger exemplar."
            )
    if not any(_room(e, reach) for e in exemplars):
        raise MethodError(
            f"no window={window} of the exemplar is free of masked pixels; choose a smaller window, or mask less."
        )


def with_window(
    method: Any, exemplars: Exemplars, limits: Pair, whole: bool, reach: Callable[[Pair], Reach]
) -> Any:
    """Return a method with its window decided: as wide as the largest elements, within limits, if that fits.

    `whole`: as many rows as columns, not half of them; `reach` returns how far a window of (rows, columns) reads.
    """
    if method.window is not AUTO:
        check_window(exemplars, words(method.window), reach(extent(method.window)))
        return method
    least, most = limits
    used = sampled(exemplars)
    side = min(max(max(elements(e).size for e in used), least), most) // 2 * 2 + 1
    high = side if whole else side // 2 + 1
    while side > 3 and not all(_room(e, reach((high, side))) for e in used):
        side -= 2
        high = side if whole else side // 2 + 1
    check_window(exemplars, str(side), reach((high, side)))
    return replace(method, window=side if whole else (high, side))


def _room(exemplar: Exemplar, reach: Reach) -> bool:
    size = reach[0] + reach[2] + 1, reach[1] + reach[3] + 1
    usable = exemplar.free
    shape = tuple(n + exemplar.toroidal * (side - 1) for n, side in zip(usable.shape, size, strict=True))
    return bool(valid_windows(shape, usable, exemplar.toroidal, size).any())


def _allowed(usable: Mask, reach: Reach) -> Mask:
    """Return where everything within reach lies inside the picture and is usable."""
    top, left, bottom, right = reach
    out = np.zeros_like(usable)
    free = valid_windows(usable.shape, usable, False, (top + bottom + 1, left + right + 1))
    out[top : top + free.shape[0], left : left + free.shape[1]] = free
    return out
