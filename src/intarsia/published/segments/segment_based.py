"""Segment-based synthesis: patches whose boundary zone holds the same kinds of segments, cut in along the best seam.

Source: fragments of a poster and of a short paper, without author or title, on how patch size and boundary zone follow
from a segmentation (docs/sources-003.md says what can be read in them).

Departures: patch and zone come from a vote over scales, because one scale fails on blur or noise; the histogram of
segments, which does not see how things are arranged, only says which patches are then compared pixel by pixel; windows
are laid in waves with evenly widened overlaps (layout=raster: as given); the cut is a minimum cut without memory of old
seams; repeats have a price (usage=0: none). The source leaves open how many patches are looked at, and the threshold.

Cost: the analysis, then `hits` times `points` patches compared for every window.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ...draws import below
from ...lazy import lazy
from ...methods import parameters
from ...methods.base import Ability
from ...params import AUTO, extent, param

if TYPE_CHECKING:
    import numpy as np

    from ... import sourcemap
    from ...analysis import features
    from ...arrays import Array
    from ...canvas import Canvas
    from ...exemplar import Exemplar
    from ...patches import growth as patches_growth
    from ...patches import settings
    from ...run import Run
    from ...search import candidates, sizes
    from ...segments import segments
    from . import histograms, readings
else:
    np = lazy("numpy")
    features = lazy("intarsia.analysis.features")
    patches_growth = lazy("intarsia.patches.growth")
    settings = lazy("intarsia.patches.settings")
    candidates = lazy("intarsia.search.candidates")
    histograms = lazy("intarsia.published.segments.histograms")
    readings = lazy("intarsia.published.segments.readings")
    segments = lazy("intarsia.segments.segments")
    sizes = lazy("intarsia.search.sizes")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 2008  # keeps this method's draws apart from those of others
POINTS = 1 << 20  # draws of points are apart from those of the choice


@dataclass(frozen=True)
class SegmentBased(parameters.CutSquares):
    """Lay patches that continue the segments around them, in a size found from the segments."""

    slug: ClassVar[str] = "segment-based"
    paper: ClassVar[str] = "fragments without author or title"
    summary: ClassVar[str] = "patches chosen by the segments in their boundary zone"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.MASK})

    patch: int | tuple[int, int] | None = parameters.patch_side()
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width that two neighbours share; automatic: the gap found, or a quarter of the patch given",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    layout: str = parameters.layout()
    hits: int = param(256, "int", "how many histograms of segments are looked at for every patch", low=1, high=1 << 12)
    points: int = param(8, "int", "how many patches are drawn of each of them", low=1, high=1 << 12)
    threshold: float | None = param(
        AUTO, "float", "draw among patches that differ by less than this share of the contrast, else take the best; "
        "automatic: by less than all but a fiftieth of those compared", low=0, high=100,
    )  # fmt: skip
    usage: float = param(0.2, "float", "price of using a patch again, in usual distances", low=0, high=100)

    energy: str = param(
        "vote", "choice", "which segments are its elements: by a vote over twelve scales, or at one scale those of "
        "least energy, in each of the readings of the source: fractions added or multiplied, or variances",
        choices=("vote", "sum", "product", "variances"),
    )  # fmt: skip

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> SegmentBased:
        """Decide patch and overlap from the segments of the exemplar."""
        patch, overlap = self.patch, self.overlap
        if patch is AUTO:
            found = self._found(exemplars[0])
            patch = sizes.supplied(exemplars, found.patch)
            if overlap is AUTO:  # a mask may leave less than the zone
                overlap = min(found.zone, patch - 1)
        elif overlap is AUTO:
            rows, columns = extent(patch)
            overlap = (rows // 4, columns // 4) if rows != columns else rows // 4
        sizes.check_patch(patch, exemplars)
        return replace(self, patch=patch, overlap=overlap)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Grow the map window by window, from patches with alike segments in the boundary zone."""
        method = self.resolved(exemplars, canvas)
        found = method._found(exemplars[0])
        zone = extent(method.overlap or 0)
        its = settings.PatchSettings(
            patch=method.footprint, overlap=zone, hangs=method.hangs,
            finder=lambda _, variants, patch, listed: histograms.SegmentSearch(
                variants, patch, found.group_map, zone, method.hits, method.points, seed, STAGE + POINTS
            ),
            repeats=settings.Repeats(usage=method.usage),
        )  # fmt: skip
        growth = patches_growth.Growth(its, exemplars, canvas)
        limit = None if method.threshold is AUTO else method.threshold * features.contrast(growth.features, exemplars)

        def chosen(window: tuple[int, int], found: candidates.Candidates, bits: int) -> patches_growth.Pick:
            prices = growth.repetition.prices(*window, found)
            return choose(found, prices, found.usual if limit is None else limit * int((found.known > 0).sum()), bits)

        growth.fill(seed, STAGE, run, choose=chosen, join=growth.cutting())
        return growth.map(self.blend)

    def _found(self, exemplar: Exemplar) -> segments.Segments:
        if self.energy == "vote":
            return segments.segments(exemplar)
        known = ("published segments", self.energy)
        return exemplar.memo(known, lambda: readings.published_segments(exemplar, self.energy))


def choose(found: candidates.Candidates, prices: Array, limit: float, bits: int) -> patches_growth.Pick:
    """Draw one of the patches whose squared difference, with the price of a repeat, is below `limit`, or the best."""
    near = np.flatnonzero(prices < limit)
    v, y, x = found.rows[near[below(len(near), bits)] if len(near) else int(np.argmin(prices)), 1:].tolist()
    return v, y, x
