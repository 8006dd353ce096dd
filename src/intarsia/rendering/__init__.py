"""Drawing a map: colours, mixing at seams, finishing, normals and magnification.

The ground that a map is drawn from: exemplars end to end, how far a pixel is from what is unusable, and the map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Mask, UInt8
from ..errors import InputError
from ..exemplar import Exemplar, Exemplars
from ..geometry import Box
from ..image import Plane
from ..kernels.pieces_of_maps import HOLE
from ..lazy import ndimage
from ..sourcemap import SourceMap
from .vote_kernels import Map, Reach, cut_window

OUTSIDE = "the map points outside its exemplars; it belongs to others, or is damaged."


@dataclass(frozen=True)
class Ground:
    """A map, and one plane of its exemplars end to end, all in px of the plane."""

    samples: Array  # (N, C) codes of all exemplars
    reach: Reach
    smap: SourceMap
    full: Map
    scale: int  # how many times larger than the map

    @classmethod
    def of(cls, exemplars: Exemplars, planes: list[Plane], scale: int, smap: SourceMap, feather: int) -> Ground:
        """Lay the planes end to end, those that are smaller than the map (-`scale` times) enlarged.

        Without a `feather`, in px of the plane, nobody votes, and no distance is measured.
        """
        grow = max(scale, 1)
        layers = [enlarged(p.samples, max(-scale, 1)) for p in planes]
        flat = [layer.reshape(-1, layer.shape[2]) for layer in layers]
        samples = flat[0] if len(flat) == 1 else np.concatenate(flat)
        starts = np.cumsum([0] + [len(f) for f in flat[:-1]])
        table = [(n, *la.shape[:2], e.toroidal) for n, la, e in zip(starts, layers, exemplars, strict=True)]
        masked = [e for e in exemplars if any(other.usable is not None for other in exemplars)]
        free = [np.zeros(0, bool), *(enlarged(e.free, grow).reshape(-1) for e in masked)]
        near = [_distances_to_unusable(e, grow, (feather + 1) // 2 + 1).reshape(-1) for e in exemplars if feather]
        reach = Reach(
            np.array(table, np.int64), np.concatenate(free), np.concatenate([np.zeros(0, np.uint16), *near])
        )
        full = smap.yx, smap.numbers, smap.turns
        for array in (samples, *full):
            array.flags.writeable = False
        return cls(samples, reach, smap, full, grow)

    @property
    def usable(self) -> Mask | None:
        """Which pixels (N,) may be used; None where all or none may."""
        free = self.reach.free
        return free if free.any() and not free.all() else None

    def cut(self, box: Box) -> tuple[Array, ...]:
        """Cut a box out of the map: the parts of `full`, and of maps that are not exact the last two of `Part`.

        InputError where it points outside its exemplars.
        """
        size, smap = (box.height, box.width), self.smap
        part = np.empty((*size, 2), np.int32), np.empty(size, np.uint8), np.empty(size, np.uint8)
        places = None if smap.exact else (np.empty((*size, 2)), np.empty((*size, 4)))
        wrap = smap.wrap.y, smap.wrap.x
        warp = smap.frame, smap.sub
        if not cut_window(self.full, *warp, (box.y0, box.x0), self.scale, wrap, self.reach.table, part, places):
            raise InputError(OUTSIDE)
        return (*part, *(places or ()))

    def refuse_holes(self, here: UInt8) -> None:
        """InputError where the exemplars `here`, which are to be drawn, have holes."""
        if (here == HOLE).any():
            holes = int(self.smap.holes.sum())
            raise InputError(
                f"the map has {holes} holes, where nothing was chosen; fill them, or draw a window without."
            )


def enlarged(samples: Array, times: int) -> Array:
    """Return pixels (H, W, ...) as squares of `times` x `times`; one time is the array itself."""
    return samples if times == 1 else np.repeat(np.repeat(samples, times, 0), times, 1)


def _distances_to_unusable(exemplar: Exemplar, grow: int, cap: int) -> NDArray[np.uint16]:
    """Measure how far every pixel is from what must not be read: 0 there, `cap` at most."""
    height, width = exemplar.height * grow, exemplar.width * grow
    if exemplar.usable is None:
        if exemplar.toroidal:
            return np.full((height, width), cap, np.uint16)
        rows, columns = (np.minimum(np.arange(1, n + 1), np.arange(n, 0, -1)) for n in (height, width))
        return np.minimum(np.minimum.outer(rows, columns), cap).astype(np.uint16)
    usable = enlarged(exemplar.usable, grow)
    # Around a torus the nearest one is never further than one round.
    edge = min(cap, max(height, width)) if exemplar.toroidal else 1
    padded = np.pad(usable, edge, mode="wrap") if exemplar.toroidal else np.pad(usable, edge)
    distance = ndimage.distance_transform_cdt(padded, metric="chessboard")[edge:-edge, edge:-edge]
    return np.minimum(distance, cap).astype(np.uint16)
