"""Even use of the exemplar as a term of the energy: every pixel costs by its number of occurrences.

Windows of an element must lie inside the exemplar, so its middle belongs to thousands of placements and
its rim to hardly any. Here every exemplar pixel has a count of how often the map shows it, kept as cuts are laid. To
show it once more costs its count times a rate; so what a cut takes and leaves has a price for each pixel, positive or
negative, beside that of seams, and the least cut is that of their sum: the derivative of a quadratic energy of use.

That pixels which are used too often are dear is the thought of Kaspar, Neubert, Lischinski, Pauly and Kopf, "Self
Tuning Texture Optimization", Eurographics 2015. That the cut itself pays for it is this project's own.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int32
from ..kernels.jit import kernel
from ..kernels.maxflow import FREE, NEW
from .energy_kernels import source_at

SHARE = 64  # rates are kept in 1/64 of what seams are counted in


class Usage(NamedTuple):
    """Occurrences of every exemplar pixel in a map, and their cost."""

    origin: Int32  # (pixels of all variants,): which exemplar pixel each is
    rate: Int32  # (exemplar pixels,): what each showing costs the next, in 1/SHARE; of no size: it costs nothing
    shown: Int32  # (exemplar pixels,): how often each is shown, with what :func:`rim` counts


@kernel
def price_usage(usage: Any, step: int, old: Any, new: Any, state: Any, more: Any) -> Any:
    """Write the usage cost of taking each pixel of a patch instead of what is there into `more`.

    `old`, `new` (h, w): numbers of pixels of the variants, -1: none; only every `step`-th px of a window is looked at,
    where areas shrink faster than seams. Returns what is paid whatever is chosen: what must be taken, and all that can
    be saved.
    """
    total = np.int64(0)
    for i in range(old.shape[0]):
        for j in range(old.shape[1]):
            more[i, j] = 0
            if state[i, j] != FREE and state[i, j] != NEW:
                continue
            cost = np.int64(0)
            if new[i, j] >= 0:
                k = usage.origin[new[i, j]]
                cost += np.int64(usage.rate[k]) * usage.shown[k]
            if old[i, j] >= 0:
                k = usage.origin[old[i, j]]
                cost -= np.int64(usage.rate[k]) * (usage.shown[k] - 1)
            more[i, j] = cost * step // SHARE
            if state[i, j] == NEW or more[i, j] < 0:
                total += more[i, j]
    return total


@kernel
def count_map(grown: Any, pieces: Any, usage: Any) -> None:
    """Add the occurrences of all exemplar pixels in a map to the counts."""
    height, width = grown.variant.shape
    for y in range(height):
        for x in range(width):
            here = source_at(grown, pieces, y, x)
            if here >= 0:
                usage.shown[usage.origin[here]] += 1
