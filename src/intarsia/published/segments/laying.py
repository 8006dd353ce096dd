"""Segment-based synthesis at work: sizes from the segments, patches drawn among those with alike boundary zones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...analysis.features import contrast
from ...arrays import Array
from ...canvas import Canvas
from ...draws import below
from ...exemplar import Exemplar
from ...params import AUTO, extent
from ...patches.growth import Growth, PatchSettings, Pick, Repeats
from ...run import Run
from ...search.candidates import Candidates
from ...search.sizes import check_patch, supplied
from ...segments.segments import Segments, segments
from ...sourcemap import SourceMap
from .histograms import SegmentSearch
from .readings import published_segments
from .segment_based import SegmentBased

STAGE = 2008  # keeps this method's draws apart from those of others
POINTS = 1 << 20  # draws of points are apart from those of the choice


def resolved(method: SegmentBased, exemplars: Sequence[Exemplar], canvas: Canvas) -> SegmentBased:
    """Decide patch and overlap from the segments of the exemplar."""
    patch, overlap = method.patch, method.overlap
    if patch is AUTO:
        found = _found(method, exemplars[0])
        patch = supplied(exemplars, found.patch)
        if overlap is AUTO:  # a mask may leave less than the zone
            overlap = min(found.zone, patch - 1)
    elif overlap is AUTO:
        rows, columns = extent(patch)
        overlap = (rows // 4, columns // 4) if rows != columns else rows // 4
    check_patch(patch, exemplars)
    return replace(method, patch=patch, overlap=overlap)


def synthesize(method: SegmentBased, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Grow the map window by window, from patches with alike segments in the boundary zone."""
    groups, zone = _found(method, exemplars[0]).group_map, extent(method.overlap or 0)
    its = PatchSettings(
        patch=method.footprint, overlap=zone, hangs=method.hangs,
        finder=lambda _, variants, patch, listed: SegmentSearch(
            variants, patch, groups, zone, method.hits, method.points, seed, STAGE + POINTS
        ),
        repeats=Repeats(usage=method.usage),
    )  # fmt: skip
    growth = Growth(its, exemplars, canvas)
    limit = None if method.threshold is AUTO else method.threshold * contrast(growth.features, exemplars)

    def chosen(window: tuple[int, int], found: Candidates, bits: int) -> Pick:
        prices = growth.repetition.prices(*window, found)
        return choose(found, prices, found.usual if limit is None else limit * int((found.known > 0).sum()), bits)

    growth.fill(seed, STAGE, run, choose=chosen, join=growth.cutting())
    return growth.map(method.blend)


def _found(method: SegmentBased, exemplar: Exemplar) -> Segments:
    if method.energy == "vote":
        return segments(exemplar)
    known = ("published segments", method.energy)
    return exemplar.memo(known, lambda: published_segments(exemplar, method.energy))


def choose(found: Candidates, prices: Array, limit: float, bits: int) -> Pick:
    """Draw one of the patches whose squared difference, with the price of a repeat, is below `limit`, or the best."""
    near = np.flatnonzero(prices < limit)
    v, y, x = found.rows[near[below(len(near), bits)] if len(near) else int(np.argmin(prices)), 1:].tolist()
    return v, y, x
