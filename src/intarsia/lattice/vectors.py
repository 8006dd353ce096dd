"""The lattice vectors of an exemplar: found, checked, and in whole numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..analysis.features import features
from ..errors import MethodError, ParameterError
from ..exemplar import Exemplar
from .lattice import Lattice, Lattices, find_lattice

UNIT = 256  # lattice vectors are whole numbers of 1/256 px
Vector = tuple[int, int]  # (rows, columns) in 1/256 px
Pairs = Sequence[Sequence[float]] | None


def lattice_of(
    exemplar: Exemplar, slug: str, channel_weights: tuple[float, ...] | None = None
) -> tuple[tuple[float, float], ...]:
    """Find the lattice vectors of an exemplar, (x, y) in px; MethodError where it has none."""
    found = lattices_of(exemplar, channel_weights)
    if found.accepted is None:
        confidence = found.ranked[0].confidence if found.ranked else 0.0
        raise MethodError(
            f"{slug} finds no lattice in the exemplar (confidence {confidence:.2f}); use method image-quilting, or "
            "give the lattice vectors."
        )
    return vectors_of(found.accepted)


def lattices_of(exemplar: Exemplar, channel_weights: tuple[float, ...] | None = None) -> Lattices:
    """What is known of the lattice of an exemplar; looked for once."""

    def looked() -> Lattices:
        return find_lattice(features([exemplar], channel_weights).pictures[0], exemplar.usable)

    return exemplar.memo(("lattices", channel_weights), looked)


def vectors_of(found: Lattice) -> tuple[tuple[float, float], ...]:
    """The vectors of a lattice as methods take them: (x, y) px."""
    return tuple((x / UNIT, y / UNIT) for y, x in found.vectors)


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
