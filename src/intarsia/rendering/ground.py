"""The ground that a map is drawn from: exemplars end to end, and how far a pixel is from what is unusable."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Int64, Mask, UInt8
from ..errors import InputError
from ..exemplar import Exemplar, Exemplars
from ..geometry import Box
from ..kernels.pieces_of_maps import HOLE
from ..lazy import ndimage
from .vote_kernels import Map, VotedExemplars, cut_window

OUTSIDE = "the map points outside its exemplars; it belongs to others, or is damaged."


def enlarged(samples: Array, times: int) -> Array:
    """Return pixels (H, W, ...) as squares of `times` x `times`; one time is the array itself."""
    return samples if times == 1 else np.repeat(np.repeat(samples, times, 0), times, 1)


def ground_of(
    exemplars: Exemplars, layers: list[Array], grow: int, feather: int
) -> tuple[Array, VotedExemplars]:
    """Lay one plane of every exemplar end to end.

    `layers` are its pixels (H, W, C), `grow` times as large as the base. Returns the pixels (N, C) and what
    votes must know of them; without a feather nobody votes, and no distance is measured.
    """
    flat = [layer.reshape(-1, layer.shape[2]) for layer in layers]
    samples = flat[0] if len(flat) == 1 else np.concatenate(flat)
    samples.flags.writeable = False
    starts = np.cumsum([0] + [len(f) for f in flat[:-1]])
    table = [(n, *la.shape[:2], e.toroidal) for n, la, e in zip(starts, layers, exemplars, strict=True)]
    near = [_distances_to_unusable(e, grow, (feather + 1) // 2 + 1).reshape(-1) for e in exemplars if feather]
    return samples, VotedExemplars(np.array(table, np.int64), np.concatenate(near) if near else np.zeros(0, np.uint16))


def usable_pixels(exemplars: Exemplars, grow: int) -> Mask | None:
    """Return which pixels (N,) of the ground may be used; None where all or none may."""
    flat = masks_of(exemplars, grow)
    return flat if flat.any() and not flat.all() else None


def masks_of(exemplars: Exemplars, grow: int) -> Mask:
    """Return the masks of the exemplars, `grow` times enlarged, as that of the pixels (N,) of the ground."""
    return np.concatenate([enlarged(e.free, grow).reshape(-1) for e in exemplars])


def cut_out_map(full: Map, box: Box, scale: int, wrap: tuple[bool, bool], table: Int64) -> Map:
    """Cut a box, in px of the plane, out of a map; InputError where it points outside its exemplars."""
    size = (box.height, box.width)
    part = (np.empty((*size, 2), np.int32), np.empty(size, np.uint8), np.empty(size, np.uint8))
    if not cut_window(full, (box.y0, box.x0), scale, wrap, table, part):
        raise InputError(OUTSIDE)
    return part


def refuse_holes(here: UInt8, which: UInt8) -> None:
    """InputError where the exemplars `here`, which are to be drawn, have holes; `which`: those of the whole map."""
    if (here == HOLE).any():
        holes = int((which == HOLE).sum())
        raise InputError(f"the map has {holes} holes, where nothing was chosen; fill them, or draw a window without.")


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
