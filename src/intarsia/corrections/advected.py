"""A map carried along by a flow, and corrected where the flow tore it (Lefebvre and Hoppe 2006: texture advection).

Pixels that move by the same step stay beside the same neighbours, and are left as they are. Where neighbours move by
different steps they no longer fit: only there, and a few px around, the correction operation looks for better ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..analysis import blocks
from ..foundation import ndimage
from ..foundation.arrays import Array, Mask, Pair
from ..foundation.run import Run, below, draw_many
from ..model import Exemplar
from .descent import REACH, Corrections, subpass
from .stack import ExemplarStack

STAGE = 200610  # keeps these draws apart from those of others
SQUARE = 16  # px of the canvas, which begin together where the exemplar ends
AROUND = 2  # px about a tear that are corrected, too

Bools = Mask
Closed = tuple[bool, bool]


def carried(
    yx: Array, steps: Array, closed: Closed, exemplar: Exemplar, home: Array, lot: Pair
) -> tuple[Array, Bools]:
    """Move a map by whole pixels (H, W, 2): S'(p) = S(q) + (p - steps(p) - q), q on the canvas next to p - steps(p).

    What flows in over a border that does not wrap continues what was at the border; where that runs out of the exemplar
    it begins again at its other side, each square of the canvas elsewhere along it, drawn by `lot`: seed and frame.
    Returns the map, and which pixels no longer fit a neighbour that fitted before.
    """
    height, width, size = *yx.shape[:2], (exemplar.height, exemplar.width)
    source = np.moveaxis(np.indices((height, width)), 0, 2) - steps
    sides = (height, width)
    own = np.stack(
        [source[..., a] % n if closed[a] else source[..., a].clip(0, n - 1) for a, n in enumerate(sides)], axis=2
    )
    beyond = np.stack([0 * own[..., a] if closed[a] else source[..., a] - own[..., a] for a in (0, 1)], axis=2)
    ahead = yx[own[..., 0], own[..., 1]] + beyond
    out = at_home(ahead if exemplar.toroidal else _begun_again(ahead, size, lot), exemplar, home)
    torn = np.zeros((height, width), bool)
    for axis in (0, 1):
        turn = np.roll(np.arange(sides[axis]), -1)
        jump = np.take(out, turn, axis) - out
        jump[..., axis] -= 1
        if exemplar.toroidal:
            jump %= size
        together = (np.take(steps, turn, axis) == steps).all(axis=2)
        together &= (beyond == 0).all(axis=2) & (np.take(beyond, turn, axis) == 0).all(axis=2)
        broken = (jump != 0).any(axis=2) & ~together
        if not closed[axis]:
            broken[(slice(None),) * axis + (-1,)] = False
        torn |= broken | np.roll(broken, 1, axis)
    return out, torn


def _begun_again(coords: Array, size: Pair, lot: Pair) -> Array:
    """Move what lies outside of the exemplar along its border, by draws that belong to squares of the canvas."""
    outside = [(coords[..., axis] < 0) | (coords[..., axis] >= n) for axis, n in enumerate(size)]
    ys, xs = np.nonzero(outside[0] | outside[1])
    if not len(ys):
        return coords
    squares, index = np.unique(np.stack([ys, xs], axis=1) // SQUARE, axis=0, return_inverse=True)
    bits = draw_many(lot[0], STAGE, lot[1], [(int(y), int(x)) for y, x in squares])
    for axis, n in enumerate(size):
        shift = np.array([below(n, b) for b in bits], np.int64)[index.ravel()]
        coords[ys, xs, axis] += np.where(outside[1 - axis][ys, xs], shift, 0)
    return coords


def at_home(coords: Array, exemplar: Exemplar, home: Array) -> Array:
    """Bring coordinates back into the exemplar, as if it continued in itself, and from masked pixels to usable ones."""
    inside = coords % (exemplar.height, exemplar.width)
    if len(home):
        flat = home[inside[..., 0] * exemplar.width + inside[..., 1]]
        inside = np.stack([flat // exemplar.width, flat % exemplar.width], axis=2)
    return np.asarray(inside, np.int32)


@dataclass(frozen=True)
class TornPlaces:
    """How torn places of a map are corrected; the levels of an exemplar, the rules, and how the canvas closes."""

    stack: ExemplarStack
    rules: Corrections
    closed: Closed  # around the canvas: along y, along x

    def mended(self, yx: Array, torn: Bools, top: int, run: Run) -> Array:
        """Correct torn pixels, first every 2**top-th of them with its surroundings, at last all."""
        for level in range(min(top, len(self.stack.levels) - 1), 0, -1):
            yx, torn = self._coarse(yx, torn, level, run)
        return self._corrected(yx, _wider(torn, AROUND, self.closed), 0, self.closed, run)

    def _coarse(self, yx: Array, torn: Bools, level: int, run: Run) -> tuple[Array, Bools]:
        """Correct a map of every h-th pixel; what changes there is laid out as squares of h px."""
        h, (height, width) = 1 << level, yx.shape[:2]
        rows, columns = height // h, width // h
        if not torn.any() or not rows or not columns:
            return yx, torn
        # A torus that h does not divide has no even steps; there the border is like any other.
        closed = (self.closed[0] and height % h == 0, self.closed[1] and width % h == 0)
        whole = np.asarray(blocks(torn, h).any(axis=(1, 3)))
        every = np.ascontiguousarray(yx[h // 2 : rows * h : h, h // 2 : columns * h : h])
        found = self._corrected(every, whole, level, closed, run)
        changed = (found != every).any(axis=2)
        away = np.moveaxis(np.indices((h, h)), 0, 2) - h // 2
        squares = (found[:, None, :, None] + away[None, :, None]).reshape(rows * h, columns * h, 2)
        inside = changed.repeat(h, axis=0).repeat(h, axis=1)
        out, torn = yx.copy(), torn.copy()
        squares = at_home(squares, self.stack.exemplar, self.stack.home)
        out[: rows * h, : columns * h][inside] = squares[inside]
        torn[: rows * h, : columns * h] |= inside
        return out, torn

    def _corrected(self, yx: Array, where: Bools, level: int, closed: Closed, run: Run) -> Array:
        """Run the passes of a level; only pixels `where` may change. What a subpass finds is written at its end."""
        if not where.any():
            return yx
        place, side = self.stack.levels[level], round(self.rules.subpasses**0.5)
        arrays = place.ready()
        yx = np.array(yx, np.int32)
        kinds = [(i, j) for i in range(side) for j in range(side)]
        with run.pool() as each:
            for i, j in kinds * self.rules.passes:
                rows, columns = i + side * np.flatnonzero(where[i::side].any(axis=1)), np.arange(j, yx.shape[1], side)
                if not len(rows) or not len(columns):
                    continue
                padded, at = place.positions(self._padded(yx, place.h, closed)), (rows + REACH, columns + REACH)
                better = place.pixels(subpass(padded, at, arrays, self.rules, None, place.stride, run, each))
                index = np.ix_(rows, columns)
                yx[index] = np.where(where[index][..., None], better, yx[index])
        return yx

    def _padded(self, yx: Array, h: int, closed: Closed) -> Array:
        """The map with two px more on all sides: around the torus, or what continues the border, in the exemplar."""
        exemplar = self.stack.exemplar
        for axis, around in enumerate(closed):
            n = yx.shape[axis]
            at = np.arange(-REACH, n + REACH)
            own = at % n if around else at.clip(0, n - 1)
            yx = np.take(yx, own, axis)
            if not around:
                moved = np.zeros(2, np.int64)
                moved[axis] = h
                beyond = np.expand_dims(at - own, 1 - axis)
                yx = yx + beyond[..., None] * moved
        size = np.array([exemplar.height, exemplar.width])
        return np.asarray(yx % size if exemplar.toroidal else yx.clip(0, size - 1), np.int32)


def _wider(mask: Bools, px: int, closed: Closed) -> Bools:
    """The pixels of a mask, and those so near to them, along rows, columns and diagonals."""
    modes: list[Literal["wrap", "nearest"]] = ["wrap" if around else "nearest" for around in closed]
    return np.asarray(ndimage.maximum_filter(mask, 2 * px + 1, mode=modes))
