"""How far pixels are moved at random, where pictures or functions say so (Lefebvre and Hoppe 2005, section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..field import Field
from .correction_kernels import FINE, Axis

Array = NDArray[Any]


@dataclass(frozen=True)
class Shares:
    """What part of the jitter holds over the output, and where the coordinates to be moved lie in the exemplar."""

    output: Field | None = None
    exemplar: Field | None = None

    @classmethod
    def of(cls, output: Field | float | None, exemplar: Field | float | None) -> Shares:
        """Take numbers for fields that are the same everywhere."""
        given = (v if v is None or isinstance(v, Field) else Field(v) for v in (output, exemplar))
        return cls(*given)


EVERYWHERE = Shares()  # all of the jitter


def part_at(field: Field | None, rows: Array, cols: Array) -> Array:
    """What part of the jitter holds at places, in 1 / 4096: (rows, columns) int64, or (1, 1) where all of it does."""
    return np.full((1, 1), 1 << FINE, np.int64) if field is None else jitter_shares(field, rows, cols)


def spread_over(whole: int, output: Array, exemplar: Array, parents: Array, axes: list[Axis]) -> Array:
    """Return the jitter of each pixel of a level, in 1 / 4096 px: (H, W) int64.

    `whole` is that of the level, `output` its part for each pixel; `exemplar` (H', W') that for each exemplar pixel,
    read where the pixel is handed down to: S[parent] + step, within the exemplar.
    """
    rows, cols = axes
    if exemplar.size > 1:
        above = parents[rows.parent][:, cols.parent]
        y, x = above[..., 0] + rows.step[:, None], above[..., 1] + cols.step
        exemplar = exemplar[y % exemplar.shape[0], x % exemplar.shape[1]]
    part = np.broadcast_to(output * exemplar, (len(rows.at), len(cols.at)))
    return np.ascontiguousarray((whole * part + (1 << (2 * FINE - 1))) >> (2 * FINE))


def jitter_shares(field: Field, rows: Array, cols: Array) -> Array:
    """Return what part of the jitter holds at places, in 1 / 4096: (rows, columns) int64."""
    return np.asarray(np.rint(field.at(rows, cols) * (1 << FINE)), np.int64)
