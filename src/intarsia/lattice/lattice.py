"""The lattice of a texture: by which two steps tiles, bricks or threads repeat, or that they do not.

Found from the exemplar alone: guess lattices from peaks of the correlation and of the spectrum, score each by
how much better the texture agrees with itself at its points than anywhere else in the cell, fit the best ones
to a fraction of a px, and accept the winner only if enough points say so. Rows without a period along them
have one vector; most textures have none, and are told so.

Source: Lopez Recas 2011 (near-regular textures), chapter 3. Departures: another goodness, see ``fit.py``.
All decisions compare whole numbers.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..analysis.sums import factor_for, reduced
from ..errors import ParameterError
from .candidates import candidates, distinct, waves_of
from .correlation_map import CorrelatedPictures, CorrelationMap, correlation_map, pictures
from .fit import RING, fitted, relatives, resolved, score, shortlist
from .refine import refined
from .row_pitch import courses
from .verdict import FAINT, SURE, Lattice, Lattices, one_vector, two_vectors

__all__ = ["Lattice", "Lattices", "Rule", "find_lattice"]

Mask = NDArray[np.bool_]
Int64 = NDArray[np.int64]
Rule = Literal["contrast", "courses"]

LEAST_SIDE = 16  # px: four of the shortest vectors; a smaller exemplar has no room for a lattice
SHOWN = 5  # candidates that are reported
FAMILY = 6  # best lattices whose double and half cells are tried as well


def find_lattice(features: NDArray[np.int16], usable: Mask | None = None, rule: Rule = "contrast") -> Lattices:
    """Find by which steps a texture repeats.

    Parameters
    ----------
    features : int16 array, shape (H, W, C)
        Any size. Above 512 px a side a box-reduced copy is searched, and the vectors are then refined.
    usable : bool array, shape (H, W), optional
        False where pixels do not count.
    rule : "contrast" or "courses"
        ``courses`` looks for one vector only.

    Returns
    -------
    Lattices
        The same on every machine. Nothing is found below 16 px a side, or in constant exemplars.

    Raises
    ------
    ParameterError
        where the rule or the mask does not fit.
    """
    if rule not in ("contrast", "courses"):
        raise ParameterError(f"rule={rule} is unknown; choose contrast or courses.")
    if usable is not None and usable.shape != features.shape[:2]:
        raise ParameterError(f"the mask has shape {usable.shape}, the features {features.shape[:2]}; make them equal.")
    if usable is not None and usable.all():
        usable = None
    if min(features.shape[:2]) < LEAST_SIDE:
        return Lattices(None, (), f"Below {LEAST_SIDE} px a side nothing can repeat.")
    factor = factor_for(features.shape)
    found = _found(*reduced(features, usable, factor), rule == "courses")
    return found if factor == 1 else _at_full_size(found, features, usable, factor)


def _found(features: NDArray[np.int64], usable: Mask | None, one: bool) -> Lattices:
    """Search an exemplar of its own size."""
    height, width = features.shape[:2]
    prepared = pictures(features, usable)
    found = correlation_map(prepared)
    if found is None:
        return Lattices(None, (), "The exemplar is constant.")
    waves = waves_of(prepared)
    ranked = [] if one else _two(found, candidates(found, waves, height, width), prepared)
    if ranked and ranked[0].verdict == SURE:
        return Lattices(ranked[0], tuple(ranked), ranked[0].reasons[-1])
    rows = [one_vector(c, prepared) for c in courses(found, waves)[:SHOWN]]
    if rows and rows[0].verdict == SURE:
        return Lattices(rows[0], (rows[0], *ranked[: SHOWN - 1]), rows[0].reasons[-1])
    if ranked and ranked[0].verdict == FAINT:
        return Lattices(ranked[0], tuple(ranked), ranked[0].reasons[-1])
    together = tuple(sorted([*ranked, *rows], key=lambda one: -one.share)[:SHOWN])
    return Lattices(None, together, together[0].reasons[-1] if together else "No offset agrees with the exemplar.")


def _two(found: CorrelationMap, guesses: Int64, prepared: CorrelatedPictures) -> list[Lattice]:
    """Rank lattices of two vectors: shortlist, fit, score; then the relatives of the best."""
    size = prepared.edges.shape[0], prepared.edges.shape[1]
    lattices, fits = fitted(found, shortlist(found, guesses), size)
    scored = score(found, lattices, RING)
    kin = relatives(scored.vectors[scored.best(FAMILY)])
    more, others = fitted(found, distinct(kin, *size), size)
    scored = score(found, distinct(np.concatenate([lattices, more]), *size), RING)
    fits = {**others, **fits}
    ranked = []
    for k in scored.ranked(SHOWN):
        one = fits[tuple(scored.vectors[k].ravel().tolist())]
        vectors = resolved(found, scored.vectors[k], one.residual)
        ranked.append(two_vectors(vectors, scored, int(k), one, prepared))
    return ranked


def _at_full_size(found: Lattices, features: NDArray[np.int16], usable: Mask | None, factor: int) -> Lattices:
    """Scale the vectors back, and refine those of the accepted lattice at full resolution."""

    def scaled(one: Lattice) -> Lattice:
        rows = tuple((y * factor, x * factor) for y, x in one.vectors)
        return replace(one, vectors=rows, residual=one.residual * factor)

    ranked = tuple(scaled(one) for one in found.ranked)
    if found.accepted is None:
        return replace(found, ranked=ranked, reduction=factor, refined=False)
    best = scaled(found.accepted)
    exact = refined(features, usable, np.array(best.vectors, np.int64), factor)
    if exact is not None:
        rows = tuple((int(y), int(x)) for y, x in exact)
        best = replace(best, vectors=rows)
    ranked = tuple(best if one is found.accepted else other for one, other in zip(found.ranked, ranked, strict=True))
    return replace(found, accepted=best, ranked=ranked, reduction=factor, refined=exact is not None)
