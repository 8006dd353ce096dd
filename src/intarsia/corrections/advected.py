"""Texture advection: a map moved along a flow and corrected only where neighbours separate (Lefebvre and Hoppe 2006).

Pixels that move by the same offset keep their neighbours and stay unchanged. Where neighbouring pixels move by
different offsets they no longer match; only there, and within a few px, corrections are run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis import blocks
from ..foundation import ndimage
from ..foundation.arrays import Array, Mask, Pair
from ..foundation.run import Run, below, draw_many
from .coordinate_pyramid import REACH, CorrectionParameters, subpass
from .stack import ExemplarStack

STAGE = 200610  # key of these random numbers, which makes them independent of other methods
SQUARE = 16  # px: side of the canvas squares that share a random shift where the exemplar ends
AROUND = 2  # px around torn pixels that are corrected as well

Closed = tuple[bool, bool]


def _begun_again(coords: Array, size: Pair, lot: Pair) -> Array:
    """Shift coordinates (H, W, 2) outside of the exemplar along its border, in place, by a random shift per square.

    `size`: of the exemplar; `lot`: seed and frame number of the random shifts.
    """
    outside = (coords < 0) | (coords >= size)
    ys, xs = np.nonzero(outside.any(axis=2))
    if len(ys):
        squares, index = np.unique(np.stack([ys, xs], axis=1) // SQUARE, axis=0, return_inverse=True)
        shift = np.array([[below(n, b) for n in size] for b in draw_many(lot[0], STAGE, lot[1], squares)], np.int64)
        coords[ys, xs] += np.where(outside[ys, xs][:, ::-1], shift[index.ravel()], 0)
    return coords


def _on(at: Array, n: int, around: bool) -> Array:
    """Return coordinates modulo `n` px if `around`, else clamped to 0 .. n - 1."""
    return at % n if around else at.clip(0, n - 1)


@dataclass(frozen=True)
class AdvectedCorrections:
    """Moves a map along a flow and corrects it where neighbouring pixels no longer match.

    ``stack``: levels of the exemplar; ``rules``: of the corrections; ``closed``: whether the canvas wraps along y, x.
    """

    stack: ExemplarStack
    rules: CorrectionParameters
    closed: Closed

    def moved(self, yx: Array, steps: Array, lot: Pair) -> tuple[Array, Mask]:
        """Return the map (H, W, 2) moved by whole pixels, and which pixels no longer match a neighbour (H, W).

        S'(p) = S(q) + (p - steps(p) - q), q being the canvas pixel nearest to p - steps(p). Beyond a border that does
        not wrap the coordinates of the border pixel are continued; beyond the exemplar they re-enter on its opposite
        side, shifted along the border by a random shift per canvas square. ``steps`` (H, W, 2): px; ``lot``: seed and
        frame number of these shifts.
        """
        sides, exemplar = yx.shape[:2], self.stack.exemplar
        size = exemplar.height, exemplar.width
        source = np.moveaxis(np.indices(sides), 0, 2) - steps
        own = np.stack([_on(source[..., a], n, self.closed[a]) for a, n in enumerate(sides)], axis=2)
        beyond = np.where(self.closed, 0, source - own)
        ahead = yx[own[..., 0], own[..., 1]] + beyond
        out = self._inside(ahead if exemplar.toroidal else _begun_again(ahead, size, lot))
        near, torn = (beyond == 0).all(axis=2), np.zeros(sides, bool)
        for axis in (0, 1):
            jump = np.roll(out, -1, axis) - out
            jump[..., axis] -= 1
            if exemplar.toroidal:
                jump %= size
            together = (np.roll(steps, -1, axis) == steps).all(axis=2) & near & np.roll(near, -1, axis)
            broken = (jump != 0).any(axis=2) & ~together
            if not self.closed[axis]:
                broken[(slice(None),) * axis + (-1,)] = False
            torn |= broken | np.roll(broken, 1, axis)
        return out, torn

    def _inside(self, coords: Array) -> Array:
        """Return coordinates wrapped into the exemplar, masked pixels replaced by the nearest usable ones: int32."""
        exemplar, home = self.stack.exemplar, self.stack.home
        inside = coords % (exemplar.height, exemplar.width)
        if len(home):
            inside = np.stack(np.divmod(home[inside[..., 0] * exemplar.width + inside[..., 1]], exemplar.width), axis=2)
        return np.asarray(inside, np.int32)

    def mended(self, yx: Array, torn: Mask, top: int, run: Run) -> Array:
        """Return the map with torn pixels (H, W) corrected: from the level of spacing 2**top px to that of 1 px."""
        for level in range(min(top, len(self.stack.levels) - 1), 0, -1):
            yx, torn = self._coarse(yx, torn, level, run)
        modes: Any = ["wrap" if around else "nearest" for around in self.closed]
        near = ndimage.maximum_filter(torn, 2 * AROUND + 1, mode=modes)
        return self._corrected(yx, near, 0, self.closed, run)

    def _coarse(self, yx: Array, torn: Mask, level: int, run: Run) -> tuple[Array, Mask]:
        """Correct the map of every h-th pixel, h = 2**level; write changes as squares of h px, marked as torn."""
        h, (height, width) = 1 << level, yx.shape[:2]
        rows, columns = height // h, width // h
        if not torn.any() or not rows or not columns:
            return yx, torn
        # Along an axis that h does not divide, the canvas is not treated as a torus.
        closed = (self.closed[0] and height % h == 0, self.closed[1] and width % h == 0)
        whole: Mask = np.any(blocks(torn, h), axis=(1, 3))
        every = yx[h // 2 : rows * h : h, h // 2 : columns * h : h]
        found = self._corrected(every, whole, level, closed, run)
        changed = (found != every).any(axis=2)
        away = np.moveaxis(np.indices((h, h)), 0, 2) - h // 2
        squares = (found[:, None, :, None] + away[None, :, None]).reshape(rows * h, columns * h, 2)
        inside = changed.repeat(h, axis=0).repeat(h, axis=1)
        out, torn = yx.copy(), torn.copy()
        out[: rows * h, : columns * h][inside] = self._inside(squares)[inside]
        torn[: rows * h, : columns * h] |= inside
        return out, torn

    def _corrected(self, yx: Array, where: Mask, level: int, closed: Closed, run: Run) -> Array:
        """Run the passes of a level; only pixels in `where` change. A subpass reads the map before it."""
        if not where.any():
            return yx
        place, side = self.stack.levels[level].ready(), round(self.rules.subpasses**0.5)
        yx = np.array(yx, np.int32)
        kinds = [(i, j) for i in range(side) for j in range(side)]
        with run.pool() as each:
            for i, j in kinds * self.rules.passes:
                rows, columns = i + side * np.flatnonzero(where[i::side].any(axis=1)), np.arange(j, yx.shape[1], side)
                if not len(rows) or not len(columns):
                    continue
                padded, at = place.positions(self._padded(yx, place.h, closed)), (rows + REACH, columns + REACH)
                better = place.pixels(subpass(padded, at, place, self.rules, None, run, each))
                index = np.ix_(rows, columns)
                yx[index] = np.where(where[index][..., None], better, yx[index])
        return yx

    def _padded(self, yx: Array, h: int, closed: Closed) -> Array:
        """Return the map padded by two px on all sides: wrapped, or continuing the border pixels in the exemplar."""
        exemplar = self.stack.exemplar
        for axis, around in enumerate(closed):
            at = np.arange(-REACH, yx.shape[axis] + REACH)
            own = _on(at, yx.shape[axis], around)
            yx = np.take(yx, own, axis)
            if not around:
                yx[..., axis] += np.expand_dims(h * (at - own), 1 - axis)
        size = np.array([exemplar.height, exemplar.width])
        return np.asarray(yx % size if exemplar.toroidal else yx.clip(0, size - 1), np.int32)
