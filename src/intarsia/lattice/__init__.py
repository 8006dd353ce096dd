"""Lattice detection for near-regular textures: candidates, least-squares fit, and the decision whether there is one.

A lattice is found from the exemplar alone. Candidates come from peaks of its autocorrelation and of its spectrum. Each
is scored by how much better the texture matches itself at the lattice points than anywhere else in the cell; the best
are fitted to a fraction of a px, and the winner is accepted only if enough points support it. Courses that do not
repeat along themselves have one vector, perpendicular to them. Most textures have no lattice.

Source: Lopez Recas 2011 (near-regular textures), chapter 3. Departures: another score of candidates, see ``fit.py``;
scores are whole numbers.

This module also finds canvas lengths around which a lattice closes (no paper; a definition): along an axis of n px it
closes where one of its vectors is (n, 0). The misfit is the distance of the nearest lattice vector from (n, 0).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from ..analysis import factor_for, reduced
from ..analysis.features import features
from ..foundation import MethodError, ParameterError
from ..foundation.arrays import Int16, Int64, Mask
from ..foundation.geometry import UNIT
from ..foundation.params import Steps, Weights
from ..model import Exemplar
from .correlation_peaks import (
    CorrelatedPictures,
    CorrelationMap,
    correlation_map,
    lattice_candidates,
    pictures,
    waves_of,
)
from .decision import REFUSED, SURE, Lattice, Lattices, one_vector, row_pitches, two_vectors
from .fit import fitted, refined, score, shortlist

Vector = tuple[int, int]  # (rows, columns) in 1/256 px
Vectors = tuple[Vector, Vector]
Pairs = Sequence[Sequence[float]] | None


def lattice_of(
    exemplar: Exemplar, slug: str, channel_weights: Weights = None
) -> Steps:
    """Return the lattice vectors of an exemplar, one or two of (x, y) in px. Raise MethodError if it has none.

    `slug`: name of the method for the message; `channel_weights`: weights of the feature channels, None: default.
    """
    found = lattices_of(exemplar, channel_weights)
    if found.accepted is None:
        confidence = found.ranked[0].confidence if found.ranked else 0.0
        raise MethodError(
            f"{slug} finds no lattice in the exemplar (confidence {confidence:.2f}); use method image-quilting, or "
            "give the lattice vectors."
        )
    return vectors_of(found.accepted)


def lattices_of(exemplar: Exemplar, channel_weights: Weights = None) -> Lattices:
    """Return the detected lattices of an exemplar; computed once and kept with it."""
    return exemplar.memo(
        ("lattices", channel_weights),
        lambda: find_lattice(features([exemplar], channel_weights).pictures[0], exemplar.usable),
    )


def vectors_of(found: Lattice) -> Steps:
    """Return the vectors of a lattice in the form of method parameters: (x, y) in px."""
    return tuple((x / UNIT, y / UNIT) for y, x in found.vectors)


def check_lattice(lattice: Pairs, exemplar: Exemplar) -> None:
    """Raise ParameterError for vectors that span no lattice or are longer than the exemplar."""
    cell_of(lattice, (exemplar.height, exemplar.width))


def cell_of(lattice: Pairs, shape: tuple[int, ...]) -> tuple[Vector, Vector | None]:
    """Return one or two lattice vectors, given as (x, y) in px, as (rows, columns) in 1/256 px; None: no second.

    `shape`: rows and columns of the exemplar, px. Raise ParameterError for vectors shorter than 1 px, longer than the
    longer side, or within about 6 degrees of parallel.
    """
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


STRAIN = 0.02  # largest strain, slant included, of a lattice or a pitch to close around a wrapped canvas


def misfit_message(axis: int, length: int, what: str, strain: float, good: list[int]) -> str:
    """Return the message for a canvas size around which the lattice does not close: why, and which sizes do.

    `axis`: 0 height, 1 width; `length`: px; `what`: the finding; `strain`: a share of 1; `good`: lengths that close.
    """
    remedy = f"choose {' or '.join(map(str, good))} px." if good else "the lattice is slanted; drop wrap."
    why = f"{what} (strain {100 * strain:.1f} %, at most {100 * STRAIN:.0f} %)"
    return f"wrap: {('height', 'width')[axis]}={length} px {why}; {remedy}"


NEAR = 0.05  # allowed misfit as a share of the shortest vector: 2 px for tiles of 40 px, hidden by a joint
LEAST = 1.5  # px, allowed misfit at least: not visible; rounding to whole px gives half of it, lens distortion as much


def _points(vectors: Vectors, length: int, axis: int) -> tuple[Vector, list[Vector]]:
    """Return the vector of `length` px along an axis, and the lattice points near it but the origin; 1/256 px."""
    (a, b), (c, d) = vectors
    goal = (length * UNIT, 0) if axis == 0 else (0, length * UNIT)
    area = a * d - b * c
    m, n = (goal[0] * d - goal[1] * c) // area, (goal[1] * a - goal[0] * b) // area
    steps = [(s, t) for s in range(m - 1, m + 3) for t in range(n - 1, n + 3)]
    return goal, [(s * a + t * c, s * b + t * d) for s, t in steps if (s, t) != (0, 0)]


def closing_vector(vectors: Vectors, length: int, axis: int) -> Vector:
    """Return the lattice vector, (rows, columns) in 1/256 px, that goes once around `length` px of an axis.

    `axis`: 0 rows, 1 columns. The distance of a vector from (length, 0) or (0, length)
    is taken relative to its own length, so that a canvas below half a period holds one period, not none.
    """
    (y, x), points = _points(vectors, length, axis)
    return min(points, key=lambda p: Fraction((p[0] - y) ** 2 + (p[1] - x) ** 2, p[0] ** 2 + p[1] ** 2))


def misfit(vectors: Sequence[Vector], length: int, axis: int) -> float:
    """Return how far, px, a lattice is from closing around `length` px of an axis (0: rows, 1: columns).

    `vectors`: one or two of (rows, columns) in 1/256 px. With one vector only its pitch must close.
    """
    if len(vectors) == 2:
        goal, points = _points((vectors[0], vectors[1]), length, axis)
        return min(math.dist(point, goal) for point in points) / UNIT
    pitch = math.hypot(*vectors[0])
    along = length * UNIT * vectors[0][axis] / pitch
    return abs(along - pitch * round(along / pitch)) / UNIT


def allowed_misfit(vectors: Sequence[Vector]) -> float:
    """Return the misfit, px, up to which a lattice counts as closed."""
    return max(LEAST, NEAR * min(math.hypot(*v) for v in vectors) / UNIT)


def closing_length(vectors: Sequence[Vector], length: int, axis: int, unit: int = 1) -> int | None:
    """Return the largest multiple of `unit` up to `length` px, at least half of it, around which a lattice closes.

    `length` itself is returned if it closes, multiple or not, or if there is one vector and less than one pitch fits
    along the axis. Otherwise, of the consecutive multiples that close, from the largest down, the one with the least
    misfit. None if no length closes.
    """
    most = allowed_misfit(vectors)
    if len(vectors) == 1 and length * UNIT * abs(vectors[0][axis]) < math.hypot(*vectors[0]) ** 2:
        return length
    if misfit(vectors, length, axis) <= most:
        return length
    fitting = [n for n in range(length - length % unit, (length - 1) // 2, -unit) if misfit(vectors, n, axis) <= most]
    if not fitting:
        return None
    first = [n for k, n in enumerate(fitting) if fitting[0] - n == k * unit]
    return min(first, key=lambda n: misfit(vectors, n, axis))


LEAST_SIDE = 16  # px: four times the shortest vector searched; nothing is searched in smaller exemplars
SHOWN = 5  # candidates that are returned


def find_lattice(features: Int16, usable: Mask | None = None, courses: bool = False) -> Lattices:
    """Detect the lattice of a texture.

    Parameters
    ----------
    features : int16 array, shape (H, W, C)
        Any size. Above 512 px a side a box-reduced copy is searched, and the vectors are then refined at full size.
    usable : bool array, shape (H, W), optional
        False where pixels do not count.
    courses : bool
        Whether to search for a pitch of courses (one vector) only.

    Returns
    -------
    Lattices
        The same on every machine. Nothing is found below 16 px a side, or in constant exemplars.

    Raises
    ------
    ParameterError
        If the mask has another shape.
    """
    if usable is not None:
        if usable.shape != features.shape[:2]:
            raise ParameterError(
                f"the mask has shape {usable.shape}, the features {features.shape[:2]}; make them equal."
            )
        usable = None if usable.all() else usable
    if min(features.shape[:2]) < LEAST_SIDE:
        return Lattices(None, (), f"Below {LEAST_SIDE} px a side nothing can repeat.")
    factor = factor_for(features.shape)
    found = _found(*reduced(features, usable, factor), courses)
    return found if factor == 1 else _at_full_size(found, features, usable, factor)


def _found(features: Int64, usable: Mask | None, one: bool) -> Lattices:
    """Detect the lattice of features of at most 512 px a side; `one`: search for one vector only."""
    prepared = pictures(features, usable)
    found = correlation_map(prepared)
    if found is None:
        return Lattices(None, (), "The exemplar is constant.")
    waves = waves_of(prepared)
    ranked = [] if one else _two(found, lattice_candidates(found, waves, *features.shape[:2]), prepared)
    best = ranked[0].verdict if ranked else REFUSED
    if best != SURE:
        rows = [one_vector(c, prepared) for c in row_pitches(found, waves)[:SHOWN]]
        if rows and rows[0].verdict == SURE:
            best, ranked = SURE, [rows[0], *ranked[: SHOWN - 1]]
        elif best == REFUSED:
            ranked = sorted([*ranked, *rows], key=lambda one: -one.share)[:SHOWN]
    why = ranked[0].reasons[-1] if ranked else "No offset agrees with the exemplar."
    return Lattices(None if best == REFUSED else ranked[0], tuple(ranked), why)


def _two(found: CorrelationMap, guesses: Int64, prepared: CorrelatedPictures) -> list[Lattice]:
    """Return the best lattices of two vectors: shortlist, fit, score."""
    size = prepared.edges.shape[0], prepared.edges.shape[1]
    lattices, fits = fitted(found, shortlist(found, guesses), size)
    scored = score(found, lattices)
    best = [(k, fits[tuple(scored.vectors[k].ravel().tolist())]) for k in scored.ranked(SHOWN)]
    return [two_vectors(found, scored, k, one, prepared) for k, one in best]


def _at_full_size(found: Lattices, features: Int16, usable: Mask | None, factor: int) -> Lattices:
    """Multiply vectors and residuals by `factor`; refine the accepted lattice, the first, at full resolution."""
    ranked = [
        replace(one, vectors=tuple((y * factor, x * factor) for y, x in one.vectors), residual=one.residual * factor)
        for one in found.ranked
    ]
    if found.accepted is None:
        return replace(found, ranked=tuple(ranked))
    exact = refined(features, usable, np.array(ranked[0].vectors, np.int64), factor)
    if exact is not None:
        ranked[0] = replace(ranked[0], vectors=tuple((y, x) for y, x in exact.tolist()))
    return replace(found, accepted=ranked[0], ranked=tuple(ranked))
