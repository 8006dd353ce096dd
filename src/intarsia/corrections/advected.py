"""A map carried along by a flow, and corrected where the flow tore it (Lefebvre and Hoppe 2006: texture advection).

Pixels that move by the same step stay beside the same neighbours, and are left as they are. Where neighbours move by
different steps they no longer fit: only there, and a few px around, the correction operation looks for better ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis import blocks
from ..foundation import ndimage
from ..foundation.arrays import Array, Mask, Pair
from ..foundation.run import Run, below, draw_many
from .descent import REACH, Corrections, subpass
from .stack import ExemplarStack

STAGE = 200610  # keeps these draws apart from those of others
SQUARE = 16  # px of the canvas, which begin together where the exemplar ends
AROUND = 2  # px about a tear that are corrected, too

Closed = tuple[bool, bool]


def _begun_again(coords: Array, size: Pair, lot: Pair) -> Array:
    """Move what lies outside of the exemplar along its border, by draws that belong to squares of the canvas."""
    outside = (coords < 0) | (coords >= size)
    ys, xs = np.nonzero(outside.any(axis=2))
    if len(ys):
        squares, index = np.unique(np.stack([ys, xs], axis=1) // SQUARE, axis=0, return_inverse=True)
        shift = np.array([[below(n, b) for n in size] for b in draw_many(lot[0], STAGE, lot[1], squares)], np.int64)
        coords[ys, xs] += np.where(outside[ys, xs][:, ::-1], shift[index.ravel()], 0)
    return coords


def _on(at: Array, n: int, around: bool) -> Array:
    """Coordinates on an axis of `n` px: around it, or the nearest."""
    return at % n if around else at.clip(0, n - 1)


@dataclass(frozen=True)
class TornPlaces:
    """How torn places of a map are corrected; the levels of an exemplar, the rules, and how the canvas closes."""

    stack: ExemplarStack
    rules: Corrections
    closed: Closed  # around the canvas: along y, along x

    def carried(self, yx: Array, steps: Array, lot: Pair) -> tuple[Array, Mask]:
        """Move a map by whole pixels (H, W, 2): S'(p) = S(q) + (p - steps(p) - q), q on the canvas beside p - steps(p).

        What flows in over a border that does not wrap continues what was at the border; where that runs out of the
        exemplar it begins again at its other side, each square of the canvas elsewhere along it, drawn by `lot`: seed
        and frame. Returns the map, and which pixels no longer fit a neighbour that fitted before.
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
        """Bring coordinates back into the exemplar, as if it continued in itself, from masked pixels to usable ones."""
        exemplar, home = self.stack.exemplar, self.stack.home
        inside = coords % (exemplar.height, exemplar.width)
        if len(home):
            inside = np.stack(np.divmod(home[inside[..., 0] * exemplar.width + inside[..., 1]], exemplar.width), axis=2)
        return np.asarray(inside, np.int32)

    def mended(self, yx: Array, torn: Mask, top: int, run: Run) -> Array:
        """Correct torn pixels, first every 2**top-th of them with its surroundings, at last all."""
        for level in range(min(top, len(self.stack.levels) - 1), 0, -1):
            yx, torn = self._coarse(yx, torn, level, run)
        modes: Any = ["wrap" if around else "nearest" for around in self.closed]
        near = ndimage.maximum_filter(torn, 2 * AROUND + 1, mode=modes)
        return self._corrected(yx, near, 0, self.closed, run)

    def _coarse(self, yx: Array, torn: Mask, level: int, run: Run) -> tuple[Array, Mask]:
        """Correct a map of every h-th pixel; what changes there is laid out as squares of h px."""
        h, (height, width) = 1 << level, yx.shape[:2]
        rows, columns = height // h, width // h
        if not torn.any() or not rows or not columns:
            return yx, torn
        # A torus that h does not divide has no even steps; there the border is like any other.
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
        """Run the passes of a level; only pixels `where` may change. What a subpass finds is written at its end."""
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
        """The map with two px more on all sides: around the torus, or what continues the border, in the exemplar."""
        exemplar = self.stack.exemplar
        for axis, around in enumerate(closed):
            at = np.arange(-REACH, yx.shape[axis] + REACH)
            own = _on(at, yx.shape[axis], around)
            yx = np.take(yx, own, axis)
            if not around:
                yx[..., axis] += np.expand_dims(h * (at - own), 1 - axis)
        size = np.array([exemplar.height, exemplar.width])
        return np.asarray(yx % size if exemplar.toroidal else yx.clip(0, size - 1), np.int32)
