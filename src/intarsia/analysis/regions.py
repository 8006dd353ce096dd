"""Whether an exemplar shows one texture or two, side by side.

Its windows are sorted into two kinds. In one texture both kinds are mixed everywhere; of two textures, each kind keeps
to a part of the picture of its own.

Source: no paper. Two-means over windows by mean colour and strength of edges; thresholds set on photographs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .reduction import block_sums

Mask = NDArray[np.bool_]
Array = NDArray[np.int64]

PARTS = 12  # windows along the shorter side, at most
ROUNDS = 16
APART = 0.62  # share of the differences between windows that two kinds must explain,
TOGETHER = 0.9  # of the neighbouring windows that must be of one kind,
LEAST = 0.2  # of the windows that the smaller kind must hold



@dataclass(frozen=True)
class Regions:
    """Two kinds of windows.

    Attributes
    ----------
    apart : float
        0 to 1: how much of the differences between windows is that between the two kinds.
    together : float
        0 to 1: how many neighbouring windows are of the same kind; about 0.5 where they are mixed.
    smaller : float
        Share of the rarer kind.
    """

    apart: float
    together: float
    smaller: float

    @property
    def two(self) -> bool:
        """Whether these are two textures, side by side."""
        return self.apart >= APART and self.together >= TOGETHER and self.smaller >= LEAST


def regions_of(picture: NDArray[np.int16], usable: Mask | None) -> Regions:
    """Sort windows, 12 along the shorter side, into two kinds."""
    side = max(min(picture.shape[:2]) // PARTS, 4)
    rows, columns = (n // side for n in picture.shape[:2])
    if min(rows, columns) < 4:
        return Regions(0.0, 0.5, 0.0)
    described = _described(picture, usable, side, rows, columns)
    kind, apart = _two_kinds(described.reshape(rows * columns, -1))
    kind = kind.reshape(rows, columns)
    equal = int((kind[1:] == kind[:-1]).sum()) + int((kind[:, 1:] == kind[:, :-1]).sum())
    return Regions(apart, equal / (2 * rows * columns - rows - columns), min(kind.mean(), 1 - kind.mean()))


def _described(picture: NDArray[np.int16], usable: Mask | None, side: int, rows: int, columns: int) -> Array:
    """Mean of each channel and of the steps between neighbours, window by window, each of variance about 1000^2."""
    p = picture.astype(np.int64)
    edges = np.zeros(p.shape[:2], np.int64)
    edges[1:] += np.abs(p[1:] - p[:-1]).sum(axis=2)
    edges[:, 1:] += np.abs(p[:, 1:] - p[:, :-1]).sum(axis=2)
    layers = np.dstack([p, edges])
    free = np.ones(p.shape[:2], np.int64) if usable is None else usable.astype(np.int64)
    count = np.maximum(block_sums(free, side), 1)[..., None]
    mean = 16 * block_sums(layers * free[..., None], side) // count
    mean -= mean.reshape(-1, mean.shape[2]).sum(axis=0) // (rows * columns)
    square = (mean.reshape(rows * columns, -1) ** 2).sum(axis=0)
    spread = np.sqrt(np.maximum(square / (rows * columns), 1.0))
    weight = np.r_[np.full(p.shape[2], 1 / p.shape[2] ** 0.5), 1.0]
    return np.asarray(np.rint(1000 * mean / spread * weight), np.int64)


def _two_kinds(described: Array) -> tuple[Array, float]:
    """Two-means from the two ends of the longest axis, in whole numbers; 0 or 1 of each, and the share explained."""
    middle = described - described.sum(axis=0) // len(described)
    total = int((middle**2).sum())
    if not total:
        return np.zeros(len(described), np.int64), 0.0
    first = middle[int((middle**2).sum(axis=1).argmax())]
    kind = (middle @ first > 0).astype(np.int64)
    for _ in range(ROUNDS):
        if kind.all() or not kind.any():
            break
        means = [middle[kind == k].sum(axis=0) // int((kind == k).sum()) for k in (0, 1)]
        new = (((middle - means[1]) ** 2).sum(axis=1) < ((middle - means[0]) ** 2).sum(axis=1)).astype(np.int64)
        if (new == kind).all():
            break
        kind = new
    if kind.all() or not kind.any():
        return kind, 0.0
    within = sum(int(((m - m.sum(axis=0) // len(m)) ** 2).sum()) for m in (middle[kind == 0], middle[kind == 1]))
    return kind, 1 - within / total
