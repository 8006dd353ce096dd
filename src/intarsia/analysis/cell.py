"""The lattice vectors of an exemplar: found, checked, and in whole numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..errors import MethodError, ParameterError
from ..exemplar import Exemplar
from .blockgrid import UNIT, Vector
from .features import features
from .lattice import find_lattice

Pairs = Sequence[Sequence[float]] | None


def lattice_of(
    exemplar: Exemplar, slug: str, channel_weights: tuple[float, ...] | None = None
) -> tuple[tuple[float, float], ...]:
    """Find the lattice vectors of an exemplar, (x, y) in px; MethodError where it has none."""
    found = find_lattice(features([exemplar], channel_weights).pictures[0], exemplar.usable)
    if found.accepted is None:
        confidence = found.ranked[0].confidence if found.ranked else 0.0
        raise MethodError(
            f"{slug} finds no lattice in the exemplar (confidence {confidence:.2f}); use method image-quilting, or "
            "give the lattice vectors."
        )
    return tuple((x / UNIT, y / UNIT) for y, x in found.accepted.vectors)


def check_lattice(lattice: Pairs, exemplar: Exemplar) -> None:
    """Refuse vectors that span no lattice, or leave the exemplar."""
    cell_of(lattice, (exemplar.height, exemplar.width))


def cell_of(lattice: Pairs, shape: tuple[int, ...]) -> tuple[Vector, Vector | None]:
    """The lattice vectors as (rows, columns) in 1/256 px, refusing what spans no lattice."""
    vectors = [(round(y * UNIT), round(x * UNIT)) for x, y in lattice or ()]
    for v in vectors:
        if not UNIT <= math.hypot(*v) <= UNIT * max(shape):
            raise ParameterError("a lattice vector must be 1 px long at least, and shorter than the exemplar.")
    if len(vectors) == 2:
        (a, b), (c, d) = vectors
        if abs(a * d - b * c) < 0.1 * math.hypot(a, b) * math.hypot(c, d):
            raise ParameterError("the two lattice vectors are parallel, or nearly so; give others, or only one.")
        return vectors[0], vectors[1]
    return vectors[0], None
