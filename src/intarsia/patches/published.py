"""Every patch looked at, where a short-list would hide some: what Multrus 2003 draws among (3.3.4, 4.2.1).

Slower than the lists that all else goes by: each patch is measured until it is farther than what counts.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..search import exhaustive_kernels
from ..search.candidates import Candidates
from ..search.fourier_kernels import FAR, Among
from .repeats import Table

if TYPE_CHECKING:
    from .growing_map import Window
    from .growth import Growth


def every_within(growth: Growth, window: Window, found: Candidates, limit: int) -> Candidates:
    """Return all patches that a window may take and that are at most so far away (squared), nearest first."""
    if growth.layout.places is not None:  # edges weigh half of what is compared with the limit
        limit = 2 * limit + 1
    table = Table(growth.variants.valid if growth.guided is None else growth.guided.allowed_at(window))
    squared = np.empty(len(table.flat), np.int64)
    prices, uses = growth.repetition.search_prices, np.zeros(len(table.flat), np.int32)
    if prices.multiply and growth.finder.factor == 1:
        uses = np.concatenate([counts.ravel() for counts in prices.counts])
    among = Among(table.flat, table.offsets)
    exhaustive_kernels.within(found.feats, found.known, growth.variants.posed, among, uses, limit, squared)
    rows = table.rows(squared >= 0)
    rows[:, 0] = squared[squared >= 0]
    return growth.weighed(
        np.array(growth.at(window), np.int64), replace(found, rows=rows[np.argsort(rows[:, 0], kind="stable")])
    )


def every_at_boundary(growth: Growth, window: Window, found: Candidates) -> Candidates:
    """Return all patches that a window may take where labels meet, by seam and guide together, cheapest first."""
    guided, at = growth.guided, np.array([growth.at(window)], np.int64)
    assert guided is not None, "labels meet under a guide"
    table = Table(guided.allowed_at(window))
    among, uses = Among(table.flat, table.offsets), np.zeros(len(table.flat), np.int32)
    seam, apart = np.empty((2, len(table.flat)), np.int64)
    (wanted,), inside = guided.guidance.wanted(at)
    exhaustive_kernels.within(found.feats, found.known, growth.variants.posed, among, uses, int(FAR), seam)
    exhaustive_kernels.within(wanted, inside[0], guided.guidance.pictures.posed, among, uses, int(FAR), apart)
    allowed = seam >= 0
    rows = table.rows(allowed)
    share = guided.shares(found.known[None], inside)[0]
    rows[:, 0] = np.floor((np.sqrt(seam[allowed]) + share * np.sqrt(apart[allowed])) ** 2 + 0.5)
    return growth.weighed(at[0], replace(found, rows=rows[np.argsort(rows[:, 0], kind="stable")]))
