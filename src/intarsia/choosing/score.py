"""How well an output keeps to its exemplar: one number to choose among several outputs of one exemplar.

Both are looked at reduced, so that an element is about ten px wide; 12 x 12 windows are compared by their lowest
cosines. Smaller is better. Values of different exemplars do not compare.

* ``strange``: how far windows of the output are from the nearest window of the exemplar: cut, fused, shifted elements.
* ``lost``: how far windows of the exemplar are from the nearest of the output: lost things, and drift.
  Half of it is the mean over the farthest tenth of the windows alone.
* ``seams``: what the seams cost at full size, steps of tone inside of an element included.
* ``copies``: how much more often than others the most used pixels are shown, and how far one piece is copied whole.
* ``blur``: how much weaker the steps between neighbours are than in the exemplar.

Source: no paper; our own, tried on photographs. Whole numbers decide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..analysis.reduction import block_sums, blocks
from ..analysis.usable import valid_windows
from ..exemplar import Exemplar
from ..seams.cost import seam_total
from ..sourcemap import SourceMap

Array = NDArray[Any]

# Halved and doubled on 12 textures, quilted in the six ways of trials: on how many another one is kept.
WINDOW = 12  # px of the reduced pictures; halved: four, doubled: two
WIDE = 1.25  # elements in a window, reduced to them; halved: six, doubled: nine
COSINES = 6  # along each axis; halved: three, doubled: none
FINE = 64  # cosines are whole multiples of 1 / FINE, so that sums are exact
MOST = 2500  # windows compared of each; halved and doubled: one
FARTHEST = 0.9  # of the windows are nearer than those that count as lost; 0.8 and 0.95: none
SHARP = 0.97  # below this the output is blurred; 0.9: one, 1: three
USED = 1 / 20  # of the pixels: the most used; halved and doubled: none
WHOLE = 4  # how much a copy in one piece counts beside pixels shown often; halved and doubled: one
# Halved or doubled: up to three each; at 0 strange and lost three, copies and blur one, seams none, and tenfold four.
WEIGHTS = {"strange": 1.0, "lost": 1.0, "seams": 1.0, "copies": 0.1, "blur": 20.0}


@dataclass(frozen=True)
class Score:
    """What speaks against an output; smaller is better."""

    strange: float
    lost: float
    seams: float
    copies: float
    blur: float

    @property
    def total(self) -> float:
        """The one number."""
        return float(sum(weight * getattr(self, name) for name, weight in WEIGHTS.items()))

    def as_dict(self) -> dict[str, float]:
        """Return it as JSON."""
        return {name: round(getattr(self, name), 4) for name in WEIGHTS} | {"total": round(self.total, 4)}


def score(exemplars: Sequence[Exemplar], smap: SourceMap, element: int) -> Score:
    """Judge a map without holes of exemplars whose elements are `element` px large."""
    feats = features(exemplars)
    drawn = _drawn(feats.pictures, smap)
    factor = max(1, round(WIDE * element / WINDOW))
    theirs = np.concatenate([_windows(p, factor, e.usable) for p, e in zip(feats.pictures, exemplars, strict=True)])
    mine = _windows(drawn, factor, None)
    if not len(theirs) or not len(mine):
        return Score(0.0, 0.0, 0.0, 0.0, 0.0)
    spread = max(1.0, float(((theirs - theirs.sum(axis=0) // len(theirs)) ** 2).sum()) / len(theirs))
    strange, lost = _nearest(mine, theirs), _nearest(theirs, mine)
    rare = np.sort(lost)[int(FARTHEST * len(lost)) :]
    usual = _steps(feats.pictures, exemplars)
    pixels = smap.height * smap.width
    seams = seam_total(feats, exemplars, smap) / pixels / max(usual, 1e-9) / 2
    return Score(
        float(strange.sum()) / len(strange) / spread,
        (float(lost.sum()) / len(lost) + float(rare.sum()) / max(len(rare), 1)) / 2 / spread,
        seams,
        _copies(exemplars, smap, element),
        max(0.0, SHARP - _steps([drawn], None) / max(usual, 1e-9)),
    )


def _drawn(pictures: Sequence[Array], smap: SourceMap) -> Array:
    """The output in features, upright."""
    if smap.which is None:
        return np.asarray(pictures[0][smap.yx[..., 0], smap.yx[..., 1]])
    out = np.zeros((smap.height, smap.width, pictures[0].shape[2]), np.int16)
    for number, picture in enumerate(pictures):
        at = smap.which == number
        out[at] = picture[smap.yx[at, 0], smap.yx[at, 1]]
    return out


@cache
def _cosines() -> Array:
    """The lowest cosines of a window, as whole numbers: (WINDOW * WINDOW, COSINES**2)."""
    i = np.arange(WINDOW)
    waves = np.array([np.cos(np.pi * k * (2 * i + 1) / (2 * WINDOW)) * (1 if k else 0.5**0.5) for k in range(COSINES)])
    return np.asarray(np.rint(np.einsum("ky,lx->yxkl", waves, waves).reshape(WINDOW * WINDOW, -1) * FINE))


def _windows(picture: Array, factor: int, usable: Array | None) -> Array:
    """Cosines of evenly spread windows of a reduced picture: whole numbers, (n, features)."""
    rows, columns = (n // factor for n in picture.shape[:2])
    if min(rows, columns) < WINDOW:
        return np.zeros((0, 1))
    small = block_sums(picture, factor) // factor**2
    high, wide = rows - WINDOW + 1, columns - WINDOW + 1
    step = max(1, math.isqrt(high * wide // MOST) + (high * wide > MOST))
    y, x = (a.ravel() for a in np.mgrid[0:high:step, 0:wide:step])
    if usable is not None:
        free = np.asarray(blocks(usable, factor).all(axis=(1, 3)))
        whole = valid_windows(free.shape, free, False, (WINDOW, WINDOW))[y, x]
        y, x = y[whole], x[whole]
    held = np.lib.stride_tricks.sliding_window_view(small, (WINDOW, WINDOW), axis=(0, 1))[y, x]
    flat = held.reshape(len(y), small.shape[2], -1).astype(np.float64)
    return np.asarray(np.rint(flat @ _cosines() / FINE).reshape(len(y), -1))


def _nearest(mine: Array, theirs: Array) -> Array:
    """Squared distance of each to the nearest of the others; sums of whole numbers below 2**53, so exact."""
    squares = (theirs * theirs).sum(axis=1)
    out = np.empty(len(mine))
    for begin in range(0, len(mine), 512):
        some = mine[begin : begin + 512]
        out[begin : begin + 512] = (squares - 2 * (some @ theirs.T)).min(axis=1) + (some * some).sum(axis=1)
    return out


def _steps(pictures: Sequence[Array], exemplars: Sequence[Exemplar] | None) -> float:
    """Mean step between neighbours."""
    total, count = 0, 0
    for number, picture in enumerate(pictures):
        usable = None if exemplars is None else exemplars[number].usable
        for axis in (0, 1):
            steps = np.abs(np.diff(picture.astype(np.int32), axis=axis)).sum(axis=2)
            if usable is not None:
                along = np.moveaxis(usable, axis, 0)
                steps = np.moveaxis(steps, axis, 0)[along[1:] & along[:-1]]
            total, count = total + int(steps.sum()), count + steps.size
    return total / max(count, 1)


def _copies(exemplars: Sequence[Exemplar], smap: SourceMap, element: int) -> float:
    """How unevenly the exemplar is used, and how much of the output lies in one copy with what is an element away."""
    counts = np.concatenate([
        c.ravel() if e.usable is None else c[e.usable] for c, e in zip(smap.usage(), exemplars, strict=True)
    ])  # fmt: skip
    counts = np.sort(counts)
    top = int(counts[int((1 - USED) * len(counts)) :].sum()) / max(1, int(USED * len(counts)))
    mean = max(int(counts.sum()) / max(len(counts), 1), 1e-9)
    away = max(element, 1)
    whole = 0.0
    for axis, length in ((0, smap.height), (1, smap.width)):
        if length > away:
            ahead = np.take(smap.yx, range(away, length), axis) - np.take(smap.yx, range(length - away), axis)
            step = np.array((away, 0) if axis == 0 else (0, away))
            whole += float((ahead == step).all(axis=2).sum()) / ahead[..., 0].size / 2
    return top / mean + WHOLE * whole
