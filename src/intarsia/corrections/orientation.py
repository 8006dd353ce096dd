"""How a texture lies in the output, place by place: turned and scaled (Lefebvre and Hoppe 2006, section 5).

All numbers are whole, from a table of sines, so that no machine decides otherwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..field import Field
from .orientation_kernels import UNIT

TURN = 5760  # steps of a full turn, 16 a degree
ZOOM = 256  # steps of 1
SMALLEST, LARGEST = ZOOM // 4, 4 * ZOOM  # what methods allow
SINES = np.array([round((1 << UNIT) * math.sin(2 * math.pi * n / TURN)) for n in range(TURN)], np.int64)

Array = NDArray[Any]


@dataclass(frozen=True)
class Orientation:
    """Degrees by which the texture lies turned, to the left as seen, and how many times larger it is shown."""

    angle: Field
    zoom: Field

    @classmethod
    def of(cls, angle: float | Field, zoom: float | Field) -> Orientation | None:
        """Return what two settings say; None where nothing is turned or scaled."""
        if (angle, zoom) == (0, 1):
            return None
        return cls(*(v if isinstance(v, Field) else Field(v) for v in (angle, zoom)))

    @property
    def reach(self) -> int:
        """How far in the exemplar, in steps of a level, neighbours of a pixel are read that are up to 2 px off."""
        least = SMALLEST / ZOOM if self.zoom.number is None else self.zoom.number
        return math.ceil(2 * math.sqrt(2) / least + 1)

    def at(self, rows: Array, cols: Array) -> Array:
        """Return J, the step of the exemplar for a step of the output: (rows, columns, 4) int32, 1 / 4096.

        In the order of rows and columns of the matrix: y from y, y from x, x from y, x from x.
        """
        if self.angle.number is not None and self.zoom.number is not None and len(rows) * len(cols) > 1:
            return np.broadcast_to(self.at(rows[:1], cols[:1]), (len(rows), len(cols), 4)).copy()
        turned, larger = turns(self.angle, rows, cols), zooms(self.zoom, rows, cols)
        sine, cosine = SINES[turned], SINES[(turned + TURN // 4) % TURN]
        matrix = np.stack([cosine, sine, -sine, cosine], axis=2)
        return np.asarray((matrix * (2 * ZOOM) + larger[..., None]) // (2 * larger[..., None]), np.int32)


def turns(angle: Field, rows: Array, cols: Array) -> Array:
    """Return how far the texture lies turned at places, in 1 / 16 degree: (rows, columns) int64, below a full turn."""
    return np.asarray(np.rint(angle.at(rows, cols, around=True) * (TURN / 360)).astype(np.int64) % TURN)


def zooms(zoom: Field, rows: Array, cols: Array) -> Array:
    """Return how many times larger it is shown at places, in 1 / 256: (rows, columns) int64."""
    return np.clip(np.rint(zoom.at(rows, cols) * ZOOM), SMALLEST, LARGEST).astype(np.int64)


def less_steps(y: Any, x: Any, lattice: list[list[int]]) -> Any:
    """Return what is left of (y, x), Python's whole numbers of any size, after whole steps of a lattice."""
    (ay, ax), (by, bx) = lattice
    det = ay * bx - ax * by
    m, n = (y * bx - x * by) // det, (ay * x - ax * y) // det
    return y - m * ay - n * by, x - m * ax - n * bx


def origins(frame: Array, rows: Array, cols: Array, size: Array, lattice: Array) -> Array:
    """Return J(p) p for places however far away, less whole exemplars or lattice steps: (H, W, 2)."""
    matrix, p, q = frame.astype(object), rows.astype(object)[:, None], cols.astype(object)[None, :]
    y, x = matrix[..., 0] * p + matrix[..., 1] * q, matrix[..., 2] * p + matrix[..., 3] * q  # 1 / 4096 px
    if len(lattice):
        y, x = less_steps(y, x, (lattice << (UNIT - 8)).tolist())
    half = 1 << (UNIT - 1)
    out = [np.asarray((v + half) >> UNIT) for v in (y, x)]
    if not len(lattice):
        out = [v % int(side) for v, side in zip(out, size, strict=False)]
    return np.stack(out, axis=2).astype(np.int64)
