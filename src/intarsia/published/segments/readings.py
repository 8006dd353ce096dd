"""The choice of the fragments at one scale, in every reading of their energy, which cannot be read for sure.

Source: the fragments (docs/sources-003.md), SelectFeature: at the middle scale alone, among groups that do not overlap,
the one of least energy.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ...analysis.features import features
from ...analysis.sums import factor_for, reduced
from ...exemplar import Exemplar
from ...segments.feature_group import DISC, FINE, Group
from ...segments.felzenszwalb import even_colours
from ...segments.segments import Segments, candidates_at, fallback, of_group, scales


def _parts(group: Group) -> tuple[float, float]:
    """Var / range of distances and of sizes: the fragments' fractions."""
    values = group.distances / FINE, group.sizes.mean(axis=1)
    distance, size = (float(v.var() / max(np.ptp(v), 1.0)) for v in values)
    return distance, size


ENERGIES: dict[str, Callable[[Group], float]] = {
    "sum": lambda group: sum(_parts(group)) + group.edge_score / DISC,
    "product": lambda group: math.prod(_parts(group)) + group.edge_score / DISC,
    "variances": lambda group: float((group.offsets / FINE).var(axis=0).sum() + group.sizes.var(axis=0).sum()),
}
"""The pseudo-code Var(D) / range(D) + Var(W) / range(W) + Q, as a sum or a product; and the short text."""


def published_segments(exemplar: Exemplar, form: str) -> Segments:
    """Return the segments at the middle scale, with the group of least energy; of equal ones the first."""
    feats = features([exemplar])
    picture, usable = feats.pictures[0][:, :, : feats.base], exemplar.usable
    factor = factor_for(picture.shape)
    small, mask = reduced(picture, usable, factor)
    colours = even_colours(small, mask)
    if colours is None:
        return fallback(picture, usable, None, "The exemplar is constant.")
    every = list(scales(colours, mask))
    scale, tree = every[len(every) // 2]
    pixels = small.shape[0] * small.shape[1] if mask is None else int(np.count_nonzero(mask))
    groups = [c for c in candidates_at(scale, tree, pixels) if c.node in tree.leaves]
    if not groups:
        return fallback(picture, usable, tree, "No group of segments passes the filters.")
    return of_group(min(groups, key=lambda c: ENERGIES[form](c.lists)), 1.0, factor, picture.shape[:2])
