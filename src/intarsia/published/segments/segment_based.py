"""Segment-based synthesis: patches with the same kinds of segments in the boundary zone, cut along the best seam.

Source: fragments of a poster and of a short paper, without author or title, on how patch size and boundary zone follow
from a segmentation (docs/sources-003.md says what can be read in them).

Departures: patch and zone come from a vote over scales, because one scale fails on blur or noise; the histogram of
segments, which does not see how they are arranged, only selects the patches that are compared pixel by pixel; windows
are filled in parallel batches with evenly widened overlaps (layout=raster: as given); the cut is a minimum cut without
memory of old seams; repeats have a price (repeat_penalty=0: none). The source leaves open how many patches are
compared, and the threshold.

Cost: the analysis, then `hits` times `points` patches compared for every window.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ... import methods
from ...foundation.params import AUTO, param
from ...methods import Ability


@dataclass(frozen=True)
class SegmentBased(methods.CutSquares):
    """Place patches that continue the segments around them, in a size found from the segments."""

    slug: ClassVar[str] = "segment-based"
    paper: ClassVar[str] = "fragments without author or title"
    summary: ClassVar[str] = "patches chosen by the segments in their boundary zone"
    engine: ClassVar[str] = "intarsia.published.segments.engine"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.MASK})

    patch: int | tuple[int, int] | None = methods.patch_side()
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width that two neighbours share; automatic: the gap found, or a quarter of the patch given",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    layout: str = methods.layout()
    hits: int = param(256, "int", "how many histograms of segments are looked at for every patch", low=1, high=1 << 12)
    points: int = param(8, "int", "how many patches are drawn of each of them", low=1, high=1 << 12)
    threshold: float | None = param(
        AUTO, "float", "draw among patches that differ by less than this share of the contrast, else take the best; "
        "automatic: by less than all but a fiftieth of those compared", low=0, high=100,
    )  # fmt: skip
    repeat_penalty: float = param(0.2, "float", "price of using a patch again, in usual distances", low=0, high=100)

    energy: str = param(
        "vote", "choice", "which segments are its elements: by a vote over twelve scales, or at one scale those of "
        "least energy, in each of the readings of the source: fractions added or multiplied, or variances",
        choices=("vote", "sum", "product", "variances"),
    )  # fmt: skip
