"""The choice of the fragments (docs/sources-003.md) in every reading of their energy, for comparison with ours."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from intarsia.segments.feature_group import DISC, FINE, Group, admitted, measured, size_and_gap
from intarsia.segments.felzenszwalb import even_colours
from intarsia.segments.segments import _scales


def _parts(group: Group) -> tuple[float, float]:
    """Var / range of distances and of sizes: the fragments' fractions."""
    values = group.distances / FINE, group.sizes.mean(axis=1)
    distance, size = (float(v.var() / max(np.ptp(v), 1.0)) for v in values)
    return distance, size


ENERGIES: dict[str, Callable[[Group], float]] = {
    "even": lambda group: group.energy,
    "sum": lambda group: sum(_parts(group)) + group.edge_score / DISC,
    "product": lambda group: math.prod(_parts(group)) + group.edge_score / DISC,
    "variances": lambda group: float((group.offsets / FINE).var(axis=0).sum() + group.sizes.var(axis=0).sum()),
}
"""Ours; the pseudo-code Var(D) / range(D) + Var(W) / range(W) + Q, as a sum or a product; and the short text."""


def select_feature(groups: list[Group | None], pixels: int, form: str) -> int | None:
    """Return which group to choose: of those admitted the one of least energy, the first of equals; or none."""
    energies = [ENERGIES[form](g) if g is not None and admitted(g, pixels) else math.inf for g in groups]
    best = min(energies, default=math.inf)
    return None if best == math.inf else energies.index(best)


def published_size(picture: np.ndarray, form: str) -> float | None:
    """Element and gap, px, of the group of least energy at the middle scale alone; None: none will do."""
    scales = list(_scales(even_colours(picture.astype(np.int64), None), None))
    tree = scales[len(scales) // 2][1]
    lists = [measured(tree.elements(n)) for n in tree.leaves]
    best = select_feature(lists, picture.shape[0] * picture.shape[1], form)
    return None if best is None else size_and_gap(lists[best])[0] / FINE
