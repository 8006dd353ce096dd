"""Engine of patch-based sampling: candidate bounds, the draw among candidates, and how patches are joined.

Where a short-list would hide some of the candidates of Multrus 2003 (3.3.4, 4.2.1), every patch is measured, until its
distance exceeds the bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...analysis.features import Features, features
from ...foundation.arrays import Array, Pair
from ...foundation.params import AUTO, extent
from ...foundation.run import Run, below, draw
from ...model import Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import SourceMap
from ...patches import Pick, Window
from ...patches.patch_synthesis import Boundaries, PatchSettings, PatchSynthesis, Stages
from ...patches.repetition import Repetition
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
from .guided_search import GuidedPatchSearch
from .patch_sampling import PatchSampling
from .pyramid import GuidedPyramid, PyramidSearch, check_pyramid
from .repetition import UseCounter, UseFactors, UseMarks

STAGE = 2003  # keeps this method's draws apart from those of others
SHORT_LIST_MAX = 64  # candidates may be chosen from a short-list; for more of them every patch is looked at
LEAST_LISTED = 16  # candidates kept of every search, or thrice as many as may be chosen
LISTED_BY_EPSILON = 48  # in a pyramid
UNLIMITED = 1 << 60


def resolved(method: PatchSampling, exemplars: Exemplars, canvas: Canvas) -> PatchSampling:
    """Return the method with patch and overlap derived from the size of the texture's elements."""
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
    """Build the map window by window, in raster order as far as windows overlap."""
    misses: list[int] = []
    settings = settings_of(method)
    if method.pyramid != "off" and method.pyramid_draws == "every":
        draws = partial(draw_at_level, method, features(exemplars, method.channel_weights), seed)
        settings = replace(settings, finder=partial(_pyramid_search, method, draws))
    stages = Stages(settings, exemplars, canvas, method.blend)
    for growth in stages:
        pick = partial(choose, method, growth, misses=misses)
        growth.fill(seed, STAGE, run, choose=pick, join=partial(place_patch, method, growth))
    if misses:
        run.notes.append(f"{len(misses)} patches had no candidate within epsilon; the best was taken.")
    return stages.map


def short_list_size(method: PatchSampling) -> int:
    """Return how many candidates a search keeps: more than may be chosen, as the short-list is approximate."""
    if method.bound != "best" and not needs_exhaustive_search(method):
        return LISTED_BY_EPSILON
    most = max(1 if needs_exhaustive_search(method) else method.candidates, method.boundary_candidates)
    return max(LEAST_LISTED, most, 3 * min(most, SHORT_LIST_MAX)) * (2 if _search(method) == "exact" else 1)


def needs_exhaustive_search(method: PatchSampling) -> bool:
    """Return whether every patch must be measured, as a candidate could be missing from a short-list."""
    far = method.bound != "best" or method.candidates > SHORT_LIST_MAX or method.repetition in ("counter", "marks")
    return method.pyramid == "off" and far


def _search(method: PatchSampling) -> str:
    """Return the search to use: counters and marks belong to single positions, which need the exact search."""
    return "exact" if method.repetition in ("counter", "marks") else method.search


def settings_of(method: PatchSampling) -> PatchSettings:
    """Return how patches are placed; patch and overlap must be resolved."""
    overlap = extent(method.overlap or 0)
    rule = {"counter": UseCounter, "marks": UseMarks}.get(method.repetition, Repetition)
    usage = method.repeat_penalty if method.repetition == "prices" else 0.0
    coarse = method.pyramid != "off"
    return PatchSettings(
        patch=method.footprint, overlap=overlap, hangs=method.hangs, weights=method.channel_weights,
        isometries=method.isometries, search=_search(method), listed=short_list_size(method), rim=max(overlap),
        finder=partial(_pyramid_search, method, None) if coarse else None,
        guided=GuidedPyramid if coarse else GuidedPatchSearch,
        rule=rule, usage=usage,
        boundaries=Boundaries.of(
            method.footprint, method.boundary_patch, method.boundary_isometries, method.boundary_tolerance
        ),
    )  # fmt: skip


def draw_at_level(
    method: PatchSampling, its: Features, seed: int, costs: Array, level: int, at: list[int],
    window: tuple[Array, Array], guided: bool,
) -> int:  # fmt: skip
    """Draw the index of one of the ascending costs that the bound admits at a level; see PyramidSearch."""
    many = method.boundary_candidates if guided else _admitted_count(method, costs, its.brightness(*window))
    return below(min(max(many, 1), len(costs)), draw(seed, STAGE, 1 + level, *at))


def _pyramid_search(
    method: PatchSampling, draws: Callable[..., int] | None, its: PatchSettings, variants: PosedExemplars, patch: Pair,
    listed: int,
) -> Search:  # fmt: skip
    kept, listed = (method.pyramid_kept, listed) if draws is None else (method.boundary_candidates,) * 2
    return PyramidSearch(variants, patch, its.overlap, method.pyramid, kept, listed, draws)


def choose(
    method: PatchSampling, growth: PatchSynthesis, window: Window, found: Candidates, bits: int, misses: list[int]
) -> Pick:
    """Draw one of the candidates that the bound admits; if it admits none, take the best and record a miss."""
    at_boundary = growth.at_boundary(window)
    rows, prices = _priced(growth, window, found)
    brightness = growth.features.brightness(found.feats, found.known) if method.bound == "epsilon" else 0
    if needs_exhaustive_search(method) and not at_boundary:
        limit = max(int(prices[0]), _price_limit(method, prices, brightness))
        found = all_within(growth, window, found, limit)
        rows, prices = _priced(growth, window, found)
    many = method.boundary_candidates if at_boundary else _admitted_count(method, prices, brightness)
    misses += [1] * (many == 0)
    v, u, s = rows[below(min(max(many, 1), len(rows)), bits), 1:].tolist()
    return v, u, s


def _admitted_count(method: PatchSampling, prices: Array, brightness: int) -> int:
    """Return how many of the ascending `prices` may be chosen; 0: none, so the best is taken."""
    if method.bound == "best":
        return min(method.candidates, len(prices))
    return int(np.searchsorted(prices, _price_limit(method, prices, brightness), side="right"))


def _price_limit(method: PatchSampling, prices: Array, brightness: int) -> int:
    """Return the highest price that may be chosen, given the lowest prices."""
    if method.bound == "epsilon":  # d < epsilon R, both squared (Multrus 2003, 3.3.4)
        return math.ceil(method.epsilon**2 * brightness) - 1
    return int(prices[method.candidates - 1]) if len(prices) >= method.candidates else UNLIMITED


def _priced(growth: PatchSynthesis, window: Window, found: Candidates) -> tuple[Array, Array]:
    """Return the candidates, cheapest first, and their prices."""
    prices = growth.repetition.prices(window[0], window[1], found)
    order = np.argsort(prices, kind="stable")
    return found.rows[order], prices[order]


def place_patch(method: PatchSampling, growth: PatchSynthesis, window: Window, pick: Pick, found: Candidates) -> None:
    """Place a patch into a window, joined as the parameter `join` requires."""
    if method.join == "cut" or (growth.at_boundary(window) and method.boundary_join == "cut"):
        growth.cutting()(window, pick, found)
    else:
        growth.growing.lay_over(growth.at(window), pick, found.known, growth.settings.overlap)


def every_patch(valid: Sequence[Array]) -> Array:
    """Return all `valid` first pixels of patches, one mask for each variant, as unmeasured candidates: (n, 4)."""
    rows = np.vstack([np.pad(np.argwhere(ok), ((0, 0), (2, 0)), constant_values=v) for v, ok in enumerate(valid)])
    rows[:, 0] = FAR
    return rows


def all_within(growth: PatchSynthesis, window: Window, found: Candidates, limit: int) -> Candidates:
    """Return all patches allowed in a window within a squared distance, nearest first."""
    if growth.layout.places is not None:  # edges weigh half of what is compared with the limit
        limit = 2 * limit + 1
    valid = growth.variants.valid if growth.guided is None else growth.guided.allowed_at(window)
    rows, prices, most = every_patch(valid), growth.repetition.search_prices, np.array(limit)
    if isinstance(prices, UseFactors):  # by 1 + uses, squared; 256 = once
        uses = np.concatenate([counts[ok] for counts, ok in zip(prices.counts, valid, strict=True)]).astype(np.int64)
        most = limit // (1 + uses // 256) ** 2
    rows[:, 0] = most
    fourier_kernels.measure(found.feats, found.known, growth.variants.posed, rows)
    rows = nearest(rows[rows[:, 0] <= most])
    return growth.weighed(window, replace(found, rows=rows))
