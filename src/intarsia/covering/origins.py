"""What lists of copies are made from: which exemplar pixel every pixel of the pieces is, and how it strikes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import Features, pose_array
from ..analysis.popout import popout
from ..exemplar import Exemplar
from ..geometry import ISOMETRIES
from ..search.posed import PosedExemplars
from .copies_kernels import STEP, Copies, Origins

Array = NDArray[Any]

FLOOR = 31  # of 256: what a repeat of the plainest pixel costs; without it all but what strikes is repeated
PLAIN, STEEP = 307, 2  # of 256: what strikes less than this strikes not at all; half of what it strikes more counts,
MOST = 384  # up to so much


def origins_of(
    variants: PosedExemplars, usable: NDArray[np.uint8], feats: Features, exemplars: Sequence[Exemplar]
) -> Origins:
    """Say of every pixel of the variants which exemplar pixel it is; of these, the cell and how much they strike.

    `usable` (pixels of all variants,): which may be shown.
    """
    pixel, place, cell, first, weight, begin, cells = [], [], [], [], [], 0, 0
    for number, e in enumerate(exemplars):
        first.append(begin)
        place.append(np.moveaxis(np.indices((e.height, e.width), np.int32), 0, 2).reshape(-1, 2))
        wide = -(-e.width // STEP)
        cell.append((np.arange(e.height)[:, None] // STEP * wide + np.arange(e.width) // STEP + cells).ravel())
        weight.append(strikes(feats, number, e).ravel())
        begin, cells = begin + e.height * e.width, cells + wide * -(-e.height // STEP)
    for v in range(len(variants)):
        number, (rows, stride) = int(variants.exemplar[v]), variants.picture(v).shape[:2]
        e = exemplars[number]
        numbers = first[number] + np.arange(e.height * e.width).reshape(e.height, e.width)
        posed = pose_array(numbers, int(variants.pose[v]))
        pixel.append(np.pad(posed, ((0, rows - posed.shape[0]), (0, stride - posed.shape[1])), "wrap").ravel())
    pixels, frames = np.concatenate(pixel).astype(np.int32), variants.table.copy()
    frames[:, 0] //= variants.channels
    return Origins(
        pixels, np.where(usable, pixels, np.int32(-1)), frames, variants.toroidal,
        np.array([np.array(ISOMETRIES[p].j).ravel() for p in variants.pose.tolist()], np.int64), variants.pose,
        np.concatenate(place), np.concatenate(cell).astype(np.int32), np.concatenate(weight),
    )  # fmt: skip


def strikes(feats: Features, number: int, exemplar: Exemplar) -> Array:
    """How much a repeat of each pixel of an exemplar is seen, (H, W) int32, 256 = usual; measured once."""

    def measured() -> Array:
        found = popout(feats.pictures[number][:, :, : feats.base], exemplar.usable, exemplar.toroidal)
        return (FLOOR + np.clip((found - PLAIN) // STEEP, 0, MOST)).astype(np.int32)

    return feats.memo(("strikes", number), measured)


def around(px: int, width: int) -> Array:
    """Eight places around a pixel in each pose, as they lie around a copy of it in each: (8, 8, 8, 3).

    As rows, columns, and pixels of a canvas so wide.
    """
    slant = px * 181 // 256
    straight = (px, 0), (-px, 0), (0, px), (0, -px)
    places = np.array([*straight, (slant, slant), (slant, -slant), (-slant, slant), (-slant, -slant)])
    steps = [np.array(isometry.j) for isometry in ISOMETRIES]  # orthogonal: their transposes lead back
    away = np.array([[places @ a.T @ b for b in steps] for a in steps], np.int64)
    return np.concatenate([away, away[..., :1] * width + away[..., 1:]], axis=3)


def no_copies(shape: tuple[int, ...], tile: int, cells: int) -> Copies:
    """Empty lists of copies, in tiles of at least so many px that cover a canvas evenly."""
    counts = [max(n // tile, 1) for n in shape]
    tiles = [-(-n // c) for n, c in zip(shape, counts, strict=True)]
    samples = math.prod(-(-n // STEP) for n in shape)
    return Copies(
        np.full(shape, -1, np.int32), np.full((cells, math.prod(counts)), -1, np.int32),
        np.full(samples, -1, np.int32), np.full(samples, -1, np.int32), np.zeros((samples, 5), np.int32),
        np.zeros(cells, np.int32), np.array([*counts, *tiles], np.int64),
    )  # fmt: skip
