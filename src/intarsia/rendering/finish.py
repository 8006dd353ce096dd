"""Finish a drawn picture: even out steps of light and colour across seams.

    out'(p) = out(p) + s (mean of out around p - mean of the exemplar around S(p), as it lies there)

Both means are over a box of radius r. Further than r from every seam they are over the same pixels, and nothing
changes; at a seam the slow changes of both sides meet in the middle, while detail finer than the box stays. What stays
is then levelled with r / 4, and so on, down to 2 px: with one radius, pieces that fit at the seam but not around it
would get a step that they did not have. So every band of the picture is blended over a width that suits it, as Burt
and Adelson (1983) blend, with boxes in place of their Gaussians and a support that ends. All is done to the stored
numbers, sRGB codes too: a step of light is a factor more than a sum, and in linear light what is added to a bright
stone turns the gap beside it black. Sums are of whole numbers, so that a window is that window of the whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError
from ..geometry import Box
from ..image import Array
from ..levelling import Finish, Levelling
from ..run import Run
from .cell_kernels import Map
from .finish_kernels import Sums, add_means, add_up, move_codes, step_sizes, take_off
from .ground import cut_out_map

MAX_RADIUS = 1024
"""The widest radius in px of a plane: sums over (2 x 1024 + 1)**2 differences of numbers of 36 bits fit into 64."""

_BITS, _OPACITY = 36, 8  # of a value, of a weight; opacity takes its bits from the values
_RATIO, _FINEST = 4, 2  # of one radius to the next; the least that follows another
_ROWS, _COLUMNS, _TOGETHER = 256, 1024, 4  # of a cell, at least; channels at a time
_NONE, _PLAIN = np.zeros((0, 0), np.int64), np.zeros(0, np.int32)


@dataclass(frozen=True)
class Bench:
    """All that finishing a plane needs: exemplars end to end, and the map itself."""

    samples: Array  # (N, C) codes of all exemplars
    table: NDArray[np.int64]  # (n, 4): number of the first pixel, height, width, 1 if toroidal
    usable: NDArray[np.bool_] | None  # (N,)
    alpha: bool  # whether opacity comes last; it stays
    full: Map
    wrap: tuple[bool, bool]
    scale: int

    def finished(self, draw: Callable[[Box], Array], box: Box, finishes: tuple[Finish, ...], run: Run) -> Array:
        """Draw a box of the map, in px of the map, and finish it; `draw` draws any box that lies on the canvas."""
        reach = sum(f.radius for f in finishes)
        for how in finishes:
            if how.radius * self.scale > MAX_RADIUS:
                raise ParameterError(
                    f"radius={how.radius} is too wide on a {self.scale}x larger plane; "
                    f"at most {MAX_RADIUS // self.scale} px."
                )
        here = _with_margin(box, reach, self.full[0].shape, self.wrap)
        codes = self._drawn(draw, here)
        for how in finishes:
            reach -= how.radius
            inner = _with_margin(box, reach, self.full[0].shape, self.wrap)
            codes = self._levelled(codes, _enlarged_box(here, self.scale), _enlarged_box(inner, self.scale), how, run)
            here = inner
        return codes

    def _drawn(self, draw: Callable[[Box], Array], box: Box) -> Array:
        """Draw a box; what lies in it more than once, around a torus, is drawn once."""
        height, width = self.full[0].shape[:2]
        rows = (0, height) if box.height > height else (box.y0, box.y1)
        columns = (0, width) if box.width > width else (box.x0, box.x1)
        codes = draw(Box(rows[0], columns[0], rows[1], columns[1]))
        if box.height > height:
            codes = codes[np.arange(box.y0 * self.scale, box.y1 * self.scale) % len(codes)]
        if box.width > width:
            codes = codes[:, np.arange(box.x0 * self.scale, box.x1 * self.scale) % codes.shape[1]]
        return codes

    def _levelled(self, codes: Array, box: Box, inner: Box, how: Levelling, run: Run) -> Array:
        """Level a picture.

        `codes` (h, w, C) are what is drawn of `box`, in px of the plane, which reaches the radius beyond `inner`
        or to the border of the canvas. Returns the codes of `inner`.
        """
        radius = how.radius * self.scale
        dy, dx = inner.y0 - box.y0, inner.x0 - box.x0
        out = codes[dy : dy + inner.height, dx : dx + inner.width].copy()
        rows, columns = max(_ROWS, radius), max(_COLUMNS, radius)
        cells = [
            Box(y, x, min(y + rows, inner.height), min(x + columns, inner.width))
            for y in range(0, inner.height, rows)
            for x in range(0, inner.width, columns)
        ]
        weights = self._weights()
        colours = codes.shape[2] - self.alpha
        with run.pool() as each:
            for first in range(0, colours, _TOGETHER):
                channels = _Channels.of(self, slice(first, min(first + _TOGETHER, colours)), weights, radius)

                def level(cell: Box, channels: _Channels = channels) -> None:
                    there = slice(cell.y0, cell.y1), slice(cell.x0, cell.x1), channels.span
                    here = np.ascontiguousarray(out[there])  # one layout for kernels, whatever the size
                    place = Box(cell.y0 + dy, cell.x0 + dx, cell.y1 + dy, cell.x1 + dx)  # in `box`
                    wide, steps = _with_margin(place, radius, codes.shape), np.zeros(here.shape)
                    part = cut_out_map(self.full, wide.moved(box.y0, box.x0), self.scale, self.wrap, self.table)
                    values, weight = channels.numbers(_cut(codes, wide, Box(0, 0, 0, 0)))
                    for band in channels.bands:
                        near = _with_margin(place, band.radius, codes.shape)
                        seen = _cut(values, near, wide)
                        if band is not channels.bands[0]:
                            take_off(seen, _cut_map(part, near, wide), self.table, band.smooth)
                        own = _sums_of(seen, _cut(weight, near, wide) if weight.size else weight)
                        corner = (place.y0 - near.y0, place.x0 - near.x0)
                        step_sizes(_cut_map(part, place, wide), own, band.theirs, corner, band.radius, steps)
                    channels.move(here, steps, how.strength)
                    out[there] = here

                each(level, cells)
                run.tick(1, 1)
        return out

    def _weights(self) -> NDArray[np.int64] | None:
        """How much every pixel of the exemplars counts; None where all count alike."""
        opaque = _opacity(self.samples[:, -1]) if self.alpha else None
        if self.usable is None:
            return opaque
        return self.usable.astype(np.int64) if opaque is None else opaque * self.usable


@dataclass(frozen=True)
class _Band:
    """What is levelled with one radius: the exemplars without what wider radii have seen to."""

    radius: int
    smooth: NDArray[np.int64]  # (N, C): what wider radii have seen to
    theirs: Sums


@dataclass(frozen=True)
class _Channels:
    """Some channels of a plane: their numbers, their range, and the sums of the exemplars."""

    span: slice
    alpha: bool  # whether opacity comes last in the plane
    shift: int  # codes become whole numbers of 2**-shift
    spread: NDArray[np.float64]  # (C, 2): least and greatest code of the exemplars
    bands: tuple[_Band, ...]

    @classmethod
    def of(cls, bench: Bench, span: slice, weights: NDArray[np.int64] | None, radius: int) -> _Channels:
        codes = bench.samples[:, span]
        seen = codes if weights is None or not weights.any() else codes[weights > 0]
        if codes.dtype.kind == "f":  # what is masked out may hold anything
            seen = np.nan_to_num(seen.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
        spread = np.stack([seen.min(axis=0), seen.max(axis=0)], axis=1).astype(np.float64)
        room = _BITS - _OPACITY * bench.alpha
        if codes.dtype.kind == "f":
            shift = min(room - math.frexp(float(np.abs(spread).max()))[1], 1000)
        else:
            shift = room - 8 * codes.itemsize
        values, smooth, bands = _as_integers(codes, shift), np.zeros(codes.shape, np.int64), []
        while True:
            bands.append(_Band(radius, smooth, _sums_of_all(bench.table, values - smooth, weights)))
            radius //= _RATIO
            if radius < _FINEST:
                return cls(span, bench.alpha, shift, spread, tuple(bands))
            smooth = smooth.copy()
            add_means(bands[-1].theirs, bands[-1].radius, smooth)

    def numbers(self, codes: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return what is added up of a piece of the picture (h, w, C): values, and weights unless all count alike."""
        values = _as_integers(codes[..., self.span], self.shift)
        return values, _opacity(codes[..., -1]) if self.alpha else _NONE

    def move(self, codes: Array, steps: NDArray[np.float64], strength: float) -> None:
        """Add the steps to codes (h, w, C), within the range of the exemplars."""
        if codes.dtype.kind != "f":
            move_codes(codes, steps, math.ldexp(strength, -self.shift), self.spread)
            return
        own = codes.astype(np.float64)
        wanted = own + np.ldexp(steps, -self.shift) * strength
        codes[...] = np.clip(wanted, np.minimum(self.spread[:, 0], own), np.maximum(self.spread[:, 1], own))


def _enlarged_box(box: Box, scale: int) -> Box:
    return Box(box.y0 * scale, box.x0 * scale, box.y1 * scale, box.x1 * scale)


def _with_margin(
    cell: Box, radius: int, shape: tuple[int, ...], wrap: tuple[bool, bool] = (False, False)
) -> Box:
    """Return the cell with its surroundings, as far as the picture or canvas goes."""
    y0, x0, y1, x1 = cell.y0 - radius, cell.x0 - radius, cell.y1 + radius, cell.x1 + radius
    if not wrap[0]:
        y0, y1 = max(y0, 0), min(y1, shape[0])
    if not wrap[1]:
        x0, x1 = max(x0, 0), min(x1, shape[1])
    return Box(y0, x0, y1, x1)


def _cut(array: Array, box: Box, frame: Box) -> Array:
    """Cut a box out of an array that begins where `frame` does."""
    y, x = box.y0 - frame.y0, box.x0 - frame.x0
    return array[y : y + box.height, x : x + box.width].copy()


def _cut_map(part: Map, box: Box, frame: Box) -> Map:
    return _cut(part[0], box, frame), _cut(part[1], box, frame), _cut(part[2], box, frame)


def _as_integers(codes: Array, shift: int) -> NDArray[np.int64]:
    """Return codes as whole numbers of 2**-shift; what is not finite, which only masked pixels may be, as 0."""
    if codes.dtype.kind != "f":
        return np.asarray(codes.astype(np.int64) << shift)
    values = np.nan_to_num(codes.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    top = math.ldexp(1.0, _BITS)
    return np.asarray(np.rint(np.clip(np.ldexp(values, shift), -top, top)), np.int64)


def _opacity(alpha: Array) -> NDArray[np.int64]:
    """Return opacity as weights of 8 bits."""
    if alpha.dtype.kind == "f":
        share = np.clip(np.nan_to_num(alpha.astype(np.float64), nan=0.0), 0.0, 1.0)
        return np.rint(share * ((1 << _OPACITY) - 1)).astype(np.int64)
    return np.asarray(alpha.astype(np.int64) >> (0 if alpha.itemsize == 1 else 16 - _OPACITY))


def _sums_of_all(table: NDArray[np.int64], values: NDArray[np.int64], weights: NDArray[np.int64] | None) -> Sums:
    """Add up exemplars, (N, C) end to end."""
    flat, heavy, corners, first = [], [], table.copy(), 0
    for at, (start, height, width, _) in enumerate(table):
        pixels, shape = slice(start, start + height * width), (height, width)
        weight = _NONE if weights is None else weights[pixels].reshape(shape)
        flat.append(_corner_sums(values[pixels].reshape(*shape, -1), weight))
        heavy.append(_corner_sums(weight[..., None], _NONE))
        corners[at, 0] = first
        first += len(flat[-1])
    return Sums(np.concatenate(flat), np.concatenate(heavy), corners)


def _sums_of(values: NDArray[np.int64], weight: NDArray[np.int64]) -> Sums:
    """Add up a piece of the picture."""
    table = np.array([[0, *values.shape[:2], 0]], np.int64)
    return Sums(_corner_sums(values, weight), _corner_sums(weight[..., None], _NONE), table)


def _corner_sums(values: Array, weight: NDArray[np.int64]) -> NDArray[np.int64]:
    """Add up all above and left of every corner of a picture (h, w, C): ((h + 1) (w + 1), C) numbers."""
    if not values.size:
        return np.zeros((0, 1), np.int64)
    sums = np.empty((values.shape[0] + 1, values.shape[1] + 1, values.shape[2]), np.int64)
    add_up(values, weight, sums)
    return sums.reshape(-1, values.shape[2])
