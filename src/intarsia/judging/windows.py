"""Windows as low-frequency DCT coefficients in integers, and exact nearest-neighbour search among them.

Windows of 8 x 8 px of a picture reduced 2, 4 or 8 times are compared by their lowest DCT coefficients ("cosines"). They
are integers so small that float32 products and sums are exact: the nearest window is the same on every machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..analysis import block_sums, blocks
from ..foundation.arrays import Array, Int32, Mask

SIDE = 8  # px: side of a window, in the reduced picture
COSINES = 4  # DCT orders along the two axes that add up to less than this are kept: ten coefficients of each channel
ORDERS = [(k, other) for k in range(COSINES) for other in range(COSINES - k)]  # vertical and horizontal order
FINE = 64  # the values of cosines are rounded to whole multiples of 1 / FINE
LONGEST = 2**22  # largest squared length of a vector: products and sums stay below 2**24, exact in float32
MOST = 16500  # windows of the exemplars; if there are more, only every second, third, ... along each axis is taken
BATCH = 128  # windows that are compared at a time, so that they fit into a cache
ALL = slice(None)  # all features
ROOT = 16  # distances are whole multiples of 1 / ROOT


@cache
def _cosines() -> Array:
    """Return the lowest cosines of a window as integers: (SIDE * SIDE, 10)."""
    i = np.arange(SIDE)
    waves = np.array([np.cos(np.pi * k * (2 * i + 1) / (2 * SIDE)) * (1 if k else 0.5**0.5) for k in range(COSINES)])
    both = [np.multiply.outer(waves[k], waves[other]).ravel() for k, other in ORDERS]
    return np.asarray(np.rint(np.stack(both, axis=1) * FINE / (SIDE / 2)))


def poses(waves: Array) -> list[Array]:
    """Return windows (n, features) in the eight isometries: odd orders change sign when mirrored, axes may swap."""
    each = waves.reshape(len(waves), -1, len(ORDERS))
    turned = each[:, :, [ORDERS.index((across, down)) for down, across in ORDERS]]
    signs = [[(-1) ** (a * down + b * across) for down, across in ORDERS] for a in (0, 1) for b in (0, 1)]
    return [(laid * np.array(s, np.float32)).reshape(waves.shape) for laid in (each, turned) for s in signs]


def block_means(picture: Array, factor: int) -> Array:
    """Return means over blocks of factor x factor px, rounded down."""
    return picture if factor == 1 else block_sums(picture, factor) // (factor * factor)


def dct_coefficients(picture: Array, rows: Array, columns: Array, middle: Array, shorten: int) -> Array:
    """Return the DCT coefficients of the windows that begin at `rows` x `columns`: float32 (rows, columns, features).

    `middle` is subtracted from every channel first; the result is divided by `shorten` and rounded.
    """
    held = np.lib.stride_tricks.sliding_window_view(picture, (SIDE, SIDE), axis=(0, 1))[rows][:, columns]
    flat = held.reshape(len(rows), len(columns), picture.shape[2], -1) - middle[:, None]
    waves = np.rint(flat.astype(np.float32) @ _cosines().astype(np.float32) / (FINE * shorten))
    return np.asarray(waves.reshape(len(rows), len(columns), -1), np.float32)


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows of one or more exemplars at one reduction.

    ``factor``: of the reduction. ``waves`` float32 (n, features): their DCT coefficients, less ``middle`` and divided
    by ``shorten`` (see `dct_coefficients`); ``squares`` (n,): their squared lengths. ``at`` int (n, 2): row and column
    of each in ``table``, which holds their numbers, -1 for none. Exemplars are stacked vertically in the table,
    separated by SIDE rows. ``stride``: px of the reduced picture between neighbours of the table.
    """

    factor: int
    stride: int
    middle: Array
    shorten: int
    waves: Array
    squares: Array
    at: Array
    table: Int32

    @classmethod
    def of(cls, pictures: list[Array], usable: list[Mask | None], factor: int) -> Windows | None:
        """Cut all windows with usable pixels only; None if there are none."""
        small = [block_means(p, factor) for p in pictures]
        room = [(p.shape[0] - SIDE + 1, p.shape[1] - SIDE + 1) for p in small]
        count = sum(max(0, h) * max(0, w) for h, w in room)
        stride = max(1, math.isqrt(max(count - 1, 0) // MOST) + (count > MOST))
        if not count:
            return None
        flat = np.concatenate([p.reshape(-1, p.shape[2]) for p in small])
        middle = np.asarray(flat.sum(axis=0) // len(flat))
        longest = SIDE * SIDE * int(((flat - middle) ** 2).sum(axis=1).max())
        shorten = 1 + math.isqrt(longest // LONGEST)
        tables: list[Array] = []
        waves: list[Array] = []
        begin = below = 0
        for p, (h, w), free in zip(small, room, usable, strict=True):
            if min(h, w) < 1:
                continue
            rows, columns = np.arange(0, h, stride), np.arange(0, w, stride)
            found = dct_coefficients(p, rows, columns, middle, shorten)
            whole = np.ones(found.shape[:2], bool) if free is None else _whole(free, factor, rows, columns)
            numbers = np.full(whole.shape, -1, np.int32)
            numbers[whole] = begin + np.arange(int(whole.sum()))
            tables.append(np.asarray(numbers))
            waves.append(found[whole])
            begin, below = begin + int(whole.sum()), max(below, whole.shape[1])
        if not begin:
            return None
        gap = np.full((SIDE, below), -1, np.int32)
        wide = [np.pad(t, ((0, 0), (0, below - t.shape[1])), constant_values=-1) for t in tables]
        table = np.concatenate([part for t in wide for part in (t, gap)])
        at = np.argwhere(table >= 0)
        every = np.concatenate(waves)
        return cls(factor, stride, middle, shorten, every, (every * every).sum(axis=1), at, table)

    def cut(self, picture: Array, step: int) -> Array:
        """Return the windows of an output picture that begin every `step` px of it: (rows, columns, features)."""
        small = block_means(picture, self.factor)
        rows, columns = (np.arange(0, n - SIDE + 1, max(1, step // self.factor)) for n in small.shape[:2])
        return dct_coefficients(small, rows, columns, self.middle, self.shorten)

    def middles(self, pictures: Sequence[Array]) -> Array:
        """Return the values of pictures (H, W), sized as the exemplars, at window centres: shaped as ``table``."""
        out, begin = np.zeros(self.table.shape), 0
        for p in pictures:
            rows, columns = (np.arange(0, n // self.factor - SIDE + 1, self.stride) for n in p.shape)
            if rows.size and columns.size:
                middle = ((a * self.factor + SIDE * self.factor // 2) for a in (rows, columns))
                out[begin : begin + len(rows), : len(columns)] = p[np.ix_(*middle)]
                begin += len(rows) + SIDE
        return out

    def nearest(self, waves: Array) -> tuple[Array, Array]:
        """Return the distance of each of `waves` (n, features) to its nearest window, in 1 / ROOT, and its number."""
        return nearest(waves, self.waves, self.squares)

    def apart(self, waves: Array, numbers: Array, features: slice = ALL) -> Array:
        """Return the distance of each of `waves` (..., features) to the window of its number, in 1 / ROOT."""
        off = waves[..., features] - self.waves[numbers][..., features]
        return rooted((off * off).sum(axis=-1))

    def own(self, most: int) -> tuple[Array, Array]:
        """Find the nearest window at more than half a window's side for a regular sample of about `most` windows.

        Returns the numbers of the sample and the distances in 1 / ROOT; windows without a neighbour are left out.
        """
        some = np.arange(0, len(self.waves), max(1, -(-len(self.waves) // most)))
        reach = -(-(SIDE // 2 + 1) // self.stride)
        least = np.empty(len(some))
        for begin in range(0, len(some), BATCH):
            batch = some[begin : begin + BATCH]
            squares = self.squares - 2 * (self.waves[batch] @ self.waves.T)
            for row, (y, x) in zip(squares, self.at[batch], strict=True):
                near = self.table[max(0, y - reach + 1) : y + reach, max(0, x - reach + 1) : x + reach]
                row[near[near >= 0]] = np.inf
            least[begin : begin + BATCH] = squares.min(axis=1) + self.squares[batch]
        known = np.isfinite(least)
        return some[known], rooted(least[known])

    @property
    def tones(self) -> slice:
        """The features that are the means of the channels."""
        return slice(0, None, len(_cosines()[0]))

    def unrelated(self, features: slice = ALL) -> int:
        """Return the median distance of many pairs of windows, in 1 / ROOT."""
        n = len(self.waves)
        one = np.arange(0, n, max(1, n // 2000))
        other = (one * 7919 + n // 3) % n
        return max(1, int(np.sort(self.apart(self.waves[one], other, features))[len(one) // 2]))


def _whole(usable: Mask, factor: int, rows: Array, columns: Array) -> Mask:
    """Return a mask of the windows with usable pixels only."""
    free = blocks(usable, factor).all(axis=(1, 3))
    held = np.lib.stride_tricks.sliding_window_view(free, (SIDE, SIDE))[rows][:, columns]
    return np.asarray(held.all(axis=(2, 3)))


def nearest(waves: Array, others: Array, squares: Array) -> tuple[Array, Array]:
    """Return the distance of each of `waves` to the nearest of `others`, in 1 / ROOT, and its number."""
    least, which = np.empty(len(waves), np.float32), np.empty(len(waves), np.int64)
    turned = np.ascontiguousarray(others.T)
    for begin in range(0, len(waves), BATCH):
        found = waves[begin : begin + BATCH] @ turned
        found *= -2
        found += squares
        number = found.argmin(axis=1)
        which[begin : begin + BATCH] = number
        least[begin : begin + BATCH] = found[np.arange(len(number)), number]
    return rooted(least + (waves * waves).sum(axis=1)), which


def rooted(squares: Array) -> Array:
    """Return square roots of integers in units of 1 / ROOT, rounded."""
    return np.asarray(np.rint(ROOT * np.sqrt(np.maximum(squares, 0).astype(np.float64))), np.int64)
