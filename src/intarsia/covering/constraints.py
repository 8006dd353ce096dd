"""Limits on a patch over a finished map: to follow the guide no less than before, and to repeat nothing too near."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..guide import Guide
from ..patches.growth import Growth, Pick
from ..sourcemap import HOLE

Array = NDArray[Any]
Box = tuple[int, int, int, int]


class Constraints:
    """Says which pixels of a box must not be taken from a patch.

    Parameters
    ----------
    growth : Growth
        The map, with all that it is made from.
    guide : Guide, optional
        Where a patch differs more from it than the map does, the map stays.
    distance : int
        Where a patch would show an exemplar pixel nearer than so many px to another copy of it, the map stays; 0:
        no such rule.
    """

    def __init__(self, growth: Growth, guide: Guide | None, distance: int) -> None:
        self.work, self.variants, self.wraps = growth.growing, growth.variants, growth.layout.wraps
        self.distance, self.guide = distance, guide
        self.any = guide is not None or distance > 0
        self.tallest = max(e.height for e in growth.exemplars)
        self.widest = max(e.width for e in growth.exemplars)

    def __call__(self, box: Box, pick: Pick) -> Array:
        """Return (rows, columns) bool: True where the patch `pick` that begins at the box's first pixel may not be."""
        yx, which = self._patch(box, pick)
        barred = np.zeros(box[2:], bool)
        if self.guide is not None:
            here = self._around(box, 0)
            old = self.variants.to_exemplars(self.work.yx[here], self.work.variant[here])
            barred |= self._off(yx, which, here) > self._off(old[0], old[1], here)
        if self.distance:
            barred |= self._too_near(box, yx, which)
        return barred

    def returns(self, box: Box, pick: Pick, take: Array) -> bool:
        """Say whether what is taken of a patch would now return too near."""
        if not self.distance:
            return False
        return bool((self._too_near(box, *self._patch(box, pick)) & (take > 0)).any())

    def _patch(self, box: Box, pick: Pick) -> tuple[Array, Array]:
        """Exemplar pixels (rows, columns, 2), and exemplars (rows, columns), that a patch shows in a box."""
        size = self.variants.table[pick[0], 1:3]
        yx = np.moveaxis(np.indices(box[2:], np.int32), 0, 2) + np.array(pick[1:], np.int32)
        yx = (yx % size).astype(np.int32)  # beyond an exemplar that does not continue nothing is taken
        grown, which, _ = self.variants.to_exemplars(yx, np.full(box[2:], pick[0], np.uint8))
        return grown, which

    def _around(self, box: Box, px: int) -> tuple[Array, ...]:
        """Index of a box and `px` around it, within the canvas or round it."""
        axes = []
        for at, n, length, wrap in zip(box[:2], box[2:], self.work.variant.shape, self.wraps, strict=True):
            along = np.arange(at - px, at + n + px)
            axes.append(along % length if wrap else along[(along >= 0) & (along < length)])
        return np.ix_(*axes)

    def _off(self, yx: Array, which: Array, here: tuple[Array, ...]) -> Array:
        """How far pixels are from what the guide asks for here: 0 or 1 with labels, else the sum over channels."""
        assert self.guide is not None
        target = self.guide.target.samples[here]
        out = np.zeros(which.shape, np.float64)
        for number, plane in enumerate(self.guide.sources):
            mine = which == number
            there = plane.samples[yx[mine, 0], yx[mine, 1]]
            if self.guide.is_labels:
                out[mine] = (there != target[mine]).any(axis=1)
            else:
                out[mine] = np.abs(there.astype(np.float64) - target[mine]).sum(axis=1)
        return out

    def _too_near(self, box: Box, yx: Array, which: Array) -> Array:
        """Where a copy of the pixel, at another place than this, is nearer than the distance."""
        reach = self.distance - 1
        first = [at - reach if wrap else max(at - reach, 0) for at, wrap in zip(box[:2], self.wraps, strict=True)]
        index = self._around(box, reach)
        there, others, _ = self.variants.to_exemplars(self.work.yx[index], self.work.variant[index])
        mine, known = self._keys(yx, which).ravel(), self._keys(there, others).ravel()
        order = np.argsort(known, kind="stable")
        begin, end = (np.searchsorted(known[order], mine, side) for side in ("left", "right"))
        counts = end - begin
        p = np.repeat(np.arange(len(mine)), counts)  # every pair of a pixel of the patch and a copy on the canvas
        q = order[np.arange(len(p)) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(begin, counts)]
        gaps = [a + f - b - at for a, b, f, at in zip(
            np.divmod(q, others.shape[1]), np.divmod(p, which.shape[1]), first, box[:2], strict=True)]  # fmt: skip
        far = gaps[0] ** 2 + gaps[1] ** 2
        out = np.zeros(len(mine), bool)
        out[p[(far > 0) & (far < self.distance**2)]] = True
        return out.reshape(which.shape)

    def _keys(self, yx: Array, which: Array) -> Array:
        """One number for every exemplar pixel; another one for holes."""
        keys = (which.astype(np.int64) * self.tallest + yx[..., 0]) * self.widest + yx[..., 1]
        return np.where(which == HOLE, -1, keys)
