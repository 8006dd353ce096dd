"""How mortar looks, and how little each pixel of an exemplar looks like it."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..lazy import ndimage

FACE = 255  # what a pixel of a face counts; one of mortar counts 0
class Mortar(NamedTuple):
    """How mortar is told from faces. What halving and doubling does is of 16 walls (docs/design/012)."""

    noise: float = 16.0  # variance of a channel at least; at 1 2 joints of 25 are lost, at 256 one course of 5
    near: int = 1  # tenths of the way from mortar to faces that are still mortar; at 0 one wall loses a joint of 43,
    far: int = 8  # and all face; at 7 one loses two of 25
    middle: tuple[int, int] = (3, 7)  # tenths of a course are faces; (4, 6): 54 joints of 113, (1, 9): all walls differ
    dull: int = FACE // 3  # the least of a face: it is raised to a full one; halved and doubled: nothing is seen
    sharp: int = 4096  # the largest weight of a channel: whole numbers, so that no last bit decides
    least: int = 4  # px of each are the fewest to compare; halved and doubled: nothing


MORTAR = Mortar()


def model(smooth: Array, usable: NDArray[np.bool_], beds: Array, pitch: float) -> tuple[NDArray[np.int16], float]:
    """How little each pixel looks like mortar, by the mixture of channels that parts it from faces best; and how well.

    Fisher's linear discriminant between the pixels on the beds (n, W) and those in the middle between them. The
    weights are rounded to whole numbers, so that no last bit of the linear algebra decides.
    """
    first, last = MORTAR.middle
    parts = np.linspace(first / 10, last / 10, max(2, int(pitch * (last - first) / 10)))
    between = (np.rint(a + part * (b - a)).astype(np.int64) for a, b in pairwise(beds) for part in parts)
    mortar, face = _on([*(beds - 1), *beds], usable.shape, 1) & usable, _on(between, usable.shape, 0) & usable
    plain = np.full(usable.shape, FACE, np.int16)
    if min(mortar.sum(), face.sum()) < MORTAR.least:
        return plain, 0.0
    one, two = smooth[mortar].astype(np.float64), smooth[face].astype(np.float64)
    a, b = np.median(one, axis=0), np.median(two, axis=0)
    spread = np.atleast_2d(np.cov(one, rowvar=False) + np.cov(two, rowvar=False)) / 2
    weights = np.linalg.solve(spread + MORTAR.noise * np.eye(smooth.shape[2]), b - a)
    score = float((weights * (b - a)).sum())
    if score < 1e-9:
        return plain, 0.0
    whole = np.rint(weights * (MORTAR.sharp / np.abs(weights).max())).astype(np.int64)
    low, high = int((a * whole).sum()), int((b * whole).sum())
    value = (smooth.astype(np.int64) * whole).sum(axis=2) - low
    faces = (value * 10 - MORTAR.near * (high - low)) * FACE // ((MORTAR.far - MORTAR.near) * max(high - low, 1))
    return np.asarray(np.clip(faces, 0, FACE), np.int16), score


def _on(rows: Iterable[Array], shape: tuple[int, int], rim: int) -> NDArray[np.bool_]:
    """The pixels of some rows (W,), those of the rim above and below left out."""
    on = np.zeros(shape, bool)
    x = np.arange(shape[1])
    for y in rows:
        ok = (y >= rim) & (y < shape[0] - rim)
        on[y[ok], x[ok]] = True
    return on


def levelled(faces: Array, pitch: int) -> NDArray[np.int16]:
    """Faces made equally bright everywhere, so that mortar between dull ones is seen, too."""
    side = max(3, 2 * pitch)
    part = faces > MORTAR.dull
    count = ndimage.uniform_filter(part.astype(np.float64), side)
    mean = ndimage.uniform_filter(np.where(part, faces, 0).astype(np.float64), side) / np.maximum(count, 1e-6)
    factor = FACE / np.clip(mean, MORTAR.dull, FACE)
    return np.asarray(np.clip(np.rint(faces * factor), 0, FACE), np.int16)


def mortar_at(row: Array, x: int) -> tuple[int, int]:
    """The pixels around x that look like mortar: first, end; none where x itself does not."""
    a = b = min(max(x, 0), len(row) - 1)
    while a > 0 and row[a - 1] < FACE // 2:
        a -= 1
    while b < len(row) and row[b] < FACE // 2:
        b += 1
    return a, b
