"""Drag and drop: a feature of the exemplar is shown where somebody wants it (Lefebvre and Hoppe 2005, section 5)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..exemplar import Exemplar
from .orientation_kernels import UNIT

Array = NDArray[Any]


class Pin(NamedTuple):
    """Exemplar pixel (sx, sy) shown at output pixel (x, y), and what lies within `radius` around it; all in px."""

    sx: int
    sy: int
    x: int
    y: int
    radius: int


def pinned(
    coords: Array, places: list[Array], periods: tuple[int, int], pin: Pin, exemplar: Exemplar, frame: Array | None
) -> None:
    """Lay a feature into the coordinates (H, W, 2) of a level, in place: S[p] = u + J(p) (h p - q) in a disc.

    ``places``: where its rows and columns lie in the output; ``periods``: after how many px they close, or 0.
    """
    away = []
    for at, period, q in zip(places, periods, (pin.y, pin.x), strict=True):
        d = at - q
        away.append((d + period // 2) % period - period // 2 if period else d)
    rows, cols = (np.flatnonzero(abs(d) <= pin.radius) for d in away)
    dy, dx = np.meshgrid(away[0][rows], away[1][cols], indexing="ij")
    inside = dy * dy + dx * dx <= pin.radius**2
    if frame is not None:
        j = frame[np.ix_(rows, cols)].astype(np.int64)
        half = 1 << (UNIT - 1)
        dy, dx = ((j[..., n] * dy + j[..., n + 1] * dx + half) >> UNIT for n in (0, 2))
    y, x = pin.sy + dy, pin.sx + dx
    inside &= (y >= 0) & (x >= 0) & (y < exemplar.height) & (x < exemplar.width)
    if exemplar.usable is not None:
        inside[inside] &= exemplar.usable[y[inside], x[inside]]
    block = coords[np.ix_(rows, cols)]
    block[inside] = np.stack([y[inside], x[inside]], axis=1)
    coords[np.ix_(rows, cols)] = block
