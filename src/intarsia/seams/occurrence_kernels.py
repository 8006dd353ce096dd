"""Even use of the exemplar as a term of the energy: every pixel costs by its number of occurrences.

A patch must lie inside the exemplar, so a pixel in the middle of it belongs to thousands of placements and one at the
border to hardly any. Therefore every exemplar pixel has a count of its occurrences in the map, updated with every cut.
A further occurrence costs the count times a rate. The usage energy is thus the sum over exemplar pixels of rate times
n (n - 1) / 2. In a cut it is linearised: each pixel gets a unary cost of being replaced, the cost of the new occurrence
minus that of the old one, of either sign; the minimum cut minimises the sum of these and the seams.

That overused exemplar pixels are penalised follows Kaspar, Neubert, Lischinski, Pauly and Kopf, "Self Tuning Texture
Optimization", Eurographics 2015. The term in the cut is our own.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int32
from ..kernels.jit import kernel
from ..kernels.maxflow import FREE, NEW
from .energy_kernels import source_at

SHARE = 64  # rates are kept in 1/64 of the unit of seam costs


class Usage(NamedTuple):
    """Occurrences of every exemplar pixel in a map, and their cost."""

    origin: Int32  # (pixels of all variants,): the number of the exemplar pixel that each shows
    rate: Int32  # (exemplar pixels,): what each occurrence adds to the cost of the next, in 1/SHARE; empty: no cost
    shown: Int32  # (exemplar pixels,): occurrences plus the initial count (:func:`.occurrences.border_counts`)


@kernel
def price_usage(usage: Any, step: int, old: Any, new: Any, state: Any, more: Any) -> Any:
    """Write the change of the usage cost by replacing each pixel of a window with that of a patch into `more`.

    `old`, `new` (h, w): pixel numbers in the variants, -1: none. `state` (h, w): FREE, NEW and others as of
    :func:`intarsia.kernels.maxflow.least_cut`; 0 is written for pixels that are neither. With every `step`-th pixel
    sampled, costs are multiplied by `step`, as a sampled pixel stands for `step` squared, a sampled seam for `step`.
    Returns a lower bound of the change by any cut: the sum over pixels that must be replaced, and over savings.
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
