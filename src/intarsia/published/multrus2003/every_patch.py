"""Every patch looked at, where a short-list would hide some: what Multrus 2003 draws among (3.3.4, 4.2.1).

Slower than the lists that all else goes by: each patch is measured until it is farther than what counts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...patches.growing_map import Window
from ...patches.growth import Growth
from ...patches.repetition import Table
from ...search import fourier_kernels
from ...search.candidates import Candidates, nearest
from ...search.fourier_kernels import FAR
from .repeats import Factors


def every_within(growth: Growth, window: Window, found: Candidates, limit: int) -> Candidates:
    """Return all patches that a window may take and that are at most so far away (squared), nearest first."""
    if growth.layout.places is not None:  # edges weigh half of what is compared with the limit
        limit = 2 * limit + 1
    table = Table(growth.variants.valid if growth.guided is None else growth.guided.allowed_at(window))
    rows, prices, most = table.rows(table.flat), growth.repetition.search_prices, np.array(limit)
    if isinstance(prices, Factors):  # by 1 + uses, squared; 256 = once
        uses = np.concatenate([counts.ravel() for counts in prices.counts])[table.flat > 0].astype(np.int64)
        most = limit // (1 + uses // 256) ** 2
    rows[:, 0] = most
    fourier_kernels.measure(found.feats, found.known, growth.variants.posed, rows)
    rows = nearest(rows[rows[:, 0] <= most])
    return growth.weighed(np.array(growth.at(window), np.int64), replace(found, rows=rows))


def every_at_boundary(growth: Growth, window: Window, found: Candidates) -> Candidates:
    """Return all patches that a window may take where labels meet, by seam and guide together, cheapest first."""
    guided, at = growth.guided, np.array([growth.at(window)], np.int64)
    assert guided is not None, "labels meet under a guide"
    table = Table(guided.allowed_at(window))
    (wanted,), inside = guided.guidance.wanted(at)
    rows = table.rows(table.flat)
    rows[:, 0] = FAR
    apart = rows.copy()
    fourier_kernels.measure(found.feats, found.known, growth.variants.posed, rows)
    fourier_kernels.measure(wanted, inside[0], guided.guidance.pictures.posed, apart)
    share = guided.shares(found.known[None], inside)[0]
    rows[:, 0] = np.floor((np.sqrt(rows[:, 0]) + share * np.sqrt(apart[:, 0])) ** 2 + 0.5)
    return growth.weighed(at[0], replace(found, rows=nearest(rows)))
