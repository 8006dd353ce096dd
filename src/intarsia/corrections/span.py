"""Pixels of pyramid levels along an axis, their places in the output, and the Jacobian of a rotated or scaled texture.

Rotation and scale vary from place to place (Lefebvre and Hoppe 2006, section 5). All numbers are integer, from a table
of sines, so that every machine computes the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Array
from ..foundation.field import Field
from .correction_kernels import UNIT

TURN = 5760  # units of a full turn, 16 per degree
ZOOM = 256  # units of scale 1
SMALLEST, LARGEST = ZOOM // 4, 4 * ZOOM  # scales that methods allow: 1/4 to 4
SINES = np.array([round((1 << UNIT) * math.sin(2 * math.pi * n / TURN)) for n in range(TURN)], np.int64)



@dataclass(frozen=True)
class Orientation:
    """Rotation of the texture in degrees, counter-clockwise as seen, and its scale."""

    angle: Field
    zoom: Field

    @classmethod
    def of(cls, angle: float | Field, zoom: float | Field) -> Orientation | None:
        """Return the orientation of two settings; None if nothing is rotated or scaled."""
        if (angle, zoom) == (0, 1):
            return None
        return cls(*(v if isinstance(v, Field) else Field(v) for v in (angle, zoom)))

    @property
    def reach(self) -> int:
        """How far in the exemplar, in units of a level's spacing, neighbours of a pixel within 2 px are read."""
        least = SMALLEST / ZOOM if self.zoom.number is None else self.zoom.number
        return math.ceil(2 * math.sqrt(2) / least + 1)

    def at(self, rows: Array, cols: Array) -> Array:
        """Return J, the exemplar offset for an output offset: (rows, columns, 4) int32, 1 / 4096.

        The matrix by rows: y from y, y from x, x from y, x from x.
        """
        if self.angle.number is not None and self.zoom.number is not None and len(rows) * len(cols) > 1:
            return np.broadcast_to(self.at(rows[:1], cols[:1]), (len(rows), len(cols), 4)).copy()
        turned, larger = turns(self.angle, rows, cols), zooms(self.zoom, rows, cols)
        sine, cosine = SINES[turned], SINES[(turned + TURN // 4) % TURN]
        matrix = np.stack([cosine, sine, -sine, cosine], axis=2)
        return np.asarray((matrix * (2 * ZOOM) + larger[..., None]) // (2 * larger[..., None]), np.int32)


def turns(angle: Field, rows: Array, cols: Array) -> Array:
    """Return the rotation at places, in 1 / 16 degree: (rows, columns) int64, below a full turn."""
    return np.asarray(np.rint(angle.at(rows, cols, around=True) * (TURN / 360)).astype(np.int64) % TURN)


def zooms(zoom: Field, rows: Array, cols: Array) -> Array:
    """Return the scale at places, in 1 / 256: (rows, columns) int64."""
    return np.clip(np.rint(zoom.at(rows, cols) * ZOOM), SMALLEST, LARGEST).astype(np.int64)


def modulo_lattice(y: Any, x: Any, lattice: list[list[int]]) -> Any:
    """Return (y, x), Python integers of any size, reduced by lattice vectors."""
    (ay, ax), (by, bx) = lattice
    det = ay * bx - ax * by
    m, n = (y * bx - x * by) // det, (ay * x - ax * y) // det
    return y - m * ay - n * by, x - m * ax - n * bx


def warped_origins(frame: Array, rows: Array, cols: Array, size: Array, lattice: Array) -> Array:
    """Return J(p) p for places at any distance, modulo the exemplar's size or the lattice: (H, W, 2)."""
    matrix, p, q = frame.astype(object), rows.astype(object)[:, None], cols.astype(object)[None, :]
    y, x = matrix[..., 0] * p + matrix[..., 1] * q, matrix[..., 2] * p + matrix[..., 3] * q  # 1 / 4096 px
    if len(lattice):
        y, x = modulo_lattice(y, x, (lattice << (UNIT - 8)).tolist())
    half = 1 << (UNIT - 1)
    out = [np.asarray((v + half) >> UNIT) for v in (y, x)]
    if not len(lattice):
        out = [v % int(side) for v, side in zip(out, size, strict=False)]
    return np.stack(out, axis=2).astype(np.int64)


class Span(NamedTuple):
    """Pixels start .. stop-1 of an axis at some level; it wraps after `period` of them, unless that is 0."""

    start: int
    stop: int
    period: int

    @property
    def at(self) -> Array:
        """The absolute coordinates, each one in the first period."""
        every = np.arange(self.start, self.stop, dtype=np.int64)
        return every % self.period if self.period else every

    def wider(self, margin: int) -> Span:
        """Return the span enlarged by `margin` px on either side."""
        return Span(self.start - margin, self.stop + margin, self.period)

    def above(self) -> Span:
        """Return the pixels of the next coarser level that are the parents of these."""
        if self.period:
            above = (self.period + 1) // 2
            return Span(0, above, above)
        return Span(self.start >> 1, ((self.stop - 1) >> 1) + 1, 0)


Spans = tuple[Span, Span]  # rows and columns


def places_of(level: int, spans: list[Spans]) -> list[Array]:
    """Return the places of the rows and of the columns of a level in the output, px."""
    axes = zip(spans[level], spans[0], strict=True)
    return [place_of(own.at, own.period, level, whole.period) for own, whole in axes]


def place_of(at: Array, period: int, level: int, whole: int) -> Array:
    """Return the places of the pixels `at` of a level in the output, px: the middles of their squares.

    A torus of `whole` px is divided evenly among its `period` pixels; where they cannot all be `h` px apart, the odd
    steps differ from level to level.
    """
    if period:
        odd = 2 * period * (level * 79 % 128) // 128  # 79 / 128: about the golden section
        return np.asarray(((2 * at + 1) * whole + odd) // (2 * period))
    return np.asarray((at << level) + ((1 << level) >> 1))


def previewed(coords: Array, places: list[Array], wanted: Spans, size: Array) -> Array:
    """Return the output as if synthesis ended at some level, each pixel of which gives a square copy: (H, W, 2).

    `places`: their rows and columns, px; if there are more than in the map, those in the middle. `wanted`: the rows and
    columns of the output. `size`: of the exemplar, at which coordinates wrap.
    """
    index, steps = [], []
    for axis, (place, span) in enumerate(zip(places, wanted, strict=True)):
        more = (len(place) - coords.shape[axis]) // 2
        own, first = np.unique(place[more : len(place) - more], return_index=True)
        nearest = np.searchsorted((own[:-1] + own[1:]) // 2, span.at)
        index.append(first[nearest])
        steps.append(span.at - own[nearest])
    found = coords[np.ix_(*index)].astype(np.int64)
    found[:, :, 0] += steps[0][:, None]
    found[:, :, 1] += steps[1][None, :]
    return np.asarray(found % size[:2], np.int32)


def whole_lattice(vectors: tuple[tuple[float, ...], ...] | None) -> Array:
    """Return two lattice vectors as (y, x) in 1/256 px, of positive determinant; empty without vectors.

    A single vector is completed by one of 1 px perpendicular to it.
    """
    if not vectors:
        return np.zeros((0, 2), np.int64)
    whole = [[round(256 * y), round(256 * x)] for x, y in vectors]
    if len(whole) == 1:
        (y, x), length = whole[0], math.hypot(*whole[0])
        whole.append([round(-256 * x / length), round(256 * y / length)])
    (ay, ax), (by, bx) = whole
    return np.array(whole if ay * bx > ax * by else whole[::-1], np.int64)


def residues(places: Array, lattice: Array, axis: int) -> Array:
    """Return (place, 0) (axis 0) or (0, place) reduced by lattice vectors: (N, 2), 1/256 px, for places of any size."""
    far = 256 * places.astype(object)
    y, x = (far, 0 * far) if axis == 0 else (0 * far, far)
    return np.stack(modulo_lattice(y, x, lattice.tolist()), axis=1).astype(np.int64)
