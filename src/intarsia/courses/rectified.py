"""The exemplar that blocks are taken from, as it is or with its courses laid straight, and the lattice of that."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..exemplar import Exemplar
from ..lattice.lattice import find_lattice
from ..lattice.vectors import check_lattice, lattice_of, lattices_of, vectors_of
from ..lattice.verdict import Lattice
from .rectify import Straight, straight_of

Vectors = tuple[tuple[float, float], ...]
Weights = tuple[float, ...] | None


class Gain(NamedTuple):
    """When the straight exemplar is taken: of 92 textures 27 can be laid straight, one gains (docs/design/012)."""

    least: float = 1.15  # times the confidence as it is; at 1 six more are moved (1.00 to 1.13), doubled: none is
    clear: float = 2.0  # times what is asked, if it has none as it is; halved: scales and slabs get one, doubled: none
    loose: float = 0.5  # px: two vectors that fit better are straight enough; halved: a rattan is moved, doubled: as is
    level: float = 2.0  # px over the exemplar: courses that lean less are level, as 1 px at each end is rounding


GAIN = Gain()


@dataclass(frozen=True, eq=False)
class Rectified:
    """The exemplar that blocks are read from, its lattice (x, y) px, and how it was laid straight, if it was."""

    exemplar: Exemplar
    lattice: Vectors
    straight: Straight | None

    def to_exemplar(self, yx: NDArray[np.int32]) -> NDArray[np.int32]:
        """Turn pixels of it into pixels of the exemplar as it was given."""
        return yx if self.straight is None else self.straight.to_exemplar(yx)


def rectified_for(
    exemplar: Exemplar, slug: str, lattice: Vectors | None = None, choice: str = "auto", weights: Weights = None
) -> Rectified:
    """Decide whether courses are laid straight, and find the lattice; MethodError, of the method `slug`, without one.

    `choice`: auto, on or off. With given vectors, `lattice` (x, y) px, ``auto`` leaves the exemplar as it is; with
    ``on`` they are those of the straight one.
    """
    if lattice is not None:
        straight = straight_of(exemplar, weights) if choice == "on" else None
        laid = exemplar if straight is None else straight.exemplar
        check_lattice(lattice, laid)
        return Rectified(laid, lattice, straight)
    better = None
    if choice != "off":
        better = improved(exemplar, weights) if choice == "auto" else levelled(exemplar, weights)
    if better is not None:
        return Rectified(better[0].exemplar, vectors_of(better[1]), better[0])
    return Rectified(exemplar, lattice_of(exemplar, slug, weights), None)


def improved(exemplar: Exemplar, weights: Weights = None) -> tuple[Straight, Lattice] | None:
    """The exemplar laid straight and its lattice, where it is much surer than as it is; else None."""
    plain = lattices_of(exemplar, weights).accepted
    if plain is not None and plain.kind == "2-D" and plain.residual < GAIN.loose:
        return None
    straight = straight_of(exemplar, weights)
    found = None if straight is None or straight.off < 1 else levelled(exemplar, weights)
    if found is None:
        return None
    if plain is None:
        return found if found[1].share >= GAIN.clear else None
    alike = found[1].kind == plain.kind
    return found if alike and found[1].confidence >= GAIN.least * plain.confidence else None


def levelled(exemplar: Exemplar, weights: Weights = None) -> tuple[Straight, Lattice] | None:
    """The exemplar laid straight and its lattice; None where it is straight already, or has none.

    Courses stay courses; where the exemplar has no lattice as it is, that of one or two vectors is taken that is surer.
    """
    straight = straight_of(exemplar, weights)
    if straight is None:
        return None
    laid, plain = straight.exemplar, lattices_of(exemplar, weights).accepted
    two = None
    if plain is None or plain.kind == "2-D":
        two = lattices_of(laid, weights).accepted
        if two is not None and (two.kind == "1-D" or plain is not None):
            return straight, _level(two, laid)
    one = find_lattice(features([laid], weights).pictures[0], laid.usable, "courses").accepted
    best = max((found for found in (one, two) if found is not None), key=lambda found: found.share, default=None)
    return None if best is None else (straight, _level(best, laid))


def _level(found: Lattice, laid: Exemplar) -> Lattice:
    """Courses that hardly lean, made level."""
    if found.kind == "2-D":
        return found
    ((y, x),) = found.vectors
    if abs(x) * laid.width < GAIN.level * abs(y):
        return replace(found, vectors=((abs(y), 0),))
    return replace(found, vectors=((0, abs(x)),)) if abs(y) * laid.height < GAIN.level * abs(x) else found
