"""How directed a texture is, whether it continues across its borders, and whether it is one.

For that its windows are sorted into two kinds. In one texture both kinds are mixed everywhere; of two textures, side by
side, each kind keeps to a part of the picture of its own.

Source: no paper. Two-means over windows by mean colour and strength of edges; thresholds set on photographs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .sums import block_sums

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


SEAMLESS = 1.3  # the step over the border may be so many times that between neighbours inside


@dataclass(frozen=True)
class Structure:
    """Edges of a texture.

    Attributes
    ----------
    coherence : float
        0 to 1: how much all edges run in one direction.
    angle : float
        That direction, degrees: 0 to the right, 90 downwards.
    """

    coherence: float
    angle: float


@dataclass(frozen=True)
class Border:
    """The step over the borders, relative to that between neighbours inside; `rows`: over top and bottom."""

    rows: float
    columns: float

    @property
    def closed(self) -> bool:
        """Whether the exemplar can be laid side by side."""
        return max(self.rows, self.columns) <= SEAMLESS


def structure_of(picture: NDArray[np.int16], usable: Mask | None) -> Structure:
    """Measure the gradients of the sum of all channels."""
    total = picture.sum(axis=2, dtype=np.int64)
    if min(total.shape) < 3:
        return Structure(0.0, 0.0)
    down, right = total[2:, 1:-1] - total[:-2, 1:-1], total[1:-1, 2:] - total[1:-1, :-2]
    if usable is not None:
        free = usable[2:, 1:-1] & usable[:-2, 1:-1] & usable[1:-1, 2:] & usable[1:-1, :-2]
        down, right = down[free], right[free]
    yy, xx, xy = (int((a * b).sum()) for a, b in ((down, down), (right, right), (down, right)))
    if yy + xx == 0:
        return Structure(0.0, 0.0)
    coherence = math.hypot(xx - yy, 2 * xy) / (xx + yy)
    across = 0.5 * math.atan2(2 * xy, xx - yy)  # where the gradient points; edges run across it
    return Structure(coherence, round(math.degrees(across) + 90, 1) % 180)


def border_of(picture: NDArray[np.int16], usable: Mask | None) -> Border:
    """Compare the step over each pair of opposite borders with the usual step along that axis."""
    shares = []
    for axis in (0, 1):
        p = np.moveaxis(picture, axis, 0).astype(np.int64)
        free = np.ones(p.shape[:2], bool) if usable is None else np.moveaxis(usable, axis, 0)
        if len(p) < 4:
            shares.append(math.inf)
            continue
        steps = np.abs(p[1:] - p[:-1]).sum(axis=2)
        inside = free[1:] & free[:-1]
        over = np.abs(p[0] - p[-1]).sum(axis=1)[free[0] & free[-1]]
        usual = int(steps[inside].sum()) / max(int(inside.sum()), 1)
        shares.append(float(over.sum()) / len(over) / usual if len(over) and usual else math.inf)
    return Border(*shares)


def flat_colours(samples: NDArray[Any], most: int, equal: int) -> bool:
    """Say whether samples (H, W, C) are of 2 to `most` colours in patches: `equal` neighbours of 10 are alike."""
    codes = np.zeros(samples.shape[:2], np.uint64)
    for c in range(samples.shape[2]):
        codes = codes * np.uint64(65599) + samples[..., c].astype(np.uint64)
    if not 2 <= len(np.unique(codes)) <= most:
        return False
    alike = int((codes[1:] == codes[:-1]).sum()) + int((codes[:, 1:] == codes[:, :-1]).sum())
    return 10 * alike >= equal * max(2 * codes.size - sum(codes.shape), 1)
