"""Patch-based sampling at work: which patches may be chosen by each bound, and how they meet.

Where a short-list would hide some of what Multrus 2003 draws among (3.3.4, 4.2.1), every patch is measured until it is
farther than what counts.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from ...analysis.features import features
from ...foundation.arrays import Array, Pair
from ...foundation.params import AUTO, extent
from ...foundation.run import Run, below
from ...model import Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import SourceMap
from ...patches import Pick, Window
from ...patches.growth import Boundaries, Growth, PatchSettings, Repeats, Stages
from ...patches.repetition import Repetition, Table
from ...search import (
    Candidates,
    PosedExemplars,
    Search,
    check_patch,
    default_patch,
    fourier_kernels,
    nearest,
    resolved_isometries,
)
from ...search.fourier_kernels import FAR
from ...search.guide import check_guide, guided_patch
from .guided import GuidedByRoots
from .patch_sampling import PatchSampling
from .pyramid import Drawn, DrawnPyramid, GuidedPyramid, PyramidSearch, check_pyramid
from .repeats import Counter, Factors, Marks

STAGE = 2003  # keeps this method's draws apart from those of others
MOST = 64  # candidates may be chosen from a short-list; for more of them every patch is looked at
LEAST_LISTED = 16  # candidates kept of every search, or thrice as many as may be chosen
LISTED_BY_EPSILON = 48  # in a pyramid
UNLIMITED = 1 << 60


def resolved(method: PatchSampling, exemplars: Exemplars, canvas: Canvas) -> PatchSampling:
    """Decide patch and seam from the size of the texture's elements."""
    patch, overlap = method.patch, method.overlap
    if patch is AUTO:
        whole = default_patch(exemplars) if canvas.guide is None else guided_patch(exemplars, canvas.guide)
        if overlap is AUTO:  # where there is room for seams on both sides
            overlap = min(max(1, whole // 6), (whole - 1) // 2)
        patch = max(1, whole - 2 * max(extent(overlap)))
    elif overlap is AUTO:
        rows, columns = extent(patch)
        overlap = (max(1, rows // 5), max(1, columns // 5)) if rows != columns else max(1, rows // 5)
    known = replace(method, patch=patch, overlap=overlap)
    isometries = resolved_isometries(method.isometries, exemplars, known.footprint)
    check_patch(patch, exemplars, isometries, overlap)
    if canvas.guide is not None:
        check_guide(exemplars, canvas.guide, known.footprint)
    if method.pyramid != "off":
        check_pyramid(extent(patch), extent(overlap))
    bounds = resolved_isometries(method.boundary_isometries, exemplars, known.footprint)
    return replace(known, isometries=isometries, boundary_isometries=bounds)


def synthesize(
    method: PatchSampling, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> SourceMap:
    """Grow the map window by window, in raster order as far as windows touch."""
    misses: list[int] = []
    settings = settings_of(method)
    if method.pyramid != "off" and method.pyramid_draws == "every":
        its = features(exemplars, method.channel_weights)
        drawn = Drawn(seed, STAGE, partial(_admitted, method), method.boundary_candidates, its)
        settings = replace(settings, finder=partial(_drawing, method, drawn))
    stages = Stages(settings, exemplars, canvas, method.blend)
    for growth in stages:
        pick = partial(choose, method, growth, misses=misses)
        growth.fill(seed, STAGE, run, choose=pick, join=partial(join_in, method, growth))
    if misses:
        run.notes.append(f"{len(misses)} patches had no candidate within epsilon; the best was taken.")
    return stages.map


def listed(method: PatchSampling) -> int:
    """How many candidates a search keeps: the short-list is rough, so more than may be chosen."""
    if method.bound != "best" and not of_all(method):
        return LISTED_BY_EPSILON
    at_bounds = method.boundary_candidates if method.pyramid != "off" else min(method.boundary_candidates, MOST)
    most = max(1 if of_all(method) else method.candidates, at_bounds)
    return max(LEAST_LISTED, most, 3 * min(most, MOST)) * (2 if _search(method) == "exact" else 1)


def of_all(method: PatchSampling) -> bool:
    """Whether every patch is looked at, as what may be chosen could lie beyond a short-list."""
    far = method.bound != "best" or method.candidates > MOST or method.repetition in ("counter", "marks")
    return method.pyramid == "off" and far


def _search(method: PatchSampling) -> str:
    """Counters and marks are those of single places, which the exact search has."""
    return "exact" if method.repetition in ("counter", "marks") else method.search


def settings_of(method: PatchSampling) -> PatchSettings:
    """How patches are laid; known once patch and overlap are."""
    overlap = extent(method.overlap or 0)
    rule = {"counter": Counter, "marks": Marks}.get(method.repetition, Repetition)
    usage = method.usage if method.repetition == "prices" else 0.0
    coarse = method.pyramid != "off"
    return PatchSettings(
        patch=method.footprint, overlap=overlap, hangs=method.hangs, weights=method.channel_weights,
        isometries=method.isometries, search=_search(method), listed=listed(method), rim=max(overlap),
        finder=partial(_from_coarse, method) if coarse else None, guided=GuidedPyramid if coarse else GuidedByRoots,
        repeats=Repeats(rule, usage, method.min_repeat_distance),
        boundaries=Boundaries.of(
            method.footprint, method.boundary_patch, method.boundary_isometries, method.boundary_slack
        ),
    )  # fmt: skip


def _from_coarse(
    method: PatchSampling, its: PatchSettings, variants: PosedExemplars, patch: Pair, listed: int
) -> Search:
    return PyramidSearch(variants, patch, its.overlap, method.pyramid, method.pyramid_kept, listed)


def _drawing(
    method: PatchSampling, drawn: Drawn, its: PatchSettings, variants: PosedExemplars, patch: Pair,
    listed: int,
) -> Search:  # fmt: skip
    return DrawnPyramid(variants, patch, its.overlap, method.pyramid, drawn)


def choose(
    method: PatchSampling, growth: Growth, window: Window, found: Candidates, bits: int, misses: list[int]
) -> Pick | None:
    """Draw one of the candidates that the bound admits; note a miss where it admits none."""
    at_boundary = growth.at_boundary(window)
    rows, prices = _priced(growth, window, found)
    brightness = growth.features.brightness(found.feats, found.known) if method.bound == "epsilon" else 0
    if of_all(method) and not at_boundary and not found.permitted:
        best = int(prices[0]) if len(prices) else UNLIMITED
        found = every_within(growth, window, found, max(best, _limit(method, prices, brightness)))
        rows, prices = _priced(growth, window, found)
    if at_boundary and method.boundary_candidates > MOST and method.pyramid == "off" and not found.permitted:
        rows, prices = _priced(growth, window, every_at_boundary(growth, window, found))
    if not len(rows):
        return None
    many = method.boundary_candidates if at_boundary else _admitted(method, prices, brightness)
    misses += [1] * (many == 0)
    v, u, s = rows[below(min(max(many, 1), len(rows)), bits), 1:].tolist()
    return v, u, s


def _admitted(method: PatchSampling, prices: Array, brightness: int) -> int:
    """How many of `prices`, the lowest first, may be chosen; 0: none, so the best is taken."""
    if method.bound == "best":
        return min(method.candidates, len(prices))
    return int(np.searchsorted(prices, _limit(method, prices, brightness), side="right"))


def _limit(method: PatchSampling, prices: Array, brightness: int) -> int:
    """The highest price that may be chosen, by the lowest ones of all."""
    if method.bound == "epsilon":  # d < epsilon R, both squared (Multrus 2003, 3.3.4)
        return math.ceil(method.epsilon**2 * brightness) - 1
    last = 0 if method.bound == "relative" else method.candidates - 1
    if len(prices) <= last:
        return UNLIMITED
    return int((1 + method.epsilon) ** 2 * int(prices[0])) if method.bound == "relative" else int(prices[last])


def _priced(growth: Growth, window: Window, found: Candidates) -> tuple[Array, Array]:
    """The candidates that are not forbidden, the cheapest first, and their prices."""
    prices = growth.repetition.prices(window[0], window[1], found)
    order = np.argsort(prices, kind="stable")
    order = order[prices[order] >= 0]
    return found.rows[order], prices[order]


def join_in(method: PatchSampling, growth: Growth, window: Window, pick: Pick, found: Candidates) -> None:
    """Lay a patch into a window, as `join` says."""
    if method.join == "cut" or (growth.at_boundary(window) and method.boundary_join == "cut"):
        growth.cutting()(window, pick, found)
    else:
        growth.growing.lay_over(growth.at(window), pick, found.known, growth.settings.overlap)


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
    return growth.weighed(window, replace(found, rows=rows))


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
    rows[:, 0] = guided.cost(rows[:, 0], apart[:, 0], share)
    return growth.weighed(window, replace(found, rows=nearest(rows)))
