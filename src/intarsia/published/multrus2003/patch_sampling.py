"""Patch-based sampling: patches whose seams match, feathered into one another.

Liang, Liu, Xu, Guo and Shum, "Real-time texture synthesis by patch-based sampling", ACM Transactions on Graphics
2001; Multrus 2003 (see docs/sources-000.md).

Departures: the search compares with the unblended pieces, so the map does not depend on the feather (it differs
at the corners of seams); patches may be joined along the cheapest seam instead, which Multrus names as future
work; a bound relative to the best distance stands beside the source's, which is stricter where the exemplar is dark.

Cost: one FFT search over the exemplar for each patch, about N_out / pitch^2 of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from ...blend import Blend
from ...draws import below
from ...lazy import lazy
from ...methods import parameters
from ...methods.base import Ability, MethodBase
from ...params import AUTO, extent, param

if TYPE_CHECKING:
    import numpy as np

    from ...analysis import features, symmetry
    from ...arrays import Array
    from ...canvas import Canvas
    from ...exemplar import Exemplar
    from ...patches import growing_map, labelled, repetition, settings
    from ...patches.growth import Growth, Pick
    from ...run import Run
    from ...search import guide, posed, sizes
    from ...search.candidates import Search
    from ...sourcemap import SourceMap
    from . import drawn_pyramid, every_patch, pyramid, repeats
else:
    np = lazy("numpy")
    labelled = lazy("intarsia.patches.labelled")
    settings = lazy("intarsia.patches.settings")
    drawn_pyramid = lazy("intarsia.published.multrus2003.drawn_pyramid")
    features = lazy("intarsia.analysis.features")
    guide = lazy("intarsia.search.guide")
    growing_map = lazy("intarsia.patches.growing_map")
    every_patch = lazy("intarsia.published.multrus2003.every_patch")
    pyramid = lazy("intarsia.published.multrus2003.pyramid")
    repeats = lazy("intarsia.published.multrus2003.repeats")
    repetition = lazy("intarsia.patches.repetition")
    sizes = lazy("intarsia.search.sizes")
    symmetry = lazy("intarsia.analysis.symmetry")

STAGE = 2003  # keeps this method's draws apart from those of others
MOST = 64  # candidates may be chosen from a short-list; for more of them every patch is looked at
LEAST_LISTED = 16  # candidates kept of every search, or thrice as many as may be chosen
LISTED_BY_EPSILON = 48  # in a pyramid
UNLIMITED = 1 << 60


@dataclass(frozen=True)
class PatchSampling(MethodBase):
    """Lay patches whose seams match what is there, and feather the seams."""

    slug: ClassVar[str] = "patch-sampling"
    paper: ClassVar[str] = "Liang et al. 2001; Multrus 2003"
    summary: ClassVar[str] = "patches with matching seams, feathered"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.GUIDE, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    patch: int | tuple[int, int] | None = param(
        AUTO, "extent", "side of a patch without its seams; automatic: so that with them it spans an element",
        low=1, high=1 << 16, unit="px",
    )  # fmt: skip
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width of the seam, which two neighbours share; automatic: a fifth of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    bound: str = param(
        "best", "choice", "who may be chosen: the best few, all within epsilon of black, or of the best distance",
        choices=("best", "epsilon", "relative"),
    )  # fmt: skip
    candidates: int = param(5, "int", "with bound=best: how many may be chosen", low=1, high=99_999)
    epsilon: float = param(0.1, "float", "with the other bounds: how far from the ideal one may be", low=0, high=100)
    join: str = param(
        "feather", "choice", "how patches meet: feathered, cut in the middle of the seam, or along the cheapest seam",
        choices=("feather", "middle", "cut"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()
    isometries: str | tuple[int, ...] = parameters.poses()
    repetition: str = param(
        "prices", "choice", "what a repeat costs: our prices, the source's counter or marks, or nothing",
        choices=("prices", "counter", "marks", "none"),
    )  # fmt: skip
    usage: float = parameters.usage_price()
    min_repeat_distance: int = parameters.repeat_distance()
    search: str = parameters.search_ways()
    pyramid: str = param(
        "off", "choice", "search from coarse to fine, and what is averaged before every second pixel is dropped",
        choices=("off", "mean", "gaussian", "none"),
    )  # fmt: skip
    pyramid_kept: int = param(
        8, "int", "in a pyramid: the best places of a level, from which the next is searched", low=1, high=64
    )
    pyramid_draws: str = param(
        "finest", "choice", "in a pyramid: draw at the finest level, or at every one and follow that place alone, as "
        "published",
        choices=("finest", "every"),
    )  # fmt: skip
    boundary_patch: int | None = parameters.boundary_patch()
    boundary_isometries: str | tuple[int, ...] | None = parameters.boundary_poses()
    boundary_slack: int | None = parameters.boundary_slack()
    boundary_candidates: int = param(
        1, "int", "how many may be chosen where a patch holds a boundary of painted labels", low=1, high=99_999
    )
    boundary_join: str = param(
        "cut", "choice", "how such patches meet: along the cheapest seam, or like all others", choices=("cut", "same")
    )

    @property
    def blend(self) -> Blend:
        """A feather as wide as the seam."""
        return Blend(max(extent(self.overlap or 0)) if self.join == "feather" else 0)

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; known once patch and overlap are."""
        patch, overlap = extent(self.patch or 0), extent(self.overlap or 0)
        return patch[0] + overlap[0], patch[1] + overlap[1]

    @property
    def hangs(self) -> int:
        """Patches begin one seam before the border, and keep their pitch."""
        return 1

    @property
    def footprint(self) -> tuple[int, int]:
        """Rows and columns of the exemplar that a patch needs, its seams included."""
        patch, overlap = extent(self.patch or 0), extent(self.overlap or 0)
        return patch[0] + 2 * overlap[0], patch[1] + 2 * overlap[1]

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> PatchSampling:
        """Decide patch and seam from the size of the texture's elements."""
        patch, overlap = self.patch, self.overlap
        if patch is AUTO:
            whole = sizes.default_patch(exemplars, canvas.guide)
            if overlap is AUTO:  # where there is room for seams on both sides
                overlap = min(max(1, whole // 6), (whole - 1) // 2)
            patch = max(1, whole - 2 * max(extent(overlap)))
        elif overlap is AUTO:
            rows, columns = extent(patch)
            overlap = (max(1, rows // 5), max(1, columns // 5)) if rows != columns else max(1, rows // 5)
        resolved = replace(self, patch=patch, overlap=overlap)
        isometries = symmetry.resolved_isometries(self.isometries, exemplars, resolved.footprint)
        sizes.check_patch(resolved.patch or 0, exemplars, isometries, resolved.overlap or 0)
        if canvas.guide is not None:
            guide.check_guide(exemplars, canvas.guide, resolved.footprint)
        if self.pyramid != "off":
            pyramid.check_pyramid(extent(patch), extent(resolved.overlap or 0))
        bounds = self.boundary_isometries
        bounds = None if bounds is None else symmetry.resolved_isometries(bounds, exemplars, resolved.footprint)
        return replace(resolved, isometries=isometries, boundary_isometries=bounds)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> SourceMap:
        """Grow the map window by window, in raster order as far as windows touch."""
        method = self.resolved(exemplars, canvas)
        misses: list[int] = []
        settings = method.patch_settings
        if self.pyramid != "off" and self.pyramid_draws == "every":
            its = features.features(exemplars, self.channel_weights)
            drawn = drawn_pyramid.Drawn(seed, STAGE, self._admitted, self.boundary_candidates, its)
            settings = replace(settings, finder=partial(self._drawing, drawn))
        stages = labelled.Stages(settings, exemplars, canvas, method.blend)
        for growth in stages:
            choose = partial(method.choose, growth, misses=misses)
            growth.fill(seed, STAGE, run, choose=choose, join=partial(method.join_in, growth))
        if misses:
            run.notes.append(f"{len(misses)} patches had no candidate within epsilon; the best was taken.")
        return stages.map

    @property
    def listed(self) -> int:
        """How many candidates a search keeps: the short-list is rough, so more than may be chosen."""
        if self.bound != "best" and not self.of_all:
            return LISTED_BY_EPSILON
        at_bounds = self.boundary_candidates if self.pyramid != "off" else min(self.boundary_candidates, MOST)
        most = max(1 if self.of_all else self.candidates, at_bounds)
        return max(LEAST_LISTED, most, 3 * min(most, MOST)) * (2 if self._search == "exact" else 1)

    @property
    def of_all(self) -> bool:
        """Whether every patch is looked at, as what may be chosen could lie beyond a short-list."""
        far = self.bound != "best" or self.candidates > MOST or self.repetition in ("counter", "marks")
        return self.pyramid == "off" and far

    @property
    def _search(self) -> str:
        """Counters and marks are those of single places, which the exact search has."""
        return "exact" if self.repetition in ("counter", "marks") else self.search

    @property
    def patch_settings(self) -> settings.PatchSettings:
        """How patches are laid; known once patch and overlap are."""
        overlap = extent(self.overlap or 0)
        rules = {"counter": repeats.Counter, "marks": repeats.Marks}
        rule = rules.get(self.repetition, repetition.Repetition)
        usage = self.usage if self.repetition == "prices" else 0.0
        return settings.PatchSettings(
            patch=self.footprint, overlap=overlap, hangs=self.hangs, weights=self.channel_weights,
            isometries=self.isometries, search=self._search, listed=self.listed, rim=max(overlap),
            finder=self._from_coarse if self.pyramid != "off" else None,
            guided=pyramid.GuidedPyramid if self.pyramid != "off" else None,
            repeats=settings.Repeats(rule, usage, self.min_repeat_distance),
            boundaries=settings.Boundaries.of(
                self.footprint, self.boundary_patch, self.boundary_isometries, self.boundary_slack
            ),
        )  # fmt: skip

    def _from_coarse(
        self, its: settings.PatchSettings, variants: posed.PosedExemplars, patch: tuple[int, int], listed: int
    ) -> Search:
        return pyramid.PyramidSearch(variants, patch, its.overlap, self.pyramid, self.pyramid_kept, listed)

    def _drawing(
        self, drawn: drawn_pyramid.Drawn, its: settings.PatchSettings, variants: posed.PosedExemplars,
        patch: tuple[int, int], listed: int,
    ) -> Search:  # fmt: skip
        return drawn_pyramid.DrawnPyramid(variants, patch, its.overlap, self.pyramid, drawn)

    def choose(
        self, growth: Growth, window: growing_map.Window, found: Any, bits: int, misses: list[int]
    ) -> Pick | None:
        """Draw one of the candidates that the bound admits; note a miss where it admits none."""
        at_boundary = growth.at_boundary(window)
        rows, prices = self._priced(growth, window, found)
        brightness = growth.features.brightness(found.feats, found.known) if self.bound == "epsilon" else 0
        if self.of_all and not at_boundary and not found.permitted:
            best = int(prices[0]) if len(prices) else UNLIMITED
            found = every_patch.every_within(growth, window, found, max(best, self._limit(prices, brightness)))
            rows, prices = self._priced(growth, window, found)
        if at_boundary and self.boundary_candidates > MOST and self.pyramid == "off" and not found.permitted:
            rows, prices = self._priced(growth, window, every_patch.every_at_boundary(growth, window, found))
        if not len(rows):
            return None
        many = self.boundary_candidates if at_boundary else self._admitted(prices, brightness)
        misses += [1] * (many == 0)
        v, u, s = rows[below(min(max(many, 1), len(rows)), bits), 1:].tolist()
        return v, u, s

    def _admitted(self, prices: Array, brightness: int) -> int:
        """How many of `prices`, the lowest first, may be chosen; 0: none, so the best is taken."""
        if self.bound == "best":
            return min(self.candidates, len(prices))
        return int(np.searchsorted(prices, self._limit(prices, brightness), side="right"))

    def _limit(self, prices: Array, brightness: int) -> int:
        """The highest price that may be chosen, by the lowest ones of all."""
        if self.bound == "epsilon":  # d < epsilon R, both squared (Multrus 2003, 3.3.4)
            return math.ceil(self.epsilon**2 * brightness) - 1
        last = 0 if self.bound == "relative" else self.candidates - 1
        if len(prices) <= last:
            return UNLIMITED
        return int((1 + self.epsilon) ** 2 * int(prices[0])) if self.bound == "relative" else int(prices[last])

    @staticmethod
    def _priced(growth: Growth, window: growing_map.Window, found: Any) -> tuple[Array, Array]:
        """The candidates that are not forbidden, the cheapest first, and their prices."""
        prices = growth.repetition.prices(window[0], window[1], found)
        order = np.argsort(prices, kind="stable")
        order = order[prices[order] >= 0]
        return found.rows[order], prices[order]

    def join_in(self, growth: Growth, at: growing_map.Window, pick: Pick, found: Any) -> None:
        """Lay a patch into the window that begins at `at`, as `join` says."""
        bounds = growth.guided is not None and growth.at_boundary(growth.window(at))
        if self.join == "cut" or (bounds and self.boundary_join == "cut"):
            growth.cutting()(at, pick, found)
        else:
            growth.growing.lay_over(at, pick, found.known, growth.layout, growth.settings.overlap)
