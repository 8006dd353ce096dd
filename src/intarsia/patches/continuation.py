"""The start map of a canvas, for methods that lay out an endless texture by a lattice, by courses or by tiles.

Such a method continues a picture, too: its texture is laid so that the lattice of the picture goes on, and is then cut
against the picture along the cheapest seam (Kwatra et al. 2003, eq. 1), at most as deep as the rim.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Laid
from ..canvas import Canvas
from ..geometry import Wrap
from ..kernels.cuts import PLAIN, min_cut, seam_costs
from ..kernels.maxflow import FREE, NEW, OLD
from ..lazy import ndimage
from ..sourcemap import HOLE, Source, SourceMap

Mask = NDArray[np.bool_]
Vector = tuple[int, int]


def depth_of(known: Mask, wrap: Wrap, most: int) -> NDArray[Any]:
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
    depth: NDArray[Any]  # (H, W): how deep its pixels lie, 0 in holes
    rim: int  # how deep they may be replaced, px
    # The exemplar pixel that canvas pixel (0, 0) shows, or would show if the piece of most pixels reached so far.
    anchor: Vector
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
        anchor: Vector = tuple(found[int(np.argmax(counts))].tolist())  # of equals the first
        band = upright & (offset == anchor).all(axis=2) & (depth <= rim)
        return cls(start, depth, deepest, anchor, band)

    @property
    def full(self) -> bool:
        """True where nothing is to be added."""
        return not bool(self.start.holes.any())

    def zone(self, at: Vector, window: Mask, side: int) -> NDArray[np.int64]:
        """List the band's pixels in a window at `at` of the endless texture: (n, 3) row, column, `side`."""
        ok, index = [], []
        for axis, around in enumerate((self.start.wrap.y, self.start.wrap.x)):
            n, length = np.arange(window.shape[axis]) + at[axis] - self.anchor[axis], self.band.shape[axis]
            ok.append(np.full(len(n), True) if around else (n >= 0) & (n < length))
            index.append(n % length)
        y, x = np.nonzero(self.band[np.ix_(*index)] & np.outer(*ok) & window)
        return np.stack([y, x, np.full(len(y), side)], axis=1).astype(np.int64)

    def joined(
        self, yx: NDArray[np.int32], pose: NDArray[np.uint8] | None, picture: NDArray[np.int16]
    ) -> tuple[NDArray[np.int32], NDArray[np.uint8] | None]:
        """Lay the start map over a new map, cut along the cheapest seam; `picture`: the exemplar's features."""
        taken = self._taken(yx, picture)
        if pose is not None or self.start.pose is not None:
            new, old = (np.zeros(taken.shape, np.uint8) if p is None else p for p in (pose, self.start.pose))
            pose = np.where(taken, new, old)
        return np.where(taken[:, :, None], yx, self.start.yx), pose

    def _taken(self, yx: NDArray[np.int32], picture: NDArray[np.int16]) -> Mask:
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

